"""Malformed calls, each as the old simulator answered it (reference: what its two versions were seen
to do), or better where it aborted, crashed, or went on with half of an action."""

from __future__ import annotations

import copy
import json
import math
import pickle
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any, Callable

import MatterSim
import pytest

np = pytest.importorskip("numpy")

SCAN = "17DRP5sb8fy"
START = "5b9b2794954e4694a45fc424a8643081"
EXCLUDED = "cb6a9786e4ff47f79a11b024c36ef7c0"


@pytest.fixture
def make(connectivity: str) -> Callable[..., MatterSim.Simulator]:
    def make(batch: int = 1, discretized: bool = False, begin: str = "initialize") -> Any:
        sim = MatterSim.Simulator()
        sim.setNavGraphPath(connectivity)
        sim.setRenderingEnabled(False)
        sim.setBatchSize(batch)
        sim.setDiscretizedViewingAngles(discretized)
        if begin:
            getattr(sim, begin)()
        return sim

    return make


def start(sim: Any, n: int = 1, heading: float = 0, elevation: float = 0) -> None:
    sim.newEpisode([SCAN] * n, [START] * n, [heading] * n, [elevation] * n)


def summary(sim: Any) -> list[tuple[Any, ...]]:
    return [
        (s.scanId, s.step, s.location and s.location.viewpointId, s.heading, s.elevation,
         s.viewIndex, len(s.navigableLocations))
        for s in sim.getState()
    ]  # fmt: skip


# --- names ----------------------------------------------------------------------------------------


def test_unknown_scan_is_an_index_error(make: Any) -> None:
    with pytest.raises(IndexError, match="nowhere"):
        make().newEpisode(["nowhere"], [START], [0], [0])
    with pytest.raises(IndexError, match="nowhere"):
        make().newRandomEpisode(["nowhere"])


