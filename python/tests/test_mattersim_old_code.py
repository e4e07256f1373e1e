"""The calls that code of 2018 to 2026 makes of MatterSim, each in our own words."""

from __future__ import annotations

import base64
import csv
import itertools
import json
import math
import multiprocessing
import sys
import time
from collections import namedtuple
from pathlib import Path
from typing import Any, Optional

import enfilade
import MatterSim
import pytest
from old_simulator import NEIGHBOUR, SCAN, START

np = pytest.importorskip("numpy")

WIDTH, HEIGHT, VFOV = 640, 480, 60
TSV_FIELDS = ["scanId", "viewpointId", "image_w", "image_h", "vfov", "features"]


def set_up(connectivity: str) -> Any:
    """What both versions are told before they begin."""
    sim = MatterSim.Simulator()
    sim.setRenderingEnabled(False)
    sim.setDiscretizedViewingAngles(True)
    sim.setCameraResolution(WIDTH, HEIGHT)
    sim.setCameraVFOV(math.radians(VFOV))
    sim.setNavGraphPath(connectivity)
    return sim


def make_v02(connectivity: str) -> Any:
    """As everyone makes theirs since 2020: one simulator an agent, no pictures."""
    sim = set_up(connectivity)
    sim.setBatchSize(1)
    sim.initialize()
    return sim


def sweep_v02(sim: Any, scan: str, viewpoint: str) -> list[Any]:
    states = []
    for ix in range(36):
        if ix == 0:
            sim.newEpisode([scan], [viewpoint], [0], [math.radians(-30)])
        elif ix % 12 == 0:
            sim.makeAction([0], [1.0], [1.0])
        else:
            sim.makeAction([0], [1.0], [0])
        state = sim.getState()[0]
        assert state.viewIndex == ix
        states.append((state.heading, state.elevation, state.navigableLocations))
    return states


def test_the_sweep_of_36_views_counts_them(connectivity: str) -> None:
    states = sweep_v02(make_v02(connectivity), SCAN, START)
    assert [round(math.degrees(h)) for h, _, _ in states] == [30 * (i % 12) for i in range(36)]
    assert [round(math.degrees(e)) for _, e, _ in states] == [-30] * 12 + [0] * 12 + [30] * 12


def test_the_sweep_by_v01_calls(connectivity: str) -> None:
    sim = set_up(connectivity)
    sim.init()
    for ix in range(36):
        if ix == 0:
            sim.newEpisode(SCAN, START, 0, math.radians(-30))
        elif ix % 12 == 0:
            sim.makeAction(0, 1.0, 1.0)
        else:
            sim.makeAction(0, 1.0, 0)
        assert sim.getState().viewIndex == ix


@pytest.mark.parametrize(
    ("width", "height", "vfov", "step", "count"),
    [(224, 224, 90, 30, 12), (128, 128, 60, 30, 12), (330, 248, 60, 30, 12), (640, 480, 45, 45, 8),
     (600, 600, 80, 30, 12)],
)  # fmt: skip
def test_rings_of_views_by_other_cameras(
    connectivity: str, width: int, height: int, vfov: int, step: int, count: int
) -> None:
    """Rings of a level camera as BEVBert, GridMM, HAMT, NavGPT and REVERIE's object features have
    them; those that don't turn by 30 degrees are not discretized."""
    sim = MatterSim.Simulator()
    sim.setRenderingEnabled(False)
    sim.setNavGraphPath(connectivity)
    sim.setRestrictedNavigation(False)
    sim.setDiscretizedViewingAngles(step == 30)
    sim.setCameraResolution(width, height)
    sim.setCameraVFOV(math.radians(vfov))
    sim.setBatchSize(1)
    sim.initialize()
    turn = 1.0 if step == 30 else math.radians(step)
    for ix in range(count):
        if ix == 0:
            sim.newEpisode([SCAN], [START], [0], [0])
        else:
            sim.makeAction([0], [turn], [0])
        state = sim.getState()[0]
        assert state.viewIndex == (12 + ix if step == 30 else 0)
        assert math.degrees(state.heading) == pytest.approx(ix * step)
        assert len(state.navigableLocations) == 4
        assert np.array(state.rgb, copy=False).shape == (height, width, 3)


