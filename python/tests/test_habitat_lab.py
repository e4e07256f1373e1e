"""habitat-lab, unchanged, on the drop-in habitat_sim: an episode of VLN and one of PointNav in a small room."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any, Iterable

import pytest

np = pytest.importorskip("numpy")
pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")

pytest.register_assert_rewrite("habitat_rooms")

habitat = pytest.importorskip("habitat", reason="habitat-lab is not installed")

pytest_plugins = ["habitat_rooms"]

START, GOAL = [0.0, 0.05, 0.0], [0.0, 0.05, -3.5]  # the wall is between them
STOP, FORWARD = 0, 1


@pytest.fixture(scope="module")
def tasks(rooms: Path) -> Path:
    """The folder of the room, with an episode for each task."""
    episode = {
        "episode_id": "1", "scene_id": "room.glb", "start_position": START, "start_rotation": [0, 0, 0, 1],
        "goals": [{"position": GOAL, "radius": 3.0}], "info": {"geodesic_distance": 7.0},
    }  # fmt: skip
    told = {
        **episode, "trajectory_id": 1, "reference_path": [START, GOAL],
        "instruction": {"instruction_text": "Go around the wall."},
    }  # fmt: skip
    words = {"word_list": ["wall"], "word2idx_dict": {"wall": 0}}
    for name, content in (
        ("vln", {"episodes": [told], "instruction_vocab": words}),
        ("point", {"episodes": [episode]}),
    ):
        with gzip.open(rooms / f"{name}.json.gz", "wt") as file:
            json.dump(content, file)
    return rooms


def configuration(config: str, episodes: Path) -> Any:
    """habitat-lab's own, with these episodes and small pictures."""
    options = [
        f"habitat.dataset.data_path={episodes}", f"habitat.dataset.scenes_dir={episodes.parent}",
        "habitat.simulator.scene_dataset=default", "habitat.task.measurements.success.success_distance=0.5",
        "habitat.simulator.habitat_sim_v0.gpu_device_id=-1",
    ]  # fmt: skip
    for sensor in ("rgb_sensor", "depth_sensor"):
        for side in ("width", "height"):
            options.append(f"habitat.simulator.agents.main_agent.sim_sensors.{sensor}.{side}=32")
    return habitat.get_config(config, overrides=options)


def run(config: str, episodes: Path, actions: Iterable[int]) -> tuple[list[dict[str, Any]], Any]:
    """Observations of an episode, and its metrics. Goes to the goal, and stops, after the actions."""
    from habitat.tasks.nav.shortest_path_follower import ShortestPathFollower

    with habitat.Env(config=configuration(config, episodes)) as env:
        seen = [env.reset()]
        seen += [env.step(action) for action in actions]
        follower = ShortestPathFollower(env.sim, 0.4, False)
        while not env.episode_over:
            action = follower.get_next_action(np.array(GOAL))
            seen.append(env.step(STOP if action is None else int(action)))
        return seen, env.get_metrics()


def test_an_episode_of_vln(tasks: Path) -> None:
    seen, metrics = run("benchmark/nav/vln_r2r.yaml", tasks / "vln.json.gz", [FORWARD] * 3)
    assert seen[0]["instruction"]["text"] == "Go around the wall."
    assert seen[0]["rgb"].shape == (32, 32, 3) and seen[0]["depth"].shape == (32, 32, 1)
    ahead = [10 * one["depth"][16, 16, 0] for one in seen[:4]]  # to the wall, at z = -2
    assert ahead == pytest.approx([2.0, 1.75, 1.5, 1.25], abs=0.01)
    assert metrics["success"] == 1 and metrics["distance_to_goal"] < 0.5
    assert 0.7 < metrics["spl"] < 1  # the first steps led to the wall


def test_an_episode_of_pointnav(tasks: Path) -> None:
    seen, metrics = run(
        "benchmark/nav/pointnav/pointnav_habitat_test.yaml", tasks / "point.json.gz", []
    )
    goals = np.array([one["pointgoal_with_gps_compass"] for one in seen])  # distance, angle to the left
    assert np.allclose(goals[0], [3.5, 0], atol=1e-3)
    assert goals[:, 1].max() > 1  # the way leads around the wall's right end
    assert goals[-1, 0] < 0.5 and metrics["success"] == 1 and metrics["spl"] > 0.9


@pytest.mark.parametrize("start", ["fork", "forkserver", "spawn"])
def test_environments_in_processes_see_what_one_alone_sees(tasks: Path, start: str) -> None:
    from habitat.core.vector_env import VectorEnv
    from habitat.gym import make_gym_from_config

    config = configuration("benchmark/nav/pointnav/pointnav_mp3d.yaml", tasks / "point.json.gz")
    with habitat.Env(config=config) as env:
        alone = [env.reset(), env.step(FORWARD)]
    made = {"make_env_fn": make_gym_from_config, "env_fn_args": [(config,), (config,)]}
    with VectorEnv(multiprocessing_start_method=start, **made) as envs:
        seen = [envs.reset(), [result[0] for result in envs.step([FORWARD, FORWARD])]]
    for expected, both in zip(alone, seen):
        for found in both:
            for name in ("rgb", "depth", "pointgoal_with_gps_compass"):
                assert np.array_equal(expected[name], found[name]), name
