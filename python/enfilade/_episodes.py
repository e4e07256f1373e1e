"""Episodes of every benchmark, and scores of results."""

from __future__ import annotations

import importlib
import json
import operator
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Optional, Sequence, Union, overload

from enfilade._arguments import whole
from enfilade._core import DatasetFolder, EpisodeSet, Graphs
from enfilade._errors import UnknownNameError
from enfilade.goals import Goal, Hidden, of_tuple

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray


_ABOUT = ("instruction_id", "path_id", "group", "scan", "language")


@dataclass(frozen=True)
class TimedWord:
    """A spoken word with its times (RxR)."""

    word: str
    start: Optional[float]  #: seconds since the recording began; None if the file has none
    end: Optional[float]


@dataclass(frozen=True)
class Turn:
    """One message of a dialogue (CVDN)."""

    role: str  #: "navigator" or "oracle"
    message: str
    nav_step: int  #: steps of the navigator before the message


@dataclass(frozen=True)
class SubInstruction:
    """A part of an instruction, and the part of the path that it describes (fine-grained R2R)."""

    words: tuple[str, ...]
    places: Optional[tuple[int, int]]  #: first and last index on the path, from 0; None in test splits


@dataclass(frozen=True)
class Episode:
    """An episode: one instruction, its start and its goal."""

    instruction_id: str  #: the instr_id of results files; in R2R "<path_id>_<k>"
    path_id: int
    scan: str
    path: tuple[str, ...]  #: viewpoint ids, start to goal; only the start if the goal is hidden
    heading: float  #: at the start, radians
    text: str  #: the instruction; in CVDN the turns and the target in one text
    # Fields of some benchmarks only.
    goal: Goal = field(default_factory=Hidden)  #: one of enfilade.goals
    group: int = 0  #: equal for paths that are not independent samples
    language: str = ""  #: "en-IN"
    words: tuple[TimedWord, ...] = ()
    turns: tuple[Turn, ...] = ()
    parts: tuple[SubInstruction, ...] = ()
    tokens: tuple[int, ...] = ()  #: `instr_encoding(s)` of the file: token ids of BERT or XLM-R
    fields: Mapping[str, str] = field(default_factory=dict)  #: SOON: obj_name, attribute, ...


@dataclass(frozen=True)
class Score:
    """The score of a results file."""

    means: dict[str, tuple[float, float, float]]  #: mean and 95 % interval by metric
    episodes: dict[str, dict[str, float]]  #: by instruction id and metric
    warnings: list[str]
    task: str = "r2r"
    scorer: str = "enfilade"  #: the scorer's name: see scorers()
    #: Per scored episode, in order: instruction_id, path_id, group, scan, language.
    about: tuple[dict[str, Any], ...] = ()

    def to_pandas(self) -> Any:
        """A pandas DataFrame with one row per episode, indexed by instruction_id: path_id, group, scan,
        language, then the metrics. Raises ImportError without pandas."""
        pandas = importlib.import_module("pandas")
        rows = [{**about, **self.episodes[about["instruction_id"]]} for about in self.about]
        return pandas.DataFrame(rows).set_index("instruction_id")


