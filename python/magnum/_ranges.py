"""Boxes along the axes."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

import numpy as np

from magnum._vectors import Vector2, Vector3

Corner = TypeVar("Corner", Vector2, Vector3)


class _Range(Generic[Corner]):
    """A box from `min` to `max`."""

    _corner: type[Corner]

    def __init__(self, low: Any = 0.0, high: Any = 0.0) -> None:
        self.min: Corner = self._corner(low)
        self.max: Corner = self._corner(high)

    def center(self) -> Corner:
        """The middle."""
        return (self.min + self.max) / 2.0

    def size(self) -> Corner:
        """The extent along each axis."""
        return self.max - self.min

    def contains(self, point: Any) -> bool:
        """Whether a point is inside; the upper sides are outside."""
        place = np.asarray(self._corner(point))
        return bool((np.asarray(self.min) <= place).all() and (place < np.asarray(self.max)).all())

    def __repr__(self) -> str:
        low, high = (", ".join(f"{x:g}" for x in corner) for corner in (self.min, self.max))
        return f"Range({{{low}}}, {{{high}}})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        return self.min == other.min and self.max == other.max

    __hash__ = None  # type: ignore[assignment]


class Range2D(_Range[Vector2]):
    """A rectangle."""

    _corner = Vector2


class Range3D(_Range[Vector3]):
    """A box."""

    _corner = Vector3
