"""Results of StreamVLN's evaluator, from the answers that a stub model gave. For habitat_sim.check."""

from __future__ import annotations

import gzip
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Optional

import habitat_sim
import numpy as np

from . import _check_navigation as navigation
from . import _check_scenes as scenes
from ._check_scenes import Job
from ._check_tally import LeftOutError, Tally

FILE = "streamvln_stub.json"
BODY, TURN, SUCCESS_DISTANCE = "r2r-ce", 15.0, 3.0  # degrees, metres
MOST_ACTIONS = 500  # of an episode
ACTIONS = {"STOP": None, "↑": "move_forward", "←": "turn_left", "→": "turn_right"}


def streamvln_parts(folder: Path) -> list[str]:
    """The file is one part: the answers go on from episode to episode."""
    known = scenes.read_json(folder / FILE)
    return [FILE] if known["results"] and known["texts"] else []


def check_streamvln(job: Job, _: str, tally: Tally) -> None:
    """The episodes of the file, one after the other."""
    scenes.choose_navigation(job.folder)
    known = scenes.read_json(job.recordings / "lab" / FILE)
    texts = iter(known["texts"])
    for i, wanted in enumerate(known["results"]):
        place = f"lab/{FILE}: results[{i}]"
        actions = _actions(texts)
        episode = _episode(job, wanted)
        if episode is None:
            tally.value(f"{place}.episode_id", wanted["episode_id"], None)
            continue
        tally.tree(place, wanted, _result(job, wanted, episode, actions))


def _actions(texts: Iterator[str]) -> list[Optional[str]]:
    """The actions of one episode, to the stop, None. The rest of an answer is dropped."""
    actions: list[Optional[str]] = []
    for text in texts:
        letters = re.findall("|".join(ACTIONS), text)
        for letter in letters or ["STOP"]:  # an answer without actions is taken for a stop
            actions.append(ACTIONS[letter])
            if actions[-1] is None or len(actions) == MOST_ACTIONS:
                return actions
    return actions


def _episode(job: Job, wanted: dict[str, Any]) -> Optional[dict[str, Any]]:
    """The episode of a result. An id may be in several splits: the instruction says which."""
    files = sorted((job.scenes / "vlnce").glob("*.json.gz"))
    if not files:
        raise LeftOutError(f"there are no episodes in {job.scenes / 'vlnce'}")
    for file in files:
        with gzip.open(file, "rt", encoding="utf-8") as stream:
            episodes = json.load(stream).get("episodes", [])
        for episode in episodes:
            same = (
                Path(episode["scene_id"]).stem == wanted["scene_id"]
                and str(episode["episode_id"]) == str(wanted["episode_id"])
                and episode["instruction"]["instruction_text"] == wanted["episode_instruction"]
            )
            if same:
                return dict(episode)
    return None


class _Measures:
    """The measures of habitat-lab and of StreamVLN, as they are updated after each action."""

    def __init__(self, finder: Any, goals: list[Any], position: Any) -> None:
        self._path = habitat_sim.MultiGoalShortestPath()
        self._path.requested_ends = np.array(goals, np.float32)
        self._finder = finder
        self.distance = float("inf")
        self._asked: Any = None  # the place of that distance
        self.near = False  # whether it ever was where stopping succeeds
        self.length, self._last = 0.0, position
        self.update(position)
        self.shortest = self.distance

    def update(self, position: Any) -> None:
        # habitat-lab keeps a distance while the agent is where it was, but for 0.1 mm.
        if self._asked is None or not np.allclose(self._asked, position, atol=1e-4):
            self._path.requested_start = position
            self._finder.find_path(self._path)
            self.distance, self._asked = self._path.geodesic_distance, position
        self.near = self.near or self.distance < SUCCESS_DISTANCE
        self.length += float(np.linalg.norm(position - self._last))
        self._last = position


def _result(
    job: Job, wanted: dict[str, Any], episode: dict[str, Any], actions: list[Optional[str]]
) -> dict[str, Any]:
    """What the evaluator writes of an episode."""
    scan = wanted["scene_id"]
    with scenes.simulator(job.glb(scan), None, scenes.body_size(job, BODY), True, TURN) as sim:
        navigation.put_on_mesh(job, sim, scan, BODY)
        agent = sim.get_agent(0)
        agent.set_state(navigation.state(episode["start_position"], episode["start_rotation"]), True)
        goals = [goal["position"] for goal in episode["goals"]]
        measures = _Measures(sim.pathfinder, goals, agent.get_state().position)
        for action in actions:
            if action is not None:
                agent.act(action)
            measures.update(agent.get_state().position)
        stopped = bool(actions) and actions[-1] is None
        success = float(stopped and measures.distance < SUCCESS_DISTANCE)
        longest = max(measures.shortest, measures.length)
        return {
            "scene_id": scan,
            "episode_id": wanted["episode_id"],
            "success": success,
            "spl": success * (measures.shortest / longest) if longest > 0 else success,
            "os": float(measures.near),
            "ne": measures.distance,
            "steps": len(actions),
            "episode_instruction": episode["instruction"]["instruction_text"],
        }