@pytest.mark.parametrize("viewpoint, words", [("nope", "nope"), (EXCLUDED, "excluded")])
def test_unknown_and_excluded_viewpoints_are_value_errors(
    make: Any, viewpoint: str, words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        make().newEpisode([SCAN], [viewpoint], [0], [0])
    with pytest.raises(ValueError, match=words):
        make(begin="init").newEpisode(SCAN, viewpoint, 0, 0)


def test_missing_graphs_are_value_errors_at_the_first_episode(tmp_path: Path) -> None:
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(str(tmp_path / "nowhere"))
    sim.setRenderingEnabled(False)
    sim.initialize()
    with pytest.raises(ValueError, match="scans.txt"):
        start(sim)


@pytest.mark.parametrize("content", [None, '[{"image_id": "a", "pose": [1,'])
def test_broken_graph_files_are_value_errors_not_aborts(tmp_path: Path, content: str) -> None:
    (tmp_path / "scans.txt").write_text("zzzz\n")
    if content:
        (tmp_path / "zzzz_connectivity.json").write_text(content)
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(str(tmp_path))
    sim.setRenderingEnabled(False)
    with pytest.raises(ValueError, match="zzzz_connectivity.json"):
        sim.newEpisode(["zzzz"], ["a"], [0], [0])


def test_each_simulator_has_its_own_graphs(tmp_path: Path, make: Any) -> None:
    start(make())
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(str(tmp_path))
    sim.setRenderingEnabled(False)
    with pytest.raises(ValueError, match="scans.txt"):
        start(sim)


# --- lists ----------------------------------------------------------------------------------------


def test_short_lists_are_index_errors_and_nothing_happens(make: Any) -> None:
    sim = make(batch=2)
    with pytest.raises(IndexError, match="1 elements for a batch of 2"):
        start(sim, 1)
    with pytest.raises(IndexError):
        sim.newEpisode([], [], [], [])
    with pytest.raises(IndexError):
        sim.newRandomEpisode([])
    start(sim, 2)
    before = summary(sim)
    with pytest.raises(IndexError):
        sim.makeAction([0], [0.1], [0])
    assert summary(sim) == before


def test_longer_lists_are_accepted_and_their_excess_unused(make: Any) -> None:
    sim = make()
    start(sim, 2)
    sim.makeAction([0, 5, 9], [0.1, 1, 1], [0, 0, 0])
    assert summary(sim) == [(SCAN, 1, START, 0.1, 0.0, 0, 2)]


def test_a_batch_of_none_is_a_batch(make: Any) -> None:
    sim = make(batch=0)
    sim.newEpisode([], [], [], [])
    sim.makeAction([], [], [])
    assert sim.getState() == []


# --- actions --------------------------------------------------------------------------------------


def test_an_index_out_of_range_is_a_value_error_and_nobody_moves(make: Any) -> None:
    sim = make(batch=2)
    start(sim, 2)
    before = summary(sim)
    with pytest.raises(ValueError, match="Invalid action index: 99 in environment 1 of 2"):
        sim.makeAction([1, 99], [0.5, 0.5], [0, 0])
    assert summary(sim) == before


@pytest.mark.parametrize("index", [-1, 0.0, "0", None, [0]])
def test_other_things_than_indices_are_type_errors(make: Any, index: Any) -> None:
    sim = make()
    start(sim)
    with pytest.raises(TypeError):
        sim.makeAction([index], [0], [0])
    with pytest.raises(TypeError):
        sim.makeAction([0], ["east"], [0])


def test_numpy_numbers_lists_tuples_and_arrays_are_fine(make: Any) -> None:
    sim = make()
    sim.newEpisode((SCAN,), np.array([START]), np.array([0]), np.array([0], np.float32))
    sim.makeAction([np.int64(0)], [np.float32(0.5)], (np.int32(0),))
    sim.makeAction(np.array([0]), np.array([0.5]), np.array([0]))
    sim.makeAction([np.array([0])], [True], [0])
    assert summary(sim)[0][:4] == (SCAN, 3, START, 2.0)


def test_scalars_after_initialize_and_lists_after_init_are_type_errors(make: Any) -> None:
    sim = make()
    with pytest.raises(TypeError, match="lists"):
        sim.newEpisode(SCAN, START, 0, 0)
    start(sim)
    with pytest.raises(TypeError, match="lists"):
        sim.makeAction(0, 0, 0)
    sim = make(begin="init")
    with pytest.raises(TypeError, match="scalars"):
        start(sim)


def test_keywords_and_missing_arguments_are_type_errors(make: Any) -> None:
    sim = make()
    with pytest.raises(TypeError):
        sim.setBatchSize(size=2)
    with pytest.raises(TypeError):
        sim.setCameraResolution(width=10, height=10)
    with pytest.raises(TypeError):
        sim.newEpisode([SCAN], [START])
    with pytest.raises(TypeError):
        sim.setBatchSize(-1)


def test_actions_out_of_turn(make: Any) -> None:
    with pytest.raises(RuntimeError, match="newEpisode"):
        make(begin="").makeAction([0], [0], [0])
    with pytest.raises(ValueError, match="Invalid action index"):
        make().makeAction([0], [0], [0])
    sim = make()
    start(sim)
    sim.close()
    sim.close()
    with pytest.raises(RuntimeError, match="newEpisode"):
        sim.makeAction([0], [0], [0])


def test_states_out_of_turn(make: Any) -> None:
    assert make(begin="").getState() == []
    assert summary(make()) == [("", 0, None, 0.0, 0.0, 0, 0)]
    sim = make(begin="")
    start(sim)
    assert summary(sim) == [(SCAN, 0, START, 0.0, 0.0, 0, 2)]


# --- numbers --------------------------------------------------------------------------------------


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("discretized", [False, True])
def test_angles_that_are_no_numbers_are_refused(make: Any, bad: float, discretized: bool) -> None:
    """The old one took them, and was at heading NaN from then on."""
    sim = make(discretized=discretized)
    with pytest.raises(ValueError, match="finite"):
        start(sim, heading=bad)
    with pytest.raises(ValueError, match="finite"):
        start(sim, elevation=bad)
    start(sim)
    before = summary(sim)
    with pytest.raises(ValueError, match="finite"):
        sim.makeAction([1], [bad], [0])
    assert summary(sim) == before


def test_strange_but_finite_angles_are_wrapped_as_before(make: Any) -> None:
    sim = make()
    start(sim, heading=1e18)
    assert summary(sim) == [(SCAN, 0, START, 6.113645647067365, 0.0, 0, 2)]
    start(sim, heading=-1e-17)
    assert sim.getState()[0].heading == 2 * math.pi
    sim = make(discretized=True)
    start(sim, heading=-1e-17)
    assert summary(sim) == [(SCAN, 0, START, 0.0, 0.0, 12, 2)]


def test_elevation_limits_are_taken_or_left() -> None:
    sim = MatterSim.Simulator()
    bad = [(0, 0.5), (-0.5, 0), (0.5, 0.6), (-math.pi / 2, 0.5), (-0.5, math.pi / 2)]
    assert [sim.setElevationLimits(*limits) for limits in bad] == [False] * 5
    assert sim.setElevationLimits(-0.5, 0.5) is True


def test_a_camera_without_pixels(make: Any) -> None:
    sim = make(begin="")
    sim.setCameraResolution(-1, 10)
    with pytest.raises(RuntimeError, match="-1 x 10"):
        sim.initialize()
    sim.setCameraResolution(0, 0)  # the old one went on, with empty pictures
    with pytest.raises(ValueError, match="0"):
        sim.initialize()


def test_the_linear_field_of_view_turns_round_past_a_whole_turn(make: Any) -> None:
    found = []
    for vfov in [1.07, 2.67, 4.0, 5.33, 6.27, 8.0, 12.0]:
        sim = make(begin="")
        sim.setCameraResolution(1000, 250)
        sim.setCameraVFOV(vfov / 4)
        start(sim)
        found.append(len(sim.getState()[0].navigableLocations))
    assert found == [2, 2, 2, 3, 4, 2, 2]


# --- setters and life -----------------------------------------------------------------------------


def test_setters_after_initialize_warn_and_wait(make: Any) -> None:
    sim = make()
    for setter, value in [
        ("setBatchSize", 3), ("setDiscretizedViewingAngles", True),
        ("setRestrictedNavigation", False), ("setRenderingEnabled", True),
        ("setDepthEnabled", True), ("setPreloadingEnabled", True), ("setCacheSize", 3),
        ("setNavGraphPath", "x"), ("setDatasetPath", "x"),
    ]:  # fmt: skip
        with pytest.warns(RuntimeWarning, match=setter):
            getattr(sim, setter)(value)
    start(sim, heading=0.1, elevation=0.2)
    assert summary(sim) == [(SCAN, 0, START, 0.1, 0.2, 0, 2)]


def test_camera_and_limits_are_heeded_at_the_next_action(make: Any) -> None:
    sim = make()
    start(sim, heading=0.1, elevation=0.2)
    sim.setCameraVFOV(1.5)
    sim.setCameraResolution(640, 200)
    assert sim.setElevationLimits(-0.1, 0.1)
    assert summary(sim)[0][1:5] == (0, START, 0.1, 0.2)
    sim.makeAction([0], [0], [0])
    state = sim.getState()[0]
    assert (state.step, state.heading, state.elevation) == (1, 0.1, 0.1)
    assert np.array(state.rgb).shape == (240, 320, 3)  # black, as nothing is drawn
    other = make(begin="")
    other.setCameraVFOV(1.5)
    other.setCameraResolution(640, 200)
    start(other, heading=0.1, elevation=0.1)
    assert summary(other)[0][3:] == summary(sim)[0][3:]


def test_initialize_again_and_close_then_initialize_begin_anew(make: Any) -> None:
    sim = make()
    start(sim)
    sim.initialize()
    assert summary(sim) == [("", 0, None, 0.0, 0.0, 0, 0)]
    start(sim)
    sim.close()
    sim.setBatchSize(2)
    sim.initialize()
    start(sim, 2)
    assert len(sim.getState()) == 2


def test_missing_pictures_are_value_errors_and_nothing_happens(connectivity: str) -> None:
    for preload in (False, True):
        sim = MatterSim.Simulator()
        sim.setNavGraphPath(connectivity)
        sim.setDatasetPath("/nonexistent")
        sim.setPreloadingEnabled(preload)
        with pytest.raises(ValueError, match="/nonexistent"):
            sim.initialize()
            start(sim)


def test_preloading_without_rendering_loads_nothing(connectivity: str) -> None:
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(connectivity)
    sim.setDatasetPath("/nonexistent")
    sim.setRenderingEnabled(False)
    sim.setPreloadingEnabled(True)
    start(sim)
    assert len(sim.getState()) == 1


# --- objects --------------------------------------------------------------------------------------


def test_states_alias_the_simulator(make: Any) -> None:
    sim = make()
    start(sim)
    state, here, ways = sim.getState()[0], None, None
    here, ways = state.location, state.navigableLocations
    sim.makeAction([1], [1.0], [0])
    assert sim.getState()[0] is state and state.heading == 1.0
    assert state.location is ways[1] and state.location is not here
    assert state.navigableLocations[0] is state.location
    assert (ways[1].rel_heading, ways[1].rel_elevation, ways[1].rel_distance) == (0, 0, 0)
    assert state.navigableLocations is not state.navigableLocations
    state.navigableLocations.clear()
    assert len(state.navigableLocations) >= 1


def test_mats_are_writeable_arrays_of_three_dimensions(make: Any) -> None:
    sim = make()
    start(sim)
    state = sim.getState()[0]
    rgb = np.asarray(state.rgb)
    depth = np.asarray(state.depth)
    assert (rgb.shape, rgb.dtype, rgb.strides) == ((240, 320, 3), np.uint8, (960, 3, 1))
    assert (depth.shape, depth.dtype, depth.strides) == ((240, 320, 1), np.uint16, (640, 2, 2))
    assert rgb.flags.writeable and not rgb.flags.owndata and not rgb.any() and not depth.any()
    rgb[0, 0, 0] = 7
    assert np.asarray(state.rgb)[0, 0, 0] == 7


def test_states_cannot_be_changed_made_or_pickled(make: Any) -> None:
    sim = make()
    start(sim)
    state = sim.getState()[0]
    for name in ("heading", "navigableLocations", "rgb", "nonsense"):
        with pytest.raises(AttributeError):
            setattr(state, name, 1)
    for thing in (state, state.location, state.rgb):
        with pytest.raises(TypeError):
            type(thing)()
        with pytest.raises(TypeError):
            pickle.dumps(thing)
        with pytest.raises(TypeError):
            copy.copy(thing)
    assert repr(state).startswith("<MatterSim.SimState object")
    assert repr(state.location).startswith("<MatterSim.ViewPoint object")


# --- v0.1 -----------------------------------------------------------------------------------------


def test_v01_errors(make: Any, tmp_path: Path) -> None:
    sim = make(begin="init")
    with pytest.raises(RuntimeError, match="newEpisode"):  # the old one crashed
        sim.getState()
    with pytest.raises(ValueError):
        sim.makeAction(0, 0, 0)
    with pytest.raises(ValueError, match="nowhere_connectivity.json"):
        sim.newEpisode("nowhere", START, 0, 0)
    with pytest.raises(ValueError, match="nowhere_connectivity.json"):
        sim.newEpisode("nowhere", "", 0, 0)
    with pytest.raises(TypeError):
        sim.newEpisode(SCAN, None, 0, 0)
    with pytest.raises(TypeError):
        sim.newEpisode(SCAN, START)
    sim.newEpisode(SCAN, START, 0, 0)
    for index in (99, -1):
        with pytest.raises(ValueError, match=f"Invalid action index: {index}"):
            sim.makeAction(index, 0, 0)
    for index in (0.0, "0"):
        with pytest.raises(TypeError):
            sim.makeAction(index, 0, 0)
    sim.makeAction(np.array([1]), np.array([0.5]), np.float32(0))
    state = sim.getState()
    with pytest.raises(TypeError, match="setRenderingEnabled"):
        state.rgb
    sim.close()
    assert sim.getState().step == 1
    with pytest.raises(ValueError):
        sim.makeAction(0, 0, 0)
    sim.newEpisode(SCAN, START, 0, 0)


def test_v01_states_are_copies(make: Any) -> None:
    sim = make(begin="init")
    sim.newEpisode(SCAN, START, 0, 0)
    first = sim.getState()
    ways = first.navigableLocations
    assert first.navigableLocations is ways and ways[0] is not first.location
    kept = [(w.viewpointId, w.rel_heading) for w in ways]
    sim.makeAction(1, 1.0, 0)
    assert first.heading == 0 and first.step == 0
    assert [(w.viewpointId, w.rel_heading) for w in ways] == kept
    ways.clear()
    assert len(sim.getState().navigableLocations) > 0
    assert first.location.point is first.location.point


def test_v01_needs_no_list_of_scans(connectivity: str, tmp_path: Path) -> None:
    name = f"{SCAN}_connectivity.json"
    (tmp_path / name).write_text((Path(connectivity) / name).read_text())
    sim = MatterSim.Simulator()
    sim.setRenderingEnabled(False)
    sim.setNavGraphPath(str(tmp_path))
    sim.init()
    sim.newEpisode(SCAN, START, 0, 0)
    assert sim.getState().location.ix == 43
    with pytest.raises(ValueError, match="2t7WUuJeko7"):
        sim.newEpisode("2t7WUuJeko7", "x", 0, 0)
    sim.setNavGraphPath(connectivity)
    sim.newEpisode("2t7WUuJeko7", "", 0, 0)


# --- the environment variable ---------------------------------------------------------------------


def test_an_unknown_option_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ENFILADE_MATTERSIM", "8bit-depth,typo")
    with pytest.raises(ValueError, match="typo"):
        MatterSim.Simulator()


def test_random_headings_are_fixed_unless_asked(make: Any, monkeypatch: Any) -> None:
    sim = make(batch=3)
    for _ in range(2):
        sim.newRandomEpisode([SCAN] * 3)
        assert [round(s.heading, 6) for s in sim.getState()] == [0.826476, 2.881784, 1.375761]
    monkeypatch.setenv("ENFILADE_MATTERSIM", "uniform-starts")
    sim = make(batch=3)
    sim.newRandomEpisode([SCAN] * 3)
    assert [round(s.heading, 6) for s in sim.getState()] != [0.826476, 2.881784, 1.375761]


def test_one_stream_is_shared_when_asked(connectivity: str) -> None:
    """In a process of its own, as the stream is the process's."""
    code = f"""
import MatterSim
def first(seed):
    sim = MatterSim.Simulator()
    sim.setNavGraphPath({connectivity!r}); sim.setRenderingEnabled(False); sim.setSeed(seed)
    sim.newRandomEpisode([{SCAN!r}])
    return sim.getState()[0].location.ix
print(first(1), first(1), first(5))"""
    import os

    def run(options: str) -> list[str]:
        environment = {**os.environ, "ENFILADE_MATTERSIM": options}
        done = subprocess.run(
            [sys.executable, "-c", code], env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.split()

    assert run("one-stream") == ["0", "6", "36"]  # as the old simulator's first three draws
    own = run("")
    assert own[0] == own[1] == "0"
