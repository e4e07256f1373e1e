"""Questions for PathFinder.find_path(), and their answers."""

from __future__ import annotations

from typing import Any

import magnum as mn
import numpy as np
from enfilade._eyes import habitat as native
from numpy.typing import NDArray

from habitat_sim._fields import Field, Structure, listed, number, numbers, vector3, whole, wrong


class ShortestPath(Structure):
    """From one point to another. The answer: `points`, and `geodesic_distance` in metres, inf without a path."""

    requested_start = Field(vector3, [0.0, 0.0, 0.0])
    requested_end = Field(vector3, [0.0, 0.0, 0.0])
    points: Field[list[mn.Vector3]] = Field(listed, [])
    geodesic_distance = Field(number, 0.0)

    def _find(self, floor: native.Floor) -> bool:
        points, self.geodesic_distance = floor.path(self.requested_start, self.requested_end)
        self.points = [mn.Vector3(point) for point in points]
        return len(points) > 0


def _goals(value: Any) -> NDArray[np.float32]:
    """(n, 3) goals from such an array, or a list of arrays or vectors."""
    wanted = "an (n, 3) array, or a list of arrays or Vector3,"
    if isinstance(value, list):
        if not all(isinstance(one, (np.ndarray, mn.Vector3)) for one in value):
            raise wrong("requested_ends", value, wanted)
        value = np.array([numbers("requested_ends", one, 3) for one in value]).reshape(-1, 3)
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu" or value.shape[1:] != (3,):
        raise wrong("requested_ends", value, wanted)
    return value.astype(np.float32, "C")


class MultiGoalShortestPath(Structure):
    """From a point to the nearest of several goals. It keeps what it learns of them from start to start.

    The answer: as of ShortestPath, and `closest_end_point_index`, -1 without a path.
    """

    requested_start = Field(vector3, [0.0, 0.0, 0.0])
    points: Field[list[mn.Vector3]] = Field(listed, [])
    geodesic_distance = Field(number, 0.0)
    closest_end_point_index = Field(whole, 0)

    def __init__(self) -> None:
        super().__init__()
        self.requested_ends = []

    @property
    def requested_ends(self) -> list[mn.Vector3]:
        """The goals: an (n, 3) array, or a list of arrays or Vector3."""
        return [mn.Vector3(goal) for goal in self.__dict__["_ends"]]

    @requested_ends.setter
    def requested_ends(self, goals: Any) -> None:
        self.__dict__.update(_ends=_goals(goals), _bounds=native.GoalBounds())

    def _find(self, floor: native.Floor) -> bool:
        points, self.geodesic_distance, self.closest_end_point_index = floor.path_to_any(
            self.requested_start, self.__dict__["_ends"], self.__dict__["_bounds"]
        )
        self.points = [mn.Vector3(point) for point in points]
        return len(points) > 0

    __eq__ = object.__eq__
    __hash__ = object.__hash__  # type: ignore[assignment]
