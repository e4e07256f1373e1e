"""Threads, forks, spawned processes, and memory over a long life."""

from __future__ import annotations

import concurrent.futures
import gc
import json
import multiprocessing
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import enfilade
import MatterSim
import pytest

np = pytest.importorskip("numpy")

STEPS = 200


def walk(folder: str, seed: int) -> list[int]:
    """Where a batch ends up; the same for a seed wherever it runs."""
    graphs = enfilade.Graphs(f"{folder}/connectivity")
    sim = enfilade.Simulator(graphs, 16, discretized=False, restricted=False, seed=seed)
    sim.new_random_episodes(graphs.scans[:1] * 16)
    for step in range(STEPS):
        sim.step(sim.state.navigable_count - 1, np.full(16, 0.1 * (step % 7)))
    found: list[int] = sim.state.viewpoint.tolist()
    return found


def walk_old(folder: str, seed: int) -> list[str]:
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(f"{folder}/connectivity")
    sim.setRenderingEnabled(False)
    sim.setSeed(seed)
    sim.newRandomEpisode(["home0001"])
    ids = []
    for step in range(STEPS):
        last = len(sim.getState()[0].navigableLocations) - 1
        sim.makeAction([last], [0.1 * (step % 7)], [0])
        ids.append(sim.getState()[0].location.viewpointId)
    return ids


def both(folder: str, seed: int) -> tuple[list[int], list[str]]:
    return walk(folder, seed), walk_old(folder, seed)


def test_eight_threads_walk_as_one_does(small: str) -> None:
    alone = [both(small, seed) for seed in range(8)]
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        assert list(pool.map(lambda seed: both(small, seed), range(8))) == alone


def test_eight_threads_draw_as_one_does(data: Any, reference: Any) -> None:
    graphs = enfilade.Graphs(str(data / "connectivity"))
    scans = str(reference / "golden" / "scans")
    panoramas = enfilade.Panoramas([scans], str(data / "connectivity"), graphs)

    def draw(seed: int) -> Any:
        renderer = enfilade.Renderer(graphs, panoramas, cache_bytes=8 << 20)
        headings = np.random.default_rng(seed).uniform(0, 6, 5)
        start = "5b9b2794954e4694a45fc424a8643081"
        return renderer.render(
            ["17DRP5sb8fy"] * 5, [start] * 5, headings, width=64, height=48
        )["rgb"]

    alone = [draw(seed) for seed in range(8)]
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        together = list(pool.map(draw, range(8)))
    assert all((a == b).all() for a, b in zip(alone, together))


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_other_processes_walk_as_this_one_does(small: str, method: str) -> None:
    here = [both(small, seed) for seed in range(3)]  # a fork inherits the open graphs
    context = multiprocessing.get_context(method)
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        assert list(pool.map(both, [small] * 3, range(3), timeout=120)) == here


def draw_in_child(renderer: Any, view: Any, expected: Any) -> bool:
    drawn = renderer.render(*view, width=64, height=48)["rgb"]
    return bool((drawn == expected).all())


def room_in_shared_memory(size: int) -> bool:
    if not os.path.isdir("/dev/shm"):
        return False
    disk = os.statvfs("/dev/shm")
    return disk.f_bavail * disk.f_frsize > size


@pytest.mark.parametrize("cache", ["private", "shared"])
def test_a_forked_renderer_draws(data: Any, reference: Any, cache: str) -> None:
    shared_bytes = 48 << 20
    if cache == "shared" and not room_in_shared_memory(shared_bytes):
        pytest.skip("/dev/shm has no room for 48 MiB")
    graphs = enfilade.Graphs(str(data / "connectivity"))
    scans = str(reference / "golden" / "scans")
    panoramas = enfilade.Panoramas([scans], str(data / "connectivity"), graphs)
    renderer = enfilade.Renderer(graphs, panoramas, threads=2, cache=cache, shared_bytes=shared_bytes)
    view = (["17DRP5sb8fy"], ["5b9b2794954e4694a45fc424a8643081"], [0.3])
    expected = renderer.render(*view, width=64, height=48)["rgb"]
    child = os.fork()
    if child == 0:
        os._exit(0 if draw_in_child(renderer, view, expected) else 1)
    assert os.waitpid(child, 0)[1] == 0


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_torchs_loader_works_with_simulators_inside(small: str, method: str) -> None:
    data = pytest.importorskip("torch.utils.data", reason="torch is not installed")

    walk(small, 1)
    loader = data.DataLoader(
        Walks(small), batch_size=2, num_workers=2, multiprocessing_context=method
    )
    found = [row for batch in loader for row in batch.tolist()]
    assert found == [walk(small, seed) for seed in range(4)]


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_torchs_loader_passes_episodes_on(made: Path, method: str) -> None:
    data = pytest.importorskip("torch.utils.data", reason="torch is not installed")

    episodes = enfilade.Episodes(made, "val_unseen", task="reverie")
    loader = data.DataLoader(
        episodes, batch_size=2, num_workers=2, multiprocessing_context=method, collate_fn=list
    )
    assert [e for batch in loader for e in batch] == list(episodes)


