"""What the two versions of the old simulator have each: v0.1's calls and errors, names, defaults,
paths; and the environment variable that chooses between old and right."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import enfilade
import MatterSim
import pytest
from old_simulator import SCAN, START, start, summary

np = pytest.importorskip("numpy")


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
        _ = state.rgb
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


POSE = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


def entry(name: str, **changed: Any) -> dict[str, Any]:
    return {"image_id": name, "pose": POSE, "included": True, "unobstructed": [False, False],
            "visible": [False, False], "height": 1.5, **changed}  # fmt: skip


@pytest.mark.parametrize(
    ("content", "error", "words"),
    [
        ("[{", ValueError, "zzzz_connectivity.json"),  # RuntimeError, with the parser's words
        ([{"image_id": "a"}], ValueError, "zzzz_connectivity.json"),  # a crash
        ([entry("a", unobstructed=[False]), entry("b")], ValueError, "unobstructed"),  # a crash
        ([entry("a", included=False), entry("b", included=False)], RuntimeError, "included"),
        ([], RuntimeError, "included"),  # a crash
    ],
)
def test_v01_graphs_without_a_place_to_start(
    tmp_path: Path, content: Any, error: Any, words: str
) -> None:
    """What the old one did is beside each, where it was something else."""
    text = content if isinstance(content, str) else json.dumps(content)
    (tmp_path / "zzzz_connectivity.json").write_text(text)
    sim = MatterSim.Simulator()
    sim.setNavGraphPath(str(tmp_path))
    sim.setRenderingEnabled(False)
    sim.init()
    for _ in range(2):  # asked again, the old one had forgotten what was wrong, or crashed
        with pytest.raises(error, match=words):
            sim.newEpisode("zzzz", "", 0, 0)
    (tmp_path / "zzzz_connectivity.json").write_text(json.dumps([entry("a"), entry("b")]))
    os.utime(tmp_path / "zzzz_connectivity.json", (1, 1))
    sim.newEpisode("zzzz", "b", 0, 0)
    assert sim.getState().location.ix == 1


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_v01_angles_that_are_no_numbers_are_refused(make: Any, bad: float) -> None:
    sim = make(begin="init")
    for angles in ((bad, 0), (0, bad)):
        with pytest.raises(ValueError, match="finite"):
            sim.newEpisode(SCAN, START, *angles)
    sim.newEpisode(SCAN, START, 0, 0)
    with pytest.raises(ValueError, match="finite"):
        sim.makeAction(0, bad, 0)
    assert (sim.getState().step, sim.getState().heading) == (0, 0)


def test_what_is_set_at_once_and_what_is_not_by_v01(make: Any, connectivity: str) -> None:
    """Paths, camera, limits and seed take effect after init(); the others give a warning."""
    sim = make(begin="init")
    for setter, value in [("setRenderingEnabled", False), ("setDiscretizedViewingAngles", True)]:
        with pytest.warns(RuntimeWarning, match=setter):
            getattr(sim, setter)(value)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.setNavGraphPath(connectivity)
        sim.setDatasetPath("x")
        sim.setCameraResolution(640, 480)
        sim.setCameraVFOV(1.0)
        sim.setSeed(3)
        assert sim.setElevationLimits(-0.1, 0.1)
    sim.newEpisode(SCAN, START, 0.1, 0.5)
    state = sim.getState()
    assert (state.heading, state.elevation, state.viewIndex) == (0.1, 0.1, 0)
    sim.init()  # once more is harmless
    sim.newEpisode(SCAN, START, 0.1, 0.5)
    assert sim.getState().viewIndex != 0


# --- what there is --------------------------------------------------------------------------------

SETTERS = [
    "setBatchSize", "setCacheSize", "setCameraResolution", "setCameraVFOV", "setDatasetPath",
    "setDepthEnabled", "setDiscretizedViewingAngles", "setElevationLimits", "setNavGraphPath",
    "setPreloadingEnabled", "setRenderingEnabled", "setRestrictedNavigation", "setSeed",
]  # fmt: skip
CALLS = ["close", "getState", "init", "initialize", "makeAction", "newEpisode", "newRandomEpisode",
         "resetTimers", "timingInfo"]  # fmt: skip


def public(thing: Any) -> list[str]:
    return sorted(name for name in dir(thing) if not name.startswith("_"))


def test_names_are_those_of_both_versions_and_no_others() -> None:
    assert public(MatterSim) == ["Mat", "SimState", "Simulator", "ViewPoint", "cbf"]
    assert public(MatterSim.Simulator) == sorted([*SETTERS, *CALLS])
    assert public(MatterSim.SimState) == [
        "depth", "elevation", "heading", "location", "navigableLocations", "rgb", "scanId", "step",
        "viewIndex"]  # fmt: skip
    assert public(MatterSim.ViewPoint) == [
        "ix", "point", "rel_distance", "rel_elevation", "rel_heading", "viewpointId", "x", "y", "z"
    ]  # fmt: skip
    assert public(MatterSim.Mat) == []


def test_defaults_are_the_old_ones(make: Any, connectivity: str) -> None:
    """A simulator that is told nothing, against one that is told everything."""
    plain = make(begin="")
    told = make(begin="")
    told.setCameraResolution(320, 240)
    told.setCameraVFOV(0.8)
    assert told.setElevationLimits(-0.94, 0.94)
    told.setDiscretizedViewingAngles(False)
    told.setRestrictedNavigation(True)
    told.setPreloadingEnabled(False)
    told.setDepthEnabled(False)
    told.setCacheSize(200)
    told.setSeed(1)
    for sim in (plain, told):
        sim.newRandomEpisode([SCAN])
    for action in ([0], [1.5], [1.5]), ([0], [-0.7], [-3]), ([0], [2.5], [0.3]):
        plain.makeAction(*action)
        told.makeAction(*action)
        assert summary(plain) == summary(told)
        assert plain.getState()[0].elevation in (0.94, -0.94, -0.94 + 0.3)
    assert np.asarray(plain.getState()[0].rgb).shape == (240, 320, 3)


def test_paths_are_relative_to_the_working_directory_of_their_first_use(
    connectivity: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "connectivity").symlink_to(connectivity)
    sim = MatterSim.Simulator()
    sim.setRenderingEnabled(False)
    sim.initialize()
    monkeypatch.chdir(tmp_path)  # ./connectivity is what nobody has set
    start(sim)
    one = MatterSim.Simulator()
    one.setRenderingEnabled(False)
    one.newEpisode(SCAN, START, 0, 0)
    assert sim.getState()[0].location.ix == one.getState().location.ix == 43
    place = (SCAN, START, 0, 0)
    for version, call in (("init", place), ("initialize", tuple([one] for one in place))):
        sim = MatterSim.Simulator()
        getattr(sim, version)()
        with pytest.raises(ValueError, match="data/v1/scans"):
            sim.newEpisode(*call)


# --- the environment variable ---------------------------------------------------------------------


def test_an_unknown_option_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ENFILADE_MATTERSIM", "8bit-depth,typo")
    with pytest.raises(ValueError, match="typo"):
        MatterSim.Simulator()


def test_random_headings_are_fixed_unless_asked(make: Any, monkeypatch: Any) -> None:
    sim = make(batch=3)
    for seed in (1, 7):
        sim.setSeed(seed)
        sim.newRandomEpisode([SCAN] * 3)
        assert [round(s.heading, 6) for s in sim.getState()] == [0.826476, 2.881784, 1.375761]
    monkeypatch.setenv("ENFILADE_MATTERSIM", "uniform-starts")
    sim = make(batch=3)
    sim.newRandomEpisode([SCAN] * 3)
    assert [round(s.heading, 6) for s in sim.getState()] != [0.826476, 2.881784, 1.375761]


@pytest.mark.parametrize("seed", [1, 7])
def test_the_new_simulator_draws_the_same_starts_when_asked(
    make: Any, connectivity: str, seed: int
) -> None:
    old = make(batch=3)
    old.setSeed(seed)
    new = enfilade.Simulator(
        enfilade.Graphs(connectivity), 3, discretized=False, seed=seed, random_starts="mattersim"
    )
    for scans in ([SCAN, "2t7WUuJeko7", SCAN], [SCAN] * 3):
        old.newRandomEpisode(scans)
        new.new_random_episodes(scans)
        states = old.getState()
        assert [s.location.viewpointId for s in states] == new.viewpoint_ids()
        assert [s.heading for s in states] == new.state.heading.tolist()


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
