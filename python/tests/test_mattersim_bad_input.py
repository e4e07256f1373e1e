"""Malformed calls, each as the old simulator answered it (reference: what its two versions were
seen to do), or better where it aborted, crashed, or went on with half of an action. Those of v0.1
are in test_mattersim_versions.py."""

from __future__ import annotations

import copy
import math
import pickle
from pathlib import Path
from typing import Any

import enfilade
import MatterSim
import pytest
from old_simulator import EXCLUDED, SCAN, START, make_simulator, start, summary

np = pytest.importorskip("numpy")


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


class Clearing:
    """A number that empties a list when it is converted."""

    def __init__(self, elements: list[Any]) -> None:
        self.elements = elements

    def __index__(self) -> int:
        self.elements.clear()
        return 0

    def __float__(self) -> float:
        self.elements.clear()
        return 0.0


class OwnList(list):  # type: ignore[type-arg]
    pass


def started(small: str, batch: int) -> tuple[Any, str, str]:
    """A simulator of the synthetic graphs with an episode, its scan and its viewpoint."""
    folder = f"{small}/connectivity"
    graphs = enfilade.Graphs(folder)
    scan = graphs.scans[0]
    viewpoint = next(v for v in graphs[scan].viewpoints if graphs[scan].included(v))
    sim = make_simulator(folder, batch)
    sim.newEpisode([scan] * batch, [viewpoint] * batch, [0] * batch, [0] * batch)
    return sim, scan, viewpoint


@pytest.mark.parametrize("kind", [list, OwnList])
@pytest.mark.parametrize("place", [0, 1, 2])
def test_lists_that_their_elements_shorten_are_index_errors(
    small: str, kind: Any, place: int
) -> None:
    """Reading on behind the end of such a list would crash."""
    sim, scan, viewpoint = started(small, 3)
    before = summary(sim)
    elements = kind()
    elements.extend([Clearing(elements), 0, 0])
    arguments: list[Any] = [[0] * 3, [0] * 3, [0] * 3]
    arguments[place] = elements
    with pytest.raises(IndexError, match="0 elements for a batch of 3"):
        sim.makeAction(*arguments)
    assert len(elements) == 0 and summary(sim) == before
    if place > 0:
        elements.extend([Clearing(elements), 0, 0])
        with pytest.raises(IndexError, match="0 elements for a batch of 3"):
            sim.newEpisode([scan] * 3, [viewpoint] * 3, *arguments[1:])
        assert summary(sim) == before
    sim.makeAction([0] * 3, [0] * 3, [0] * 3)
    assert [state.step for state in sim.getState()] == [1] * 3


def test_a_list_that_its_last_element_empties_was_read_whole(small: str) -> None:
    sim, _, _ = started(small, 1)
    angles: list[Any] = []
    angles.append(Clearing(angles))
    sim.makeAction([0], angles, [0])
    assert len(angles) == 0 and sim.getState()[0].step == 1


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


def test_setters_take_what_they_took_and_name_what_they_do_not(make: Any) -> None:
    """Flags come as command lines have them: 0 and 1, None, NumPy's."""
    sim = MatterSim.Simulator()
    for flag in (True, 0, 1, None, np.bool_(False), 0.0):
        sim.setRenderingEnabled(flag)
        sim.setDepthEnabled(flag)
    sim.setBatchSize(np.int64(2))
    sim.setCameraResolution(np.int32(64), np.uint8(48))
    sim.setCameraVFOV(np.float32(0.5))
    sim.setCameraVFOV(1)
    sim.setSeed(-1)
    for setter, values in [
        ("setRenderingEnabled", ("yes",)), ("setDepthEnabled", ([1],)), ("setBatchSize", (2.0,)),
        ("setBatchSize", (2**32,)), ("setCacheSize", (-1,)), ("setCameraResolution", (64.0, 48)),
        ("setCameraVFOV", ("60",)), ("setSeed", (2**31,)), ("setSeed", (1.0,)),
        ("setElevationLimits", (None, 1)), ("setNavGraphPath", (3,)),
    ]:  # fmt: skip
        with pytest.raises(TypeError, match=f"{setter}.*wanted"):
            getattr(sim, setter)(*values)
    other = make(begin="")
    other.setRestrictedNavigation(0)
    start(other)
    assert len(other.getState()[0].navigableLocations) == 4


def test_actions_out_of_turn(make: Any) -> None:
    with pytest.raises(RuntimeError, match="newEpisode"):
        make(begin="").makeAction([0], [0], [0])
    with pytest.raises(ValueError, match="Invalid action index"):
        make().makeAction([0], [0], [0])
    make(begin="").close()
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
@pytest.mark.parametrize("restricted", [False, True])
def test_angles_that_are_no_numbers_are_refused(
    make: Any, bad: float, discretized: bool, restricted: bool
) -> None:
    """The old one took them, and was at heading NaN from then on."""
    sim = make(discretized=discretized, begin="")
    sim.setRestrictedNavigation(restricted)
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
        text = rf"{setter}\(\) after initialize\(\) takes effect at the next initialize\(\) only"
        with pytest.warns(RuntimeWarning, match=text):
            getattr(sim, setter)(value)
    start(sim, heading=0.1, elevation=0.2)
    assert summary(sim) == [(SCAN, 0, START, 0.1, 0.2, 0, 2)]


def test_camera_and_limits_take_effect_at_the_next_action(make: Any) -> None:
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
    assert repr(sim).startswith("<MatterSim.Simulator object")


# --- all of them ----------------------------------------------------------------------------------

