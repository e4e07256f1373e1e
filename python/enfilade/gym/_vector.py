"""Many agents in episodes of a benchmark, stepped together in C++."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any, Dict, Optional, Union

import gymnasium
import numpy as np
from gymnasium.utils import EzPickle
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from enfilade._continuous import ContinuousEpisodes
from enfilade._dataset import SeenObject
from enfilade._episodes import Episodes
from enfilade._errors import ArgumentError
from enfilade.gym._batch import RENDER_MODES
from enfilade.gym._config import AnyConfig, config_of
from enfilade.gym._env import batch_of

Observation = Dict[str, Any]
Flags = NDArray[np.bool_]


class VlnVectorEnv(gymnasium.vector.VectorEnv[Observation, Any, NDArray[Any]], EzPickle):
    """n environments of a benchmark. Observations are those of VlnEnv, with n in front of each shape.

    Args:
        config: of all agents, as in VlnEnv; reset(seed=s) gives agent k the episodes of a single
            environment's reset(seed=s + k).
        num_envs: n.
        autoreset_mode: Gymnasium's NEXT_STEP, SAME_STEP (final_obs and final_info in the info) or
            DISABLED (reset(options={"reset_mask": flags})).
        render_mode: "rgb_array" or "ansi"; render() returns n of them.
        task: overrides the config's.
        options: fields of the config.

    Info:
        - distance: (n,) metres to the goal.
        - episode_index: (n,) indices into `episodes`.
        - success, spl: (n,) at an episode's end. metrics(k) has the others. Continuous: all of VLN-CE's
          measures.
        - answered: (n,) at an episode's end, in tasks with answers.
        - Each has its mask `_name`, as usual in Gymnasium.

    A pickled or copied environment has the same config.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 2}

    def __init__(
        self,
        config: Optional[AnyConfig] = None,
        num_envs: int = 1,
        *,
        autoreset_mode: Union[str, AutoresetMode] = AutoresetMode.NEXT_STEP,
        render_mode: Optional[str] = None,
        task: Optional[str] = None,
        **options: Any,
    ) -> None:
        super().__init__()
        EzPickle.__init__(
            self, config, num_envs, autoreset_mode=autoreset_mode, render_mode=render_mode, task=task,
            **options,
        )  # fmt: skip
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        next_step = self.autoreset_mode == AutoresetMode.NEXT_STEP
        own = config_of(config, task, options)
        self._batch = batch_of(own, num_envs, reset_at_next_step=next_step)
        self.num_envs = num_envs
        self.render_mode = self._batch.checked_mode(render_mode)
        self.metadata = {**self._batch.metadata(), "autoreset_mode": self.autoreset_mode}
        self.single_observation_space = self._batch.single_observation_space
        self.single_action_space = self._batch.single_action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._all = np.ones(num_envs, bool)

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
        return self._batch.observe(), self._info(self._all if mask is None else mask)

    def step(
        self, actions: ArrayLike
    ) -> tuple[Observation, NDArray[np.float64], Flags, Flags, dict[str, Any]]:
        """One action per environment, (n,). Raises TypeError or ArgumentError for invalid actions."""
        batch = self._batch
        rewards = batch.step(actions)
        terminated, truncated = batch.terminated(), batch.truncated()
        info = self._info(self._all)
        seen = batch.observe()
        ended = terminated | truncated
        if ended.any():
            final = batch.final_info(ended)
            if self.autoreset_mode == AutoresetMode.SAME_STEP:
                info = self._reset_ended(ended, seen, {**info, **final})
            else:
                info.update(final)
        return seen, rewards, terminated, truncated, info

    def answer(self, agent: int, answer: Any) -> None:
        """Sets an agent's answer in its episode; see VlnEnv.answer()."""
        self._batch.answer(agent, answer)

    def objects(self, agent: int) -> list[SeenObject]:
        """The objects that an agent may name; see VlnEnv.objects()."""
        return self._batch.objects(agent)

    def expert(self, agent: int, rule: Optional[str] = None) -> Optional[int]:
        """A teacher's action; see VlnEnv.expert()."""
        return self._batch.expert(agent, rule)

    def action_masks(self) -> NDArray[np.bool_]:
        """(n, actions) bool: which actions have an effect."""
        return self._batch.action_masks()

    @property
    def episodes(self) -> Union[Episodes, ContinuousEpisodes]:
        """The episodes of the split; `arrays["episode"]` has the indices of the current ones."""
        return self._batch.episodes

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """The state of n agents, by name, for teachers. Read-only views of the environment's memory; the
        next call overwrites them.

        Graphs:
            - (n,): scan, viewpoint (indices), heading, elevation (radians), view_index, step, episode,
              distance (metres), reward, terminated, truncated, began, success, spl.
            - (n, m): candidate_viewpoint (indices), candidate_mask.
            - (n, m, 3): candidates.
            - (n, m), "panoramic" and "map" actions only: candidate_view (of 36).
            - (n, actions), "map" only: node_viewpoint, node_visited, node_mask.
            - (n, actions, 7), "map" only: nodes.

        Continuous arrays are those of ContinuousState, with two changes: `episode` is the index into
        `episodes`, and `state` the EpisodeStatus. There is also `distance`, metres.
        """
        return self._batch.arrays

    def metrics(self, agent: int) -> dict[str, float]:
        """All metrics of an agent's trajectory so far (docs/tasks.md). With SAME_STEP this is the new
        episode's after an end."""
        return self._batch.metrics(agent)

    def render(self) -> Optional[tuple[Any, ...]]:
        """A tuple of n results of VlnEnv.render(); None without a render mode."""
        seen = self._batch.render(self.render_mode)
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

    def _reset_ended(
        self, ended: Flags, seen: Observation, final_info: dict[str, Any]
    ) -> dict[str, Any]:
        agents = np.flatnonzero(ended)
        final = np.full(self.num_envs, None, object)
        for agent in agents:
            final[agent] = {name: copy(value[agent]) for name, value in seen.items()}
        for name in final_info:
            if name.startswith("_"):
                final_info[name] = final_info[name] & ended
        self._batch.reset(ended)
        self._batch.observe_again(seen, agents)
        return {
            **self._info(self._all),
            "final_obs": final,
            "_final_obs": ended,
            "final_info": final_info,
            "_final_info": ended.copy(),
        }
