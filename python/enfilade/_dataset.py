"""A data folder."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Optional, Union, overload

from enfilade._continuous import TASKS as CONTINUOUS_TASKS
from enfilade._continuous import ContinuousEpisodes, PathLike, continuous_episodes
from enfilade._core import DatasetFolder, Graphs, Panoramas
from enfilade._episodes import Episodes
from enfilade._errors import ArgumentError
from enfilade._layers import checked_layer

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from enfilade._renderer import Renderer
    from enfilade._simulator import Simulator


@dataclass(frozen=True)
class Part:
    """A part of a data set: found, or missing with advice how to get it."""

    name: str  #: "connectivity", "R2R val_seen", "regions", "panoramas"
    present: bool
    found: str  #: "90 scans"; or the reason why it cannot be used
    advice: str  #: how to get it; empty if present


@dataclass(frozen=True)
class SeenObject:
    """An object in the views of one viewpoint (REVERIE's boxes)."""

    id: int
    name: str  #: "plant#pot": category, and detail if any
    views: tuple[int, ...]  #: views that show it, 0..35; empty if none does
    boxes: tuple[tuple[int, int, int, int], ...]  #: one per view: x, y, width, height of 640 x 480


class Dataset:
    """A data set: graphs, panoramas, episodes and regions of one folder.

    >>> d = enfilade.Dataset("data")
    >>> sim = d.simulator(batch_size=2)
    >>> d.episodes("val_unseen")[0].text
    >>> picture = d.render(d.graphs.scans[0], viewpoint, heading=math.pi / 2)     # (480, 640, 3)

    Args:
        folder: in Enfilade's layout (`connectivity/`, `r2r/`, `regions/`, `store/`), in
            Matterport3DSimulator's, with all files side by side, or with only stores. None: the folder
            that the environment variable ENFILADE_DATA names.

    A part is opened at first use. Any thread may use it. Unpickling opens the folder again. Raises
    FileError if it is not a folder.
    """

    def __init__(self, folder: Optional[PathLike] = None) -> None:
        self._core = DatasetFolder(folder)
        self._renderer: Optional[Renderer] = None

    @property
    def folder(self) -> Path:
        """The folder, as given."""
        return Path(self._core.folder)

    @property
    def synthetic(self) -> bool:
        """Whether the buildings are synthetic homes. Results on them have to be called synthetic."""
        return self._core.synthetic

    @property
    def graphs(self) -> Graphs:
        """The navigation graphs. Raises FileError, InvalidInput."""
        graphs = self._core.graphs
        graphs._folder = os.fspath(self.folder)  # type: ignore[attr-defined]  # to pickle them
        return graphs

    @property
    def panoramas(self) -> Panoramas:
        """The panoramas, in the order of the graphs. A scan is opened at first use."""
        panoramas = self._core.panoramas
        panoramas._folder = os.fspath(self.folder)  # type: ignore[attr-defined]  # to pickle them
        return panoramas

    @property
    def splits(self) -> list[str]:
        """Those of train, val_seen, val_unseen and test that exist."""
        return self._core.splits

    @property
    def tasks(self) -> dict[str, list[str]]:
        """The benchmarks of both worlds with annotations in the folder, each with its splits."""
        return self._core.tasks

    @overload
    def episodes(  # type: ignore[overload-overlap]  # a name that is known narrows the class
        self, split: str, task: Literal["r2r-ce", "rxr-ce"], *, file: Optional[PathLike] = None
    ) -> ContinuousEpisodes: ...
    @overload
    def episodes(
        self, split: str, task: str = "r2r", *, all_instructions: bool = False,
        file: Optional[PathLike] = None,
    ) -> Episodes: ...  # fmt: skip
    def episodes(
        self, split: str, task: str = "r2r", *, all_instructions: bool = False,
        file: Optional[PathLike] = None,
    ) -> Union[Episodes, ContinuousEpisodes]:  # fmt: skip
        """The episodes of a split: ContinuousEpisodes for "r2r-ce" and "rxr-ce", else Episodes.

        Arguments and errors are those of Episodes, and of continuous_episodes(). Raises ArgumentError for
        all_instructions in a continuous task.
        """
        if task not in CONTINUOUS_TASKS:
            return Episodes._of_dataset(self._core, split, task, all_instructions, file)
        if all_instructions:
            raise ArgumentError(f"all_instructions: not an option of {task}")
        return continuous_episodes(self.folder, task, split, file=file)

    def objects(self, scan: str, viewpoint: str) -> list[SeenObject]:
        """The objects around a viewpoint (REVERIE's boxes), in the order of the file, including those
        that no view shows. The first call reads the boxes of all scans. Raises FileError, InvalidInput."""
        return [SeenObject(*row) for row in self._core.objects_at(scan, viewpoint)]

    def __reduce__(self) -> tuple[Any, ...]:
        return Dataset, (os.fspath(self.folder),)

    def region(self, scan: str, viewpoint: str) -> Optional[int]:
        """The region (room) of a viewpoint; None if the region map does not have it. Raises FileError or
        InvalidInput for the map."""
        return self._core.region(scan, viewpoint)

    def examine(self) -> list[Part]:
        """Every part that a data set can have: found, or missing with advice. Reads all annotations,
        which takes about a second for R2R."""
        return [Part(*row) for row in self._core.examine()]

    def simulator(self, batch_size: int = 1, **options: Any) -> Simulator:
        """A simulator of these graphs; options and errors are those of Simulator."""
        from enfilade._simulator import Simulator

        return Simulator(self.graphs, batch_size, **options)

    def renderer(self, **options: Any) -> Renderer:
        """A renderer of these panoramas; options and errors are those of Renderer."""
        from enfilade._renderer import Renderer

        return Renderer(self.graphs, self.panoramas, **options)

    def render(
        self,
        scan: str,
        viewpoint: str,
        heading: float = 0.0,
        elevation: float = 0.0,
        *,
        width: int = 640,
        height: int = 480,
        vfov: float = math.radians(60),
        layer: str = "rgb",
    ) -> NDArray[Any]:
        """One image; angles in radians. For many images use renderer(). One thread at a time.

        Args:
            layer: "rgb": (height, width, 3) uint8; "depth", "semantic" or "instance": (height, width), as
                in Renderer.render().

        Raises UnknownNameError, FileError, InvalidInput, and ArgumentError for invalid angles, sizes or
        layers.
        """
        layer = checked_layer("layer", layer)
        if self._renderer is None:
            self._renderer = self.renderer()
        drawn = self._renderer.render(
            [scan], [viewpoint], heading, elevation, width=width, height=height, vfov=vfov,
            rgb="rgb8" if layer == "rgb" else None, layers=(layer,),
        )  # fmt: skip
        picture: NDArray[Any] = drawn[layer][0]
        return picture


def _graphs_of(folder: str) -> Graphs:
    return Dataset(folder).graphs


def _panoramas_of(folder: str) -> Panoramas:
    return Dataset(folder).panoramas