# The rows of the reference's table of what the old simulator did, each with its test here or, where
# old code does such things or the environment variable matters, in a file beside it.
ROWS = {
    "unknown scan, newEpisode": "unknown_scan_is_an_index_error",
    "unknown viewpoint": "unknown_and_excluded_viewpoints_are_value_errors",
    "excluded viewpoint": "unknown_and_excluded_viewpoints_are_value_errors",
    "unknown scan, newRandomEpisode": "unknown_scan_is_an_index_error",
    "empty lists, newEpisode": "short_lists_are_index_errors_and_nothing_happens",
    "empty list, newRandomEpisode": "short_lists_are_index_errors_and_nothing_happens",
    "batch 2, lists of 1, newEpisode": "short_lists_are_index_errors_and_nothing_happens",
    "batch 1, lists of 2 (longer), newEpisode": "longer_lists_are_accepted_and_their_excess_unused",
    "batch 2, makeAction lists of 1": "short_lists_are_index_errors_and_nothing_happens",
    "batch 1, makeAction lists of 3 (longer)": "longer_lists_are_accepted_and_their_excess_unused",
    "index out of range": "an_index_out_of_range_is_a_value_error_and_nobody_moves",
    "index out of range in item 1 of 2 (partial effect?)":
        "an_index_out_of_range_is_a_value_error_and_nobody_moves",
    "negative index": "other_things_than_indices_are_type_errors",
    "float index 0.0": "other_things_than_indices_are_type_errors",
    "numpy int64 index, numpy arrays": "numpy_numbers_lists_tuples_and_arrays_are_fine",
    "scalars instead of lists": "scalars_after_initialize_and_lists_after_init_are_type_errors",
    "makeAction before initialize": "actions_out_of_turn",
    "makeAction after initialize, before newEpisode": "actions_out_of_turn",
    "getState before initialize": "states_out_of_turn",
    "getState after initialize, before newEpisode": "states_out_of_turn",
    "newEpisode without initialize (auto-initialises)": "states_out_of_turn",
    "NaN heading, restricted": "angles_that_are_no_numbers_are_refused",
    "NaN heading, unrestricted": "angles_that_are_no_numbers_are_refused",
    "NaN heading, discretized": "angles_that_are_no_numbers_are_refused",
    "NaN elevation": "angles_that_are_no_numbers_are_refused",
    "NaN elevation, discretized": "angles_that_are_no_numbers_are_refused",
    "inf heading": "angles_that_are_no_numbers_are_refused",
    "inf elevation": "angles_that_are_no_numbers_are_refused",
    "huge heading 1e18": "strange_but_finite_angles_are_wrapped_as_before",
    "heading -1e-17 (wrap gives exactly 2 pi?)": "strange_but_finite_angles_are_wrapped_as_before",
    "heading -1e-17, discretized": "strange_but_finite_angles_are_wrapped_as_before",
    "bad elevation limits": "elevation_limits_are_taken_or_left",
    "setters after initialize": "setters_after_initialize_warn_and_wait",
    "vfov*W/H >= 2 pi (hfov wraps)": "the_linear_field_of_view_turns_round_past_a_whole_turn",
    "resolution 0x0": "a_camera_without_pixels",
    "negative resolution": "a_camera_without_pixels",
    "batch size 0": "a_batch_of_none_is_a_batch",
    "negative batch size": "keywords_and_missing_arguments_are_type_errors",
    "nav graph path missing": "missing_graphs_are_value_errors_at_the_first_episode",
    "scan listed but connectivity file missing": "broken_graph_files_are_value_errors_not_aborts",
    "truncated connectivity json": "broken_graph_files_are_value_errors_not_aborts",
    "second simulator with other navGraphPath in one process":
        "each_simulator_has_its_own_graphs",
    "skybox missing, rendering on": "missing_pictures_are_value_errors_and_nothing_happens",
    "skybox missing, preloading": "missing_pictures_are_value_errors_and_nothing_happens",
    "close, then initialize again": "initialize_again_and_close_then_initialize_begin_anew",
    "initialize twice": "initialize_again_and_close_then_initialize_begin_anew",
    "close twice, close before initialize": "actions_out_of_turn",
    "makeAction after close": "actions_out_of_turn",
    "two live rendering simulators, 64x48 then 32x24 (`two_sim.py`)":
        "two_simulators_with_pictures_do_not_disturb_each_other",
    "cache size 1 (and 2)": "small_caches_draw_no_black_pictures",
    "cache size 2, batch 4 of two different viewpoints": "small_caches_draw_no_black_pictures",
    "state object aliasing": "states_alias_the_simulator",
    "writable image buffer": "mats_are_writeable_arrays_of_three_dimensions",
    "depth disabled: content of depth": "mats_are_writeable_arrays_of_three_dimensions",
    "read-only attributes": "states_cannot_be_changed_made_or_pickled",
    "pickle/copy/repr of state": "states_cannot_be_changed_made_or_pickled",
    "Python keyword arguments": "keywords_and_missing_arguments_are_type_errors",
    "newRandomEpisode headings: same every call, seed has no effect on heading":
        "random_headings_are_fixed_unless_asked",
    "setPreloadingEnabled(True) with rendering disabled, skyboxes absent":
        "preloading_without_rendering_loads_nothing",
}  # fmt: skip


def test_every_row_of_the_reference_has_a_test(reference: Path) -> None:
    lines = (reference / "bad_input.md").read_text().splitlines()
    rows = [line.split("|")[1].strip() for line in lines if line.startswith("| ")]
    assert rows[0] == "case" and sorted(rows[1:]) == sorted(ROWS)
    here = Path(__file__)
    others = ("bad_input", "old_code", "versions")
    text = "".join(here.with_name(f"test_mattersim_{name}.py").read_text() for name in others)
    assert [test for test in ROWS.values() if f"def test_{test}(" not in text] == []
