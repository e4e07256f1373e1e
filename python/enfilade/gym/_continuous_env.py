"""Continuous environments of VLN-CE's episodes: one agent, or many at once."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import Any, Dict, Optional, Union

import gymnasium
import numpy as np
from gymnasium.utils import EzPickle
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from enfilade._continuous import ContinuousEpisodes
from enfilade._errors import ArgumentError
from enfilade.gym._continuous import RENDER_MODES, ContinuousBatch, ContinuousEnvConfig, checked_mode

Observation = Dict[str, Any]
Flags = NDArray[np.bool_]


class ContinuousRoomToRoomEnv(gymnasium.Env[Observation, Any], EzPickle):
    """Enfilade/ContinuousRoomToRoom-v0 (R2R-CE) and Enfilade/ContinuousRoomAcrossRoom-v0 (RxR-CE).

    Actions: 0 stop, 1 forward, 2 left, 3 right; RxR-CE also 4 look up, 5 look down.

    Observations:
        - instruction: text, unless the config has text=False.
        - position: (3,) the feet, metres, world frame (z up).
        - pose: (2,) heading (clockwise from +y) and elevation of the camera, radians.
        - collided: (1,) whether a wall shortened the last step.
        - rgb, depth, class, instance: those of the config's `observe`.

    Info:
        - episode_id, scan.
        - distance: metres to the goal by the shortest path; NaN if the goal is hidden.
        - VLN-CE's measures (success, spl, ndtw, ...): at an episode's end, unless the goal is hidden.

    A pickled or copied environment has the same config.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 4}

    def __init__(
        self,
        config: ContinuousEnvConfig,
        render_mode: Optional[str] = None,
        *,
        task: Optional[str] = None,
    ) -> None:
        EzPickle.__init__(self, config, render_mode, task=task)
        self.render_mode = checked_mode(render_mode)
        self._batch = ContinuousBatch(config if task is None else replace(config, task=task), 1)
        self.observation_space = self._batch.single_observation_space
        self.action_space = self._batch.single_action_space

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode: drawn from the seed's stream, or options["episode"], an index or an episode
        id."""
        chosen = self._batch.chosen_episodes(options)
        self._batch.seed([seed])
        super().reset(seed=seed)
        self._batch.reset(chosen=chosen)
        return self._observation(), self._info()

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Executes an action; at the episode's end `info` has the measures."""
        rewards = self._batch.step([action])
        terminated = bool(self._batch.terminated()[0])
        truncated = bool(self._batch.truncated()[0])
        info = self._info()
        if terminated or truncated:
            info.update(self._batch.final_metrics(0))
        return self._observation(), float(rewards[0]), terminated, truncated, info

    def expert(self, rule: str = "reference") -> Optional[int]:
        """A teacher's action. "reference": along the reference path, by the rule of VLN-CE's experts;
        "shortest": along the shortest path to the goal. None if the goal is hidden."""
        return self._batch.expert(0, rule)

    @property
    def episodes(self) -> ContinuousEpisodes:
        """The episodes of the split; `arrays["episode"]` is the index of the current one."""
        return self._batch.episodes

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """The agent's state, by name, as in ContinuousRoomToRoomVectorEnv.arrays with n = 1."""
        return self._batch.arrays

    def metrics(self) -> dict[str, float]:
        """VLN-CE's measures of the trajectory so far. Raises ArgumentError for a hidden goal."""
        return self._batch.metrics(0)

    def render(self) -> Union[None, NDArray[np.uint8], str]:
        """rgb_array: (height, width, 3) uint8, the agent's view. ansi: its state as text."""
        seen = self._batch.describe(self.render_mode)
        return None if seen is None else seen[0]

    def _observation(self) -> Observation:
        return {name: value[0] for name, value in self._batch.observe().items()}

    def _info(self) -> dict[str, Any]:
        episode = self._batch.episodes[int(self._batch.arrays["episode"][0])]
        return {
            "episode_id": episode.id,
            "scan": episode.scan,
            "distance": float(self._batch.arrays["distance"][0]),
        }


