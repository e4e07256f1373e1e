"""How fast the Python package is: python bench_python.py DATA

Times are of this process's CPU, so that other programs of the machine count little; one thread. Each
figure is the median of seven repeats.
"""

from __future__ import annotations

import math
import platform
import statistics
import sys
import time
from typing import Any, Callable

import enfilade
import MatterSim
import numpy as np
from enfilade.gym import EnvConfig, RoomToRoomVectorEnv

STEPS = 3000


def rate(work: Callable[[], int]) -> float:
    """Steps a second of CPU time; `work` says how many it did."""
    work()
    rates = []
    for _ in range(7):
        begin = time.process_time()
        count = work()
        rates.append(count / (time.process_time() - begin))
    return statistics.median(rates)


def read_all(state: Any) -> float:
    """Reads every field that old code reads."""
    here = state.location
    total = state.step + state.heading + state.elevation + state.viewIndex + here.ix
    total += here.x + here.y + here.z + len(state.scanId) + len(here.viewpointId)
    for way in state.navigableLocations:
        total += way.rel_heading + way.rel_elevation + way.rel_distance + way.ix
        total += way.x + way.y + way.z + len(way.viewpointId)
    return float(total)


def drop_in(connectivity: str, batch: int, read: bool) -> float:
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(connectivity)
    sim.setRenderingEnabled(False)
    sim.setDiscretizedViewingAngles(True)
    sim.setCameraResolution(640, 480)
    sim.setCameraVFOV(math.radians(60))
    sim.setBatchSize(batch)
    sim.initialize()
    scans = enfilade.Graphs(connectivity).scans
    turns = [[(i + k) % 3 - 1.0 for i in range(batch)] for k in range(7)]
    level = [0.0] * batch

    def walk() -> int:
        rounds = max(1, STEPS // batch)
        sim.newRandomEpisode([scans[i % len(scans)] for i in range(batch)])
        for k in range(rounds):
            states = sim.getState()
            indices = [len(s.navigableLocations) - 1 for s in states]
            sim.makeAction(indices, turns[k % 7], level)
            if read:
                for state in sim.getState():
                    read_all(state)
        return rounds * batch

    return rate(walk)


def vector_environment(data: str) -> float:
    envs = RoomToRoomVectorEnv(EnvConfig(data, "train"), 256)
    envs.reset(seed=1)
    actions = np.random.default_rng(1).integers(1, 4, (200, 256))

    def walk() -> int:
        for row in actions:
            envs.step(row)
        return actions.size

    return rate(walk)


def candidates(connectivity: str) -> tuple[int, float]:
    graphs = enfilade.Graphs(connectivity)
    graphs.load_all()
    sim = enfilade.Simulator(graphs)
    places = sum(graphs[s].included(v) for s in graphs.scans for v in graphs[s].viewpoints)
    return places, 1 / rate(lambda: bool(len(sim.all_candidates().scan)))


def main(data: str) -> None:
    connectivity = f"{data}/connectivity"
    with open("/proc/cpuinfo") as file:
        cpu = next((x.split(":")[1].strip() for x in file if x.startswith("model name")), "?")
    print(f"{cpu}; {platform.python_implementation()} {platform.python_version()}; "
          f"NumPy {np.__version__}")  # fmt: skip
    for batch in (1, 100):
        for read in (False, True):
            what = "every field read" if read else "length of the list read"
            found = drop_in(connectivity, batch, read)
            print(f"MatterSim, graph only, batch {batch}, {what}: {found / 1e3:.0f} thousand steps/s")
    print(f"vector environment, 256 agents: {vector_environment(data) / 1e6:.2f} million steps/s")
    places, seconds = candidates(connectivity)
    print(f"candidates of {places} viewpoints: {seconds:.3f} s")


if __name__ == "__main__":
    main(*sys.argv[1:])
