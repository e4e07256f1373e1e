"""How fast the Python package is.

    python bench_python.py DATA
    python bench_python.py --pictures HOMES --bench-render build/release/bin/bench_render

Times are of the CPU, so that other programs of the machine count little; one thread. Of graphs alone,
DATA, each figure is the median of seven repeats. Of pictures: the same walk in the same buildings as
bench_render's, from Python and by bench_render in turns; each figure is the median of all turns.
"""

from __future__ import annotations

import argparse
import math
import platform
import resource
import statistics
import subprocess
import time
from typing import Any, Callable, Optional

import enfilade
import MatterSim
import numpy as np
from enfilade.gym import EnvConfig, VlnVectorEnv

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
    envs = VlnVectorEnv(EnvConfig(data, "train"), 256)
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


# --- pictures -------------------------------------------------------------------------------------

FRAMES, TURNS = 600, 7


class Walk:
    """The walk that bench_render takes: std::mt19937 gives the numbers of NumPy's MT19937. Its
    actions are drawn beforehand: drawing lots in Python is none of the package's work."""

    def __init__(self, graphs: enfilade.Graphs, scans: list[str], batch: int, size: tuple[int, int]):
        random = np.random.RandomState(12345)._bit_generator
        self.sim = enfilade.Simulator(graphs, batch, width=size[0], height=size[1])
        self.scans = [scans[k % len(scans)] for k in range(batch)]
        self.starts = []
        for scan in self.scans:
            graph = graphs[scan]
            viewpoints = graph.viewpoints
            while True:
                viewpoint = viewpoints[random.random_raw() % len(viewpoints)]
                if graph.included(viewpoint):
                    break
            self.starts.append(viewpoint)
        self.actions = []
        state = self.begin()
        for _ in range(1, max(FRAMES // batch, 1)):
            drawn = random.random_raw(3 * batch).reshape(-1, 3)
            turns = np.ascontiguousarray((drawn[:, 1:] % 3).T, np.float64) - 1
            self.actions.append((drawn[:, 0].astype(np.uint32) % state.navigable_count, *turns))
            self.sim.step(*self.actions[-1])

    def begin(self) -> Any:
        return self.sim.new_episodes(self.scans, self.starts)


class Pictures:
    """One row of the table: frames a second from Python and from bench_render."""

    def __init__(self, homes: str, scans: list[str], size: str, batch: int) -> None:
        self.homes, self.scans, self.size, self.batch = homes, scans, size, batch
        self.graphs = enfilade.Graphs(f"{homes}/connectivity")
        panoramas = enfilade.open_panoramas(homes, self.graphs)
        self.renderer = enfilade.Renderer(self.graphs, panoramas, threads=1, cache_bytes=8 << 30)
        width, height = map(int, size.split("x"))
        self.shape = (batch, height, width, 3)
        self.walk = Walk(self.graphs, scans, batch, (width, height))

    def from_python(self, out: Optional[dict[str, Any]]) -> float:
        self.walk.begin()
        sim, render = self.walk.sim, self.renderer.render_agents
        begin = time.process_time()
        render(sim, out=out)
        for action in self.walk.actions:
            sim.step(*action)
            render(sim, out=out)
        return (1 + len(self.walk.actions)) * self.batch / (time.process_time() - begin)

    def from_environment(self) -> float:
        width, height = self.shape[2], self.shape[1]
        config = EnvConfig(self.homes, observe=("rgb",), width=width, height=height, reward="none",
                           max_steps=10**9)  # fmt: skip
        envs = VlnVectorEnv(config, self.batch)
        envs._batch._renderer = self.renderer  # whose threads and cache the others have
        here = [k for k, episode in enumerate(envs.episodes) if episode.scan in self.scans]
        envs.reset(seed=1, options={"episode": [here[k % len(here)] for k in range(self.batch)]})
        actions = np.random.default_rng(1).integers(1, 4, (max(FRAMES // self.batch, 1), self.batch))
        begin = time.process_time()
        for row in actions:
            envs.step(row)
        return actions.size / (time.process_time() - begin)

    def by_bench_render(self, program: str) -> float:
        """Of what five repetitions more cost: starting and decoding do not count."""
        seconds = []
        for repetitions in (1, 6):
            command = [program, "walk", "--images", f"{self.homes}/store", "--connectivity",
                       f"{self.homes}/connectivity", "--scans", ",".join(self.scans),
                       "--size", self.size, "--outputs", "rgb", "--batch", str(self.batch),
                       "--threads", "1", "--frames", str(FRAMES), "--reps", str(repetitions)]  # fmt: skip
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            seconds.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        return 5 * max(FRAMES // self.batch, 1) * self.batch / (seconds[1] - seconds[0])

    def compare(self, program: str) -> str:
        out = {"rgb": np.empty(self.shape, np.uint8)}
        ways: dict[str, Callable[[], float]] = {
            "out=": lambda: self.from_python(out),
            "fresh arrays": lambda: self.from_python(None),
            "vector environment": self.from_environment,
            "C++": lambda: self.by_bench_render(program),
        }
        for way in ways.values():
            way()  # decodes
        rates: dict[str, list[float]] = {name: [] for name in ways}
        for _ in range(TURNS):
            for name, way in ways.items():
                rates[name].append(way())
        found = {name: statistics.median(some) for name, some in rates.items()}
        shares = ", ".join(f"{n} {100 * r / found['C++']:.1f} %" for n, r in found.items() if n != "C++")
        return f"C++ {found['C++']:.0f} frames/s; of it from Python: {shares}"


def pictures(homes: str, program: str) -> None:
    scans = [enfilade.Episodes(homes, "train")[0].scan]  # one home, so that all that is seen is in the cache
    for size in ("640x480", "224x224"):
        for batch in (1, 10, 100):
            found = Pictures(homes, scans, size, batch).compare(program)
            print(f"{size}, batch {batch}: {found}", flush=True)


# --- all ------------------------------------------------------------------------------------------


def graph_only(data: str) -> None:
    connectivity = f"{data}/connectivity"
    for batch in (1, 100):
        for read in (False, True):
            what = "every field read" if read else "length of the list read"
            found = drop_in(connectivity, batch, read)
            print(f"MatterSim, graph only, batch {batch}, {what}: {found / 1e3:.0f} thousand steps/s")
    print(f"vector environment, 256 agents: {vector_environment(data) / 1e6:.2f} million steps/s")
    places, seconds = candidates(connectivity)
    print(f"candidates of {places} viewpoints: {seconds:.3f} s")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("data", nargs="?", help="folder of graphs and annotations")
    parser.add_argument("--pictures", metavar="HOMES", help="folder of homes with a store")
    parser.add_argument("--bench-render", help="the program that draws from C++")
    options = parser.parse_args()
    if (options.pictures is None) != (options.bench_render is None):
        parser.error("--pictures and --bench-render come together")
    if options.data is None and options.pictures is None:
        parser.error("DATA or --pictures is wanted")
    with open("/proc/cpuinfo") as file:
        cpu = next((x.split(":")[1].strip() for x in file if x.startswith("model name")), "?")
    print(f"{cpu}; {platform.python_implementation()} {platform.python_version()}; "
          f"NumPy {np.__version__}")  # fmt: skip
    if options.data:
        graph_only(options.data)
    if options.pictures:
        pictures(options.pictures, options.bench_render)


if __name__ == "__main__":
    main()
