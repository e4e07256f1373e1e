"""Directions of Habitat's frame: x right, y up, z towards the viewer."""

from __future__ import annotations

from magnum import Vector3, Vector4

from habitat_sim._missing import PHYSICS, refused

UP = Vector3(0.0, 1.0, 0.0)
GRAVITY = -UP
FRONT = Vector3(-0.0, -0.0, -1.0)
BACK = Vector3(0.0, 0.0, 1.0)
LEFT = Vector3(-1.0, 0.0, 0.0)
RIGHT = Vector3(1.0, 0.0, 0.0)


class OBB:
    """An oriented box, as semantic objects have one."""

    def __init__(self, center: Vector3, sizes: Vector3, rotation: Vector4) -> None:
        self.center, self.sizes, self.half_extents = center, sizes, sizes * 0.5
        self.rotation = rotation
        """x, y, z, w."""


_numpy = "Enfilade has no such geometry; use numpy"

Ray = refused("habitat_sim.geo.Ray", PHYSICS)
build_catmull_rom_spline = refused("habitat_sim.geo.build_catmull_rom_spline", _numpy)
compute_gravity_aligned_MOBB = refused("habitat_sim.geo.compute_gravity_aligned_MOBB", _numpy)
get_transformed_bb = refused("habitat_sim.geo.get_transformed_bb", _numpy)

__all__ = [
    "BACK", "FRONT", "GRAVITY", "LEFT", "OBB", "RIGHT", "Ray", "UP", "build_catmull_rom_spline",
    "compute_gravity_aligned_MOBB", "get_transformed_bb",
]  # fmt: skip
