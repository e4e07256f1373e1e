"""Rotations of numpy-quaternion, which act on vectors of Habitat's frame."""

from __future__ import annotations

import math
from typing import Any

import magnum as mn
import numpy as np
from numpy.typing import ArrayLike, NDArray

from habitat_sim._missing import refused
from habitat_sim._rotations import Quaternion, to_quaternion

__all__ = [
    "angle_between_quats", "d3_40_colors_hex", "d3_40_colors_rgb", "orthonormalize_rotation_shear",
    "quat_from_angle_axis", "quat_from_coeffs", "quat_from_magnum", "quat_from_two_vectors",
    "quat_rotate_vector", "quat_to_angle_axis", "quat_to_coeffs", "quat_to_magnum", "random_quaternion",
]  # fmt: skip


def quat_from_coeffs(coeffs: ArrayLike) -> Any:
    """The rotation of four numbers x, y, z, w."""
    return to_quaternion(np.asarray(coeffs))


def quat_to_coeffs(quat: Any) -> NDArray[np.float64]:
    """Its four numbers x, y, z, w."""
    return np.array([quat.x, quat.y, quat.z, quat.w])


def quat_from_magnum(quat: mn.Quaternion) -> Any:
    """The rotation of a magnum.Quaternion."""
    return to_quaternion(quat.xyzw)


def quat_to_magnum(quat: Any) -> mn.Quaternion:
    """Its magnum.Quaternion."""
    return mn.Quaternion((quat.x, quat.y, quat.z), quat.w)


def quat_from_angle_axis(theta: float, axis: ArrayLike) -> Any:
    """The turn by an angle, radians, about an axis of any length."""
    direction = np.asarray(axis, np.float64)
    x, y, z = math.sin(theta / 2) * direction / np.linalg.norm(direction)
    return Quaternion(math.cos(theta / 2), x, y, z)


def quat_to_angle_axis(quat: Any) -> tuple[float, NDArray[np.float64]]:
    """The angle, radians, 0 to 2 pi, and the axis of a rotation; x for one that turns nothing."""
    vector = np.array([quat.x, quat.y, quat.z])
    sine = float(np.linalg.norm(vector))
    if sine < 1e-12:
        return 0.0, np.array([1.0, 0.0, 0.0])
    return 2 * math.atan2(sine, quat.w), vector / sine


def quat_from_two_vectors(v0: ArrayLike, v1: ArrayLike) -> Any:
    """The shortest turn from one direction to another."""
    a, b = (np.asarray(v, np.float64) / np.linalg.norm(np.asarray(v, np.float64)) for v in (v0, v1))
    cosine = float(a @ b)
    if cosine < -1 + 1e-8:  # about any axis at right angles
        least = np.eye(3)[np.argmin(np.abs(a))]
        return quat_from_angle_axis(math.pi, np.cross(a, least))
    return Quaternion(1 + cosine, *np.cross(a, b)).normalized()


def quat_rotate_vector(quat: Any, v: ArrayLike) -> NDArray[np.float64]:
    """A vector, turned."""
    turned = quat * Quaternion(0, *np.asarray(v, np.float64)) * quat.inverse()
    return np.array([turned.x, turned.y, turned.z])


def angle_between_quats(q1: Any, q2: Any) -> float:
    """The angle of the turn from one rotation to another, radians, 0 to pi."""
    turn = q1.inverse() * q2
    return 2 * math.atan2(float(np.linalg.norm([turn.x, turn.y, turn.z])), abs(turn.w))


def random_quaternion() -> Any:
    """A random rotation, of NumPy's global generator."""
    x, y, z, w = np.random.standard_normal(4)
    return Quaternion(w, x, y, z).normalized()


d3_40_colors_hex = refused(
    "habitat_sim.utils.common.d3_40_colors_hex", "Enfilade has no table of colours"
)
d3_40_colors_rgb = refused(
    "habitat_sim.utils.common.d3_40_colors_rgb", "Enfilade has no table of colours"
)
orthonormalize_rotation_shear = refused(
    "habitat_sim.utils.common.orthonormalize_rotation_shear",
    "Enfilade has no scaled nodes; use numpy.linalg.svd",
)
