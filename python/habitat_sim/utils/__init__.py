"""Rotations, hooks of profilers, and downloads, which are not there."""

from __future__ import annotations

from habitat_sim.utils import common, datasets_download, profiling_utils
from habitat_sim.utils.common import (
    angle_between_quats,
    d3_40_colors_hex,
    d3_40_colors_rgb,
    orthonormalize_rotation_shear,
    quat_from_angle_axis,
    quat_from_coeffs,
    quat_from_magnum,
    quat_from_two_vectors,
    quat_rotate_vector,
    quat_to_angle_axis,
    quat_to_coeffs,
    quat_to_magnum,
    random_quaternion,
)

__all__ = [
    "angle_between_quats", "common", "d3_40_colors_hex", "d3_40_colors_rgb", "datasets_download",
    "orthonormalize_rotation_shear", "profiling_utils", "quat_from_angle_axis", "quat_from_coeffs", "quat_from_magnum", "quat_from_two_vectors",
    "quat_rotate_vector", "quat_to_angle_axis", "quat_to_coeffs", "quat_to_magnum", "random_quaternion",
]  # fmt: skip
