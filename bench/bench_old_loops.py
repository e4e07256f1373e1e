"""What old training code does around its network, and the lines that replace it.

    python bench_old_loops.py DATA [--scans 10]

The loops are those of the public agents of the HAMT and DUET families, written here from a description of
their calls: a sweep of 36 views to tabulate candidates, teleports with getState() of batch 1, and shortest
ways of all pairs by networkx. Times are of the CPU, of all threads together, each the best of five runs
(all_candidates(): of three; networkx: one run).
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import time
from pathlib import Path
from typing import Any, Callable

import enfilade
import MatterSim

VIEWS = 36
STEP = math.radians(30)


def best(work: Callable[[], Any], repeats: int = 5) -> float:
    """Seconds."""
    seconds = []
    for _ in range(repeats):
        begin = time.process_time()
        work()
        seconds.append(time.process_time() - begin)
    return min(seconds)


def old_simulator(connectivity: str) -> Any:
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(connectivity)
    sim.setRenderingEnabled(False)
    sim.setDiscretizedViewingAngles(True)
    sim.setCameraResolution(640, 480)
    sim.setCameraVFOV(math.radians(60))
    sim.setBatchSize(1)
    sim.initialize()
    return sim


def sweep(sim: Any, scan: str, viewpoint: str) -> dict[str, tuple[Any, ...]]:
    """For each neighbour the view that has it nearest to its middle."""
    found: dict[str, tuple[Any, ...]] = {}
    for view in range(VIEWS):
        if view == 0:
            sim.newEpisode([scan], [viewpoint], [0], [-STEP])
        elif view % 12 == 0:
            sim.makeAction([0], [1.0], [1.0])
        else:
            sim.makeAction([0], [1.0], [0])
        state = sim.getState()[0]
        heading, elevation = state.heading, state.elevation
        for index, way in enumerate(state.navigableLocations[1:]):
            distance = math.sqrt(way.rel_heading**2 + way.rel_elevation**2)
            if way.viewpointId not in found or distance < found[way.viewpointId][0]:
                found[way.viewpointId] = (
                    distance, view, index + 1, heading + way.rel_heading,
                    elevation + way.rel_elevation, way.ix, (way.x, way.y, way.z),
                )  # fmt: skip
    return found


def teleports(sim: Any, places: list[tuple[str, str]]) -> int:
    """newEpisode() at each place, and what an agent reads there."""
    seen = 0
    for k, (scan, viewpoint) in enumerate(places):
        sim.newEpisode([scan], [viewpoint], [k % 12 * STEP], [0])
        state = sim.getState()[0]
        seen += len(state.navigableLocations) + state.viewIndex + len(state.location.viewpointId)
        seen += int(state.heading + state.elevation + state.location.x)
    return seen


def networkx_tables(connectivity: Path, scans: list[str]) -> Any:
    import networkx

    tables = {}
    for scan in scans:
        rows = json.loads((connectivity / f"{scan}_connectivity.json").read_text())
        graph = networkx.Graph()
        at = {row["image_id"]: [row["pose"][k] for k in (3, 7, 11)] for row in rows}
        for row in rows:
            for j, there in enumerate(row["unobstructed"]):
                if row["included"] and there and rows[j]["included"]:
                    other = rows[j]["image_id"]
                    graph.add_edge(row["image_id"], other, weight=math.dist(at[row["image_id"]], at[other]))
        paths = dict(networkx.all_pairs_dijkstra_path(graph))
        tables[scan] = (paths, dict(networkx.all_pairs_dijkstra_path_length(graph)))
    return tables


def our_tables(connectivity: Path, scans: list[str]) -> Any:
    graphs = enfilade.Graphs(connectivity)
    return {scan: (graphs[scan].path, graphs[scan].distances()) for scan in scans}


def check(sim: Any, agents: Any, scan: str, viewpoint: str) -> None:
    """Both ways to the same candidates."""
    old = sweep(sim, scan, viewpoint)
    new = {c.viewpoint: c for c in agents.candidates(scan, viewpoint)}
    assert old.keys() == new.keys()
    for name, row in old.items():
        c = new[name]
        assert (c.view_index, c.index, c.ix) == (row[1], row[2], row[5])
        assert abs(c.normalized_heading - row[3]) < 1e-9 and c.position == row[6]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--scans", type=int, default=10, help="of networkx's tables; 0: none")
    options = parser.parse_args()
    connectivity = options.data / "connectivity"
    graphs = enfilade.Graphs(connectivity)
    graphs.load_all()
    places = [(scan, v) for scan in graphs.scans[:8] for v in graphs[scan] if graphs[scan].included(v)]
    few = places[:: max(1, len(places) // 60)]
    sim, agents = old_simulator(str(connectivity)), enfilade.Simulator(graphs)
    for place in few[:5]:
        check(sim, agents, *place)
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}")

    def line(what: str, seconds: float, n: int) -> None:
        print(f"{what:<52}{1e6 * seconds / n:>12.2f} us")

    n = len(few)
    line("36 views of a viewpoint, MatterSim", best(lambda: [sweep(sim, *p) for p in few]), n)
    line("  sim.candidates(scan, viewpoint)", best(lambda: [agents.candidates(*p) for p in few]), n)
    line("  sim.all_candidates(), a viewpoint", best(lambda: agents.all_candidates(), 3),
         sum(len(graphs[s]) for s in graphs))  # fmt: skip
    line("newEpisode(), getState()[0], MatterSim", best(lambda: teleports(sim, places)), len(places))
    line("  getState()[0] alone", best(lambda: [sim.getState()[0] for _ in range(10000)]), 10000)
    scans = graphs.scans[: options.scans]
    if scans:
        line("tables of a scan, networkx", best(lambda: networkx_tables(connectivity, scans), 1), len(scans))
        line("  graph.distances(), graph.path()", best(lambda: our_tables(connectivity, scans)), len(scans))


if __name__ == "__main__":
    main()
