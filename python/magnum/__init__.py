"""A drop-in for what of `magnum` navigation with Habitat uses: vectors, quaternions, angles, boxes.

Numbers are float32. Names for drawing and for robots can be imported, inherited and annotated with; using one
raises NotImplementedError. See docs/python_habitat_sim.md.
"""

from __future__ import annotations

from magnum import math, trade
from magnum._angles import Deg, Rad
from magnum._ranges import Range2D, Range3D
from magnum._refused import refused
from magnum._rotations import Matrix3, Matrix4, Quaternion
from magnum._vectors import Color3, Color4, Vector2, Vector2i, Vector3, Vector4

MutableImageView2D = refused(
    "magnum.MutableImageView2D",
    "images are numpy arrays here, as get_sensor_observations() returns them",
)

__all__ = [
    "Color3", "Color4", "Deg", "Matrix3", "Matrix4", "MutableImageView2D", "Quaternion", "Rad", "Range2D",
    "Range3D", "Vector2", "Vector2i", "Vector3", "Vector4", "math", "trade",
]  # fmt: skip