def test_angle_features_of_the_helper_simulator(connectivity: str) -> None:
    """[sin h, cos h, sin e, cos e] 32 times over, by a simulator that stands at one place for ever."""
    states = sweep_v02(
        make_v02(connectivity), "ZMojNkEp431", "2f4d90acd4024c269fb0efe49a8ac540"
    )
    feature = np.empty((36, 128), np.float32)
    for ix, (heading, elevation, _) in enumerate(states):
        feature[ix] = [
            math.sin(heading), math.cos(heading), math.sin(elevation), math.cos(elevation)
        ] * 32  # fmt: skip
    assert feature[15, :4] == pytest.approx([1, 0, 0, 1], abs=1e-6)
    assert feature[35, 124:] == pytest.approx([-0.5, 3**0.5 / 2, 0.5, 3**0.5 / 2], abs=1e-6)


def test_candidates_are_what_make_candidate_makes(connectivity: str) -> None:
    """The hot loop of EnvDrop's descendants, against the one call that replaces it."""
    sim = make_v02(connectivity)
    graphs = enfilade.Graphs(connectivity)
    native = enfilade.Simulator(graphs)
    graph = graphs[SCAN]
    for viewpoint in graph.viewpoints:
        if not graph.included(viewpoint):
            continue
        found: dict[str, dict[str, Any]] = {}
        for ix, (heading, elevation, ways) in enumerate(sweep_v02(sim, SCAN, viewpoint)):
            for j, way in enumerate(ways[1:]):
                angle = np.sqrt(way.rel_heading**2 + way.rel_elevation**2)
                if way.viewpointId in found and angle >= found[way.viewpointId]["distance"]:
                    continue
                found[way.viewpointId] = {
                    "pointId": ix,
                    "idx": j + 1,
                    "normalized_heading": heading + way.rel_heading,
                    "normalized_elevation": elevation + way.rel_elevation,
                    "distance": angle,
                    "position": (way.x, way.y, way.z),
                }
        candidates = native.candidates(SCAN, viewpoint)
        assert [c.viewpoint for c in candidates] == list(found)
        for c in candidates:
            old = found[c.viewpoint]
            assert (c.view_index, c.index) == (old["pointId"], old["idx"])
            assert c.normalized_heading == old["normalized_heading"]
            assert c.normalized_elevation == old["normalized_elevation"]
            assert c.angle == old["distance"] and c.position == old["position"]


def test_teleporting_by_new_episode(connectivity: str) -> None:
    """DUET's agents never act: they begin a new episode wherever they want to be."""
    sim = make_v02(connectivity)
    sim.newEpisode([SCAN], [START], [0], [0])
    state = sim.getState()[0]
    for _ in range(5):
        way = state.navigableLocations[-1]
        heading = (state.heading + way.rel_heading) % (2 * math.pi)
        elevation = state.elevation + way.rel_elevation
        target = way.viewpointId
        sim.newEpisode([state.scanId], [target], [heading], [elevation])
        state = sim.getState()[0]
        assert state.location.viewpointId == target and state.step == 0


def test_a_list_of_a_hundred_simulators_is_cheap(connectivity: str) -> None:
    sims = [make_v02(connectivity) for _ in range(100)]
    sims[0].newEpisode([SCAN], [START], [0], [0])
    begin = time.perf_counter()
    more = [make_v02(connectivity) for _ in range(100)]
    for sim in more:
        sim.newEpisode([SCAN], [START], [0], [0])
    assert time.perf_counter() - begin < 0.5  # they would read the graph a hundred times in 0.3 s
    for i, sim in enumerate(sims + more):
        sim.newEpisode([SCAN], [START], [i * 0.1], [0])
        ids = [loc.viewpointId for loc in sim.getState()[0].navigableLocations]
        assert ids[0] == START


