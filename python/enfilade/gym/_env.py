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
    """RoomToRoom-v0, and the environments of other benchmarks (enfilade.gym.ENV_TASKS). Observations, a
    Dict:

    instruction: text, unless the config has text=False. pose: heading and elevation, radians. candidates: (m, 3) rel_heading,
    rel_elevation (radians from where the agent looks) and distance (metres); row 0 is where it
    stands. candidate_mask: (m,) 1 for rows in use. tokens: token ids, where the config names a
    vocabulary. rgb, depth, class, instance: where the config wants them. Of "map" actions also nodes:
    (actions, 7), where each lies, as DUET's position features have it (docs/agents.md), row 0 being [stop], and
    node_mask: (actions,) 1 where the agent can go.

    reset(options={"episode": e}) takes an index or instruction id instead of drawing one.
    info: instruction_id, scan, viewpoint, distance (metres to the goal); at an episode's end also
    success and spl, of the walk alone, and where the task asks for an answer, answered: whether it was
    right. metrics() has the others. Pickled or copied, it is a new one of the same config.
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
            if self._batch.config.task in ANSWERS:
                info["answered"] = bool(self._batch.answered(_ALONE)[0])
        return self._observation(), float(rewards[0]), terminated, truncated, info

    def answer(self, answer: Any) -> None:
        """What the agent answers in this episode; the last one before its end counts, None is no answer.
        REVERIE: the object's id; SOON: (heading, elevation) of the object from where the agent stops,
        radians, world frame; R2R-Back: the id of the viewpoint where it turned. Raises ArgumentError for
        a task that asks for none."""
        self._batch.answer(0, answer)

    def objects(self) -> list[SeenObject]:
        """What may be named here: the objects around the agent that a view shows (REVERIE)."""
        return self._batch.objects(0)

    def expert(self, rule: str = "spl") -> Optional[int]:
        """The action of a teacher, which knows the goal: a step on the shortest path to it, or stop; of
        "map" actions that of DUET's pseudo-expert, by its rule "spl" or "ndtw". None if the goal is
        hidden or out of reach."""
        return self._batch.expert(0, rule)

    def action_masks(self) -> NDArray[np.bool_]:
        """(actions,) bool: which actions do something, as sb3-contrib's MaskablePPO asks for them."""
        mask: NDArray[np.bool_] = self._batch.action_masks()[0]
        return mask

    @property
    def episodes(self) -> Episodes:
        """Of the split; `arrays["episode"]` says which one runs."""
        return self._batch.episodes

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """The state of the agent, by name, as in RoomToRoomVectorEnv.arrays with n = 1."""
        return self._batch.arrays

    def metrics(self) -> dict[str, float]:
        """All metrics of the path, and of the answer, in this episode so far (docs/tasks.md): of R2R ours,
        of other tasks those of the first of enfilade.scorers(task)."""
        return self._batch.metrics(0)

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
