"""Vectors of float32 numbers, and of integers."""

from __future__ import annotations

import operator
from typing import Any, Iterator, TypeVar

import numpy as np
from numpy.typing import NDArray

Own = TypeVar("Own", bound="Vector")


class _Component:
    """One number of a vector, as an attribute."""

    def __init__(self, index: int) -> None:
        self._index = index

    def __get__(self, instance: Any, owner: Any = None) -> Any:
        return self if instance is None else instance[self._index]

    def __set__(self, instance: Any, value: float) -> None:
        instance[self._index] = value


class Vector:
    """A few numbers. np.array() makes an array of it; two are equal if their numbers differ by less than
    1e-5, also relative to their size."""

    _size = 0
    _type: Any = np.float32

    def __init__(self, *values: Any) -> None:
        """Of nothing (zeros), of one number, of as many numbers, or of a vector, an array or a sequence."""
        self._numbers: NDArray[Any] = np.zeros(self._size, self._type)
        if not values:
            return
        given = np.asarray(values[0] if len(values) == 1 else values)
        if given.dtype.kind not in "fiu" or given.shape not in ((), (self._size,)):
            raise TypeError(f"{type(self).__name__}{values!r}: one or {self._size} numbers are wanted")
        if self._type is not np.float32 and given.dtype.kind == "f":
            raise TypeError(f"{type(self).__name__}{values!r}: integers are wanted")
        self._numbers[:] = given

    @classmethod
    def zero_init(cls: type[Own]) -> Own:
        """Zeros."""
        return cls()

    def __array__(self, dtype: Any = None, copy: Any = None) -> NDArray[Any]:
        return np.array(self._numbers, dtype)

    def __len__(self) -> int:
        return self._size

    def __iter__(self) -> Iterator[Any]:
        return iter(self._numbers.tolist())

    def _at(self, index: Any) -> int:
        number = operator.index(index)
        if not -self._size <= number < self._size:
            raise IndexError(f"index {number}: {type(self).__name__} has {self._size} numbers")
        return number

    def __getitem__(self, index: int) -> Any:
        return self._numbers[self._at(index)].item()

    def __setitem__(self, index: int, value: float) -> None:
        self._numbers[self._at(index)] = value

    def __repr__(self) -> str:
        return f"Vector({', '.join(f'{x:g}' for x in self)})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Vector) or len(other) != self._size:
            return NotImplemented
        return bool(np.allclose(self._numbers, other._numbers, rtol=1e-5, atol=1e-5))

    __hash__ = None  # type: ignore[assignment]

    def tolist(self) -> list[Any]:
        """The numbers, as of an array."""
        numbers: list[Any] = self._numbers.tolist()
        return numbers

    def dot(self) -> Any:
        """The square of the length. magnum.math.dot() is the product of two."""
        return (self._numbers @ self._numbers).item()

    def length(self) -> float:
        """The length."""
        return float(np.sqrt(self._numbers @ self._numbers))

    def normalized(self: Own) -> Own:
        """The vector of length 1 in the same direction."""
        return type(self)(self._numbers / np.sqrt(self._numbers @ self._numbers))

    def is_normalized(self) -> bool:
        """Whether the length is 1."""
        return bool(abs(self.dot() - 1) < 2e-5)

    def sum(self) -> Any:
        """The sum of the numbers."""
        return self._numbers.sum().item()

    def __neg__(self: Own) -> Own:
        return type(self)(-self._numbers)

    def __add__(self: Own, other: Any) -> Own:
        return type(self)(self._numbers + type(self)(other)._numbers)

    def __sub__(self: Own, other: Any) -> Own:
        return type(self)(self._numbers - type(self)(other)._numbers)

    def __mul__(self: Own, other: Any) -> Own:
        return type(self)(self._numbers * type(self)(other)._numbers)

    __rmul__ = __mul__

    def __truediv__(self: Own, other: Any) -> Own:
        return type(self)((self._numbers / type(self)(other)._numbers).astype(self._type))


class Vector2(Vector):
    """Two numbers."""

    _size = 2
    x, y = _Component(0), _Component(1)


class Vector2i(Vector):
    """Two integers: height and width of images."""

    _size = 2
    _type = np.int32
    x, y = _Component(0), _Component(1)


class Vector3(Vector):
    """Three numbers: a point or direction."""

    _size = 3
    x, y, z = _Component(0), _Component(1), _Component(2)

    @staticmethod
    def x_axis(length: float = 1.0) -> Vector3:
        """A vector along x."""
        return Vector3(length, 0.0, 0.0)

    @staticmethod
    def y_axis(length: float = 1.0) -> Vector3:
        """A vector along y."""
        return Vector3(0.0, length, 0.0)

    @staticmethod
    def z_axis(length: float = 1.0) -> Vector3:
        """A vector along z."""
        return Vector3(0.0, 0.0, length)


class Vector4(Vector):
    """Four numbers."""

    _size = 4
    x, y, z, w = _Component(0), _Component(1), _Component(2), _Component(3)


class Color3(Vector3):
    """Red, green and blue, from 0 to 1."""

    r, g, b = _Component(0), _Component(1), _Component(2)


class Color4(Vector4):
    """Red, green, blue and opacity, from 0 to 1."""

    r, g, b, a = _Component(0), _Component(1), _Component(2), _Component(3)

    def __init__(self, *values: Any) -> None:
        """As of other vectors; of three numbers, an opaque colour."""
        super().__init__(*values, *([1.0] if len(values) == 3 else []))