class OneBatch:
    """R2R's own environment: one simulator, and an element an agent in each list."""

    def __init__(self, connectivity: str, agents: int) -> None:
        self.sim = set_up(connectivity)
        self.sim.setBatchSize(agents)
        self.sim.initialize()

    def begin(self, scans: list[str], starts: list[str], headings: list[float]) -> None:
        self.sim.newEpisode(scans, starts, headings, [0] * len(scans))

    def states(self) -> list[Any]:
        return list(self.sim.getState())

    def act(self, actions: list[tuple[int, float, float]]) -> None:
        indices, headings, elevations = [], [], []
        for index, heading, elevation in actions:
            indices.append(int(index))
            headings.append(float(heading))
            elevations.append(float(elevation))
        self.sim.makeAction(indices, headings, elevations)


class ManySimulators:
    """Everyone's since: a simulator an agent."""

    def __init__(self, connectivity: str, agents: int) -> None:
        self.sims = [make_v02(connectivity) for _ in range(agents)]

    def begin(self, scans: list[str], starts: list[str], headings: list[float]) -> None:
        for sim, scan, start, heading in zip(self.sims, scans, starts, headings):
            sim.newEpisode([scan], [start], [heading], [0])

    def states(self) -> list[Any]:
        return [sim.getState()[0] for sim in self.sims]

    def act(self, actions: list[tuple[int, float, float]]) -> None:
        for sim, (index, heading, elevation) in zip(self.sims, actions):
            sim.makeAction([index], [heading], [elevation])


def teach(state: Any, ahead: Optional[str], where: Any) -> tuple[int, float, float]:
    """R2R's teacher of six actions: look until the next viewpoint is ahead, then go; None: stop."""
    if ahead is None:
        return 0, 0, 0
    for index, way in enumerate(state.navigableLocations):
        if way.viewpointId == ahead:
            if abs(way.rel_heading) > math.pi / 6:
                return 0, math.copysign(1, way.rel_heading), 0
            if way.rel_elevation > math.pi / 6 and state.viewIndex // 12 < 2:
                return 0, 0, 1
            if way.rel_elevation < -math.pi / 6 and state.viewIndex // 12 > 0:
                return 0, 0, -1
            return index, 0, 0
    if state.viewIndex // 12 != 1:
        return 0, 0, 1 - state.viewIndex // 12
    here = state.location
    heading = math.pi / 2 - math.atan2(where[1] - here.y, where[0] - here.x)
    right = (heading - state.heading) % (2 * math.pi) < math.pi
    return 0, 1 if right else -1, 0


@pytest.mark.parametrize("kind", [OneBatch, ManySimulators])
def test_walking_to_the_goals_by_the_look_and_go_idiom(
    data: Path, connectivity: str, kind: Any
) -> None:
    """Twenty paths of R2R, each walked to its end, a batch or a list of simulators at a time; and
    what its evaluation makes of the trajectories."""
    graphs = enfilade.Graphs(connectivity)
    items = json.loads((data / "r2r" / "R2R_val_seen.json").read_text())[:20]
    environment = kind(connectivity, len(items))
    environment.begin(
        [item["scan"] for item in items],
        [item["path"][0] for item in items],
        [item["heading"] for item in items],
    )
    trajectories: list[list[tuple[str, float, float]]] = [[] for _ in items]
    for _ in range(200):
        actions = []
        for item, state, trajectory in zip(items, environment.states(), trajectories):
            here, graph = state.location.viewpointId, graphs[item["scan"]]
            trajectory.append((here, state.heading, state.elevation))
            ahead = None if here == item["path"][-1] else graph.path(here, item["path"][-1])[1]
            where = None if ahead is None else graph.positions[graph.index(ahead)]
            actions.append(teach(state, ahead, where))
        if not any(any(action) for action in actions):
            break
        environment.act(actions)
    for item, trajectory in zip(items, trajectories):
        walked = [place for place, _ in itertools.groupby(place for place, _, _ in trajectory)]
        found = enfilade.metrics(graphs, item["scan"], walked, item["path"])
        assert (found["success"], found["nav_error"], found["spl"]) == (1, 0, pytest.approx(1))


