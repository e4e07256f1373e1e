"""Views of continuous agents: images of meshes from any position, rendered on the CPU.

>>> eyes = enfilade.eyes.Eyes("homes")                         # or Eyes(meshes="glb"): glb/SCAN.glb, ...
>>> seen = eyes.render_agents(sim)                             # a ContinuousSimulator
>>> seen["rgb"].shape, seen["depth"].shape                     # (n, 224, 224, 3), (n, 256, 256)

Importing this loads a ray tracer.
"""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from enfilade import _eyes
from enfilade._arguments import whole
from enfilade._continuous import ContinuousSimulator, PathLike, _data_folder, _points, _row
from enfilade._errors import ArgumentError, FileError, UnknownNameError
from enfilade._layers import LAYERS, checked_layer, layer_of

__all__ = ["LAYERS", "SIZES", "Eyes"]

SIZES = {"rgb": (224, 224), "depth": (256, 256), "semantic": (256, 256), "instance": (256, 256)}
"""Width and height of VLN-CE's images, pixels."""

Size = Tuple[int, int]
_TYPES: dict[str, Any] = {"rgb": np.uint8, "depth": np.float32, "semantic": np.uint16, "instance": np.uint32}
_SUFFIXES = (".glb", ".gltf", ".obj", ".ply")