class ContinuousRoomToRoomVectorEnv(
    gymnasium.vector.VectorEnv[Observation, Any, NDArray[Any]], EzPickle
):
    """n continuous environments, stepped together in C++. Observations have n in front of each shape.

    Args:
        config: of all agents; reset(seed=s) gives agent k the episodes of a single environment's
            reset(seed=s + k).
        num_envs: n.
        autoreset_mode: Gymnasium's NEXT_STEP, SAME_STEP (final_obs and final_info in the info) or
            DISABLED (reset(options={"reset_mask": flags})).
        render_mode: "rgb_array" or "ansi"; render() returns n of them.
        task: overrides the config's.

    Info:
        - distance: (n,) metres to the goal.
        - episode_index: (n,) indices into `episodes`.
        - VLN-CE's measures: (n,) at an episode's end.
        - Each has its mask `_name`, as usual in Gymnasium.

    A pickled or copied environment has the same config.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 4}

    def __init__(
        self,
        config: ContinuousEnvConfig,
        num_envs: int = 1,
        *,
        autoreset_mode: Union[str, AutoresetMode] = AutoresetMode.NEXT_STEP,
        render_mode: Optional[str] = None,
        task: Optional[str] = None,
    ) -> None:
        super().__init__()
        EzPickle.__init__(
            self, config, num_envs, autoreset_mode=autoreset_mode, render_mode=render_mode, task=task
        )
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.render_mode = checked_mode(render_mode)
        self._batch = ContinuousBatch(config if task is None else replace(config, task=task), num_envs)
        self.num_envs = num_envs
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode}
        self.single_observation_space = self._batch.single_observation_space
        self.single_action_space = self._batch.single_action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._all = np.ones(num_envs, bool)
        self._ended = np.zeros(num_envs, bool)

    def reset(
        self,
        *,
        seed: Union[None, int, Sequence[Optional[int]]] = None,
        options: Optional[dict[str, Any]] = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode in every environment, or in those of options["reset_mask"]. With seed s,
        environment k gets the episodes of a single one with seed s + k. Raises ArgumentError for a wrong
        number of seeds or an invalid mask."""
        if isinstance(seed, (int, np.integer)):
            seed = [int(seed) + k for k in range(self.num_envs)]
        if seed is not None and len(seed) != self.num_envs:
            raise ArgumentError(f"seed: {len(seed)} for {self.num_envs} environments")
        mask = None
        if options is not None and "reset_mask" in options:
            mask = self._checked_mask(options["reset_mask"])
        chosen = self._batch.chosen_episodes(options)
        if seed is not None:
            self._batch.seed(seed)
        self._batch.reset(mask, chosen)
        self._ended = self._ended & ~(self._all if mask is None else mask)
        return self._batch.observe(), self._info(self._all if mask is None else mask)

    def step(
        self, actions: ArrayLike
    ) -> tuple[Observation, NDArray[np.float64], Flags, Flags, dict[str, Any]]:
        """One action per environment, (n,). Raises TypeError or ArgumentError for invalid actions."""
        batch = self._batch
        next_step = self.autoreset_mode == AutoresetMode.NEXT_STEP
        rewards = batch.step(actions, self._ended if next_step else None)
        terminated, truncated = batch.terminated(), batch.truncated()
        info = self._info(self._all)
        seen = batch.observe()
        self._ended = terminated | truncated
        if self._ended.any():
            final = self._final_metrics(self._ended)
            if self.autoreset_mode == AutoresetMode.SAME_STEP:
                info = self._reset_ended(self._ended, seen, {**info, **final})
            else:
                info.update(final)
        return seen, rewards, terminated, truncated, info

    def expert(self, agent: int, rule: str = "reference") -> Optional[int]:
        """A teacher's action; see ContinuousRoomToRoomEnv.expert()."""
        return self._batch.expert(agent, rule)

    @property
    def episodes(self) -> ContinuousEpisodes:
        """The episodes of the split; `arrays["episode"]` has the indices of the current ones."""
        return self._batch.episodes

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """The state of n agents, by name, for teachers: the arrays of ContinuousState, with two changes.
        `episode` is the index into `episodes`, and `state` the EpisodeStatus. There is also `distance`,
        metres. All are (n, ...), read-only views of the environment's memory; the next call overwrites
        them."""
        return self._batch.arrays

    def metrics(self, agent: int) -> dict[str, float]:
        """VLN-CE's measures of an agent's trajectory so far. With SAME_STEP this is the new episode's after
        an end."""
        return self._batch.metrics(agent)

    def render(self) -> Optional[tuple[Any, ...]]:
        """A tuple of n results of ContinuousRoomToRoomEnv.render(); None without a render mode."""
        seen = self._batch.describe(self.render_mode)
        return None if seen is None else tuple(seen)

    def _checked_mask(self, mask: Any) -> Flags:
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
            raise TypeError("options['reset_mask']: a NumPy array of bool is wanted")
        if mask.shape != (self.num_envs,) or not mask.any():
            raise ArgumentError(f"options['reset_mask']: shape ({self.num_envs},), at least one True")
        return mask

    def _info(self, mask: Flags) -> dict[str, Any]:
        arrays = self._batch.arrays
        return {
            "distance": arrays["distance"].copy(),
            "_distance": mask.copy(),
            "episode_index": arrays["episode"].copy(),
            "_episode_index": mask.copy(),
        }

    def _final_metrics(self, ended: Flags) -> dict[str, Any]:
        info: dict[str, Any] = {}
        for agent in np.flatnonzero(ended):
            for name, value in self._batch.final_metrics(int(agent)).items():
                if name not in info:
                    info[name] = np.zeros(self.num_envs)
                    info[f"_{name}"] = np.zeros(self.num_envs, bool)
                info[name][agent], info[f"_{name}"][agent] = value, True
        return info

    def _reset_ended(
        self, ended: Flags, seen: Observation, final_info: dict[str, Any]
    ) -> dict[str, Any]:
        final = np.full(self.num_envs, None, object)
        agents = np.flatnonzero(ended)
        for agent in agents:
            final[agent] = {name: copy(value[agent]) for name, value in seen.items()}
        for name in final_info:
            if name.startswith("_"):
                final_info[name] = final_info[name] & ended
        self._batch.reset(ended)
        self._batch.observe_again(seen, agents)
        self._ended = np.zeros(self.num_envs, bool)
        return {
            **self._info(self._all),
            "final_obs": final,
            "_final_obs": ended,
            "final_info": final_info,
            "_final_info": ended.copy(),
        }