def test_pictures_alias_and_are_copied_as_old_code_does(
    reference: Path, connectivity: str
) -> None:
    sim = MatterSim.Simulator()
    sim.setDatasetPath(str(reference / "golden" / "scans"))
    sim.setNavGraphPath(connectivity)
    sim.setDiscretizedViewingAngles(True)
    sim.setCameraResolution(160, 120)
    sim.setDepthEnabled(True)
    sim.setCacheSize(1)
    sim.setBatchSize(2)
    sim.initialize()
    sim.newEpisode([SCAN] * 2, [START] * 2, [0, math.pi], [0, 0])
    first, second = sim.getState()
    seen = np.array(first.rgb, copy=False)
    kept = np.array(first.rgb, copy=True)[:, :, ::-1]
    assert seen.base is not None and seen.any() and seen.shape == (120, 160, 3)
    assert (np.array(second.rgb, copy=False) != seen).any()
    assert (kept[:, :, ::-1] == seen).all()
    sim.makeAction([0, 0], [1, 0], [0, 0])
    assert (kept[:, :, ::-1] != seen).any()  # the simulator drew over it
    assert np.array(first.depth, copy=False).squeeze().shape == (120, 160)
    sim.newEpisode([SCAN] * 2, [START] * 2, [0, math.pi], [0, 0])
    assert (kept[:, :, ::-1] == seen).all()


def extract(scans: str, connectivity: str, file: Optional[str] = None) -> float:
    """The script that everyone has of the 36 views' features, with means of colours for a network."""
    sim = MatterSim.Simulator()
    sim.setDatasetPath(scans)
    sim.setNavGraphPath(connectivity)
    sim.setRenderingEnabled(True)
    sim.setDiscretizedViewingAngles(True)
    sim.setDepthEnabled(False)
    sim.setPreloadingEnabled(False)
    sim.setBatchSize(1)
    sim.setCameraResolution(160, 120)
    sim.setCameraVFOV(math.radians(VFOV))
    sim.initialize()
    features = np.empty((36, 3), np.float32)
    for ix in range(36):
        if ix == 0:
            sim.newEpisode([SCAN], [START], [0], [math.radians(-30)])
        else:
            sim.makeAction([0], [1.0], [1.0 if ix % 12 == 0 else 0])
        state = sim.getState()[0]
        assert state.viewIndex == ix
        image = np.array(state.rgb, copy=True).astype(np.float32, copy=True)
        image -= np.array([[[103.1, 115.9, 123.2]]])  # B, G, R
        features[ix] = image.mean(axis=(0, 1))
    assert len(np.unique(features, axis=0)) == 36
    if file is not None:
        with open(file, "wt") as out:
            writer = csv.DictWriter(out, delimiter="\t", fieldnames=TSV_FIELDS)
            text = str(base64.b64encode(features), "utf-8")
            writer.writerow(dict(zip(TSV_FIELDS, (SCAN, START, 160, 120, VFOV, text))))
    return float(features.sum())


def test_the_extraction_script_writes_what_is_read(
    reference: Path, connectivity: str, tmp_path: Path
) -> None:
    from enfilade import features

    total = extract(str(reference / "golden" / "scans"), connectivity, str(tmp_path / "f.tsv"))
    read = features.open_features(tmp_path / "f.tsv")
    assert float(read[SCAN, START].sum()) == total
    assert (read.info.width, read.info.height, read.info.vfov) == (160, 120, 60)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_extraction_in_worker_processes(reference: Path, connectivity: str, method: str) -> None:
    """HAMT's script: simulators in worker processes, here of a parent that has drawn already."""
    arguments = (str(reference / "golden" / "scans"), connectivity)
    here = extract(*arguments)
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.starmap_async(extract, [arguments] * 3).get(timeout=300) == [here] * 3


