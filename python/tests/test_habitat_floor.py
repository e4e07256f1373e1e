"""Habitat's floor under native episodes, simulators and scores, beside the drop-in's, in model homes (SYNTHETIC)."""

from __future__ import annotations

import json
import pickle
import shutil
from pathlib import Path

import pytest

np = pytest.importorskip("numpy")
pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")

pytest.register_assert_rewrite("habitat_homes", "habitat_rooms")

import enfilade  # noqa: E402
import habitat_sim  # noqa: E402
from enfilade import ContinuousSimulator  # noqa: E402
from habitat_homes import FloorHomes, read_packed  # noqa: E402
from habitat_rooms import configuration, settings  # noqa: E402
from programs import run  # noqa: E402

pytest_plugins = ["habitat_homes"]


def scan_of(homes: FloorHomes) -> str:
    return Path(homes.episodes[0]["scene_id"]).stem


def to_habitat(point: object) -> list[float]:
    x, y, z = np.asarray(point, np.float32)
    return [float(x), float(z), float(-y)]


def test_the_drop_in_makes_the_same_floor(
    floor_homes: FloorHomes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(habitat_sim.nav, "navigation", "0.3.3")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    scan, saved = scan_of(floor_homes), tmp_path / "saved.navmesh"
    scene = shutil.copy(floor_homes.scenes / "mp3d" / scan / f"{scan}.glb", tmp_path)  # and no floor
    with habitat_sim.Simulator(configuration(Path(scene), settings())) as sim:
        assert sim.pathfinder.save_nav_mesh(str(saved))
    assert saved.read_bytes() == floor_homes.navmesh(scan).read_bytes()


def test_native_distances_are_those_of_the_drop_in(floor_homes: FloorHomes) -> None:
    scan = scan_of(floor_homes)
    sim = ContinuousSimulator(floor_homes.data, navmesh="habitat")
    assert sim.floor == "habitat 0.3.3"
    finder = habitat_sim.PathFinder()
    assert finder.load_nav_mesh(str(floor_homes.navmesh(scan)))
    points = [sim.random_point(scan, seed) for seed in range(20)]
    found = 0
    for start, end in zip(points, points[1:]):
        path = habitat_sim.ShortestPath()
        path.requested_start, path.requested_end = to_habitat(start), to_habitat(end)
        there = finder.find_path(path)
        metres = sim.geodesic_distance(scan, start, end)
        assert metres == (path.geodesic_distance if there else float("inf"))
        ours = sim.geodesic_path(scan, start, end)
        assert (ours is not None) == there
        if ours is not None:
            found += 1
            assert [to_habitat(p) for p in ours] == [list(map(float, p)) for p in path.points]
    assert found > 5


def test_steps_are_on_the_same_floor(floor_homes: FloorHomes) -> None:
    scan = scan_of(floor_homes)
    sim = ContinuousSimulator(floor_homes.data, navmesh="habitat", most_steps=300)
    finder = habitat_sim.PathFinder()
    assert finder.load_nav_mesh(str(floor_homes.navmesh(scan)))
    start = floor_homes.episodes[0]["start_position"]  # indoors; a random point is nearly always outside
    sim.new_episode(0, scan, enfilade.from_habitat(start), 0.3)
    rng = np.random.default_rng(1)
    for _ in range(200):
        sim.step([int(rng.choice([1, 1, 2, 3]))])
        assert finder.is_navigable(to_habitat(sim.state.position[0]))
    assert sim.state.collisions[0] > 0


def test_the_floor_is_named(floor_homes: FloorHomes) -> None:
    file = floor_homes.data / "vlnce" / f"{floor_homes.split}.json.gz"
    assert read_packed(file)["floor"] == "habitat 0.3.3"
    walks = floor_homes.data.parent / "walks.json"
    arguments = ("--task", "r2r-ce", "--data", floor_homes.data, "--split", floor_homes.split)
    assert "habitat 0.3.3" in run("run", *arguments, "--agent", "shortest", "-o", walks)
    score = json.loads(run("score", walks, *arguments, "--json", "-"))
    assert score["floor"] == "habitat 0.3.3"
    assert score["means"]["success"]["mean"] > 0.95
    assert "habitat 0.3.3" in run("score", walks, *arguments)
    map_file = floor_homes.data.parent / "map.svg"
    run("top-down", scan_of(floor_homes), "--data", floor_homes.data, "-o", map_file)
    assert "<svg" in map_file.read_text()


def test_the_floor_can_be_required(floor_homes: FloorHomes) -> None:
    sim = ContinuousSimulator(floor_homes.data, navmesh="habitat")
    assert pickle.loads(pickle.dumps(sim)).floor == sim.floor
    with pytest.raises(enfilade.ArgumentError, match="has the floor habitat 0.3.3"):
        ContinuousSimulator(floor_homes.data, navmesh="enfilade")
    with pytest.raises(enfilade.ArgumentError, match="navmesh 'mars'"):
        ContinuousSimulator(floor_homes.data, navmesh="mars")


def test_floors_are_replaced_whole(floor_homes: FloorHomes, tmp_path: Path) -> None:
    data = tmp_path / "homes"
    shutil.copytree(floor_homes.data, data, ignore=shutil.ignore_patterns("v1"))
    assert "0 made" in run("continuous", data, "--navmesh", "habitat", "--floors-only")
    run("continuous", data)
    assert ContinuousSimulator(data).floor == "enfilade"
    assert "floor" not in read_packed(data / "vlnce" / f"{floor_homes.split}.json.gz")
    scan = scan_of(floor_homes)
    shutil.copy(floor_homes.navmesh(scan), data / "navmesh" / "r2r-ce" / f"{scan}.navmesh")
    with pytest.raises(enfilade.InvalidInput, match="mixed-floors"):
        ContinuousSimulator(data)
