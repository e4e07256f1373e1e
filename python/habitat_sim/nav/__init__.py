"""Navigation: the pathfinder, shortest paths, the greedy follower.

`navigation` names the navigation of Habitat-Sim that meshes have from now on. It is "latest", or "0.3.3":
that of v0.2.0 to v0.3.3, behind published results. Its first value comes from the environment variable
ENFILADE_HABITAT_NAVIGATION.
"""

from __future__ import annotations

import os

from habitat_sim._missing import refused
from habitat_sim.nav._path_finder import HitRecord, NavMeshSettings, PathFinder
from habitat_sim.nav._shortest_paths import MultiGoalShortestPath, ShortestPath
from habitat_sim.nav.greedy_geodesic_follower import GreedyFollowerCodes, GreedyGeodesicFollower

navigation = os.environ.get("ENFILADE_HABITAT_NAVIGATION") or "latest"

_words = "use GreedyGeodesicFollower"
GreedyGeodesicFollowerImpl = refused("habitat_sim.nav.GreedyGeodesicFollowerImpl", _words)
VectorGreedyCodes = refused("habitat_sim.nav.VectorGreedyCodes", _words)

__all__ = [
    "GreedyFollowerCodes", "GreedyGeodesicFollower", "GreedyGeodesicFollowerImpl", "HitRecord",
    "MultiGoalShortestPath", "NavMeshSettings", "PathFinder", "ShortestPath", "VectorGreedyCodes",
]  # fmt: skip
