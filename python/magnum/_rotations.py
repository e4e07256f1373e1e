"""Rotations."""

from __future__ import annotations

import math
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from magnum._angles import Angle, Deg, Rad
from magnum._vectors import Vector3

OwnMatrix = TypeVar("OwnMatrix", bound="_Matrix")


class Quaternion:
    """A rotation: a vector and a scalar. Quaternion() turns nothing."""

    def __init__(self, vector: Any = (0.0, 0.0, 0.0), scalar: float = 1.0) -> None:
        """The scalar may also come with the vector, as a tuple of both."""
        if isinstance(vector, (tuple, list)) and len(vector) == 2:
            vector, scalar = vector
        self.vector, self.scalar = Vector3(vector), float(np.float32(scalar))

    @staticmethod
    def identity_init() -> Quaternion:
        """The rotation that turns nothing."""
        return Quaternion()

    @staticmethod
    def rotation(angle: Angle, axis: Any) -> Quaternion:
        """The turn about an axis of length 1."""
        if not isinstance(angle, (Deg, Rad)):
            raise TypeError(f"angle {angle!r}: a Deg or Rad is wanted")
        half = float(Rad(angle)) / 2
        return Quaternion(Vector3(axis) * math.sin(half), math.cos(half))

    @property
    def xyzw(self) -> tuple[float, float, float, float]:
        """The four numbers, the scalar last."""
        x, y, z = self.vector
        return x, y, z, self.scalar

    def __repr__(self) -> str:
        x, y, z, w = self.xyzw
        return f"Quaternion({{{x:g}, {y:g}, {z:g}}}, {w:g})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Quaternion):
            return NotImplemented
        return bool(np.allclose(self.xyzw, other.xyzw, rtol=1e-5, atol=1e-5))

    __hash__ = None  # type: ignore[assignment]

    def __neg__(self) -> Quaternion:
        return Quaternion(-self.vector, -self.scalar)

    def __mul__(self, other: Any) -> Quaternion:
        """The rotation `other`, then this one; or all four numbers times a number."""
        if not isinstance(other, Quaternion):
            return Quaternion(self.vector * other, self.scalar * other)
        a, b = np.asarray(self.vector), np.asarray(other.vector)
        turned = self.scalar * b + other.scalar * a + np.cross(a, b)
        return Quaternion(turned, self.scalar * other.scalar - float(a @ b))

    def dot(self) -> float:
        """The square of the length."""
        return float(np.float32(self.vector.dot() + self.scalar * self.scalar))

    def length(self) -> float:
        """The length; 1 for a rotation."""
        return math.sqrt(self.dot())

    def is_normalized(self) -> bool:
        """Whether the length is 1."""
        return abs(self.dot() - 1) < 2e-5

    def normalized(self) -> Quaternion:
        """The same rotation, of length 1."""
        return self * (1 / self.length())

    def conjugated(self) -> Quaternion:
        """With the vector turned round: the inverse of a rotation."""
        return Quaternion(-self.vector, self.scalar)

    def inverted(self) -> Quaternion:
        """The inverse."""
        return self.conjugated() * (1 / self.dot())

    def transform_vector(self, vector: Any) -> Vector3:
        """A vector, turned."""
        return (self * Quaternion(Vector3(vector), 0.0) * self.inverted()).vector

    def to_matrix(self) -> Matrix3:
        """The matrix that turns alike."""
        columns = [np.asarray(self.transform_vector(axis)) for axis in np.eye(3)]
        return Matrix3(np.stack(columns, axis=1))


class _Matrix:
    """A square matrix. np.array() makes an array of it, row by row; [i] is a column, as in Magnum."""

    _size = 0

    def __init__(self, rows: Any = None) -> None:
        numbers = np.eye(self._size) if rows is None else np.asarray(rows)
        if numbers.shape != (self._size, self._size):
            raise TypeError(f"{type(self).__name__}: {self._size} x {self._size} numbers are wanted")
        self._rows: NDArray[np.float32] = numbers.astype(np.float32)

    @classmethod
    def identity_init(cls: type[OwnMatrix]) -> OwnMatrix:
        """Ones on the diagonal."""
        return cls()

    def __array__(self, dtype: Any = None, copy: Any = None) -> NDArray[Any]:
        return np.array(self._rows, dtype)

    def __repr__(self) -> str:
        rows = (", ".join(f"{x:g}" for x in row) for row in self._rows)
        return f"Matrix({', '.join(f'{{{row}}}' for row in rows)})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        return bool(np.allclose(self._rows, other._rows, rtol=1e-5, atol=1e-5))

    __hash__ = None  # type: ignore[assignment]

    def __matmul__(self: OwnMatrix, other: OwnMatrix) -> OwnMatrix:
        return type(self)(self._rows @ other._rows)

    def transposed(self: OwnMatrix) -> OwnMatrix:
        """With rows for columns."""
        return type(self)(self._rows.T)

    def inverted(self: OwnMatrix) -> OwnMatrix:
        """The inverse."""
        return type(self)(np.linalg.inv(self._rows))


class Matrix3(_Matrix):
    """A rotation as a matrix."""

    _size = 3


class Matrix4(_Matrix):
    """A rotation and a translation as a matrix."""

    _size = 4

    def transform_point(self, point: Any) -> Vector3:
        """A point, turned and moved."""
        return Vector3(self._rows[:3, :3] @ np.asarray(Vector3(point)) + self._rows[:3, 3])

    def transform_vector(self, vector: Any) -> Vector3:
        """A direction, turned."""
        return Vector3(self._rows[:3, :3] @ np.asarray(Vector3(vector)))
