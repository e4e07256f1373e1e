"""Shared by the single and the vector continuous environment."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Optional, Union

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from enfilade._arguments import whole
from enfilade._continuous import (
    MOST_AGENTS,
    TASKS,
    ContinuousSimulator,
    EpisodeStatus,
    continuous_episodes,
)
from enfilade._core import FloorSet, FreeEnvironment
from enfilade._errors import ArgumentError
from enfilade.gym._config import LAYERS, REWARDS, Transition

PI = np.float32(np.pi)  # above pi, as a rounded angle may be
MOST_METRES = 10000  # the spaces' bound of coordinates, larger than any building's
SUCCESS_METRES = 3.0  # a stop nearer than this, as VLN-CE counts
EXPERTS = ("reference", "shortest")
RENDER_MODES = ["rgb_array", "ansi"]
# The type of an image's values, and their largest value.
_PICTURES: dict[str, tuple[Any, float]] = {
    "rgb": (np.uint8, 255),
    "depth": (np.float32, MOST_METRES),
    "class": (np.uint16, 2**16 - 1),
    "instance": (np.uint32, 2**32 - 1),
}


@dataclass(frozen=True)
class ContinuousEnvConfig:
    """Episodes, observations and reward of a continuous environment.

    Args:
        data: folder of the data set, with navigation meshes and episodes (`enfilade continuous`).
        split: "train", "val_seen", "val_unseen", ...
        task: "r2r-ce": 4 actions; "rxr-ce": 6 actions. Environment ids with a task's name set it.
        reward: "progress" (metres nearer to the goal by the shortest path, 2 for a stop within 3 m, -2 for
            another), "success" (1 for a stop within 3 m), "none", or a function of a Transition that
            returns (n,) numbers. To pickle the config, the function has to be importable by its name.
        max_steps: actions after which an episode is truncated.
        text: whether observations have the instruction's text; some libraries do not support it.
        simulator: options of ContinuousSimulator that differ from the task's: {"slide": False}.
        seed: of the order of episodes, until reset(seed=...).
        observe: images, any of "rgb", "depth" (metres), "class", "instance" (enfilade.eyes).
        sizes: (width, height) of images by name; default: VLN-CE's.
        vfov: vertical field of view of images, radians.
        eyes: options of enfilade.eyes.Eyes: {"meshes": "glb"}; without "meshes" the data are synthetic homes.
    """

    data: Union[str, os.PathLike[str]]
    split: str = "train"
    task: str = "r2r-ce"
    reward: Union[str, Callable[[Transition], NDArray[np.float64]]] = "progress"
    max_steps: int = 500
    text: bool = True
    simulator: dict[str, Any] = field(default_factory=dict)
    seed: int = 1
    observe: tuple[str, ...] = ()
    sizes: dict[str, tuple[int, int]] = field(default_factory=dict)
    vfov: float = math.pi / 2
    eyes: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.task not in TASKS:
            raise ArgumentError(f"task '{self.task}': one of {', '.join(TASKS)} is wanted")
        if not callable(self.reward) and self.reward not in REWARDS:
            raise ArgumentError(
                f"reward {self.reward!r}: one of {', '.join(REWARDS)} or a function is wanted"
            )
        if whole("max_steps", self.max_steps) < 1:
            raise ArgumentError("max_steps 0: at least 1 is wanted")
        whole("seed", self.seed, 2**64 - 1)
        if isinstance(self.observe, str):
            raise ArgumentError(f"observe '{self.observe}': a tuple is wanted: ('{self.observe}',)")
        for layer in self.observe:
            if layer not in LAYERS:
                raise ArgumentError(f"observe '{layer}': any of {', '.join(LAYERS)} are wanted")


class ContinuousBatch:
    """n agents in episodes of VLN-CE. `arrays` has views of the core's memory by name."""

    def __init__(self, config: ContinuousEnvConfig, n: int) -> None:
        self.config = config
        self.n = n
        self.episodes = continuous_episodes(config.data, config.task, config.split)
        if config.reward in ("progress", "success") and self.episodes[0].goals is None:
            raise ArgumentError(
                f"reward '{config.reward}': the goals of the split {config.split} are hidden"
            )
        floors = FloorSet(os.fspath(Path(config.data, "navmesh", config.task)))
        options = {**config.simulator, "most_steps": config.max_steps}
        self.core = FreeEnvironment(self.episodes._core, floors, whole("num_envs", n, MOST_AGENTS), options)
        self.arrays: dict[str, NDArray[Any]] = self.core.arrays()
        self._texts = self.episodes._core.texts
        self._rngs = [np.random.default_rng(config.seed + k) for k in range(n)]
        self._begun = False
        self._eyes: Any = None
        self._floors = floors
        self._eye_height = ContinuousSimulator(
            navigation=Path(config.data, "navmesh", config.task), task=config.task, **config.simulator
        ).config["eye_height"]
        if config.observe:
            self.eyes()
        self.single_observation_space = self._observation_space()
        self.single_action_space = spaces.Discrete(4 if config.task == "r2r-ce" else 6)

    def eyes(self) -> Any:
        """The renderer, made at first use: it loads a ray tracer."""
        if self._eyes is None:
            from enfilade.eyes import Eyes

            data = None if "meshes" in self.config.eyes else self.config.data
            self._eyes = Eyes(data, **self.config.eyes)
        return self._eyes

    def pictures(self, layers: Sequence[str], agents: NDArray[np.intp]) -> dict[str, NDArray[Any]]:
        """The current images of these agents, by name."""
        names = self._floors.scans
        scans = [names[building] for building in self.arrays["building"][agents]]
        at = self.arrays["position"][agents].astype(np.float64)
        at[:, 2] += self._eye_height
        heading, elevation = self.arrays["heading"][agents], self.arrays["elevation"][agents]
        drawn: dict[str, NDArray[Any]] = self.eyes().render(
            scans, at, heading, elevation, layers=layers, size=self.config.sizes, vfov=self.config.vfov
        )
        return drawn

    def _observation_space(self) -> spaces.Dict:
        space: dict[str, spaces.Space[Any]] = {
            "collided": spaces.MultiBinary(1),
            "pose": spaces.Box(
                np.array([0, -PI / 2], np.float32), np.array([2 * PI, PI / 2], np.float32)
            ),
            "position": spaces.Box(-MOST_METRES, MOST_METRES, (3,), np.float32),
        }
        if self.config.text:
            space["instruction"] = spaces.Text(
                max_length=max(1, *map(len, self._texts)),
                min_length=0,
                charset=frozenset("".join(self._texts)) or frozenset(" "),
            )
        for layer in self.config.observe:
            from enfilade.eyes import SIZES

            width, height = self.config.sizes.get(layer, SIZES[layer])
            kind, high = _PICTURES[layer]
            shape = (height, width, 3) if layer == "rgb" else (height, width)
            space[layer] = spaces.Box(0, high, shape, kind)
        return spaces.Dict(space)

    def seed(self, seeds: Sequence[Optional[int]]) -> None:
        """Seeds each agent's stream of episodes; None leaves it unchanged."""
        numbers = [None if seed is None else whole("seed", seed, 2**64 - 1) for seed in seeds]
        for agent, number in enumerate(numbers):
            if number is not None:
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

    def step(
        self, chosen: ArrayLike, skip: Optional[NDArray[np.bool_]] = None
    ) -> NDArray[np.float64]:
        """Steps all agents; those of `skip` begin a new episode instead. Returns the rewards, (n,). Raises
        TypeError or ArgumentError for invalid actions; then no agent has moved."""
        actions = np.asarray(chosen)
        if actions.dtype.kind not in "iub":
            raise TypeError(f"actions of type {actions.dtype}: integers are wanted")
        if actions.shape != (self.n,):
            raise ArgumentError(f"actions: shape {actions.shape}, not ({self.n},)")
        if not self._begun:
            raise ArgumentError("step(): reset() has to come first")
        count = int(self.single_action_space.n)
        if (actions < 0).any() or (actions >= count).any():
            raise ArgumentError(f"actions: 0 to {count - 1} are allowed")
        ended = self.arrays["state"] != EpisodeStatus.WALKING
        if (ended if skip is None else ended & ~skip).any():
            agent = int(np.flatnonzero(ended if skip is None else ended & ~skip)[0])
            raise ArgumentError(f"step(): the episode of agent {agent} has ended; reset() it first")
        before = self.arrays["distance"].copy()
        self.core.step(np.ascontiguousarray(actions, np.uint8))
        rewards = self._rewards(before)
        if skip is not None and skip.any():
            rewards[skip] = 0.0
            self.reset(skip)
        return rewards

    def _rewards(self, before: NDArray[np.float64]) -> NDArray[np.float64]:
        distance = self.arrays["distance"].copy()
        stopped = self.arrays["state"] == EpisodeStatus.STOPPED
        success = stopped & (distance < SUCCESS_METRES)
        reward = self.config.reward
        if callable(reward):
            nobody = np.zeros(self.n, bool)
            given = reward(Transition(before, distance, stopped, success, nobody))
            rewards: NDArray[np.float64] = np.array(given, np.float64)
            if rewards.shape != (self.n,):
                raise ValueError(f"reward: shape {rewards.shape}, not ({self.n},)")
            return rewards
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
        """(n,) episodes that ended by STOP."""
        flags: NDArray[np.bool_] = self.arrays["state"] == EpisodeStatus.STOPPED
        return flags

    def truncated(self) -> NDArray[np.bool_]:
        """(n,) episodes that ended after max_steps actions."""
        flags: NDArray[np.bool_] = self.arrays["state"] == EpisodeStatus.CUT_SHORT
        return flags

    def metrics(self, agent: int) -> dict[str, float]:
        """VLN-CE's measures of an agent's trajectory so far."""
        return self.core.score(whole("agent", agent, self.n - 1))

    def final_metrics(self, agent: int) -> dict[str, float]:
        """The same at an episode's end; empty if the goal is hidden."""
        return {} if np.isnan(self.arrays["distance"][agent]) else self.metrics(agent)

    def expert(self, agent: int, rule: str) -> Optional[int]:
        """A teacher's action. Raises ArgumentError for an unknown rule."""
        if rule not in EXPERTS:
            raise ArgumentError(f"rule '{rule}': one of {', '.join(EXPERTS)} is wanted")
        return self.core.expert(whole("agent", agent, self.n - 1), rule == "shortest")

    def chosen_episodes(self, options: Optional[dict[str, Any]]) -> Optional[NDArray[np.int64]]:
        """The episodes of reset(options={"episode": ...}): indices or ids, one or n."""
        wanted = (options or {}).get("episode")
        if wanted is None:
            return None
        each = list(wanted) if isinstance(wanted, (list, tuple, np.ndarray)) else [wanted]
        if len(each) == 1:
            each = each * self.n
        if len(each) != self.n:
            raise ArgumentError(f"options['episode']: {len(each)} for {self.n} environments")
        return np.array([self._index_of(one) for one in each], np.int64)

    def _index_of(self, wanted: Any) -> int:
        if not isinstance(wanted, str):
            return whole("episode", wanted, len(self.episodes) - 1)
        place = self.episodes.find(wanted)
        if place is None:
            raise ArgumentError(f"episode '{wanted}' is not in the split {self.config.split}")
        return place

    def observe(self) -> dict[str, Any]:
        """Copies by name, shape (n, ...), and a tuple of n texts."""
        drawn = self.pictures(self.config.observe, np.arange(self.n)) if self.config.observe else {}
        return {**self._numbers(), **drawn}

    def observe_again(self, seen: dict[str, Any], agents: NDArray[np.intp]) -> None:
        """Updates an observation after a reset of only these agents."""
        seen.update(self._numbers())
        if self.config.observe:
            for name, redrawn in self.pictures(self.config.observe, agents).items():
                seen[name][agents] = redrawn

    def _numbers(self) -> dict[str, Any]:
        pose = np.empty((self.n, 2), np.float32)
        pose[:, 0] = self.arrays["heading"]
        pose[:, 1] = self.arrays["elevation"]
        seen: dict[str, Any] = {
            "collided": self.arrays["collided"].astype(np.int8).reshape(self.n, 1),
            "pose": pose,
            "position": self.arrays["position"].copy(),
        }
        if self.config.text:
            seen["instruction"] = tuple(self._texts[e] for e in self.arrays["episode"])
        return seen

    def describe(self, mode: Optional[str]) -> Optional[list[Any]]:
        """The result of a render mode for each agent; None for no mode."""
        if mode is None:
            return None
        if not self._begun:
            raise ArgumentError("render(): reset() has to come first")
        if mode == "rgb_array":
            return list(self.pictures(("rgb",), np.arange(self.n))["rgb"])
        return [self._describe(agent) for agent in range(self.n)]

    def _describe(self, agent: int) -> str:
        episode = self.episodes[int(self.arrays["episode"][agent])]
        x, y, z = self.arrays["position"][agent]
        return (
            f"{episode.id} in {episode.scan}: {episode.instruction.strip()}\n"
            f"step {self.arrays['steps'][agent]} at ({x:.2f}, {y:.2f}, {z:.2f}), heading "
            f"{np.degrees(self.arrays['heading'][agent]):.0f}, "
            f"{self.arrays['distance'][agent]:.1f} m from the goal\n"
        )


def checked_mode(mode: Optional[str]) -> Optional[str]:
    """The mode, if valid. Raises ArgumentError for an unknown one."""
    if mode is not None and mode not in RENDER_MODES:
        raise ArgumentError(f"render_mode '{mode}': one of {', '.join(RENDER_MODES)}")
    return mode
