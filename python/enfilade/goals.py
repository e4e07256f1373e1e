"""Goals of episodes (`Episode.goal`), one class per kind.

Viewpoints are ids; headings and elevations are radians, world frame.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Union


@dataclass(frozen=True)
class NearEnd:
    """Stop near the path's last viewpoint: R2R, R2R-Last, R4R, RxR."""

    viewpoint: str


@dataclass(frozen=True)
class Hidden:
    """Not in the file: test splits. Such episodes can be run but not scored."""


@dataclass(frozen=True)
class TurningPoint:
    """R2R-Back: go to this viewpoint, name it, and return."""

    viewpoint: str


@dataclass(frozen=True)
class Object:
    """REVERIE: end at a viewpoint that shows the object, and name it."""

    id: int
    seen_from: tuple[str, ...] = ()  #: viewpoints that show it; empty if none does


@dataclass(frozen=True)
class Region:
    """CVDN: come nearer to any viewpoint of a region."""

    viewpoints: tuple[str, ...]
    player: tuple[str, ...] = ()  #: the navigator's next steps; may be empty
    planner: tuple[str, ...] = ()  #: the path shown to the oracle; may be empty


@dataclass(frozen=True)
class Box:
    """An object in a viewpoint's panorama; centre and corners are (heading, elevation)."""

    viewpoint: str
    centre: tuple[float, float]
    corners: tuple[tuple[float, float], ...]  #: left top, right top, right bottom, left bottom


@dataclass(frozen=True)
class Boxes:
    """SOON: end at a viewpoint that has a box, and point into it."""

    boxes: tuple[Box, ...]
    first_alternative: tuple[str, ...] = ()  #: the released scorer's reference; empty: the path


Goal = Union[NearEnd, Hidden, TurningPoint, Object, Region, Boxes]
"""Any of these classes."""

_KINDS: dict[str, Any] = {
    kind.__name__: kind for kind in (NearEnd, Hidden, TurningPoint, Object, Region)
}


def of_tuple(row: tuple[Any, ...]) -> Goal:
    """A goal from the core's form: the class's name, then its fields."""
    if row[0] == "Boxes":
        return Boxes(tuple(Box(*box) for box in row[1]), row[2])
    goal: Goal = _KINDS[row[0]](*row[1:])
    return goal


def to_tuple(goal: Any) -> tuple[Any, ...]:
    """The core's form of a goal. Raises TypeError for other objects."""
    if not is_dataclass(goal) or type(goal).__module__ != __name__ or isinstance(goal, (type, Box)):
        raise TypeError(f"goal {goal!r}: one of enfilade.goals is wanted")
    if isinstance(goal, Boxes):
        boxes = tuple((box.viewpoint, box.centre, box.corners) for box in goal.boxes)
        return ("Boxes", boxes, goal.first_alternative)
    return (type(goal).__name__, *(getattr(goal, field.name) for field in fields(goal)))
