"""Room-to-Room's episodes, and scores of results."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Union, overload

from enfilade._arguments import whole
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
        all_instructions: fourth instructions too, which are for training and not scored.

    Raises FileError for a folder without such a split, InvalidInput with the faults of its file
    (up to 1000).
    """

    def __init__(
        self, folder: Union[str, os.PathLike[str]], split: str, *, all_instructions: bool = False
    ) -> None:
        self._core = EpisodeSet(folder, split, all_instructions)
        self.split = split

    @property
    def graphs(self) -> Graphs:
        """The navigation graphs."""
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
        place = operator.index(index)
        if not -len(self) <= place < len(self):
            raise IndexError(f"episode {place}: the split {self.split} has {len(self)}")
        return Episode(*self._core.episode(place % len(self)))

    def __iter__(self) -> Iterator[Episode]:
        return (self[i] for i in range(len(self)))

    def score(
        self,
        file: Union[str, os.PathLike[str]],
        *,
        success_distance: float = 3.0,
        bootstrap_samples: int = 1000,
    ) -> Score:
        """Checks and scores a results file, in any of the known formats.

        Args:
            success_distance: metres along the graph, less than which a stop is a success.
            bootstrap_samples: for the intervals of the means; 0: no intervals.

        Raises FileError, and InvalidInput with the faults of the file (up to 1000).
        """
        samples = whole("bootstrap_samples", bootstrap_samples, 10**6)
        return Score(*self._core.score(file, success_distance, samples))
