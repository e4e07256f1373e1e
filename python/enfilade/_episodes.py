"""Room-to-Room's episodes, and how well they were followed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Sequence, Union, overload

from enfilade._core import EpisodeSet, Graphs


@dataclass(frozen=True)
class Episode:
    """One instruction to follow."""

    instruction_id: str  #: "<path_id>_<k>": the instr_id of results files
    path_id: int
    scan: str
    path: tuple[str, ...]  #: viewpoint ids, start to goal; the start only if the goal is hidden
    heading: float  #: of the start, radians
    text: str  #: the instruction


@dataclass(frozen=True)
class Score:
    """A results file, scored."""

    means: dict[str, tuple[float, float, float]]  #: mean and 95 % interval by metric
    episodes: dict[str, dict[str, float]]  #: by instruction id and metric
    warnings: list[str]


class Episodes(Sequence[Episode]):
    """The episodes of a split of a data folder, in the order of the file.

    >>> episodes = enfilade.Episodes("data", "val_unseen")
    >>> episodes[0].text

    Args:
        folder: holds `r2r/R2R_<split>.json` and `connectivity/`, or a checkout of
            Matterport3DSimulator's layout.
        split: "train", "val_seen", "val_unseen", "test".
        all_instructions: fourth instructions too, which are trained on but not scored.
    """

    def __init__(self, folder: str, split: str, *, all_instructions: bool = False) -> None:
        self._core = EpisodeSet(folder, split, all_instructions)
        self.split = split

    @property
    def graphs(self) -> Graphs:
        """The buildings."""
        return self._core.graphs

    def __len__(self) -> int:
        return len(self._core)

    @overload
    def __getitem__(self, index: int) -> Episode: ...
    @overload
    def __getitem__(self, index: slice) -> list[Episode]: ...
    def __getitem__(self, index: Union[int, slice]) -> Union[Episode, list[Episode]]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        if index < 0:
            index += len(self)
        if index < 0:
            raise IndexError("episode")
        return Episode(*self._core.episode(index))

    def __iter__(self) -> Iterator[Episode]:
        return (self[i] for i in range(len(self)))

    def score(
        self, file: str, *, success_distance: float = 3.0, bootstrap_samples: int = 1000
    ) -> Score:
        """Checks and scores a results file, in any of the forms found in the wild.

        Raises InvalidInput with every fault of the file.
        """
        return Score(*self._core.score(file, success_distance, bootstrap_samples))