class Episodes(Sequence[Episode]):
    """The episodes of a split of a data folder, in the order of the file.

    >>> episodes = enfilade.Episodes("data", "val_unseen", task="reverie")
    >>> episodes[0].text, episodes["1357_66_0"].goal

    Args:
        folder: holds annotations and `connectivity/`, in Enfilade's layout, in the public code's, or
            side by side.
        split: "train", "val_seen", "val_unseen", "test"; other names if a benchmark has them.
        task: "r2r", "r2r-last", "r2r-back", "r4r", "rxr", "reverie", "cvdn", "soon".
        all_instructions: R2R: fourth instructions too, which are for training and are not scored.
        file: annotations in any form that the task's public code reads; None: searched in the folder.

    Unpickling or copying reads the files again. Raises FileError for a folder without such a split,
    UnknownNameError for an unknown task, InvalidInput with the faults of a file (up to 1000).
    """

    def __init__(
        self,
        folder: Union[str, os.PathLike[str]],
        split: str,
        *,
        task: str = "r2r",
        all_instructions: bool = False,
        file: Union[None, str, os.PathLike[str]] = None,
    ) -> None:
        self._open(DatasetFolder(folder), split, task, all_instructions, file)

    def _open(
        self,
        dataset: DatasetFolder,
        split: str,
        task: str,
        all_instructions: bool,
        file: Union[None, str, os.PathLike[str]],
    ) -> None:
        self._core = EpisodeSet(dataset, task, split, all_instructions, file)
        self._graphs = dataset.graphs
        self._graphs._folder = os.fspath(dataset.folder)  # type: ignore[attr-defined]  # to pickle them
        self._made = (os.fspath(dataset.folder), split, task, all_instructions, file)
        self.split = split

    @classmethod
    def _of_dataset(
        cls,
        dataset: DatasetFolder,
        split: str,
        task: str,
        all_instructions: bool,
        file: Union[None, str, os.PathLike[str]],
    ) -> Episodes:
        episodes = cls.__new__(cls)
        episodes._open(dataset, split, task, all_instructions, file)
        return episodes

    def __reduce__(self) -> tuple[Any, ...]:
        return _read_again, self._made

    @property
    def task(self) -> str:
        """The benchmark's name: "r2r"."""
        return self._core.task

    @property
    def graphs(self) -> Graphs:
        """The navigation graphs."""
        return self._graphs

    def __len__(self) -> int:
        return len(self._core)

    @overload
    def __getitem__(self, index: Union[int, str]) -> Episode: ...
    @overload
    def __getitem__(self, index: slice) -> list[Episode]: ...
    def __getitem__(self, index: Union[int, str, slice]) -> Union[Episode, list[Episode]]:
        """The episode at an index, or with an instruction id. Raises IndexError, UnknownNameError."""
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        if isinstance(index, str):
            return _episode(self._core.episode(self.place(index)))
        place = operator.index(index)
        if not -len(self) <= place < len(self):
            raise IndexError(f"episode {place}: the split {self.split} has {len(self)}")
        return _episode(self._core.episode(place % len(self)))

    def __iter__(self) -> Iterator[Episode]:
        return (self[i] for i in range(len(self)))

    def __contains__(self, value: object) -> bool:
        """Whether the split has an instruction id, or an Episode."""
        if isinstance(value, str):
            return self._core.find(value) is not None
        return super().__contains__(value)

    def place(self, instruction_id: str) -> int:
        """The index of an instruction. Raises UnknownNameError."""
        found = self._core.find(instruction_id)
        if found is None:
            raise UnknownNameError(
                f"instruction '{instruction_id}' is not one of the {len(self)} of split {self.split}"
            )
        return found

    def score(
        self,
        results: Union[str, os.PathLike[str], Iterable[Mapping[str, Any]]],
        *,
        scorer: str = "",
        success_distance: float = 3.0,
        bootstrap_samples: int = 1000,
        part: bool = False,
    ) -> Score:
        """Checks and scores results.

        Args:
            results: a file in any of the known formats; or the same in memory: dicts with "instr_id",
                "trajectory" and the task's answers ("pred_objid", ...).
            scorer: a name of scorers(task); for R2R also "enfilade", its default. Other tasks' default
                is the scorer behind the published tables.
            success_distance: metres along the graph; a stop nearer to the goal is a success. Other
                values than 3 need the scorer "enfilade".
            bootstrap_samples: for the intervals of the means; 0: no intervals.
            part: accept results that do not cover every instruction.

        Raises FileError, ArgumentError, and InvalidInput with the faults of the results (up to 1000).
        """
        samples = whole("bootstrap_samples", bootstrap_samples, 10**6)
        file, text = None, ""
        if isinstance(results, (str, os.PathLike)):
            file = results
        else:
            text = json.dumps(list(results), default=_plain)
        name, columns, means, values, places, warnings = self._core.score(
            file, text, scorer, success_distance, samples, part
        )
        about = tuple(self._about(place) for place in places)
        each = {
            row["instruction_id"]: dict(zip(columns, numbers))
            for row, numbers in zip(about, values.tolist())
        }
        return Score(means, each, warnings, self.task, name, about)

    def _about(self, place: int) -> dict[str, Any]:
        return dict(zip(_ABOUT, self._core.about(place)))

    def score_paths(
        self,
        trajectories: Sequence[Any],
        *,
        answers: Optional[Sequence[Any]] = None,
        scorer: str = "",
        places: Optional[Sequence[int]] = None,
    ) -> dict[str, NDArray[float64]]:
        """The metrics of trajectories: {metric: (n,) array}; see enfilade.score_paths().

        Args:
            trajectories: n rows of viewpoint ids or indices.
            answers: as in enfilade.score_paths().
            places: (n,) indices of their episodes; None: all episodes, in order.
        """
        from enfilade._scores import score_paths

        chosen = self[:] if places is None else [self[place] for place in places]
        return score_paths(
            self.graphs,
            [episode.scan for episode in chosen],
            trajectories,
            [episode.path for episode in chosen],
            task=self.task,
            scorer=scorer,
            goals=[episode.goal for episode in chosen],
            answers=answers,
        )


def _read_again(
    folder: str,
    split: str,
    task: str,
    all_instructions: bool,
    file: Union[None, str, os.PathLike[str]],
) -> Episodes:
    return Episodes(folder, split, task=task, all_instructions=all_instructions, file=file)


def _episode(row: tuple[Any, ...]) -> Episode:
    instruction_id, path_id, scan, path, heading, text, goal, group, details = row
    language, words, turns, parts, tokens, fields = details
    return Episode(
        instruction_id, path_id, scan, path, heading, text,
        of_tuple(goal), group, language,
        tuple(TimedWord(*word) for word in words),
        tuple(Turn(*turn) for turn in turns),
        tuple(SubInstruction(*part) for part in parts),
        tokens, dict(fields),
    )  # fmt: skip


def _plain(value: Any) -> Any:
    """Converts NumPy's and torch's numbers and arrays for JSON."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (set, frozenset)) or not hasattr(value, "__iter__"):
        raise TypeError(f"results: a {type(value).__name__} cannot be part of them")
    return list(value)