class Eyes:
    """Renders buildings. Each is opened at first use and then stays open.

    Args:
        data: folder of synthetic homes. Meshes and light are computed from its homes.json, in up to a
            minute of one core per home. None without `meshes`: the folder that ENFILADE_DATA names.
        meshes: other buildings: a folder with SCAN.glb (or .gltf, .obj, .ply) or SCAN/SCAN.glb, or
            files by scan.
        up: the up axis of mesh files: "format" (y for glTF, z for others), "y" or "z" (Habitat's copies
            of Matterport3D).
        light: a cache folder for the light of homes; with it, opening takes about a second.
        light_spacing: metres between the points for which the light of homes is computed.
        threads: 0: all cores; never changes an image.

    One thread at a time. Raises FileError for a missing folder.
    """

    def __init__(
        self,
        data: Optional[PathLike] = None,
        *,
        meshes: Union[None, PathLike, Mapping[str, PathLike]] = None,
        up: str = "format",
        light: Optional[PathLike] = None,
        light_spacing: float = 0.05,
        threads: int = 0,
    ) -> None:
        self._files = {} if meshes is None else _mesh_files(meshes)
        self._data = _data_folder(data) if meshes is None or data is not None else None
        self._up, self._light = up, light
        self._spacing = light_spacing
        self._threads = whole("threads", threads)
        self._open: dict[str, _eyes.BuildingEyes] = {}

    def open(self, scan: str) -> None:
        """Opens a building now. Raises UnknownNameError for a scan without mesh and home, InvalidInput
        for a broken file."""
        self._building(scan)

    def render(
        self,
        scans: Sequence[str],
        eyes: ArrayLike,
        headings: ArrayLike = 0.0,
        elevations: ArrayLike = 0.0,
        *,
        layers: Sequence[str] = ("rgb", "depth"),
        size: Union[None, Size, Mapping[str, Size]] = None,
        vfov: float = math.pi / 2,
    ) -> dict[str, NDArray[Any]]:
        """Images of n views, by layer.

        Args:
            scans: (n,) names of buildings.
            eyes: (n, 3) positions of the camera, metres, world frame.
            headings: (n,) or one, radians clockwise from +y, of the centre of the image.
            elevations: (n,) or one, radians, up positive.
            layers: any of "rgb" ((n, h, w, 3) uint8), "depth" ((n, h, w) float32 metres along the optical
                axis, 0: no surface), "semantic" ((n, h, w) uint16 of mpcat40) and "instance"
                ((n, h, w) uint32, 0: no object).
            size: (width, height) of all layers, or by layer; default: SIZES.
            vfov: vertical field of view, radians.

        Raises ArgumentError for invalid arguments, and the errors of open().
        """
        places = _points("eyes", eyes)
        n = len(places)
        if isinstance(scans, str) or len(scans) != n:
            raise ArgumentError(f"scans: {n} names are wanted, one for each of the eyes")
        asked = {word: checked_layer("layers", word) for word in layers}
        by_layer = size if isinstance(size, Mapping) else {} if size is None else dict.fromkeys(layers, size)
        chosen = {**SIZES, **{layer_of(word): pixels for word, pixels in by_layer.items()}}
        sizes = {layer: _size(layer, chosen[layer]) for layer in asked.values()}
        turned, raised = _row(headings, n), _row(elevations, n)
        drawn: dict[str, NDArray[Any]] = {}
        for width, height in dict.fromkeys(sizes.values()):
            here = [layer for layer in sizes if sizes[layer] == (width, height)]
            for layer in here:
                shape = (n, height, width, 3) if layer == "rgb" else (n, height, width)
                drawn[layer] = np.empty(shape, _TYPES[layer])
            for scan in dict.fromkeys(scans):
                rows = np.flatnonzero([one == scan for one in scans])
                camera = (width, height, vfov)
                self._draw(scan, rows, places, turned, raised, camera, {k: drawn[k] for k in here})
        return {word: drawn[layer] for word, layer in asked.items()}

    def render_agents(
        self, simulator: ContinuousSimulator, **options: Any
    ) -> dict[str, NDArray[Any]]:
        """The current views of a simulator's agents, from its eye_height; options are those of render()."""
        state = simulator.state
        eyes = state.position.astype(np.float64)
        eyes[:, 2] += simulator.config["eye_height"]
        names = simulator.scans
        scans = [names[building] for building in state.building]
        return self.render(scans, eyes, state.heading, state.elevation, **options)

    def _draw(
        self,
        scan: str,
        rows: NDArray[np.intp],
        places: NDArray[np.float64],
        headings: NDArray[np.float64],
        elevations: NDArray[np.float64],
        camera: tuple[int, int, float],
        drawn: dict[str, NDArray[Any]],
    ) -> None:
        # Empty arrays are not drawn.
        whole_batch = len(rows) == len(places)
        parts = {k: v if whole_batch else np.empty_like(v[rows]) for k, v in drawn.items()}
        nothing = {layer: np.empty((0, 0, 0, 3) if layer == "rgb" else (0, 0, 0), _TYPES[layer])
                   for layer in LAYERS}  # fmt: skip
        into = [{**nothing, **parts}[layer] for layer in LAYERS]
        at, turned, raised = places[rows], headings[rows], elevations[rows]
        self._building(scan).render(at, turned, raised, *camera, *into)
        if not whole_batch:
            for layer, part in parts.items():
                drawn[layer][rows] = part

    def _building(self, scan: str) -> _eyes.BuildingEyes:
        if scan not in self._open:
            self._open[scan] = self._opened(scan)
        return self._open[scan]

    def _opened(self, scan: str) -> _eyes.BuildingEyes:
        if scan in self._files:
            return _eyes.of_mesh(os.fspath(self._files[scan]), self._up, self._threads)
        if self._data is None:
            raise UnknownNameError(f"scan '{scan}': none of the {len(self._files)} meshes is of it")
        kept = "" if self._light is None else os.fspath(Path(self._light, f"{scan}.light"))
        return _eyes.of_home(self._data, scan, kept, self._spacing, self._threads)


def _size(layer: str, size: Size) -> Size:
    width, height = (whole(f"size of {layer}", pixels, 8192) for pixels in size)
    if width == 0 or height == 0:
        raise ArgumentError(f"size of {layer}: {width} x {height} pixels, at least 1 x 1")
    return width, height


def _mesh_files(meshes: Union[PathLike, Mapping[str, PathLike]]) -> dict[str, PathLike]:
    if isinstance(meshes, Mapping):
        return dict(meshes)
    # The first suffix counts where a scan has several files.
    try:
        folder = Path(meshes)
        own = [file for file in folder.glob("*/*") if file.stem == file.parent.name]
        found = sorted([*own, *folder.iterdir()], key=lambda file: -_rank(file))
    except OSError as error:
        raise FileError(f"{os.fspath(meshes)}: {error.strerror} (looked for meshes there)") from error
    return {file.stem: file for file in found if file.suffix in _SUFFIXES}


def _rank(file: Path) -> int:
    return _SUFFIXES.index(file.suffix) if file.suffix in _SUFFIXES else len(_SUFFIXES)
