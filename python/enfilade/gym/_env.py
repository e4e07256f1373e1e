"""One agent in episodes of a benchmark."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Dict, Optional, Union

import gymnasium
import numpy as np
from gymnasium.utils import EzPickle
from numpy.typing import NDArray

from enfilade._dataset import SeenObject
from enfilade._episodes import Episodes
from enfilade.gym._batch import ANSWERS, RENDER_MODES, Batch
from enfilade.gym._config import EnvConfig

Observation = Dict[str, Any]
_ALONE = np.ones(1, bool)


class RoomToRoomEnv(gymnasium.Env[Observation, Any], EzPickle):
    """RoomToRoom-v0, and the environments of other benchmarks (enfilade.gym.ENV_TASKS).

    Observations:
        - instruction: text, unless the config has text=False.
        - pose: (2,) heading and elevation, radians.
        - candidates: (m, 3) rel_heading, rel_elevation (radians from the agent's view) and distance
          (metres); row 0 is the current viewpoint.
        - candidate_mask: (m,) 1 for rows in use.
        - tokens: token ids, if the config names a vocabulary.
        - rgb, depth, class, instance: those of the config's `observe`.
        - nodes: "map" actions only, (actions, 7), positions as in DUET's features (docs/agents.md); row 0
          is [stop].
        - node_mask: "map" actions only, (actions,) 1 for nodes that the agent can go to.

    Info:
        - instruction_id, scan, viewpoint.
        - distance: metres to the goal.
        - success, spl: at an episode's end, of the trajectory alone. metrics() has the others.
        - answered: at an episode's end, in tasks with answers: whether the answer is right.

    A pickled or copied environment has the same config.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 2}

    def __init__(
        self, config: EnvConfig, render_mode: Optional[str] = None, *, task: Optional[str] = None
    ) -> None:
        EzPickle.__init__(self, config, render_mode, task=task)
        self._batch = Batch(config if task is None else replace(config, task=task), 1)
        self._batch.checked_mode(render_mode)
        self.metadata = {**self.metadata, "render_modes": self._batch.render_modes()}
        self.render_mode = render_mode
        self.observation_space = self._batch.single_observation_space
        self.action_space = self._batch.single_action_space

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode: drawn from the seed's stream, or options["episode"], an index or an
        instruction id."""
        chosen = self._batch.chosen_episodes(options)
        self._batch.seed([seed])
        super().reset(seed=seed)
        self._batch.reset(chosen=chosen)
        return self._observation(), self._info()

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Executes an action; at the episode's end `info` has "success" and "spl"."""
        rewards = self._batch.step([action])
        terminated = bool(self._batch.arrays["terminated"][0])
        truncated = bool(self._batch.arrays["truncated"][0])
        info = self._info()
        if terminated or truncated:
            info.update({name: float(self._batch.arrays[name][0]) for name in ("success", "spl")})
            if self._batch.config.task in ANSWERS:
                info["answered"] = bool(self._batch.answered(_ALONE)[0])
        return self._observation(), float(rewards[0]), terminated, truncated, info

    def answer(self, answer: Any) -> None:
        """Sets the agent's answer in this episode; the last one before the end counts.

        Args:
            answer: REVERIE: the object's id. SOON: (heading, elevation) of the object from the last
                viewpoint, radians, world frame. R2R-Back: the id of the turning point. None: no answer.

        Raises ArgumentError for a task without answers, TypeError for an answer of the wrong type.
        """
        self._batch.answer(0, answer)

    def objects(self) -> list[SeenObject]:
        """The objects that the agent may name: those that a view of its viewpoint shows (REVERIE)."""
        return self._batch.objects(0)

    def expert(self, rule: str = "spl") -> Optional[int]:
        """A teacher's action: the next step on the shortest path to the goal, or stop. With "map" actions
        it is DUET's pseudo-expert's, by its rule "spl" or "ndtw". None if the goal is hidden or out of
        reach."""
        return self._batch.expert(0, rule)

    def action_masks(self) -> NDArray[np.bool_]:
        """(actions,) bool: which actions have an effect, for sb3-contrib's MaskablePPO."""
        mask: NDArray[np.bool_] = self._batch.action_masks()[0]
        return mask

    @property
    def episodes(self) -> Episodes:
        """The episodes of the split; `arrays["episode"]` is the index of the current one."""
        return self._batch.episodes

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """The agent's state, by name, as in RoomToRoomVectorEnv.arrays with n = 1."""
        return self._batch.arrays

    def metrics(self) -> dict[str, float]:
        """All metrics of the trajectory and the answer so far (docs/tasks.md): ours for R2R, those of the
        first of enfilade.scorers(task) for others."""
        return self._batch.metrics(0)

    def render(self) -> Union[None, NDArray[np.uint8], str]:
        """rgb_array: (height, width, 3) uint8, the agent's view. ansi: its state as text."""
        seen = self._batch.render(self.render_mode)
        return None if seen is None else seen[0]

    def _observation(self) -> Observation:
        return {name: value[0] for name, value in self._batch.observe().items()}

    def _info(self) -> dict[str, Any]:
        arrays = self._batch.arrays
        episode = self._batch.episodes[int(arrays["episode"][0])]
        graph = self._batch.episodes.graphs[episode.scan]
        return {
            "instruction_id": episode.instruction_id,
            "scan": episode.scan,
            "viewpoint": graph.viewpoints[int(arrays["viewpoint"][0])],
            "distance": float(arrays["distance"][0]),
        }
