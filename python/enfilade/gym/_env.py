"""One agent in episodes of a benchmark."""

from __future__ import annotations

from typing import Any, Dict, Optional, Union

import gymnasium
import numpy as np
from gymnasium.utils import EzPickle
from numpy.typing import NDArray

from enfilade._continuous import ContinuousEpisodes
from enfilade._dataset import SeenObject
from enfilade._episodes import Episodes
from enfilade.gym._batch import RENDER_MODES, Batch
from enfilade.gym._config import AnyConfig, ContinuousEnvConfig, config_of
from enfilade.gym._continuous import ContinuousBatch
from enfilade.gym._graph import GraphBatch

Observation = Dict[str, Any]
_ALONE = np.ones(1, bool)


def batch_of(config: AnyConfig, n: int, *, reset_at_next_step: bool = False) -> Batch:
    """n agents in the world of a config's task."""
    if isinstance(config, ContinuousEnvConfig):
        return ContinuousBatch(config, n, reset_at_next_step=reset_at_next_step)
    return GraphBatch(config, n, reset_at_next_step=reset_at_next_step)


class VlnEnv(gymnasium.Env[Observation, Any], EzPickle):
    """The environment of every benchmark (enfilade.gym.ENV_TASKS), on graphs or continuous.

    >>> env = gymnasium.make("enfilade/R2R-v0", data="homes", split="train")

    Args:
        config: EnvConfig, or ContinuousEnvConfig for r2r-ce and rxr-ce. None: made of `options`.
        render_mode: "rgb_array" or "ansi".
        task: overrides the config's.
        options: fields of the config: data, split, observe, ...

    Observations:
        - instruction: text, unless the config has text=False.
        - pose: (2,) heading and elevation, radians. Continuous: of the camera, heading clockwise from +y.
        - rgb, depth, semantic, instance: those of the config's `observe`.
        - Those of the task's world, below.

    Graphs:
        - candidates: (m, 3) rel_heading, rel_elevation (radians from the agent's view) and distance
          (metres); row 0 is the current viewpoint.
        - candidate_mask: (m,) 1 for rows in use.
        - tokens: token ids, if the config names a vocabulary.
        - nodes: "map" actions only, (actions, 7), positions as in DUET's features (docs/agents.md); row 0
          is [stop].
        - node_mask: "map" actions only, (actions,) 1 for nodes that the agent can go to.

    Continuous:
        - position: (3,) the feet, metres, world frame (z up).
        - collided: (1,) whether a wall shortened the last step.

    Continuous actions: 0 stop, 1 forward, 2 left, 3 right; RxR-CE also 4 look up, 5 look down. Actions on
    graphs: EnvConfig.actions.

    Info:
        - scan; on graphs instruction_id and viewpoint; continuous: episode_id.
        - distance: metres to the goal, continuous by the shortest path; NaN if the goal is hidden.
        - success, spl: at an episode's end, of the trajectory alone. metrics() has the others. Continuous:
          all of VLN-CE's measures, unless the goal is hidden.
        - answered: at an episode's end, in tasks with answers: whether the answer is right.

    A pickled or copied environment has the same config.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 2}

    def __init__(
        self,
        config: Optional[AnyConfig] = None,
        render_mode: Optional[str] = None,
        *,
        task: Optional[str] = None,
        **options: Any,
    ) -> None:
        EzPickle.__init__(self, config, render_mode, task=task, **options)
        self._batch = batch_of(config_of(config, task, options), 1)
        self.render_mode = self._batch.checked_mode(render_mode)
        self.metadata = self._batch.metadata()
        self.observation_space = self._batch.single_observation_space
        self.action_space = self._batch.single_action_space

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode: drawn from the seed's stream, or options["episode"], an index, or an
        instruction id or episode id."""
        chosen = self._batch.chosen_episodes(options)
        self._batch.seed([seed])
        super().reset(seed=seed)
        self._batch.reset(chosen=chosen)
        return self._observation(), self._batch.info()

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Executes an action; at the episode's end `info` has the metrics."""
        batch = self._batch
        rewards = batch.step([action])
        terminated, truncated = bool(batch.terminated()[0]), bool(batch.truncated()[0])
        info = batch.info()
        if terminated or truncated:
            final = batch.final_info(_ALONE)
            info.update({name: final[name][0].item() for name in final if not name.startswith("_")})
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

    def expert(self, rule: Optional[str] = None) -> Optional[int]:
        """A teacher's action; None if the goal is hidden or out of reach.

        Args:
            rule: on graphs "spl", the default: the next step on the shortest path to the goal, or stop.
                With "map" actions it is DUET's pseudo-expert's, by its rule "spl" or "ndtw". Continuous:
                "reference", the default: along the reference path, by the rule of VLN-CE's experts;
                "shortest": along the shortest path to the goal.
        """
        return self._batch.expert(0, rule)

    def action_masks(self) -> NDArray[np.bool_]:
        """(actions,) bool: which actions have an effect, for sb3-contrib's MaskablePPO."""
        mask: NDArray[np.bool_] = self._batch.action_masks()[0]
        return mask

    @property
    def episodes(self) -> Union[Episodes, ContinuousEpisodes]:
        """The episodes of the split; `arrays["episode"]` is the index of the current one."""
        return self._batch.episodes

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """The agent's state, by name, as in VlnVectorEnv.arrays with n = 1."""
        return self._batch.arrays

    def metrics(self) -> dict[str, float]:
        """All metrics of the trajectory and the answer so far (docs/tasks.md). On graphs: ours for R2R,
        those of the first of enfilade.scorers(task) for others. Continuous: VLN-CE's measures; raises
        ArgumentError for a hidden goal."""
        return self._batch.metrics(0)

    def render(self) -> Union[None, NDArray[np.uint8], str]:
        """rgb_array: (height, width, 3) uint8, the agent's view. ansi: its state as text."""
        seen = self._batch.render(self.render_mode)
        return None if seen is None else seen[0]

    def _observation(self) -> Observation:
        return {name: value[0] for name, value in self._batch.observe().items()}
