"""Homes for Habitat: what `enfilade homes --parts habitat` writes, opened by habitat_sim and by habitat-lab."""

from __future__ import annotations

import gzip
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

np = pytest.importorskip("numpy")
pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")

pytest.register_assert_rewrite("habitat_rooms")

import habitat_sim  # noqa: E402
from habitat_rooms import camera, configuration, settings  # noqa: E402

pytest_plugins = ["habitat_rooms"]

STOP = 0


@pytest.fixture(scope="module")
def homes(program: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What habitat-lab calls `data`, of three small flats."""
    folder = tmp_path_factory.mktemp("homes")
    subprocess.run(
        [program, "homes", "-o", str(folder), "--preset", "small", "--homes", "3", "--seed", "2", "--size", "0",
         "--paths", "6", "--tasks", "r2r", "--parts", "habitat"],
        check=True,
    )  # fmt: skip
    return folder / "habitat"


def read(homes: Path, task: str, split: str) -> Any:
    with gzip.open(homes / "datasets" / task / "v1" / split / f"{split}.json.gz", "rt") as file:
        return json.load(file)


def glb(homes: Path, episode: Any) -> Path:
    return homes / "scene_datasets" / str(episode["scene_id"])


def pathfinder(homes: Path, episode: Any) -> Any:
    """That of the scene's .navmesh."""
    finder = habitat_sim.PathFinder()
    assert finder.load_nav_mesh(str(glb(homes, episode).with_suffix(".navmesh")))
    return finder


def test_homes_open_upright_by_path_and_by_dataset(homes: Path) -> None:
    episode = read(homes, "pointnav/mp3d", "val")["episodes"][0]
    dataset = homes / "scene_datasets/mp3d/mp3d.scene_dataset_config.json"
    eyes = [camera("depth", "DEPTH")]
    for scene, named in ((glb(homes, episode), "default"), (glb(homes, episode).stem, dataset)):
        config = configuration(scene, None, eyes, scene_dataset_config_file=str(named))
        with habitat_sim.Simulator(config) as sim:
            assert sim.pathfinder.is_navigable(episode["start_position"])
            assert sim.pathfinder.nav_mesh_settings == settings()
            low, high = sim.pathfinder.get_bounds()
            assert high[1] - low[1] < high[0] - low[0], "lawn around, and one storey"
            state = habitat_sim.AgentState()
            state.position, state.rotation = episode["start_position"], episode["start_rotation"]
            sim.get_agent(0).set_state(state)
            depth = sim.get_sensor_observations()["depth"]
            assert 0 < depth[-1].max() < 3, "the floor below the eyes, at 1.25 m"
            assert len(sim.semantic_scene.objects) > 20


@pytest.mark.parametrize("split", ["train", "val"])
def test_point_goals_are_as_far_as_they_say(homes: Path, split: str) -> None:
    episodes = read(homes, "pointnav/mp3d", split)["episodes"]
    assert len(episodes) == 6
    for episode in episodes:
        finder = pathfinder(homes, episode)
        path = habitat_sim.ShortestPath()
        path.requested_start = episode["start_position"]
        path.requested_end = episode["goals"][0]["position"]
        assert finder.is_navigable(path.requested_start) and finder.is_navigable(path.requested_end)
        assert finder.find_path(path)
        assert path.geodesic_distance == episode["info"]["geodesic_distance"]


def test_objects_are_as_far_as_they_say(homes: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(habitat_sim.nav, "navigation", "0.3.3")
    data = read(homes, "objectnav/mp3d", "val")
    body = settings(0.18)
    body.agent_height = 0.88
    with habitat_sim.Simulator(configuration(glb(homes, data["episodes"][0]), body)) as sim:
        for episode in data["episodes"]:
            key = f"{glb(homes, episode).name}_{episode['object_category']}"
            views = [view for goal in data["goals_by_category"][key] for view in goal["view_points"]]
            path = habitat_sim.MultiGoalShortestPath()
            path.requested_start = episode["start_position"]
            path.requested_ends = np.array([view["agent_state"]["position"] for view in views])
            assert sim.pathfinder.is_navigable(path.requested_start)
            assert sim.pathfinder.find_path(path)
            assert path.geodesic_distance == episode["info"]["geodesic_distance"]


def test_vln_paths_can_be_walked(homes: Path) -> None:
    for split in ("train", "val_unseen"):
        episodes = read(homes, "vln/mp3d/r2r", split)["episodes"]
        assert len(episodes) >= 6
        finder = pathfinder(homes, episodes[0])
        for episode in [e for e in episodes if e["scene_id"] == episodes[0]["scene_id"]]:
            points = episode["reference_path"]
            assert points[0] == episode["start_position"]
            assert points[-1] == episode["goals"][0]["position"]
            for a, b in zip(points, points[1:]):
                path = habitat_sim.ShortestPath()
                path.requested_start, path.requested_end = a, b
                assert finder.is_navigable(a) and finder.find_path(path)
    assert "goals" not in read(homes, "vln/mp3d/r2r", "test")["episodes"][0]


def test_vln_experts_walk_from_start_to_goal(homes: Path) -> None:
    folder = homes / "datasets/vln/mp3d/r2r/v1"
    with gzip.open(folder / "val_unseen/val_unseen_gt.json.gz", "rt") as file:
        experts = json.load(file)
    for episode in read(homes, "vln/mp3d/r2r", "val_unseen")["episodes"]:
        expert = experts[str(episode["episode_id"])]
        assert expert["locations"][0] == pytest.approx(episode["start_position"], abs=1e-5)
        end = np.subtract(expert["locations"][-1], episode["goals"][0]["position"])
        assert np.linalg.norm(end) < 0.5 and expert["actions"][-1] == STOP
    assert not (folder / "test/test_gt.json.gz").exists(), "its goals are hidden"


def test_scans_are_written_as_homes_are(homes: Path, program: str, tmp_path: Path) -> None:
    data, scan = homes.parent, "home0002"
    for name in ("connectivity", "r2r"):
        shutil.copytree(data / name, tmp_path / name)
    scene = f"scene_datasets/mp3d/{scan}/{scan}"
    (tmp_path / "meshes").mkdir()
    shutil.copy(homes / f"{scene}.glb", tmp_path / f"meshes/{scan}.glb")
    words = [program, "continuous", str(tmp_path), "--parts", "habitat", "--up", "z"]
    assert subprocess.run(words, check=False).returncode == 2, "on Habitat's floor alone"
    assert not (tmp_path / "habitat").exists() and not (tmp_path / "navmesh").exists()
    subprocess.run([*words, "--navmesh", "habitat"], check=True)
    found = tmp_path / "habitat"
    assert (found / f"{scene}.navmesh").read_bytes() == (homes / f"{scene}.navmesh").read_bytes()
    sizes = [(folder / f"{scene}.glb").stat().st_size for folder in (found, homes)]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.2), "the same mesh"
    for ending in ("", "_gt"):
        file = f"datasets/vln/mp3d/r2r/v1/val_unseen/val_unseen{ending}.json.gz"
        assert json.loads(gzip.decompress((found / file).read_bytes())) == json.loads(
            gzip.decompress((homes / file).read_bytes())
        )
    assert (found / "scene_datasets/mp3d/mp3d.scene_dataset_config.json").exists()
    refused = subprocess.run(
        [program, "continuous", str(data), "--navmesh", "habitat", "--parts", "habitat"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert refused.returncode == 2 and "enfilade homes" in refused.stderr


def walk(homes: Path, config: str, task: str, split: str, near: float) -> Any:
    """The metrics of habitat-lab after its follower went to the goal of the first episode."""
    habitat = pytest.importorskip("habitat", reason="habitat-lab is not installed")
    from habitat.tasks.nav.shortest_path_follower import ShortestPathFollower

    options = [
        f"habitat.dataset.data_path='{homes}/datasets/{task}/v1/{{split}}/{{split}}.json.gz'",
        f"habitat.dataset.split={split}", f"habitat.dataset.scenes_dir={homes}/scene_datasets",
        "habitat.simulator.habitat_sim_v0.gpu_device_id=-1",
        "habitat.environment.iterator_options.shuffle=False",
    ]  # fmt: skip
    for sensor in ("rgb_sensor", "depth_sensor"):
        for side in ("width", "height"):
            options.append(f"habitat.simulator.agents.main_agent.sim_sensors.{sensor}.{side}=32")
    with habitat.Env(config=habitat.get_config(config, overrides=options)) as env:
        env.reset()
        first = env.get_metrics()["distance_to_goal"]
        told = env.current_episode.info["geodesic_distance"]
        assert first == pytest.approx(told, abs=0.05), "ours is of 0.3.3, theirs of now"
        goals = env.current_episode.goals
        views = getattr(goals[0], "view_points", None)
        if views:
            to = env.sim.geodesic_distance
            at = env.sim.get_agent_state().position
            every = [view.agent_state.position for goal in goals for view in goal.view_points]
            goal = min(every, key=lambda view: to(at, view))
        else:
            goal = goals[0].position
        follower = ShortestPathFollower(env.sim, near, False)
        while not env.episode_over:
            action = follower.get_next_action(np.array(goal))
            env.step(STOP if action is None else int(action))
        return env.get_metrics()


def test_habitat_lab_walks_vln(homes: Path) -> None:
    metrics = walk(homes, "benchmark/nav/vln_r2r.yaml", "vln/mp3d/r2r", "val_unseen", 0.15)
    assert metrics["distance_to_goal"] < 0.3


def test_habitat_lab_walks_pointnav(homes: Path) -> None:
    metrics = walk(
        homes, "benchmark/nav/pointnav/pointnav_mp3d.yaml", "pointnav/mp3d", "val", 0.15
    )
    assert metrics["success"] == 1 and metrics["spl"] > 0.7


def test_habitat_lab_walks_objectnav(homes: Path) -> None:
    metrics = walk(
        homes, "benchmark/nav/objectnav/objectnav_mp3d.yaml", "objectnav/mp3d", "val", 0.1
    )
    assert metrics["distance_to_goal"] < 0.3
