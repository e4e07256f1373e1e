"""Functions of vectors and boxes."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np

from magnum._angles import Rad
from magnum._ranges import Range2D, Range3D
from magnum._vectors import Vector, Vector3

Box = TypeVar("Box", Range2D, Range3D)

__all__ = ["angle", "cross", "dot", "join"]


def dot(a: Vector, b: Vector) -> Any:
    """The product of two vectors."""
    return (np.asarray(a) @ np.asarray(b)).item()


def cross(a: Vector3, b: Vector3) -> Vector3:
    """The vector at right angles to two others."""
    return Vector3(np.cross(np.asarray(a), np.asarray(b)))


def angle(a: Vector, b: Vector) -> Rad:
    """The angle between two vectors of length 1."""
    return Rad(float(np.arccos(np.clip(dot(a, b), -1, 1))))


def join(a: Box, b: Box) -> Box:
    """The smallest box around two."""
    low = np.minimum(np.asarray(a.min), np.asarray(b.min))
    high = np.maximum(np.asarray(a.max), np.asarray(b.max))
    return type(a)(low, high)