def test_a_driver_writes_on_what_it_is_shown(reference: Path, connectivity: str) -> None:
    """The demo's loop numbers the ways on the picture itself (cv2.putText in place), which has to be
    contiguous and writeable; the next action draws over it."""
    sim = MatterSim.Simulator()
    sim.setDatasetPath(str(reference / "golden" / "scans"))
    sim.setNavGraphPath(connectivity)
    sim.setCameraResolution(320, 240)
    sim.setCameraVFOV(math.radians(VFOV))
    sim.setDepthEnabled(True)
    assert sim.setElevationLimits(-0.6, 0.6)
    sim.initialize()
    sim.newEpisode([SCAN], [START], [0], [0])
    heading, elevation = math.radians(5), 0.7
    for _ in range(3):
        sim.makeAction([0], [heading], [elevation])
        state = sim.getState()[0]
        rgb, depth = np.array(state.rgb, copy=False), np.array(state.depth, copy=False)
        for number, way in enumerate(state.navigableLocations[1:]):
            size = 3.0 / way.rel_distance
            assert size > 0 and abs(way.rel_heading) < math.radians(VFOV * 4 / 3) / 2
            x = int(160 + way.rel_heading / math.radians(VFOV * 4 / 3) * 320)
            rgb[:9, max(x, 0) : x + 9] = number
        rgb[-9:] = 255
        assert rgb.flags.c_contiguous and rgb.flags.writeable and depth.flags.c_contiguous
        assert (np.array(sim.getState()[0].rgb, copy=False)[-9:] == 255).all()
    assert state.elevation == 0.6
    sim.makeAction([0], [0], [0])
    assert not (rgb[-9:] == 255).all()
    assert np.asarray(state.depth).max() * 0.25 / 1000 < 20  # metres


@pytest.mark.parametrize("version", ["v0.1", "v0.2"])
def test_pictures_that_are_missing_move_nobody(
    reference: Path, connectivity: str, version: str
) -> None:
    """There are pictures of START and of one of its three neighbours. The old ones had moved."""
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(connectivity)
    sim.setDatasetPath("/nonexistent")
    sim.setCameraResolution(64, 48)
    one = version == "v0.1"
    getattr(sim, "init" if one else "initialize")()
    begin = (SCAN, START, 0, 0) if one else ([SCAN], [START], [0], [0])
    with pytest.raises(ValueError, match="/nonexistent"):
        sim.newEpisode(*begin)
    if not one:
        sim.close()
    sim.setDatasetPath(str(reference / "golden" / "scans"))
    sim.newEpisode(*begin)
    for _ in range(12):
        state = sim.getState() if one else sim.getState()[0]
        kept = (state.step, state.heading, state.location.viewpointId, np.array(state.rgb))
        ids = [way.viewpointId for way in state.navigableLocations]
        for index, name in enumerate(ids):
            if name not in (START, NEIGHBOUR):
                with pytest.raises(ValueError, match=name):
                    sim.makeAction(*((index, 1.0, 0) if one else ([index], [1.0], [0])))
                state = sim.getState() if one else sim.getState()[0]
                now = (state.step, state.heading, state.location.viewpointId)
                assert now == kept[:3] and (np.array(state.rgb) == kept[3]).all()
                assert [way.viewpointId for way in state.navigableLocations] == ids
        sim.makeAction(*((0, 0.5, 0) if one else ([0], [0.5], [0])))


@pytest.mark.parametrize("cache", [0, 1, 2, 200])
def test_small_caches_draw_no_black_pictures(
    reference: Path, connectivity: str, cache: int
) -> None:
    sim = MatterSim.Simulator()
    sim.setDatasetPath(str(reference / "golden" / "scans"))
    sim.setNavGraphPath(connectivity)
    sim.setCameraResolution(64, 48)
    sim.setCacheSize(cache)
    sim.setBatchSize(4)
    sim.initialize()
    sim.newEpisode([SCAN] * 4, [START, NEIGHBOUR] * 2, [0] * 4, [0] * 4)
    means = [np.array(state.rgb, copy=False).mean() for state in sim.getState()]
    assert means[:2] == means[2:] and min(means) > 10 and means[0] != means[1]


def test_two_simulators_with_pictures_do_not_disturb_each_other(
    reference: Path, connectivity: str
) -> None:
    def make(width: int, height: int) -> Any:
        sim = MatterSim.Simulator()
        sim.setDatasetPath(str(reference / "golden" / "scans"))
        sim.setNavGraphPath(connectivity)
        sim.setCameraResolution(width, height)
        sim.newEpisode([SCAN], [START], [0], [0])
        return sim

    a = make(64, 48)
    alone = np.array(a.getState()[0].rgb)
    b = make(32, 24)
    a.makeAction([0], [0], [0])
    assert (np.array(a.getState()[0].rgb) == alone).all()
    a.close()
    b.makeAction([0], [0.1], [0])
    assert np.array(b.getState()[0].rgb).mean() > 10