class Walks:
    """A data set whose items are walks."""

    def __init__(self, folder: str) -> None:
        self.folder = folder

    def __len__(self) -> int:
        return 4

    def __getitem__(self, seed: int) -> Any:
        return np.array(walk(self.folder, seed))


def what_others_see(things: dict[str, Any]) -> dict[str, Any]:
    """Of pickled objects, in whatever process this is."""
    episodes, graphs, table = things["episodes"], things["graphs"], things["table"]
    scan = graphs.scans[0]
    viewpoint = next(filter(graphs[scan].included, graphs[scan]))
    simulator = things["simulator"]
    simulator.new_episodes([scan] * 2, [viewpoint] * 2)
    rows = table.rows(scan, viewpoint)
    return {
        "episode": episodes[1],
        "count": len(episodes),
        "scans": graphs.scans,
        "edges": things["graph"].edges(),
        "views": table.view_index[rows].tolist(),
        "headings": simulator.state.navigable_rel_heading[0, :2].tolist(),
        "words": things["vocabulary"].words,
        "score": things["score"].means["success"],
        "dataset": things["dataset"].tasks,
    }


def things_to_pickle(made: Path) -> dict[str, Any]:
    dataset = enfilade.Dataset(made)
    episodes = dataset.episodes("val_unseen")
    simulator = dataset.simulator(2, discretized=False, restricted=False)
    rows = [{"instr_id": e.instruction_id, "trajectory": list(e.path)} for e in episodes]
    return {
        "dataset": dataset,
        "episodes": episodes,
        "graphs": dataset.graphs,
        "graph": dataset.graphs[dataset.graphs.scans[0]],
        "simulator": simulator,
        "table": simulator.all_candidates(),
        "vocabulary": enfilade.Vocabulary.build(["walk on", "walk"], 1),
        "score": episodes.score(rows, bootstrap_samples=0),
    }


def test_everything_pickles(made: Path) -> None:
    things = things_to_pickle(made)
    copied = pickle.loads(pickle.dumps(things))
    assert what_others_see(copied) == what_others_see(things)
    opened = enfilade.Graphs(made / "connectivity")
    assert pickle.loads(pickle.dumps(opened)).scans == opened.scans
    part = enfilade.Episodes(made, "val_unseen", all_instructions=True)
    assert len(pickle.loads(pickle.dumps(part))) == len(part) == 12


def test_pictures_pickle(homes: str) -> None:
    d = enfilade.Dataset(homes)
    scan = d.graphs.scans[0]
    viewpoint = next(filter(d.graphs[scan].included, d.graphs[scan]))
    for renderer in (d.renderer(), enfilade.Renderer(d.graphs, enfilade.open_panoramas(homes, d.graphs))):
        again = pickle.loads(pickle.dumps(renderer))
        views = [r.render([scan], [viewpoint], 1.0, width=32, height=24)["rgb"] for r in (renderer, again)]
        assert (views[0] == views[1]).all()
    assert scan in d.panoramas and "nowhere" not in d.panoramas


def test_spawned_processes_get_everything(made: Path) -> None:
    """As a DataLoader that spawns passes its data set on."""
    things = things_to_pickle(made)
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
        assert pool.submit(what_others_see, things).result(timeout=120) == what_others_see(things)


CHOOSE_GL = """
import sys
import enfilade

graphs = enfilade.Graphs(f"{sys.argv[1]}/connectivity")
panoramas = enfilade.open_panoramas(sys.argv[1], graphs)
try:
    enfilade.Renderer(graphs, panoramas, backend="gl")
except enfilade.Error as error:
    print(error)
print(enfilade.Renderer(graphs, panoramas, backend="cpu").description)
"""


