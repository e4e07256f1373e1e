"""Simulators of the drop-in, as the tests of its calls want them."""

from __future__ import annotations

from typing import Any

import MatterSim

SCAN = "17DRP5sb8fy"
START = "5b9b2794954e4694a45fc424a8643081"
NEIGHBOUR = "51857544c192476faebf212acb1b3d90"  # of START; there are recorded pictures of both
EXCLUDED = "cb6a9786e4ff47f79a11b024c36ef7c0"


def make_simulator(
    connectivity: str, batch: int = 1, discretized: bool = False, begin: str = "initialize"
) -> Any:
    """One without pictures. `begin`: initialize (v0.2), init (v0.1), or nothing."""
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(connectivity)
    sim.setRenderingEnabled(False)
    sim.setBatchSize(batch)
    sim.setDiscretizedViewingAngles(discretized)
    if begin:
        getattr(sim, begin)()
    return sim


def start(sim: Any, n: int = 1, heading: float = 0, elevation: float = 0) -> None:
    sim.newEpisode([SCAN] * n, [START] * n, [heading] * n, [elevation] * n)


def summary(sim: Any) -> list[tuple[Any, ...]]:
    return [
        (s.scanId, s.step, s.location and s.location.viewpointId, s.heading, s.elevation,
         s.viewIndex, len(s.navigableLocations))
        for s in sim.getState()
    ]  # fmt: skip
