"""One agent in Room-to-Room."""

from __future__ import annotations

from typing import Any, Optional, Union

import gymnasium
import numpy as np
from gymnasium.utils import EzPickle
from numpy.typing import NDArray

from enfilade._episodes import Episodes
from enfilade._errors import ArgumentError
from enfilade.gym._batch import RENDER_MODES, Batch
from enfilade.gym._config import EnvConfig

Observation = dict[str, Any]


class RoomToRoomEnv(gymnasium.Env[Observation, Any], EzPickle):
    """RoomToRoom-v0. Observations, a Dict:

    instruction: text. pose: heading and elevation, radians. candidates: (m, 3) rel_heading,
    rel_elevation (radians from where the agent looks) and distance (metres); row 0 is where it
    stands. candidate_mask: (m,) 1 for rows in use. tokens: token ids, where the config names a
    vocabulary. rgb, depth, class, instance: where the config wants them.

    reset(options={"episode": e}) takes an index or instruction id instead of drawing one.
    info: instruction_id, scan, viewpoint, distance (metres to the goal); at an episode's end also
    success and spl. metrics() has the others. Pickled or copied, it is a new one of the same config.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 2}

    def __init__(self, config: EnvConfig, render_mode: Optional[str] = None) -> None:
        EzPickle.__init__(self, config, render_mode)
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise ArgumentError(f"render_mode '{render_mode}': one of {', '.join(RENDER_MODES)}")
        self._batch = Batch(config, 1)
        self._seeded = False
        self.render_mode = render_mode
        self.observation_space = self._batch.single_observation_space
        self.action_space = self._batch.single_action_space

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode: one drawn by the seed's stream, or options["episode"], an index or an
        instruction's id."""
        chosen = self._batch.chosen_episodes(options)
        self._batch.seed([seed])
        super().reset(seed=seed)
        self._batch.reset(chosen=chosen)
        return self._observation(), self._info()

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One action; at the episode's end `info` has "success" and "spl"."""
        rewards = self._batch.step([action])
        terminated = bool(self._batch.arrays["terminated"][0])
        truncated = bool(self._batch.arrays["truncated"][0])
        info = self._info()
        if terminated or truncated:
            info.update({name: float(self._batch.arrays[name][0]) for name in ("success", "spl")})
        return self._observation(), float(rewards[0]), terminated, truncated, info

    @property
    def episodes(self) -> Episodes:
        """Of the split; `arrays["episode"]` says which one runs."""
        return self._batch.episodes

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """The state of the agent, by name, as in RoomToRoomVectorEnv.arrays with n = 1."""
        return self._batch.arrays

    def metrics(self) -> dict[str, float]:
        """All metrics of the path in this episode so far (docs/tasks.md)."""
        return self._batch.core.metrics(0)

    def render(self) -> Union[None, NDArray[np.uint8], str]:
        """rgb_array: (height, width, 3) uint8, what the agent sees. ansi: where it is, in words."""
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