WorldState = namedtuple("WorldState", ["scanId", "viewpointId", "heading", "elevation"])


def world_state(sim: Any) -> WorldState:
    state = sim.getState()
    return WorldState(state.scanId, state.location.viewpointId, state.heading, state.elevation)


def test_beams_take_several_states_from_one_simulator(connectivity: str) -> None:
    """Speaker-follower's search (v0.1): world states are kept, gone back to, and compared with
    states that were taken before others."""
    sim = set_up(connectivity)
    sim.init()
    beams = [WorldState(SCAN, START, heading, 0) for heading in np.linspace(0, 6, 5)]
    taken = []
    for beam in beams:
        sim.newEpisode(*beam)
        taken.append((world_state(sim), sim.getState()))
    assert len({kept.heading for kept, _ in taken}) == 5
    for kept, state in taken:
        assert kept == (state.scanId, state.location.viewpointId, state.heading, state.elevation)
    nexts = []
    for kept, _ in taken:
        sim.newEpisode(*kept)
        sim.makeAction(np.int64(0), np.sign(-1), 0)
        nexts.append(world_state(sim))
    turns = [(kept.heading - after.heading) / (math.pi / 6) for (kept, _), after in zip(taken, nexts)]
    assert [round(turn) % 12 for turn in turns] == [1] * 5


def test_v01_goes_to_a_view_and_then_to_a_neighbour(connectivity: str) -> None:
    """Panoramic actions (v0.1): the best view of each neighbour; turning there; going."""
    sim = set_up(connectivity)
    sim.init()
    sim.newEpisode(SCAN, START, 0, math.radians(-30))
    best: dict[str, tuple[float, int, Any]] = {}
    for ix in range(36):
        state = sim.getState()
        assert state.viewIndex == ix
        for way in state.navigableLocations[1:]:
            angle = math.hypot(way.rel_heading, way.rel_elevation)
            if way.viewpointId not in best or angle < best[way.viewpointId][0]:
                best[way.viewpointId] = (angle, ix, way)
        sim.makeAction(0, 1, 1 if ix % 12 == 11 else 0)
    assert len(best) == 3
    for name, (_, view, way) in best.items():
        sim.newEpisode(SCAN, START, 0, 0)
        turn = (view % 12 - sim.getState().viewIndex + 6) % 12 - 6
        tilt = view // 12 - sim.getState().viewIndex // 12
        for _ in range(abs(turn)):
            sim.makeAction(0, np.sign(turn), 0)
        for _ in range(abs(tilt)):
            sim.makeAction(0, 0, np.sign(tilt))
        state = sim.getState()
        assert state.viewIndex == view
        index = [one.viewpointId for one in state.navigableLocations].index(name)
        sim.makeAction(index, 0, 0)
        assert sim.getState().location.viewpointId == name
        assert sim.getState().location.point == way.point == [way.x, way.y, way.z]


def test_v01_pictures_are_arrays_of_their_own(reference: Path, connectivity: str) -> None:
    sim = MatterSim.Simulator()
    sim.setDatasetPath(str(reference / "golden" / "scans"))
    sim.setNavGraphPath(connectivity)
    sim.setCameraResolution(64, 48)
    sim.init()
    sim.newEpisode(SCAN, START, 0, 0)
    state = sim.getState()
    assert isinstance(state.rgb, np.ndarray) and state.rgb.shape == (48, 64, 3)
    assert state.rgb.flags.owndata and state.rgb.flags.writeable and state.rgb is state.rgb
    before = state.rgb.copy()
    sim.makeAction(0, 1.0, 0)
    assert (state.rgb == before).all() and (sim.getState().rgb != before).any()


