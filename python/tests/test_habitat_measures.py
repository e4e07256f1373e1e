"""habitat-lab's measures of VLN-v0 beside `enfilade score`: the same walks on the same floor, in model homes
(SYNTHETIC). ENFILADE_HABITAT_EPISODES sets their number (20)."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

np = pytest.importorskip("numpy")
pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")
habitat = pytest.importorskip("habitat", reason="habitat-lab is not installed")

pytest.register_assert_rewrite("habitat_homes")

import habitat_sim  # noqa: E402
from habitat_homes import FloorHomes, read_packed  # noqa: E402
from programs import run  # noqa: E402

pytest_plugins = ["habitat_homes"]

SUCCESS_DISTANCE = 3.0  # metres: VLN-CE's
STOP, FORWARD, LEFT, RIGHT = range(4)


class Agent:
    """Follows the shortest path, with random actions in between, or only those: some succeed, some do not."""

    def __init__(self, env: Any, number: int) -> None:
        from habitat.tasks.nav.shortest_path_follower import ShortestPathFollower

        self._rng = np.random.default_rng(number)
        self._share = (0.0, 0.3, 1.0)[number % 3]  # of random actions
        self._follower = ShortestPathFollower(env.sim, 0.5, False)
        self._goal = np.array(env.current_episode.goals[0].position, np.float32)

    def act(self) -> int:
        if self._rng.random() < self._share:
            return int(self._rng.choice([STOP, FORWARD, LEFT, RIGHT], p=[0.02, 0.68, 0.15, 0.15]))
        action = self._follower.get_next_action(self._goal)
        return STOP if action is None else int(action)


def pose(env: Any, stop: bool) -> dict[str, Any]:
    state = env.sim.get_agent_state()
    heading = 2 * math.atan2(state.rotation.y, state.rotation.w)
    return {"position": [float(x) for x in state.position], "heading": heading, "stop": stop}


def ndtw(poses: list[dict[str, Any]], reference: Any) -> float:
    """VLN-CE's nDTW by exact DTW. Places that repeat the one before count once."""
    walked = [p["position"] for p in poses]
    walked = [w for k, w in enumerate(walked) if k == 0 or w != walked[k - 1]]
    apart = np.linalg.norm(np.asarray(walked)[:, None] - np.asarray(reference)[None], axis=2)
    cost = np.full((len(walked) + 1, len(reference) + 1), np.inf)
    cost[0, 0] = 0
    for i in range(len(walked)):
        for j in range(len(reference)):
            cost[i + 1, j + 1] = apart[i, j] + min(cost[i, j], cost[i, j + 1], cost[i + 1, j])
    return math.exp(-float(cost[-1, -1]) / (len(reference) * SUCCESS_DISTANCE))


def test_scores_are_those_of_habitat_lab(
    floor_homes: FloorHomes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(habitat_sim.nav, "navigation", "0.3.3")
    experts = read_packed(floor_homes.data / "vlnce" / f"{floor_homes.split}_gt.json.gz")
    walks: dict[str, list[dict[str, Any]]] = {}
    theirs: dict[str, dict[str, float]] = {}
    options = floor_homes.options()
    options.append(f"habitat.task.measurements.success.success_distance={SUCCESS_DISTANCE}")
    config = habitat.get_config("benchmark/nav/vln_r2r.yaml", overrides=options)
    with habitat.Env(config=config) as env:
        for number in range(len(floor_homes.episodes)):
            env.reset()
            agent, poses = Agent(env, number), [pose(env, False)]
            while not env.episode_over:
                action = agent.act()
                env.step(action)
                poses.append(pose(env, action == STOP))
            episode = str(env.current_episode.episode_id)
            walks[episode] = poses
            theirs[episode] = {
                **{key: float(env.get_metrics()[key]) for key in ("success", "spl", "distance_to_goal")},
                "ndtw": ndtw(poses, experts[episode]["locations"]),
            }
    assert len(walks) == len(floor_homes.episodes)
    file = tmp_path / "walks.json"
    file.write_text(json.dumps(walks))
    score = json.loads(
        run(
            "score", file, "--task", "r2r-ce", "--data", floor_homes.data, "--split", floor_homes.split,
            "--part", "--json", "-", "--per-episode",
        )
    )  # fmt: skip
    assert score["floor"] == "habitat 0.3.3" and score["episodes"] == len(walks)
    for episode, measures in theirs.items():
        for key, value in measures.items():
            ours = score["per_episode"][episode][key]
            assert ours == pytest.approx(value, abs=1e-6), (episode, key)
    for key in ("success", "spl", "distance_to_goal", "ndtw"):
        mean = float(np.mean([measures[key] for measures in theirs.values()]))
        assert score["means"][key]["mean"] == pytest.approx(mean, abs=1e-6), key
        print(f"{key}: {mean:.6f} and {score['means'][key]['mean']:.6f}")
    share = score["means"]["success"]["mean"]
    assert 0.2 < share < 1, "agents that all succeed, or none, would show little"
