"""Angles with a unit."""

from __future__ import annotations

import math
from typing import Any, TypeVar, Union

Own = TypeVar("Own", bound="_Angle")


class _Angle:
    """A number with a unit. Converts to float without changing the number."""

    _per_turn = 1.0

    def __init__(self, value: Union[float, _Angle] = 0.0) -> None:
        self._value: float
        if isinstance(value, _Angle):
            self._value = value._value * (self._per_turn / value._per_turn)
        else:
            self._value = float(value)

    def __float__(self) -> float:
        return self._value

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._value:g})"

    def _same(self, other: Any) -> float:
        """Another angle's number, in this unit."""
        if not isinstance(other, _Angle):
            raise TypeError(f"{other!r}: a Deg or Rad is wanted")
        return type(self)(other)._value

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _Angle):
            return NotImplemented
        return math.isclose(self._value, self._same(other), rel_tol=1e-6, abs_tol=1e-6)

    def __lt__(self, other: _Angle) -> bool:
        return self._value < self._same(other)

    def __gt__(self, other: _Angle) -> bool:
        return self._value > self._same(other)

    def __neg__(self: Own) -> Own:
        return type(self)(-self._value)

    def __add__(self: Own, other: _Angle) -> Own:
        return type(self)(self._value + self._same(other))

    def __sub__(self: Own, other: _Angle) -> Own:
        return type(self)(self._value - self._same(other))

    def __mul__(self: Own, number: float) -> Own:
        return type(self)(self._value * float(number))

    __rmul__ = __mul__

    def __truediv__(self: Own, number: float) -> Own:
        return type(self)(self._value / float(number))

    __hash__ = None  # type: ignore[assignment]


class Deg(_Angle):
    """An angle in degrees."""

    _per_turn = 360.0


class Rad(_Angle):
    """An angle in radians."""

    _per_turn = 2 * math.pi


Angle = Union[Deg, Rad]