def test_feature_files_are_read_by_the_usual_loop(tmp_path: Path) -> None:
    """What enfilade.features writes is read by the loop that everyone has, and the other way."""
    from enfilade import features

    rng = np.random.default_rng(1)
    values = rng.standard_normal((36, 16)).astype(np.float32)
    file = tmp_path / "features.tsv"
    features.write_tsv(str(file), {(SCAN, START): values}, width=640, height=480, vfov=60)
    csv.field_size_limit(sys.maxsize)
    with open(file, "rt") as text:
        for item in csv.DictReader(text, delimiter="\t", fieldnames=TSV_FIELDS):
            assert int(item["image_h"]) == 480 and int(item["vfov"]) == 60
            key = (item["scanId"], item["viewpointId"])
            data = base64.decodebytes(bytearray(item["features"], "utf-8"))
            old = np.frombuffer(data, np.float32).reshape((36, -1))
            assert key == (SCAN, START) and (old == values).all()
    (again,) = features.read_tsv(str(file))
    assert again.scan == SCAN and (again.features == values).all()


def test_names_that_old_code_asks_for(connectivity: str) -> None:
    sim = make_v02(connectivity)
    sim.newEpisode([SCAN], [START], [0], [0])
    state = sim.getState()[0]
    assert isinstance(sim, MatterSim.Simulator) and isinstance(state, MatterSim.SimState)
    assert isinstance(state.location, MatterSim.ViewPoint)
    assert isinstance(state.rgb, MatterSim.Mat)
    sim.resetTimers()
    assert isinstance(sim.timingInfo(), str)


def test_cbf_fills_holes_from_pixels_of_like_brightness() -> None:
    depth = np.full((48, 64), 200, np.uint8, order="F")
    depth[:, 32:] = 50
    brightness = np.full((48, 64), 250, np.uint8, order="F")
    brightness[:, 32:] = 20
    mask = np.zeros((48, 64), np.uint8, order="F")
    mask[10:20, 26:38] = 1
    holes = depth.copy(order="F")
    holes[mask == 1] = 0
    result = np.empty_like(depth, order="F")
    MatterSim.cbf(holes, brightness, mask, result)
    assert (result[mask == 0] == depth[mask == 0]).all()
    # Truncated to 8 bits twice on the way.
    assert np.abs(result.astype(int) - depth)[mask == 1].max() <= 2
    with pytest.raises(ValueError):
        MatterSim.cbf(holes, brightness, np.asfortranarray(mask[:10]), result)
    with pytest.raises(TypeError):
        MatterSim.cbf(holes.astype(float), brightness, mask, result)


def test_cbf_takes_what_the_old_scripts_gave_it() -> None:
    """A mask of bool, and a colour picture larger than depth."""
    random = np.random.default_rng(1)
    depth = np.asfortranarray(random.integers(1, 255, (32, 40)).astype(np.uint8))
    brightness = np.asfortranarray(random.integers(0, 255, (32, 40)).astype(np.uint8))
    mask = np.asfortranarray(random.random((32, 40)) < 0.2)
    wanted, found = np.empty_like(depth), np.empty_like(depth)
    MatterSim.cbf(depth, brightness, np.asfortranarray(mask.astype(np.uint8)), wanted)
    MatterSim.cbf(depth, brightness, mask, found)
    assert (found == wanted).all()
    larger = np.zeros((48, 60), np.uint8, order="F")
    larger.ravel(order="K")[: brightness.size] = brightness.ravel(order="K")
    MatterSim.cbf(depth, larger, mask, found)
    assert (found == wanted).all()
    with pytest.raises(ValueError, match="at least as many"):
        MatterSim.cbf(depth, np.asfortranarray(brightness[:10]), mask, found)
    with pytest.raises(TypeError, match="bool"):
        MatterSim.cbf(depth, brightness, np.asfortranarray(mask.astype(np.float32)), found)


def test_the_other_name_of_the_package() -> None:
    """GridMM imports it by the repository's name."""
    import Matterport3DSimulator
    from Matterport3DSimulator import MatterSim as inner

    assert Matterport3DSimulator.Simulator is MatterSim.Simulator and inner is MatterSim
    assert Matterport3DSimulator.__all__ == [*MatterSim.__all__, "MatterSim"]
