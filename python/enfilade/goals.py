"""What an episode asks for: a class for each kind of goal, as `Episode.goal` has them.

Viewpoints are ids; headings and elevations radians, world frame.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Union


@dataclass(frozen=True)
class NearEnd:
    """To stop near the path's last viewpoint: R2R, R2R-Last, R4R, RxR."""

    viewpoint: str


@dataclass(frozen=True)
class Hidden:
    """The file does not say: test splits. Such episodes can be walked and not scored."""


@dataclass(frozen=True)
class TurningPoint:
    """R2R-Back: to go there, to say where that is, and to come back."""

    viewpoint: str


@dataclass(frozen=True)
class Object:
    """REVERIE: to end where the object is seen, and to name it."""

    id: int
    seen_from: tuple[str, ...] = ()  #: empty if no viewpoint sees it


@dataclass(frozen=True)
class Region:
    """CVDN: to come nearer to any viewpoint of a region."""

    viewpoints: tuple[str, ...]
    player: tuple[str, ...] = ()  #: the navigator's next steps; may be empty
    planner: tuple[str, ...] = ()  #: the way that the oracle saw; may be empty


@dataclass(frozen=True)
class Box:
    """An object in a viewpoint's panorama: four corners, (heading, elevation) each."""

    viewpoint: str
    centre: tuple[float, float]
    corners: tuple[tuple[float, float], ...]  #: left top, right top, right bottom, left bottom


@dataclass(frozen=True)
class Boxes:
    """SOON: to end at a viewpoint that has a box, and to point into it."""

    boxes: tuple[Box, ...]
    first_alternative: tuple[str, ...] = ()  #: what the released scorer compares with; empty: the path


Goal = Union[NearEnd, Hidden, TurningPoint, Object, Region, Boxes]
"""Any of them."""

_KINDS: dict[str, Any] = {
    kind.__name__: kind for kind in (NearEnd, Hidden, TurningPoint, Object, Region)
}


def of_tuple(row: tuple[Any, ...]) -> Goal:
    """From the core's form: the name of a class, then its fields."""
    if row[0] == "Boxes":
        return Boxes(tuple(Box(*box) for box in row[1]), row[2])
    goal: Goal = _KINDS[row[0]](*row[1:])
    return goal


def to_tuple(goal: Any) -> tuple[Any, ...]:
    """To the core's form. Raises TypeError for what is no goal."""
    if not is_dataclass(goal) or type(goal).__module__ != __name__ or isinstance(goal, (type, Box)):
        raise TypeError(f"goal {goal!r}: one of enfilade.goals is wanted")
    if isinstance(goal, Boxes):
        boxes = tuple((box.viewpoint, box.centre, box.corners) for box in goal.boxes)
        return ("Boxes", boxes, goal.first_alternative)
    return (type(goal).__name__, *(getattr(goal, field.name) for field in fields(goal)))