def test_a_driver_that_crashes_is_an_error_and_not_the_end(small: str, tmp_path: Path) -> None:
    driver = os.environ.get("ENFILADE_BAD_DRIVER")
    if not driver or "gl" not in enfilade.backends():
        pytest.skip("no driver that crashes was built, or no OpenGL")
    vendor = tmp_path / "bad.json"
    vendor.write_text(json.dumps({"file_format_version": "1.0.0", "ICD": {"library_path": driver}}))
    variables = {"__EGL_VENDOR_LIBRARY_FILENAMES": str(vendor), "EN_BAD_DRIVER": "crash"}
    done = subprocess.run(
        [sys.executable, "-c", CHOOSE_GL, small],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    if "libEGL.so.1" in done.stdout:
        pytest.skip("this machine has no EGL")
    assert "the OpenGL driver crashed (SIGSEGV in libEGL_bad.so)" in done.stdout
    assert "cpu (" in done.stdout


def resident_bytes() -> int:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_a_hundred_thousand_simulators_leave_nothing_behind(small: str) -> None:
    graphs = enfilade.Graphs(f"{small}/connectivity")
    start = graphs["home0001"].viewpoints[0]

    def live_and_die(count: int) -> None:
        for _ in range(count):
            sim = MatterSim.Simulator()
            sim.setNavGraphPath(f"{small}/connectivity")
            sim.setRenderingEnabled(False)
            sim.newEpisode(["home0001"], [start], [0], [0])
            sim.makeAction([0], [1], [0])
            state = sim.getState()[0]
            assert state.location is state.navigableLocations[0]
            native = enfilade._core.BatchSimulator(
                graphs, batch_size=1, width=64, height=64, vfov=1.0, discretized=True,
                restricted=True, linear_view=True, elevation_limits=(-0.9, 0.9),
                mattersim_starts=False, seed=1, max_navigable=16, threads=1,
            )  # fmt: skip
            native.state_arrays()

    live_and_die(2_000)
    gc.collect()
    before = resident_bytes()
    live_and_die(100_000)
    gc.collect()
    assert resident_bytes() - before < 4 << 20  # a byte each would be 0.1 MB; pages come in lumps


def test_one_simulator_in_two_threads_is_refused_or_runs(small: str) -> None:
    """Never both at once: the second is told so."""
    graphs = enfilade.Graphs(f"{small}/connectivity")
    sim = enfilade.Simulator(graphs, 20_000, discretized=False, restricted=False)
    sim.new_random_episodes(["home0001"] * 20_000)
    nothing = np.zeros(20_000, np.uint32)
    refused = []

    def step() -> None:
        for _ in range(20):
            try:
                sim.step(nothing)
            except RuntimeError as error:
                refused.append(str(error))

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for done in [pool.submit(step), pool.submit(step)]:
            done.result()
    assert all("another thread" in text for text in refused)
    assert sim.state.step.max() == 40 - len(refused)


def drawing_simulator(
    homes: str, batch: int, vfov: float, size: tuple[int, int] = (64, 48)
) -> Any:
    """MatterSim in the synthetic homes, with pictures of ``size`` (width, height)."""
    scan = enfilade.Graphs(f"{homes}/connectivity").scans[0]
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(f"{homes}/connectivity")
    sim.setDatasetPath(f"{homes}/store")
    sim.setCameraResolution(*size)
    sim.setCameraVFOV(vfov)
    sim.setBatchSize(batch)
    sim.initialize()
    sim.newRandomEpisode([scan] * batch)
    return sim


def test_states_show_the_pictures_of_a_new_field_of_view(homes: str) -> None:
    sim, wide = drawing_simulator(homes, 2, 0.8), drawing_simulator(homes, 2, 1.5)
    narrow = np.array(sim.getState()[0].rgb, copy=True)
    sim.setCameraVFOV(1.5)
    sim.makeAction([0, 0], [0, 0], [0, 0])
    shown = np.array(sim.getState()[0].rgb, copy=True)
    assert (shown != narrow).any()
    assert (shown == np.asarray(wide.getState()[0].rgb)).all()


def test_setters_are_refused_while_another_thread_draws(homes: str) -> None:
    # A call must last longer than this thread needs to wake up on a busy machine: some milliseconds.
    sim = drawing_simulator(homes, 50, 1.0, (320, 240))
    refused = []
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        drawn = 0
        while not refused and drawn < 1000:  # one call may end before the setter is reached
            drawing = pool.submit(sim.makeAction, [0] * 50, [0.1] * 50, [0] * 50)
            drawn += 1
            while not drawing.done():
                try:
                    sim.setCameraVFOV(1.0)
                except RuntimeError as error:
                    refused.append(str(error))
            try:
                drawing.result()
            except RuntimeError as error:  # the setter was first
                assert "another thread" in str(error)
    assert refused and all("another thread" in text for text in refused)
