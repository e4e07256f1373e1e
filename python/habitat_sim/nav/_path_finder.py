"""The pathfinder: a navigation mesh, and what is asked of it."""

from __future__ import annotations

import os
from typing import Any, Optional, Union

import habitat_sim
import magnum as mn
from enfilade import InvalidInput
from enfilade._eyes import habitat as native
from numpy.typing import NDArray

from habitat_sim._fields import Field, Structure, number, one_of, point, vector3, whole
from habitat_sim.logging import logger
from habitat_sim.nav._mesh_cache import made_mesh
from habitat_sim.nav._shortest_paths import MultiGoalShortestPath, ShortestPath

NavMeshSettings = native.NavMeshSettings


class HitRecord(Structure):
    """The nearest wall: its place and normal, and its distance in metres."""

    hit_pos = Field(vector3, [0.0, 0.0, 0.0])
    hit_normal = Field(vector3, [0.0, 0.0, 0.0])
    hit_dist = Field(number, 0.0)


class PathFinder:
    """A navigation mesh. Before one is loaded, questions raise RuntimeError.

    Points are Vector3, arrays or lists of numbers, in metres. Random points come from the C library's
    generator, which the whole process shares.
    """

    def __init__(self) -> None:
        self._floor: Optional[native.Floor] = None

    @property
    def is_loaded(self) -> bool:
        """Whether there is a navigation mesh."""
        return self._floor is not None

    @property
    def _loaded(self) -> native.Floor:
        if self._floor is None:
            raise RuntimeError(
                "pathfinder: no navigation mesh; load_nav_mesh(), Simulator.recompute_navmesh() or "
                "SimulatorConfiguration.navmesh_settings gives one"
            )
        return self._floor

    def load_nav_mesh(self, path: str) -> bool:
        """Reads a `.navmesh` file. Returns False, and logs why, if it cannot be read."""
        name = os.fspath(path)
        try:
            with open(name, "rb") as file:
                data = file.read()
            self._floor = native.Floor.read(data, name, habitat_sim.nav.navigation)
        except (OSError, InvalidInput) as error:
            logger.error("%s", error)
            return False
        return True

    def save_nav_mesh(self, path: str) -> bool:
        """Writes a `.navmesh` file. Returns False, and logs why, if it cannot be written."""
        if self._floor is None:
            logger.error("%s: no navigation mesh to write", path)
            return False
        try:
            with open(path, "wb") as file:
                file.write(self._floor.file())
        except OSError as error:
            logger.error("%s", error)
            return False
        return True

    def _make(self, mesh_file: str, up: str, settings: native.NavMeshSettings) -> bool:
        """Makes the navigation mesh of a mesh file. Returns False, and logs why, if there is no floor."""
        one_of(NavMeshSettings)("navmesh_settings", settings)
        try:
            self._floor = made_mesh(mesh_file, up, settings, habitat_sim.nav.navigation)
        except InvalidInput as error:
            logger.error("%s", error)
            return False
        return True

    @property
    def nav_mesh_settings(self) -> Optional[native.NavMeshSettings]:
        """The settings of the mesh; None before it is loaded."""
        return None if self._floor is None else self._floor.settings

    def seed(self, new_seed: int) -> None:
        """Seeds the C library's generator; 0 and 1 are the same."""
        native.seed(whole("new_seed", new_seed) % 2**32)

    def get_random_navigable_point(self, max_tries: int = 10, island_index: int = -1) -> mn.Vector3:
        """A random point of the floor, or of one island; NaN after `max_tries` failures."""
        return mn.Vector3(self._loaded.random_point(max_tries, island_index))

    def get_random_navigable_point_near(
        self, circle_center: Any, radius: float, max_tries: int = 100, island_index: int = -1
    ) -> mn.Vector3:
        """The same within a circle, seen from above."""
        centre = point("circle_center", circle_center)
        return mn.Vector3(self._loaded.random_point_near(centre, radius, max_tries, island_index))

    def find_path(self, path: Union[ShortestPath, MultiGoalShortestPath]) -> bool:
        """Finds the path that `path` requests and writes it there. Returns whether there is one."""
        if not isinstance(path, (ShortestPath, MultiGoalShortestPath)):
            raise TypeError(f"path {path!r}: a ShortestPath or MultiGoalShortestPath is wanted")
        return path._find(self._loaded)

    def try_step(self, start: Any, end: Any) -> mn.Vector3:
        """Where a body ends that goes from start to end, along walls."""
        return self._step(start, end, True)

    def try_step_no_sliding(self, start: Any, end: Any) -> mn.Vector3:
        """Where a body ends that goes from start to end and stops at the first wall."""
        return self._step(start, end, False)

    def _step(self, start: Any, end: Any, slide: bool) -> mn.Vector3:
        return mn.Vector3(self._loaded.step(point("start", start), point("end", end), slide))

    def snap_point(self, point: Any, island_index: int = -1) -> mn.Vector3:
        """The nearest point of the floor, or of one island; NaN if there is none within reach."""
        return mn.Vector3(self._loaded.snap(_point(point), island_index))

    def is_navigable(self, pt: Any, max_y_delta: float = 0.5) -> bool:
        """Whether a point is on the floor: at most 1 cm aside, and `max_y_delta` metres above or below."""
        return self._loaded.is_navigable(_point(pt), max_y_delta)

    def get_island(self, point: Any) -> int:
        """The island of a point, -1 off the floor."""
        return self._loaded.island(_point(point))

    @property
    def num_islands(self) -> int:
        """The number of connected parts."""
        return self._loaded.islands

    def island_radius(self, pt: Any) -> float:
        """The radius, in metres, of an island, given by its number or by a point; 0 off the floor."""
        if isinstance(pt, int):
            return self._loaded.island_radius(pt)
        return self._loaded.island_radius_at(_point(pt))

    def island_area(self, island_index: int = -1) -> float:
        """The area of an island, or of all, in square metres."""
        return self._loaded.area if island_index == -1 else self._loaded.island_area(island_index)

    @property
    def navigable_area(self) -> float:
        """The area of all islands, in square metres."""
        return self._loaded.area

    def distance_to_closest_obstacle(self, pt: Any, max_search_radius: float = 2.0) -> float:
        """The distance to the nearest wall, in metres; `max_search_radius` if none is nearer."""
        return self._loaded.closest_obstacle(_point(pt), max_search_radius)[2]

    def closest_obstacle_surface_point(self, pt: Any, max_search_radius: float = 2.0) -> HitRecord:
        """The nearest wall."""
        record = HitRecord()
        found = self._loaded.closest_obstacle(_point(pt), max_search_radius)
        record.hit_pos, record.hit_normal, record.hit_dist = (
            mn.Vector3(found[0]),
            mn.Vector3(found[1]),
            found[2],
        )
        return record

    def get_bounds(self) -> tuple[mn.Vector3, mn.Vector3]:
        """The least and the greatest corner of the mesh."""
        low, high = self._loaded.bounds
        return mn.Vector3(low), mn.Vector3(high)

    def get_topdown_view(
        self, meters_per_pixel: float, height: float, eps: float = 0.5
    ) -> NDArray[Any]:
        """Whether there is floor, (z, x) of bool, at a height, `eps` metres above or below it."""
        return self._loaded.topdown(meters_per_pixel, height, eps)

    def get_topdown_island_view(
        self, meters_per_pixel: float, height: float, eps: float = 0.5
    ) -> NDArray[Any]:
        """The same with islands, of int32; -1: no floor."""
        return self._loaded.topdown_islands(meters_per_pixel, height, eps)

    def build_navmesh_vertices(self, island_index: int = -1) -> list[mn.Vector3]:
        """The corners of all triangles, three each, of all islands or one."""
        return [mn.Vector3(corner) for corner in self._loaded.vertices(island_index)]

    def build_navmesh_vertex_indices(self, island_index: int = -1) -> list[int]:
        """Which of these corners each triangle has: 0, 1, 2 and so on."""
        return list(range(len(self._loaded.vertices(island_index))))


def _point(value: Any) -> tuple[float, float, float]:
    return point("point", value)
