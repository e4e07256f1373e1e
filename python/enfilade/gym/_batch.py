"""Shared by both worlds: n agents, their episodes, observations and rewards."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from enfilade._arguments import whole
from enfilade._continuous import ContinuousEpisodes
from enfilade._episodes import Episodes
from enfilade._errors import ArgumentError
from enfilade._layers import layer_of
from enfilade.gym._config import Transition

RENDER_MODES = ["rgb_array", "ansi"]
PI = np.float32(np.pi)  # above pi, as a rounded angle may be

# The type of a layer's values, and their largest value, None: `most_metres`.
_VALUES: dict[str, tuple[Any, Optional[int]]] = {
    "rgb": (np.uint8, 255),
    "depth": (np.float32, None),
    "semantic": (np.uint16, 2**16 - 1),
    "instance": (np.uint32, 2**32 - 1),
}


class Batch:
    """n agents in episodes of a benchmark. `arrays` has views of the core's memory by name."""

    most_metres: int  # the spaces' bound of distances, coordinates and depths
    frames_per_second: int  # of videos of an episode
    config: Any
    episodes: Union[Episodes, ContinuousEpisodes]
    core: Any
    arrays: dict[str, NDArray[Any]]
    single_observation_space: spaces.Dict
    single_action_space: spaces.Discrete

    def __init__(self, config: Any, n: int) -> None:
        self.config = config
        self.n = n
        self._begun = False

    def _check_begun(self, call: str) -> None:
        if not self._begun:
            raise ArgumentError(f"{call}(): reset() has to come first")

    # --- episodes ---------------------------------------------------------------------------------

    def seed(self, seeds: Sequence[Optional[int]]) -> None:
        """Seeds each agent's stream of episodes; None leaves it unchanged."""
        numbers = [None if seed is None else whole("seed", seed, 2**64 - 1) for seed in seeds]
        for agent, number in enumerate(numbers):
            if number is not None:
                self._seed_agent(agent, number)

    def _seed_agent(self, agent: int, number: int) -> None:
        raise NotImplementedError

    def chosen_episodes(self, options: Optional[dict[str, Any]]) -> Optional[NDArray[np.int64]]:
        """The episodes of reset(options={"episode": ...}): indices or ids, one or n."""
        wanted = (options or {}).get("episode")
        if wanted is None:
            return None
        each = list(wanted) if isinstance(wanted, (list, tuple, np.ndarray)) else [wanted]
        if len(each) == 1:
            each = each * self.n
        if len(each) != self.n:
            raise ArgumentError(f"options['episode']: {len(each)} elements for {self.n} agents")
        return np.array([self._index_of(one) for one in each], np.int64)

    def _index_of(self, wanted: Any) -> int:
        if not isinstance(wanted, str):
            return whole("episode", wanted, len(self.episodes) - 1)
        place = self.episodes._core.find(wanted)
        if place is None:
            raise ArgumentError(f"episode '{wanted}' is not in the split {self.config.split}")
        return place

    def reset(
        self,
        mask: Optional[NDArray[np.bool_]] = None,
        chosen: Optional[NDArray[np.int64]] = None,
    ) -> None:
        """Begins episodes of all agents or those of a mask: `chosen` ones, or drawn."""
        raise NotImplementedError

    # --- steps ------------------------------------------------------------------------------------

    def step(self, chosen: ArrayLike) -> NDArray[np.float64]:
        """Steps all agents. Returns the rewards, (n,). Raises TypeError or ArgumentError for invalid
        actions; then no agent has moved."""
        raise NotImplementedError

    def _checked_actions(self, chosen: ArrayLike) -> NDArray[Any]:
        actions = np.asarray(chosen)
        if actions.dtype.kind not in "iub":
            raise TypeError(f"actions of type {actions.dtype}: integers are wanted")
        if actions.shape != (self.n,):
            raise ArgumentError(f"actions: shape {actions.shape}, not ({self.n},)")
        return actions

    def _own_rewards(self, transition: Transition) -> NDArray[np.float64]:
        """The rewards of the config's function."""
        rewards: NDArray[np.float64] = np.array(self.config.reward(transition), np.float64)
        if rewards.shape != (self.n,):
            raise ValueError(f"reward: shape {rewards.shape}, not ({self.n},)")
        return rewards

    def terminated(self) -> NDArray[np.bool_]:
        """(n,) episodes that ended by the action stop."""
        raise NotImplementedError

    def truncated(self) -> NDArray[np.bool_]:
        """(n,) episodes that ended after max_steps actions."""
        raise NotImplementedError

    # --- info -------------------------------------------------------------------------------------

    def info(self) -> dict[str, Any]:
        """The info of the first agent."""
        raise NotImplementedError

    def final_info(self, ended: NDArray[np.bool_]) -> dict[str, NDArray[Any]]:
        """The metrics at an episode's end: (n,) by name, each with its mask `_name`."""
        raise NotImplementedError

    def metrics(self, agent: int) -> dict[str, float]:
        """The metrics of an agent's trajectory so far."""
        raise NotImplementedError

    def expert(self, agent: int, rule: Optional[str]) -> Optional[int]:
        """A teacher's action; rule None: the default. Raises ArgumentError for an unknown rule."""
        raise NotImplementedError

    def answer(self, agent: int, answer: Any) -> None:
        """Stores an agent's answer in its episode. Raises ArgumentError for a task without answers."""
        raise ArgumentError(f"answer(): {self.config.task} asks for a path alone")

    def objects(self, agent: int) -> list[Any]:
        """The objects that an agent may name."""
        raise ArgumentError(f"objects(): {self.config.task} names no objects")

    def action_masks(self) -> NDArray[np.bool_]:
        """(n, actions): which actions have an effect."""
        return np.ones((self.n, int(self.single_action_space.n)), bool)

    # --- observations -----------------------------------------------------------------------------

    def _spaces(self) -> dict[str, spaces.Space[Any]]:
        """The spaces that both worlds have: pose, instruction and images."""
        config, texts = self.config, self.episodes._core.texts
        space: dict[str, spaces.Space[Any]] = {
            "pose": spaces.Box(
                np.array([0, -PI / 2], np.float32), np.array([2 * PI, PI / 2], np.float32)
            )
        }
        self._texts = texts
        if config.text:
            space["instruction"] = spaces.Text(
                max_length=max(1, *map(len, texts)),
                min_length=0,
                charset=frozenset("".join(texts)) or frozenset(" "),
            )
        for word in config.observe:
            layer = layer_of(word)
            kind, most = _VALUES[layer]
            width, height = self._size(layer)
            shape = (height, width, 3) if layer == "rgb" else (height, width)
            space[word] = spaces.Box(0, self.most_metres if most is None else most, shape, kind)
        return space

    def _size(self, layer: str) -> tuple[int, int]:
        """Width and height of a layer, pixels."""
        raise NotImplementedError

    def observe(self) -> dict[str, Any]:
        """Copies by name, shape (n, ...), and a tuple of n texts."""
        return {**self._seen(), **self.pictures(self.config.observe)}

    def observe_again(self, seen: dict[str, Any], agents: NDArray[np.intp]) -> None:
        """Updates an observation after a reset of only these agents; the others' images are not rendered
        again."""
        seen.update(self._seen())
        for name, redrawn in self.pictures(self.config.observe, agents).items():
            seen[name][agents] = redrawn

    def _seen(self) -> dict[str, Any]:
        pose = np.empty((self.n, 2), np.float32)
        pose[:, 0] = self.arrays["heading"]
        pose[:, 1] = self.arrays["elevation"]
        seen: dict[str, Any] = {"pose": pose, **self._numbers()}
        if self.config.text:
            seen["instruction"] = self._instructions()
        return seen

    def _instructions(self) -> tuple[str, ...]:
        return tuple(self._texts[episode] for episode in self.arrays["episode"])

    def _numbers(self) -> dict[str, Any]:
        """Copies of the world's own observations by name."""
        raise NotImplementedError

    def pictures(
        self, words: Sequence[str], agents: Optional[NDArray[np.intp]] = None
    ) -> dict[str, NDArray[Any]]:
        """The current images of all agents, or of these, by the words of the config."""
        if not words:
            return {}
        drawn = self._draw(tuple(layer_of(word) for word in words), agents)
        return {word: drawn[layer_of(word)] for word in words}

    def _draw(
        self, layers: tuple[str, ...], agents: Optional[NDArray[np.intp]]
    ) -> dict[str, NDArray[Any]]:
        raise NotImplementedError

    # --- render modes -----------------------------------------------------------------------------

    def render_modes(self) -> list[str]:
        """Those of RENDER_MODES for which the data folder has the images."""
        return RENDER_MODES

    def checked_mode(self, mode: Optional[str]) -> Optional[str]:
        """The mode, if valid. Raises ArgumentError for an unknown one, or one without images."""
        if mode is None:
            return None
        if mode not in RENDER_MODES:
            raise ArgumentError(f"render_mode '{mode}': one of {', '.join(RENDER_MODES)}")
        if mode not in self.render_modes():
            raise ArgumentError(
                f"render_mode '{mode}': {self.config.data} has no pictures of {self.episodes[0].scan}"
            )
        return mode

    def metadata(self) -> dict[str, Any]:
        """Gymnasium's metadata of an environment of these agents."""
        return {"render_modes": self.render_modes(), "render_fps": self.frames_per_second}

    def render(self, mode: Optional[str]) -> Optional[list[Any]]:
        """The result of a render mode for each agent; None for no mode."""
        if mode is None:
            return None
        self._check_begun("render")
        if mode == "rgb_array":
            return list(self.pictures(("rgb",))["rgb"])
        return [self._describe(agent) for agent in range(self.n)]

    def _describe(self, agent: int) -> str:
        """An agent's state as text: render_mode "ansi"."""
        raise NotImplementedError
