"""Metrics of every benchmark as functions of trajectories."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Union

from enfilade import _core
from enfilade._core import Graphs
from enfilade._errors import ArgumentError
from enfilade.goals import to_tuple

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray

    from enfilade.goals import Goal


@dataclass(frozen=True)
class Scorer:
    """A public scorer of a benchmark's results (docs/tasks.md)."""

    task: str
    name: str  #: "official", "duet", "hamt", ...
    source: str  #: repository and commit with which its numbers were compared
    metrics: tuple[str, ...]  #: per episode, by that code's names
    means: tuple[str, ...]  #: per set of results


def scorers(task: str) -> list[Scorer]:
    """The scorers of a task, the one behind the published tables first. Raises UnknownNameError."""
    return [Scorer(task, *row) for row in _core.scorers(task)]


def score_paths(
    graphs: Graphs,
    scans: Union[str, Sequence[str]],
    trajectories: Sequence[Any],
    references: Sequence[Any],
    *,
    task: str = "r2r",
    scorer: str = "",
    goals: Optional[Sequence[Goal]] = None,
    answers: Optional[Sequence[Any]] = None,
) -> dict[str, NDArray[float64]]:
    """The metrics of n paths by the formulas of a public scorer: {metric: (n,) array}.

    >>> enfilade.score_paths(graphs, scan, [walked], [episode.path], task="r4r")["CLS"]

    Args:
        scans: n names, or one for all.
        trajectories: n trajectories of viewpoint ids; or (n, m) indices into Graph.viewpoints, rows
            padded with -1.
        references: n reference paths, likewise.
        task: see scorers().
        scorer: its name; "": the first of the task.
        goals: n of enfilade.goals; None: the ends of the reference paths.
        answers: n, or None. REVERIE: ids of the named objects; SOON: points, heading / 2 pi and
            (elevation + pi) / 2 pi; R2R-Back: turning points. None for no answer.

    A metric without a value is NaN. Raises UnknownNameError, and ArgumentError for paths without
    viewpoints, arguments of different lengths, or goals of another task.
    """
    import numpy as np

    walked, wanted = list(trajectories), list(references)
    n = len(walked)
    names = [scans] * n if isinstance(scans, str) else list(scans)
    asked: list[Any] = [None] * n if goals is None else [to_tuple(goal) for goal in goals]
    said = [None] * n if answers is None else [_answer(answer) for answer in answers]
    for what, given in (("scans", names), ("references", wanted), ("goals", asked), ("answers", said)):
        if len(given) != n:
            raise ArgumentError(f"{what}: {len(given)} for {n} trajectories")
    if ("Hidden",) in asked:
        hidden = asked.index(("Hidden",))
        raise ArgumentError(f"goals: element {hidden} is hidden, so there is no score")
    chosen = scorers(task)[0] if not scorer else next(
        (one for one in scorers(task) if one.name == scorer), None
    )  # fmt: skip
    # The core's error lists the known scorers.
    values = _core.score_paths(graphs, task, scorer if chosen is None else chosen.name, names, walked,
                               wanted, asked, said)  # fmt: skip
    columns = chosen.metrics if chosen is not None else ()
    return {name: np.ascontiguousarray(values[:, k]) for k, name in enumerate(columns)}


def _answer(answer: Any) -> Any:
    """REVERIE's object ids may be numbers of any type."""
    return answer.item() if hasattr(answer, "item") and getattr(answer, "ndim", 1) == 0 else answer
