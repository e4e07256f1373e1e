"""Agents on navigation graphs."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from enfilade._arguments import whole
from enfilade._core import BatchEnvironment, ViewArrays, Vocabulary
from enfilade._dataset import Dataset, SeenObject
from enfilade._episodes import Episodes
from enfilade._errors import ArgumentError
from enfilade._renderer import Renderer
from enfilade.gym._batch import PI, RENDER_MODES, Batch
from enfilade.gym._config import EXPERTS, EnvConfig, Transition

# Tasks with an answer beside the trajectory: the metric that shows whether it is right.
ANSWERS = {"reverie": "rgs", "soon": "det_success", "r2r-back": "success"}


class GraphBatch(Batch):
    """n agents in episodes of a benchmark on graphs."""

    most_metres = 1000
    frames_per_second = 2
    config: EnvConfig
    episodes: Episodes
    core: BatchEnvironment

    def __init__(self, config: EnvConfig, n: int, *, reset_at_next_step: bool = False) -> None:
        super().__init__(config, n)
        self.dataset = Dataset(config.data)
        self.episodes = self.dataset.episodes(config.split, config.task)
        reward = config.reward if isinstance(config.reward, str) else "none"
        self.core = BatchEnvironment(
            self.episodes._core,
            batch_size=whole("num_envs", n),
            actions=config.actions,
            reward=reward,
            max_steps=config.max_steps,
            success_distance=config.success_distance,
            reset_at_next_step=reset_at_next_step,
            seed=config.seed,
            width=config.width,
            height=config.height,
            vfov=config.vfov,
            max_navigable=config.max_candidates,
        )
        self.arrays = self.core.arrays()
        self._views = self._views_of(slice(None))
        self.vocabulary = Vocabulary.load(config.vocabulary) if config.vocabulary else None
        self._current = [""] * n  # the texts of the current episodes
        self.answers: list[Any] = [None] * n
        self.tokens = np.zeros((n, config.tokens), np.int64)
        self._renderer: Optional[Renderer] = None
        if config.observe:
            self.renderer()
        self.single_observation_space = self._observation_space()
        self.single_action_space = spaces.Discrete(int(self.core.action_count))

    def renderer(self) -> Renderer:
        """The renderer, made at first use: graphs alone need no images."""
        if self._renderer is None:
            self._renderer = self.dataset.renderer(backend=self.config.backend, cache=self.config.cache)
        return self._renderer

    def render_modes(self) -> list[str]:
        """Those of RENDER_MODES for which the data folder has the images."""
        drawn = bool(self.config.observe) or self.episodes[0].scan in self.dataset.panoramas
        return RENDER_MODES if drawn else [mode for mode in RENDER_MODES if mode != "rgb_array"]

    def _observation_space(self) -> spaces.Dict:
        config = self.config
        rows = config.max_candidates
        space = self._spaces()
        space["candidates"] = spaces.Box(
            np.tile(np.array([-PI, -PI, 0], np.float32), (rows, 1)),
            np.tile(np.array([PI, PI, self.most_metres], np.float32), (rows, 1)),
        )
        space["candidate_mask"] = spaces.MultiBinary(rows)
        if self.vocabulary is not None:
            space["tokens"] = spaces.Box(0, len(self.vocabulary) - 1, (config.tokens,), np.int64)
        if config.actions == "map":
            nodes = int(self.core.action_count)
            space["nodes"] = spaces.Box(-1, self.most_metres, (nodes, 7), np.float32)
            space["node_mask"] = spaces.MultiBinary(nodes)
        return spaces.Dict(space)

    def _size(self, layer: str) -> tuple[int, int]:
        return self.config.width, self.config.height

    # --- episodes ---------------------------------------------------------------------------------

    def _seed_agent(self, agent: int, number: int) -> None:
        self.core.seed(agent, number)

    def reset(
        self,
        mask: Optional[NDArray[np.bool_]] = None,
        chosen: Optional[NDArray[np.int64]] = None,
    ) -> None:
        flags = None if mask is None else np.ascontiguousarray(mask, np.uint8)
        self.core.reset(flags, chosen)
        self._begun = True
        self.read_instructions()

    def step(self, chosen: ArrayLike) -> NDArray[np.float64]:
        actions = np.ascontiguousarray(self._checked_actions(chosen), np.int64)
        if isinstance(self.config.reward, str):
            self.core.step(actions)
            rewards: NDArray[np.float64] = self.arrays["reward"].copy()
            if self.config.answer_reward:
                rewards += self.config.answer_reward * self.answered(self.terminated())
        else:
            before = self.arrays["distance"].copy()
            self.core.step(actions)
            rewards = self._own_rewards(self._transition(before))
            rewards[self.arrays["began"] == 1] = 0.0
        if self.arrays["began"].any():
            self.read_instructions()
        return rewards

    def _transition(self, before: NDArray[np.float64]) -> Transition:
        distance = self.arrays["distance"].copy()
        stopped = self.terminated()
        success = stopped & (self.arrays["success"] == 1)
        return Transition(before, distance, stopped, success, self.answered(stopped))

    def terminated(self) -> NDArray[np.bool_]:
        flags: NDArray[np.bool_] = self.arrays["terminated"].astype(bool)
        return flags

    def truncated(self) -> NDArray[np.bool_]:
        flags: NDArray[np.bool_] = self.arrays["truncated"].astype(bool)
        return flags

    def info(self) -> dict[str, Any]:
        episode = self.episodes[int(self.arrays["episode"][0])]
        graph = self.episodes.graphs[episode.scan]
        return {
            "instruction_id": episode.instruction_id,
            "scan": episode.scan,
            "viewpoint": graph.viewpoints[int(self.arrays["viewpoint"][0])],
            "distance": float(self.arrays["distance"][0]),
        }

    def final_info(self, ended: NDArray[np.bool_]) -> dict[str, NDArray[Any]]:
        final = {name: np.where(ended, self.arrays[name], 0.0) for name in ("success", "spl")}
        if self.config.task in ANSWERS:
            final["answered"] = self.answered(ended)
        return {**final, **{f"_{name}": ended.copy() for name in final}}

    # --- answers ----------------------------------------------------------------------------------

    def answer(self, agent: int, answer: Any) -> None:
        """Stores an agent's answer in its episode; the last one counts. Raises ArgumentError for a task
        without answers, TypeError for an answer of the wrong type."""
        self._check_begun("answer")
        task = self.config.task
        if task not in ANSWERS:
            super().answer(agent, answer)
        if answer is not None and task == "soon":
            heading, elevation = (float(angle) for angle in answer)
            answer = (heading / (2 * np.pi) % 1, (elevation + np.pi) / (2 * np.pi))
        elif answer is not None and task == "reverie":
            answer = whole("object", answer) if not isinstance(answer, str) else answer
        elif answer is not None and not isinstance(answer, str):
            raise TypeError(f"answer {answer!r}: a viewpoint's id is wanted")
        self.answers[whole("agent", agent, self.n - 1)] = answer

    def answered(self, agents: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(n,) which of `agents` have given a right answer; none if the goal is hidden."""
        right = np.zeros(self.n, bool)
        if self.config.task in ANSWERS:
            for agent in np.flatnonzero(agents):
                hidden = np.isnan(self.arrays["success"][agent])
                if self.answers[agent] is not None and not hidden:
                    right[agent] = self.metrics(int(agent))[ANSWERS[self.config.task]] > 0
        return right

    def metrics(self, agent: int) -> dict[str, float]:
        """Metrics of an agent's trajectory and answer so far: ours for R2R, those of the task's first
        scorer for others. Raises ArgumentError before reset()."""
        if self.config.task == "r2r":
            return self.core.metrics(agent)
        self._check_begun("metrics")
        place = int(self.arrays["episode"][agent])
        answers = [self.answers[agent]] if self.config.task in ANSWERS else None
        scored = self.episodes.score_paths([self.core.walked(agent)], places=[place], answers=answers)
        return {name: float(values[0]) for name, values in scored.items()}

    def expert(self, agent: int, rule: Optional[str]) -> Optional[int]:
        """A teacher's action. Raises ArgumentError before reset(), or for an unknown rule."""
        self._check_begun("expert")
        rule = EXPERTS[0] if rule is None else rule
        if rule not in EXPERTS:
            raise ArgumentError(f"rule '{rule}': one of {', '.join(EXPERTS)} is wanted")
        return self.core.expert(whole("agent", agent, self.n - 1), rule)

    def objects(self, agent: int) -> list[SeenObject]:
        """The objects that an agent may name: those that a view of its viewpoint shows (REVERIE)."""
        scan = self.episodes.graphs.scans[int(self.arrays["scan"][agent])]
        viewpoint = self.episodes.graphs[scan].viewpoints[int(self.arrays["viewpoint"][agent])]
        return [one for one in self.dataset.objects(scan, viewpoint) if one.views]

    def action_masks(self) -> NDArray[np.bool_]:
        """(n, actions): which actions have an effect. The others do not move an agent."""
        if self.config.actions == "map":
            open_nodes: NDArray[np.bool_] = self.arrays["node_mask"].astype(bool)
            open_nodes[:, 0] = True
            return open_nodes
        there: NDArray[np.bool_] = self.arrays["candidate_mask"].astype(bool)
        if self.config.actions != "six":
            there[:, 0] = True  # stop
            return there
        possible = np.ones((self.n, 6), bool)
        elevation = self.arrays["elevation"]
        possible[:, 2] = elevation < 0.25  # elevations are -30 to 30 degrees
        possible[:, 3] = elevation > -0.25
        possible[:, 4] = there[:, 1:].any(axis=1)
        return possible

    def read_instructions(self) -> None:
        for agent in np.flatnonzero(self.arrays["began"]):
            text = self._texts[self.arrays["episode"][agent]]
            self._current[agent] = text
            self.answers[agent] = None
            if self.vocabulary is not None:
                self.tokens[agent] = self.vocabulary.encode(text, self.config.tokens)

    # --- observations -----------------------------------------------------------------------------

    def _instructions(self) -> tuple[str, ...]:
        return tuple(self._current)

    def _numbers(self) -> dict[str, Any]:
        names = ["candidate_mask", "candidates"]
        if self.config.actions == "map":
            names += ["nodes", "node_mask"]
        seen = {name: self.arrays[name].copy() for name in names}
        if self.vocabulary is not None:
            seen["tokens"] = self.tokens.copy()
        return seen

    def _draw(
        self, layers: tuple[str, ...], agents: Optional[NDArray[np.intp]]
    ) -> dict[str, NDArray[Any]]:
        config = self.config
        return self.renderer()._draw(
            self._views if agents is None else self._views_of(agents),
            config.width,
            config.height,
            config.vfov,
            rgb="rgb8" if "rgb" in layers else None,
            layers=layers,
        )

    def _views_of(self, agents: Any) -> ViewArrays:
        poses = ("scan", "viewpoint", "heading", "elevation")
        return ViewArrays(*(self.arrays[name][agents] for name in poses))

    def _describe(self, agent: int) -> str:
        episode = self.episodes[int(self.arrays["episode"][agent])]
        graph = self.episodes.graphs[episode.scan]
        ids = graph.viewpoints
        lines = [
            f"{episode.instruction_id} in {episode.scan}: {episode.text.strip()}",
            f"step {self.arrays['step'][agent]} at {ids[self.arrays['viewpoint'][agent]]}, heading "
            f"{np.degrees(self.arrays['heading'][agent]):.0f}, "
            f"{self.arrays['distance'][agent]:.1f} m from the goal",
        ]
        for k in np.flatnonzero(self.arrays["candidate_mask"][agent]):
            right, up, metres = self.arrays["candidates"][agent, k]
            name = ids[self.arrays["candidate_viewpoint"][agent, k]]
            lines.append(
                f"  {k}: {name}  {np.degrees(right):+.0f} right {np.degrees(up):+.0f} up {metres:.1f} m"
            )
        return "\n".join(lines) + "\n"
