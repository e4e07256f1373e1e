"""Continuous agents, in VLN-CE's episodes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Optional

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from enfilade._arguments import whole
from enfilade._continuous import (
    MOST_AGENTS,
    ContinuousEpisodes,
    ContinuousSimulator,
    EpisodeStatus,
    _data_folder,
    continuous_episodes,
)
from enfilade._core import FloorSet, FreeEnvironment
from enfilade._errors import ArgumentError
from enfilade._layers import layer_of
from enfilade.gym._batch import Batch
from enfilade.gym._config import ContinuousEnvConfig, Transition

SUCCESS_METRES = 3.0  # a stop nearer than this, as VLN-CE counts
EXPERTS = ("reference", "shortest")


class ContinuousBatch(Batch):
    """n agents in episodes of VLN-CE."""

    most_metres = 10000
    frames_per_second = 4
    config: ContinuousEnvConfig
    episodes: ContinuousEpisodes
    core: FreeEnvironment

    def __init__(
        self, config: ContinuousEnvConfig, n: int, *, reset_at_next_step: bool = False
    ) -> None:
        super().__init__(config, n)
        self._reset_at_next_step = reset_at_next_step
        self._data = _data_folder(config.data)
        self.episodes = continuous_episodes(self._data, config.task, config.split)
        if config.reward in ("progress", "success") and self.episodes[0].goals is None:
            raise ArgumentError(
                f"reward '{config.reward}': the goals of the split {config.split} are hidden"
            )
        navigation = Path(self._data, "navmesh", config.task)
        floors = FloorSet(os.fspath(navigation))
        options = {**config.simulator, "most_steps": config.max_steps}
        self.core = FreeEnvironment(self.episodes._core, floors, whole("num_envs", n, MOST_AGENTS), options)
        self.arrays = self.core.arrays()
        self._rngs = [np.random.default_rng(config.seed + k) for k in range(n)]
        self._eyes: Any = None
        self._floors = floors
        self._eye_height = ContinuousSimulator(
            navigation=navigation, task=config.task, **config.simulator
        ).config["eye_height"]
        if config.observe:
            self.eyes()
        self.single_observation_space = self._observation_space()
        self.single_action_space = spaces.Discrete(4 if config.task == "r2r-ce" else 6)

    def eyes(self) -> Any:
        """The renderer, made at first use: it loads a ray tracer."""
        if self._eyes is None:
            from enfilade.eyes import Eyes

            data = None if "meshes" in self.config.eyes else self._data
            self._eyes = Eyes(data, **self.config.eyes)
        return self._eyes

    def _draw(
        self, layers: tuple[str, ...], agents: Optional[NDArray[np.intp]]
    ) -> dict[str, NDArray[Any]]:
        chosen = np.arange(self.n) if agents is None else agents
        names = self._floors.scans
        scans = [names[building] for building in self.arrays["building"][chosen]]
        at = self.arrays["position"][chosen].astype(np.float64)
        at[:, 2] += self._eye_height
        heading, elevation = self.arrays["heading"][chosen], self.arrays["elevation"][chosen]
        drawn: dict[str, NDArray[Any]] = self.eyes().render(
            scans, at, heading, elevation, layers=layers, size=self.config.sizes, vfov=self.config.vfov
        )
        return drawn

    def _observation_space(self) -> spaces.Dict:
        space = self._spaces()
        space["collided"] = spaces.MultiBinary(1)
        space["position"] = spaces.Box(-self.most_metres, self.most_metres, (3,), np.float32)
        return spaces.Dict(space)

    def _size(self, layer: str) -> tuple[int, int]:
        from enfilade.eyes import SIZES

        own = {layer_of(word): size for word, size in self.config.sizes.items()}
        return own.get(layer, SIZES[layer])

    def _seed_agent(self, agent: int, number: int) -> None:
        self._rngs[agent] = np.random.default_rng(number)

    def reset(
        self,
        mask: Optional[NDArray[np.bool_]] = None,
        chosen: Optional[NDArray[np.int64]] = None,
    ) -> None:
        """Begins episodes of all agents or those of a mask: `chosen` ones, or drawn. Raises ArgumentError
        if the first call has a mask."""
        if mask is not None and not self._begun and not mask.all():
            raise ArgumentError("reset(): the first one is for all agents")
        begin = np.full(self.n, -1, np.int64)
        for agent in range(self.n) if mask is None else np.flatnonzero(mask):
            drawn = chosen is None
            begin[agent] = (
                self._rngs[agent].integers(len(self.episodes)) if drawn else chosen[agent]  # type: ignore[index]
            )
        self.core.begin(begin)
        self._begun = True

    def step(self, chosen: ArrayLike) -> NDArray[np.float64]:
        actions = self._checked_actions(chosen)
        self._check_begun("step")
        count = int(self.single_action_space.n)
        if (actions < 0).any() or (actions >= count).any():
            raise ArgumentError(f"actions: 0 to {count - 1} are allowed")
        ended: NDArray[np.bool_] = self.arrays["state"] != EpisodeStatus.WALKING
        if ended.any() and not self._reset_at_next_step:
            agent = int(np.flatnonzero(ended)[0])
            raise ArgumentError(f"step(): the episode of agent {agent} has ended; reset() it first")
        before = self.arrays["distance"].copy()
        self.core.step(np.ascontiguousarray(actions, np.uint8))
        rewards = self._rewards(before)
        if ended.any():  # these begin a new episode instead
            rewards[ended] = 0.0
            self.reset(ended)
        return rewards

    def _rewards(self, before: NDArray[np.float64]) -> NDArray[np.float64]:
        distance = self.arrays["distance"].copy()
        stopped = self.arrays["state"] == EpisodeStatus.STOPPED
        success = stopped & (distance < SUCCESS_METRES)
        reward = self.config.reward
        if callable(reward):
            none = np.zeros(self.n, bool)
            return self._own_rewards(Transition(before, distance, stopped, success, none))
        if reward == "success":
            return np.where(success, 1.0, 0.0)
        if reward == "none":
            return np.zeros(self.n)
        finite = np.isfinite(before) & np.isfinite(distance)  # not finite: no path to the goal
        nearer = np.subtract(before, distance, out=np.zeros(self.n), where=finite)
        bonus: NDArray[np.float64] = np.where(stopped, np.where(success, 2.0, -2.0), 0.0)
        bonus += nearer
        return bonus

    def terminated(self) -> NDArray[np.bool_]:
        flags: NDArray[np.bool_] = self.arrays["state"] == EpisodeStatus.STOPPED
        return flags

    def truncated(self) -> NDArray[np.bool_]:
        flags: NDArray[np.bool_] = self.arrays["state"] == EpisodeStatus.CUT_SHORT
        return flags

    def metrics(self, agent: int) -> dict[str, float]:
        """VLN-CE's measures of an agent's trajectory so far."""
        return self.core.score(whole("agent", agent, self.n - 1))

    def info(self) -> dict[str, Any]:
        episode = self.episodes[int(self.arrays["episode"][0])]
        return {
            "episode_id": episode.id,
            "scan": episode.scan,
            "distance": float(self.arrays["distance"][0]),
        }

    def final_info(self, ended: NDArray[np.bool_]) -> dict[str, NDArray[Any]]:
        final: dict[str, NDArray[Any]] = {}
        for agent in np.flatnonzero(ended & ~np.isnan(self.arrays["distance"])):  # NaN: a hidden goal
            for name, value in self.metrics(int(agent)).items():
                if name not in final:
                    final[name] = np.zeros(self.n)
                    final[f"_{name}"] = np.zeros(self.n, bool)
                final[name][agent], final[f"_{name}"][agent] = value, True
        return final

    def expert(self, agent: int, rule: Optional[str]) -> Optional[int]:
        rule = EXPERTS[0] if rule is None else rule
        if rule not in EXPERTS:
            raise ArgumentError(f"rule '{rule}': one of {', '.join(EXPERTS)} is wanted")
        return self.core.expert(whole("agent", agent, self.n - 1), rule == "shortest")

    def _numbers(self) -> dict[str, Any]:
        return {
            "collided": self.arrays["collided"].astype(np.int8).reshape(self.n, 1),
            "position": self.arrays["position"].copy(),
        }

    def _describe(self, agent: int) -> str:
        episode = self.episodes[int(self.arrays["episode"][agent])]
        x, y, z = self.arrays["position"][agent]
        return (
            f"{episode.id} in {episode.scan}: {episode.instruction.strip()}\n"
            f"step {self.arrays['steps'][agent]} at ({x:.2f}, {y:.2f}, {z:.2f}), heading "
            f"{np.degrees(self.arrays['heading'][agent]):.0f}, "
            f"{self.arrays['distance'][agent]:.1f} m from the goal\n"
        )
