"""The package's own API."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any, Callable

import enfilade
import pytest

np = pytest.importorskip("numpy")


@pytest.fixture
def graphs(small: str) -> enfilade.Graphs:
    return enfilade.Graphs(f"{small}/connectivity")


def test_importing_is_fast_and_brings_nothing_heavy() -> None:
    code = (
        "import sys, time; t = time.process_time(); import enfilade, MatterSim;"
        "t = time.process_time() - t;"
        "print(t, [m for m in ('numpy', 'torch', 'gymnasium') if m in sys.modules])"
    )
    runs = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        for _ in range(5)
    ]
    assert all(run.stdout.split(maxsplit=1)[1].strip() == "[]" for run in runs)
    # Of this process alone, in seconds: other programs of the machine do not count.
    assert min(float(run.stdout.split()[0]) for run in runs) < 0.1


def test_every_name_that_is_promised_is_there() -> None:
    for name in enfilade.__all__:
        assert getattr(enfilade, name) is not None and name in dir(enfilade)
    with pytest.raises(AttributeError):
        _ = enfilade.nonsense


# --- graphs ---------------------------------------------------------------------------------------


def test_a_graph_is_its_viewpoints_and_edges(graphs: enfilade.Graphs) -> None:
    graph = graphs[graphs.scans[0]]
    assert list(graph) == graph.viewpoints and graph.viewpoints[0] in graph and "x" not in graph
    edges = graph.edges()
    assert {frozenset(edge[:2]) for edge in edges} == {
        frozenset((a, b)) for a in graph for b in graph.neighbours(a)
    }
    assert len({frozenset(edge[:2]) for edge in edges}) == len(edges)
    for a, b, metres in edges:
        straight = np.linalg.norm(
            graph.positions[graph.index(a)] - graph.positions[graph.index(b)]
        )
        assert metres == pytest.approx(float(straight), abs=1e-4)
    pairs, lengths = graph.edge_arrays()
    assert pairs.shape == (2 * len(edges), 2) and lengths.shape == (2 * len(edges),)
    distances = graph.distances()
    for i in range(0, len(graph), 7):
        for j in range(len(graph)):
            assert distances[i, j] == graph.distance(graph.viewpoints[i], graph.viewpoints[j])


def test_networkx_takes_the_edges(graphs: enfilade.Graphs) -> None:
    networkx = pytest.importorskip("networkx", reason="networkx is not installed")
    graph = graphs[graphs.scans[0]]
    theirs = networkx.Graph()
    theirs.add_weighted_edges_from(graph.edges())
    distances = graph.distances()
    for a, found in networkx.all_pairs_dijkstra_path_length(theirs):
        for b, metres in found.items():
            assert distances[graph.index(a), graph.index(b)] == pytest.approx(metres)


def test_a_folder_one_too_high_is_told(small: str) -> None:
    with pytest.raises(enfilade.FileError, match="name that folder, .*connectivity"):
        enfilade.Graphs(small)


def test_rows_of_a_table_of_candidates(graphs: enfilade.Graphs) -> None:
    sim = enfilade.Simulator(graphs)
    table = sim.all_candidates()
    assert table.offsets[-1] == len(table.view_index)
    for scan in graphs.scans[:2]:
        for viewpoint in graphs[scan].viewpoints:
            rows = table.rows(scan, viewpoint)
            if not graphs[scan].included(viewpoint):
                assert rows.start == rows.stop
                continue
            found = sim.candidates(scan, viewpoint)
            assert table.view_index[rows].tolist() == [c.view_index for c in found]
            assert table.neighbour[rows].tolist() == [c.ix for c in found]
            assert table.rows(graphs.index(scan), graphs[scan].index(viewpoint)) == rows
    last = graphs.scans[-1]
    some = sim.all_candidates([last])
    viewpoint = next(filter(graphs[last].included, graphs[last]))
    wanted = table.normalized_heading[table.rows(last, viewpoint)]
    assert (some.normalized_heading[some.rows(last, viewpoint)] == wanted).all()
    with pytest.raises(enfilade.ArgumentError, match="not one of the 1"):
        some.rows(graphs.scans[0], 0)
    with pytest.raises(enfilade.ArgumentError, match="0 to"):
        some.rows(last, 10**6)
    with pytest.raises(enfilade.ArgumentError, match="twice"):
        sim.all_candidates([last, last])


# --- cameras --------------------------------------------------------------------------------------


def test_cameras_see_neighbours_where_they_are(graphs: enfilade.Graphs) -> None:
    """The pixel of a candidate, against its angles from the middle of the view."""
    from enfilade import camera

    k = camera.intrinsics(640, 480, math.radians(60))
    assert k[1, 1] == pytest.approx(240 / math.tan(math.radians(30))) and k[0, 2] == 320
    graph = graphs[graphs.scans[0]]
    sim = enfilade.Simulator(graphs, discretized=False)
    seen = 0
    for viewpoint in filter(graph.included, graph.viewpoints):
        for turn in range(4):
            sim.new_episodes([graph.scan], [viewpoint], 1.5 * turn)
            state = sim.state
            for j in range(1, int(state.navigable_count[0])):
                target = graph.positions[state.navigable_viewpoint[0, j]]
                here = graph.positions[graph.index(viewpoint)]
                pixel, depth = camera.project(target, 640, 480, math.radians(60), here, 1.5 * turn)
                right = math.atan((pixel[0] - 320) / k[0, 0])
                assert depth > 0 and right == pytest.approx(state.navigable_rel_heading[0, j], abs=1e-4)
                up = math.atan2(240 - pixel[1], math.hypot(k[1, 1], pixel[0] - 320))
                assert up == pytest.approx(state.navigable_rel_elevation[0, j], abs=1e-4)
                seen += 1
    assert seen > 20


def test_depth_becomes_points_and_back() -> None:
    from enfilade import camera

    depth = np.random.default_rng(1).uniform(1, 5, (12, 16))
    depth[3, 4] = 0
    pose = ((1.0, 2.0, 1.5), 0.7, 0.3)
    points = camera.unproject(depth, 1.0, *pose)
    assert points.shape == (12, 16, 3) and points.dtype == np.float32
    assert np.isnan(points[3, 4]).all() and np.isnan(points).sum() == 3
    pixels, back = camera.project(points, 16, 12, 1.0, *pose)
    fine = depth > 0
    assert np.allclose(back[fine], depth[fine], atol=1e-5)
    x, y = np.meshgrid(np.arange(16) + 0.5, np.arange(12) + 0.5)
    assert np.allclose(pixels[fine], np.stack([x, y], -1)[fine], atol=1e-3)
    old = camera.unproject(np.full((2, 2), 4000, np.uint16), 1.0)
    assert (old[..., 2] == 1).all()
    behind, z = camera.project((1.0, -9.0, 1.5), 16, 12, 1.0, (1.0, 2.0, 1.5))
    assert np.isnan(behind).all() and z < 0
    for bad in (np.zeros(3), np.zeros((2, 2, 1))):
        with pytest.raises(enfilade.ArgumentError, match="shape"):
            camera.unproject(bad, 1.0)
    with pytest.raises(enfilade.ArgumentError, match="vfov"):
        camera.intrinsics(10, 10, 4.0)

def test_graphs_know_ways(graphs: enfilade.Graphs) -> None:
    graph = graphs[graphs.scans[0]]
    assert graphs.scans[0] in graphs and "nowhere" not in graphs
    ids = graph.viewpoints
    assert len(ids) == len(graph) == len(graph.positions)
    assert graph.positions.dtype == np.float32 and not graph.positions.flags.writeable
    way = graph.path(ids[0], ids[-1])
    assert way is not None and way[0] == ids[0] and way[-1] == ids[-1]
    steps = sum(graph.distance(a, b) for a, b in zip(way, way[1:]))
    assert graph.distance(ids[0], ids[-1]) == pytest.approx(steps)
    assert all(b in graph.neighbours(a) for a, b in zip(way, way[1:]))
    assert graph.nearest(tuple(graph.positions[3])) == ids[3]


def test_graphs_outlive_their_set(small: str) -> None:
    graph = enfilade.Graphs(f"{small}/connectivity")["home0001"]
    positions = graph.positions
    names = graph.viewpoints
    del graph
    assert len(positions) == len(names) and np.isfinite(positions).all()


def test_errors_are_typed_and_name_what_is_wrong(graphs: enfilade.Graphs, tmp_path: Path) -> None:
    with pytest.raises(enfilade.UnknownNameError, match="nowhere"):
        graphs["nowhere"]
    with pytest.raises(LookupError, match="nope"):
        graphs["home0001"].distance("nope", "nope")
    with pytest.raises(enfilade.FileError, match="scans.txt"):
        enfilade.Graphs(str(tmp_path))
    with pytest.raises(OSError):
        enfilade.Graphs("/nonexistent")
    (tmp_path / "scans.txt").write_text("a")
    (tmp_path / "a_connectivity.json").write_text("[{}]")
    with pytest.raises(enfilade.InvalidInput, match=r"a_connectivity.json"):
        enfilade.Graphs(str(tmp_path))["a"]
    assert issubclass(enfilade.InvalidInput, ValueError)
    assert issubclass(enfilade.ArgumentError, enfilade.Error)


# --- simulator ------------------------------------------------------------------------------------


def test_the_state_is_a_window_into_the_simulator(graphs: enfilade.Graphs) -> None:
    sim = enfilade.Simulator(graphs, 3, discretized=False)
    ids = graphs["home0001"].viewpoints
    state = sim.new_episodes(["home0001"] * 3, ids[:3], [0, 1, 2], 0)
    assert state.heading.tolist() == [0, 1, 2] and sim.viewpoint_ids() == ids[:3]
    heading = state.heading
    sim.step([0, 0, 0], [0.5, -1, 0.25])
    assert heading.tolist() == [0.5, 0, 2.25] and state.step.tolist() == [1, 1, 1]
    assert not heading.flags.writeable and heading.base is not None
    del sim, state
    assert heading.tolist() == [0.5, 0, 2.25]


def test_a_step_that_fails_moves_nobody(graphs: enfilade.Graphs) -> None:
    sim = enfilade.Simulator(graphs, 2)
    sim.new_random_episodes(["home0001", "home0002"])
    before = sim.viewpoint_ids(), sim.state.step.tolist()
    for bad in ([0, 99], [0, -1], [0]):
        with pytest.raises(ValueError):
            sim.step(bad)
    with pytest.raises(TypeError):
        sim.step([0.0, 1.0])
    with pytest.raises(ValueError, match="finite"):
        sim.step([0, 0], [math.nan, 0])
    assert (sim.viewpoint_ids(), sim.state.step.tolist()) == before
    for wrong in ({"batch_size": 0}, {"vfov": 4.0}, {"field_of_view": "wide"}, {"width": 0}):
        with pytest.raises(ValueError):
            enfilade.Simulator(graphs, **wrong)
    with pytest.raises(LookupError):
        sim.new_episodes(["home0001", "x"], ["a", "b"])


def test_names_and_indices_mean_the_same(graphs: enfilade.Graphs) -> None:
    a, b = enfilade.Simulator(graphs, 2), enfilade.Simulator(graphs, 2)
    ids = graphs["home0002"].viewpoints
    a.new_episodes(["home0002"] * 2, [ids[4], ids[7]])
    b.new_episodes(np.array([graphs.index("home0002")] * 2), np.array([4, 7], np.int64))
    assert (a.state.viewpoint == b.state.viewpoint).all() and b.viewpoint_ids() == [ids[4], ids[7]]


def test_candidates_of_all_viewpoints_are_those_of_each(graphs: enfilade.Graphs) -> None:
    sim = enfilade.Simulator(graphs)
    table = sim.all_candidates(["home0003"])
    row = 0
    for viewpoint in graphs["home0003"].viewpoints:
        for c in sim.candidates("home0003", viewpoint):
            got = (table.neighbour[row], table.view_index[row], table.index[row])
            assert got == (c.ix, c.view_index, c.index)
            assert table.normalized_heading[row] == c.normalized_heading
            assert table.angle[row] == c.angle and table.distance[row] == c.distance
            row += 1
    assert row == len(table.scan) and (table.scan == graphs.index("home0003")).all()


def raises(error: Any, words: str, call: Callable[[], Any]) -> None:
    with pytest.raises(error, match=words):
        call()


def test_wrong_arguments_are_named(graphs: enfilade.Graphs) -> None:
    """Field, value and what is allowed; and nobody has moved."""
    sim = enfilade.Simulator(graphs, 2)
    wrong, refused = enfilade.ArgumentError, TypeError
    raises(wrong, "agent 0: no episode", lambda: sim.viewpoint_ids())
    ids = graphs["home0001"].viewpoints
    sim.new_episodes(["home0001"] * 2, ids[:2])
    before = sim.viewpoint_ids(), sim.state.step.tolist()
    make, step, begin = enfilade.Simulator, sim.step, sim.new_episodes
    for error, words, call in [
        (refused, "graphs: a str", lambda: make("data/connectivity")),
        (wrong, "batch_size -1", lambda: make(graphs, -1)),
        (refused, "batch_size 1.5", lambda: make(graphs, 1.5)),
        (wrong, "width -1", lambda: make(graphs, width=-1)),
        (wrong, "seed -1", lambda: make(graphs, seed=-1)),
        (wrong, "seed 1844", lambda: make(graphs, seed=2**64)),
        (wrong, "max_navigable 0", lambda: make(graphs, max_navigable=0)),
        (wrong, "threads -3", lambda: make(graphs, threads=-3)),
        (wrong, "vertical field of view nan", lambda: make(graphs, vfov=math.nan)),
        (wrong, "elevation_limits", lambda: make(graphs, elevation_limits=(-1, 0, 1))),
        (wrong, "indices: 99 |index 99 ", lambda: step([0, 99])),
        (wrong, "indices: -1 of agent 1", lambda: step([0, -1])),
        (wrong, "indices: 8589934592 of agent 1", lambda: step([0, 2**33])),
        (wrong, "indices: 4294967296", lambda: step(np.array([0, 2**32], np.uint64))),
        (refused, "indices of type float64", lambda: step([0.0, 0.0])),
        (refused, "indices of type object", lambda: step(None)),
        (wrong, r"indices: shape \(1, 2\)", lambda: step([[0, 0]])),
        (wrong, "indices: 0 elements for a batch of 2", lambda: step([])),
        (wrong, "heading_changes: numbers", lambda: step([0, 0], ["a", "b"])),
        (wrong, "heading_changes: 3 elements", lambda: step([0, 0], [0, 0, 0])),
        (wrong, "elevation_changes: shape", lambda: step([0, 0], None, [[0, 0]])),
        (wrong, "elevation change inf", lambda: step([0, 0], None, [0, math.inf])),
        (wrong, "scans: 1 elements for a batch of 2", lambda: begin(["home0001"], ids[:1])),
        (wrong, "viewpoints: 1 for 2 scans", lambda: begin(["home0001"] * 2, ids[:1])),
        (wrong, "scan 99: 0 to 5", lambda: begin([99, 0], [0, 0])),
        (wrong, "scans: index 99: 0 to 5", lambda: begin([99, 0], ids[:2])),
        (wrong, "viewpoint 9999 of scan", lambda: begin([0, 0], [0, 9999])),
        (wrong, "viewpoints: 4294967296 of agent 1", lambda: begin([0, 0], [0, 2**32])),
        (refused, "scans of type .*integers or names", lambda: begin([b"home0001"] * 2, ids[:2])),
        (refused, "scans of type object", lambda: begin(None, None)),
        (wrong, "heading nan", lambda: begin(["home0001"] * 2, ids[:2], math.nan)),
        (enfilade.UnknownNameError, "nope", lambda: begin(["home0001"] * 2, ["nope", "nope"])),
        (wrong, "agent 7: 0 to 1", lambda: sim.new_episode(7, "home0001", ids[0])),
        (wrong, "agent -1", lambda: sim.new_episode(-1, "home0001", ids[0])),
        (enfilade.UnknownNameError, "nope", lambda: sim.candidates("home0001", "nope")),
        (wrong, "scan 99: 0 to 5", lambda: sim.all_candidates([99])),  # it used to abort
        (ValueError, "read-only", lambda: sim.state.heading.__setitem__(0, 1.0)),
        (wrong, "success_distance nan", lambda: enfilade.metrics(
            graphs, "home0001", ids[:1], ids[:1], math.nan)),
    ]:  # fmt: skip
        raises(error, words, call)
    assert (sim.viewpoint_ids(), sim.state.step.tolist()) == before
    assert len(sim.all_candidates([]).scan) == 0


def test_paths_and_names_come_as_people_have_them(small: str) -> None:
    """pathlib's paths; names in object arrays, as data frames give them; NumPy's integers."""
    graphs = enfilade.Graphs(Path(small) / "connectivity")
    assert list(graphs) == graphs.scans
    sim = enfilade.Simulator(graphs, np.int64(2), seed=np.uint32(3))
    ids = graphs["home0001"].viewpoints
    sim.new_episodes(np.array(["home0001"] * 2, object), np.array(ids[:2], object))
    assert sim.viewpoint_ids() == ids[:2]
    sim.new_episodes(np.array(["home0001"] * 2), tuple(ids[2:4]))
    assert sim.viewpoint_ids() == ids[2:4]
    episodes = enfilade.Episodes(Path(small), "val_seen")
    assert episodes[np.int64(0)] == episodes[0]
    with pytest.raises(enfilade.FileError, match="nowhere.json"):
        episodes.score(Path("nowhere.json"))
    count = len(episodes)
    with pytest.raises(IndexError, match=f"-{count + 1}: the split val_seen has {count}"):
        episodes[-count - 1]


# --- pictures -------------------------------------------------------------------------------------


@pytest.fixture
def pictured(data: Path, reference: Path) -> tuple[enfilade.Graphs, enfilade.Renderer, Any]:
    graphs = enfilade.Graphs(str(data / "connectivity"))
    scans = str(reference / "golden" / "scans")
    panoramas = enfilade.Panoramas([scans], str(data / "connectivity"), graphs)
    view = (["17DRP5sb8fy"], ["5b9b2794954e4694a45fc424a8643081"], [0.3])
    return graphs, enfilade.Renderer(graphs, panoramas), view


def test_renderer_draws_into_what_it_is_given(pictured: Any) -> None:
    _, renderer, view = pictured
    size = {"width": 64, "height": 48}
    fresh = renderer.render(*view, layers=("depth",), **size)
    assert fresh["rgb"].shape == (1, 48, 64, 3) and fresh["depth"].dtype == np.float32
    mine = {"rgb": np.zeros((1, 48, 64, 3), np.uint8), "depth": np.zeros((1, 48, 64), np.uint16)}
    drawn = renderer.render(*view, out=mine, **size)
    assert drawn["rgb"] is mine["rgb"] and (mine["rgb"] == fresh["rgb"]).all()
    assert np.abs(mine["depth"] / 4000 - fresh["depth"]).max() < 1e-3
    planar = renderer.render(*view, rgb="planar", **size)["rgb"]
    away = np.abs(planar[0].transpose(1, 2, 0) * 255 - fresh["rgb"][0])
    assert planar.shape == (1, 3, 48, 64) and away.max() <= 1
    for bad in ({"rgb": np.zeros((1, 48, 64, 3))}, {"rgb": np.zeros((48, 64, 3), np.uint8)},
                {"smell": np.zeros((1, 48, 64))}):  # fmt: skip
        with pytest.raises((ValueError, TypeError)):
            renderer.render(*view, out=bad, **size)
    read_only = np.zeros((1, 48, 64, 3), np.uint8)
    read_only.flags.writeable = False
    with pytest.raises(TypeError):
        renderer.render(*view, out={"rgb": read_only}, **size)


def test_pictures_are_ones_own_until_they_are_let_go_of(pictured: Any) -> None:
    """Memory is used again, but not while anything looks at it."""
    _, renderer, (scan, viewpoint, _) = pictured

    def draw(heading: float) -> Any:
        return renderer.render(  # noqa: F821 (deleted below, after the last call)
            scan, viewpoint, [heading], width=64, height=48
        )["rgb"]

    first = draw(0.0)
    kept, row = first.copy(), first[0, 5]
    second = draw(2.0)
    assert not np.shares_memory(first, second) and (first == kept).all()
    place = first.ctypes.data
    del first
    third = draw(2.0)
    assert (row == kept[0, 5]).all() and third.ctypes.data != place
    del row
    assert draw(1.0).ctypes.data == place
    many = [draw(heading) for heading in (0.0, 0.0, 2.0, 2.0, 0.0, 0.0)]
    assert all((one == kept).all() for one in many[:2] + many[4:])
    del renderer
    assert (many[0] == kept).all()


def test_jax_takes_pictures_without_a_copy(pictured: Any) -> None:
    jax = pytest.importorskip("jax", reason="JAX is not installed")
    _, renderer, view = pictured
    drawn = renderer.render(*view, rgb="planar", width=64, height=48)["rgb"]
    shared = jax.dlpack.from_dlpack(drawn)
    assert shared.shape == (1, 3, 48, 64) and (np.asarray(shared) == drawn).all()
    assert shared.unsafe_buffer_pointer() == drawn.ctypes.data
    # Headings may come from there too; its arrays cannot be drawn into, as they never change.
    again = renderer.render(*view[:2], jax.numpy.asarray(view[2]), width=64, height=48)["rgb"]
    assert again.shape == (1, 48, 64, 3)
    before = np.array(shared)
    with pytest.raises(enfilade.ArgumentError, match="JAX"):
        renderer.render(view[0], view[1], [2.0], rgb="planar", width=64, height=48,
                        out={"rgb": shared})  # fmt: skip
    assert (np.asarray(shared) == before).all()


def test_tensors_of_torch_are_drawn_into(pictured: Any) -> None:
    torch = pytest.importorskip("torch")
    _, renderer, view = pictured
    tensor = torch.zeros((1, 3, 48, 64))
    renderer.render(*view, rgb="imagenet", width=64, height=48, out={"rgb": tensor})
    assert tensor.std() > 0.1
    shared = torch.from_dlpack(renderer.render(*view, width=64, height=48)["rgb"])
    assert shared.shape == (1, 48, 64, 3)


def test_the_36_views_are_those_of_the_drop_in(pictured: Any, data: Path, reference: Path) -> None:
    import MatterSim

    _, renderer, _ = pictured
    scan, viewpoint = "17DRP5sb8fy", "5b9b2794954e4694a45fc424a8643081"
    views = renderer.render_36(scan, viewpoint, width=64, height=48, rgb="bgr8")["rgb"]
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(str(data / "connectivity"))
    sim.setDatasetPath(str(reference / "golden" / "scans"))
    sim.setDiscretizedViewingAngles(True)
    sim.setCameraResolution(64, 48)
    sim.setCameraVFOV(math.radians(60))
    for ix in range(36):
        if ix == 0:
            sim.newEpisode([scan], [viewpoint], [0], [math.radians(-30)])
        else:
            sim.makeAction([0], [1], [int(ix % 12 == 0)])
        away = np.abs(np.array(sim.getState()[0].rgb).astype(int) - views[ix])
        assert (away > 2).mean() < 0.03  # along faces' edges, which the drop-in does not smooth


def test_wrong_arguments_of_a_renderer_are_named(pictured: Any, graphs: enfilade.Graphs) -> None:
    real, renderer, (scan, viewpoint, headings) = pictured
    wrong, refused, size = enfilade.ArgumentError, TypeError, {"width": 64, "height": 48}

    def draw(**options: Any) -> Any:
        return renderer.render(scan, viewpoint, headings, **{**size, **options})

    def into(picture: Any, **options: Any) -> Callable[[], Any]:
        return lambda: draw(out={"rgb": picture}, **options)

    whole = np.zeros((1, 48, 64, 6), np.uint8)
    planar = (1, 3, 48, 64)
    for error, words, call in [
        (wrong, "'hsv'", lambda: draw(rgb="hsv")),
        (wrong, "'smell'", lambda: draw(layers=("smell",))),
        (refused, "a tuple is wanted", lambda: draw(layers="depth")),
        (wrong, "width -1", lambda: draw(width=-1)),
        (wrong, "size 0 x 48", lambda: draw(width=0)),
        (refused, "width 64.0", lambda: draw(width=64.0)),
        (wrong, "field of view 60 rad", lambda: draw(vfov=60)),
        (wrong, "headings: 1 numbers", lambda: renderer.render(scan, viewpoint, [0, 1])),
        (wrong, "headings: 1 numbers", lambda: renderer.render(scan, viewpoint, ["east"])),
        (wrong, "heading: nan", lambda: renderer.render(scan, viewpoint, [math.nan])),
        (wrong, "elevation: inf", lambda: renderer.render(scan, viewpoint, [0], [math.inf])),
        (wrong, "scans: index 999", lambda: renderer.render([999], viewpoint, [0])),
        (wrong, "scan: 999", lambda: renderer.render([999], [0], [0])),
        (wrong, "viewpoint: 9999", lambda: renderer.render(scan, [9999], [0])),
        (enfilade.UnknownNameError, "nope", lambda: renderer.render(scan, ["nope"], [0])),
        (refused, "out: a ndarray", lambda: draw(out=whole)),
        (refused, "out.'rgb'.: a list", into([[0]])),
        (refused, "out.'rgb'.: a bytes", into(b"123")),
        (refused, "contiguous", into(whole[..., ::2])),
        (refused, "contiguous", into(np.zeros((1, 48, 64, 3), np.uint8, order="F"))),
        (wrong, "64 bits a value", into(np.zeros((1, 48, 64, 3)))),
        (wrong, "16 bits a value", into(np.zeros(planar, np.int16), rgb="planar")),
        (wrong, "out.'smell'", lambda: draw(out={"smell": whole[..., :3]})),
        (wrong, "cache_bytes -1", lambda: make_like(renderer, real, cache_bytes=-1)),
        (wrong, "different scans", lambda: make_like(renderer, graphs)),
        (wrong, "different scans", lambda: renderer.render_agents(enfilade.Simulator(graphs))),
        (wrong, "no episode", lambda: renderer.render_agents(enfilade.Simulator(real))),
    ]:  # fmt: skip
        raises(error, words, call)


def test_halves_of_torch_are_told_apart(pictured: Any) -> None:
    torch = pytest.importorskip("torch", reason="torch is not installed")
    _, renderer, (scan, viewpoint, headings) = pictured

    def draw(type: Any) -> Any:
        picture = torch.zeros((1, 3, 48, 64), dtype=type)
        renderer.render(scan, viewpoint, headings, width=64, height=48, rgb="planar",
                        out={"rgb": picture})  # fmt: skip
        return picture

    raises(enfilade.ArgumentError, "16 bits a value", lambda: draw(torch.bfloat16))
    assert 0.1 < draw(torch.float16).float().mean() < 0.9


def make_like(renderer: enfilade.Renderer, graphs: enfilade.Graphs, **options: Any) -> Any:
    """Another renderer of the same panoramas."""
    return enfilade.Renderer(graphs, renderer.panoramas, **options)


def test_missing_pictures_are_named(graphs: enfilade.Graphs, small: str) -> None:
    panoramas = enfilade.open_panoramas(small, graphs)
    renderer = enfilade.Renderer(graphs, panoramas)
    with pytest.raises(enfilade.Error, match="home0001"):
        renderer.render(["home0001"], [0], [0])
    with pytest.raises(ValueError, match="backend"):
        enfilade.Renderer(graphs, panoramas, backend="paint")
    with pytest.raises(ValueError, match="cache 'public': one of private, shared"):
        enfilade.Renderer(graphs, panoramas, cache="public")
    with pytest.raises(ValueError, match="MiB"):
        enfilade.Renderer(graphs, panoramas, cache="shared", shared_bytes=1000)
    assert "cpu" in enfilade.backends() and "cpu" in renderer.description


# --- Room-to-Room ---------------------------------------------------------------------------------


def test_episodes_are_a_sequence_and_are_scored(small: str, tmp_path: Path) -> None:
    episodes = enfilade.Episodes(small, "val_unseen")
    assert len(episodes) == len(list(episodes)) > 10 and episodes[-1] == list(episodes)[-1]
    assert episodes[:2] == [episodes[0], episodes[1]]
    with pytest.raises(IndexError):
        episodes[len(episodes)]
    results = [
        {"instr_id": e.instruction_id, "trajectory": [[v, 0.0, 0.0] for v in e.path]}
        for e in episodes
    ]
    file = tmp_path / "results.json"
    file.write_text(json.dumps(results))
    score = episodes.score(str(file), bootstrap_samples=10)
    assert score.means["success"] == (1.0, 1.0, 1.0)
    assert score.means["ndtw"][0] == pytest.approx(1)
    assert len(score.episodes) == len(episodes) and score.warnings == []
    file.write_text(json.dumps(results[1:]))
    with pytest.raises(enfilade.InvalidInput, match=episodes[0].instruction_id):
        episodes.score(str(file))
    with pytest.raises(enfilade.FileError):
        enfilade.Episodes(small, "val_dark")


def test_metrics_of_a_path(small: str) -> None:
    episodes = enfilade.Episodes(small, "train")
    e = episodes[0]
    perfect = enfilade.metrics(episodes.graphs, e.scan, e.path, e.path)
    assert (perfect["success"], perfect["nav_error"], perfect["cls"]) == (1, 0, 1)
    stayed = enfilade.metrics(episodes.graphs, e.scan, e.path[:1], e.path)
    assert stayed["nav_error"] == episodes.graphs[e.scan].distance(e.path[0], e.path[-1])
    with pytest.raises(LookupError):
        enfilade.metrics(episodes.graphs, e.scan, ["nope"], e.path)
    with pytest.raises(ValueError):
        enfilade.metrics(episodes.graphs, e.scan, [], e.path)


def test_words_are_tokens(tmp_path: Path) -> None:
    assert enfilade.tokenize("Walk past the table, then stop.") == [
        "walk", "past", "the", "table", ",", "then", "stop", "."]  # fmt: skip
    words = enfilade.Vocabulary.build(["go left", "go right"], least_count=1)
    ids = words.encode("go left", 6)
    assert len(ids) == 6 and words.decode(ids) == "go left"
    words.save(tmp_path / "words.txt")
    assert enfilade.Vocabulary.load(tmp_path / "words.txt").words == words.words
