"""The calls that code of 2018 to 2026 makes of MatterSim, each in our own words."""

from __future__ import annotations

import base64
import csv
import math
import time
from pathlib import Path
from typing import Any

import enfilade
import MatterSim
import pytest

np = pytest.importorskip("numpy")

SCAN = "17DRP5sb8fy"
START = "5b9b2794954e4694a45fc424a8643081"
WIDTH, HEIGHT, VFOV = 640, 480, 60


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


def test_walking_to_the_goal_by_the_look_and_go_idiom(connectivity: str) -> None:
    """R2R's teacher: turn until the next viewpoint is in view and ahead, then go forward."""
    graphs = enfilade.Graphs(connectivity)
    graph = graphs[SCAN]
    goal = max(
        (v for v in graph.viewpoints if graph.included(v)), key=lambda v: graph.distance(START, v)
    )
    path = graph.path(START, goal)
    assert path is not None
    sim = make_v02(connectivity)
    sim.newEpisode([SCAN], [START], [0], [0])
    walked = [START]
    for _ in range(300):
        state = sim.getState()[0]
        here = state.location.viewpointId
        if here == goal:
            break
        ahead = path[path.index(here) + 1]
        seen = [k for k, w in enumerate(state.navigableLocations) if w.viewpointId == ahead]
        if seen:
            sim.makeAction(seen, [0], [0])
            walked.append(ahead)
        else:
            sim.makeAction([0], [1], [0])
    assert walked == path


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
    names = ["scanId", "viewpointId", "image_w", "image_h", "vfov", "features"]
    csv.field_size_limit(2**31 - 1)
    with open(file, "rt") as text:
        for item in csv.DictReader(text, delimiter="\t", fieldnames=names):
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
