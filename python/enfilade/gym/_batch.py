"""Shared by the single and the vector environment: n agents, their observations and spaces."""

from __future__ import annotations

from collections.abc import Sequence
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
from enfilade.gym._config import EXPERTS, EnvConfig, Transition

RENDER_MODES = ["rgb_array", "ansi"]
PI = np.float32(np.pi)  # above pi, as a rounded angle may be
MOST_METRES = 1000  # the spaces' bound of distances and depths, larger than any building

# Tasks with an answer beside the trajectory: the metric that shows whether it is right.
ANSWERS = {"reverie": "rgs", "soon": "det_success", "r2r-back": "success"}

# Layer -> the renderer's name of it, type and largest value.
_LAYERS: dict[str, tuple[str, type[Any], float]] = {
    "depth": ("depth", np.float32, MOST_METRES),
    "class": ("classes", np.uint16, 2**16 - 1),
    "instance": ("instances", np.uint32, 2**32 - 1),
}


class Batch:
    """n agents in episodes of a benchmark. `arrays` has views of the core's memory by name."""

    def __init__(self, config: EnvConfig, n: int, *, reset_at_next_step: bool = False) -> None:
        self.config = config
        self.n = n
        self.dataset = Dataset(config.data)
        self.episodes: Episodes = self.dataset.episodes(config.split, config.task)
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
        self.arrays: dict[str, NDArray[Any]] = self.core.arrays()
        self._views = self._views_of(slice(None))
        self.vocabulary = Vocabulary.load(config.vocabulary) if config.vocabulary else None
        self._all_texts = self.episodes._core.texts
        self.texts = [""] * n
        self.answers: list[Any] = [None] * n
        self.tokens = np.zeros((n, config.tokens), np.int64)
        self._begun = False
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

    def _observation_space(self) -> spaces.Dict:
        config = self.config
        texts = self._all_texts
        rows = config.max_candidates
        space: dict[str, spaces.Space[Any]] = {
            "pose": spaces.Box(
                np.array([0, -PI / 2], np.float32), np.array([2 * PI, PI / 2], np.float32)
            ),
            "candidates": spaces.Box(
                np.tile(np.array([-PI, -PI, 0], np.float32), (rows, 1)),
                np.tile(np.array([PI, PI, MOST_METRES], np.float32), (rows, 1)),
            ),
            "candidate_mask": spaces.MultiBinary(rows),
        }
        if config.text:
            space["instruction"] = spaces.Text(
                max_length=max(1, *map(len, texts)),
                min_length=0,
                charset=frozenset("".join(texts)) or frozenset(" "),
            )
        if self.vocabulary is not None:
            space["tokens"] = spaces.Box(0, len(self.vocabulary) - 1, (config.tokens,), np.int64)
        if config.actions == "map":
            nodes = int(self.core.action_count)
            space["nodes"] = spaces.Box(-1, MOST_METRES, (nodes, 7), np.float32)
            space["node_mask"] = spaces.MultiBinary(nodes)
        shape = (config.height, config.width)
        for name in config.observe:
            if name == "rgb":
                space[name] = spaces.Box(0, 255, (*shape, 3), np.uint8)
            else:
                _, kind, high = _LAYERS[name]
                space[name] = spaces.Box(0, high, shape, kind)
        return spaces.Dict(space)

    # --- episodes ---------------------------------------------------------------------------------

    def seed(self, seeds: Sequence[Optional[int]]) -> None:
        """Seeds each agent's stream of episodes; None leaves it unchanged."""
        numbers = [None if seed is None else whole("seed", seed, 2**64 - 1) for seed in seeds]
        for agent, number in enumerate(numbers):
            if number is not None:
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
        """Steps all agents. Returns the rewards, (n,). Raises TypeError or ArgumentError for invalid
        actions; then no agent has moved."""
        actions = np.asarray(chosen)
        if actions.dtype.kind not in "iub":
            raise TypeError(f"actions of type {actions.dtype}: integers are wanted")
        if actions.shape != (self.n,):
            raise ArgumentError(f"actions: shape {actions.shape}, not ({self.n},)")
        actions = np.ascontiguousarray(actions, np.int64)
        if isinstance(self.config.reward, str):
            self.core.step(actions)
            rewards: NDArray[np.float64] = self.arrays["reward"].copy()
            if self.config.answer_reward:
                rewards += self.config.answer_reward * self.answered(self._stopped())
        else:
            before = self.arrays["distance"].copy()
            self.core.step(actions)
            rewards = np.asarray(self.config.reward(self._transition(before)), np.float64)
            if rewards.shape != (self.n,):
                raise ValueError(f"reward: shape {rewards.shape}, not ({self.n},)")
            rewards = np.where(self.arrays["began"] == 1, 0.0, rewards)
        if self.arrays["began"].any():
            self.read_instructions()
        return rewards

    def _transition(self, before: NDArray[np.float64]) -> Transition:
        distance = self.arrays["distance"].copy()
        stopped = self._stopped()
        success = stopped & (self.arrays["success"] == 1)
        return Transition(before, distance, stopped, success, self.answered(stopped))

    def _stopped(self) -> NDArray[np.bool_]:
        stopped: NDArray[np.bool_] = self.arrays["terminated"].astype(bool)
        return stopped

    # --- answers ----------------------------------------------------------------------------------

    def answer(self, agent: int, answer: Any) -> None:
        """Stores an agent's answer in its episode; the last one counts. Raises ArgumentError for a task
        without answers, TypeError for an answer of the wrong type."""
        if not self._begun:
            raise ArgumentError("answer(): reset() has to come first")
        task = self.config.task
        if task not in ANSWERS:
            raise ArgumentError(f"answer(): {task} asks for a path alone")
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
        if not self._begun:
            raise ArgumentError("metrics(): reset() has to come first")
        place = int(self.arrays["episode"][agent])
        answers = [self.answers[agent]] if self.config.task in ANSWERS else None
        scored = self.episodes.score_paths([self.core.walked(agent)], places=[place], answers=answers)
        return {name: float(values[0]) for name, values in scored.items()}

    def expert(self, agent: int, rule: str) -> Optional[int]:
        """A teacher's action. Raises ArgumentError before reset(), or for an unknown rule."""
        if not self._begun:
            raise ArgumentError("expert(): reset() has to come first")
        if rule not in EXPERTS:
            raise ArgumentError(f"rule '{rule}': one of {', '.join(EXPERTS)} is wanted")
        action: Optional[int] = self.core.expert(whole("agent", agent, self.n - 1), rule)
        return action

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
            text = self._all_texts[self.arrays["episode"][agent]]
            self.texts[agent] = text
            self.answers[agent] = None
            if self.vocabulary is not None:
                self.tokens[agent] = self.vocabulary.encode(text, self.config.tokens)

    def chosen_episodes(self, options: Optional[dict[str, Any]]) -> Optional[NDArray[np.int64]]:
        """The episodes of reset(options={"episode": ...}): indices or instruction ids, one or n."""
        wanted = (options or {}).get("episode")
        if wanted is None:
            return None
        each = list(wanted) if isinstance(wanted, (list, tuple, np.ndarray)) else [wanted]
        if len(each) == 1:
            each = each * self.n
        return np.array([self._index_of(one) for one in each], np.int64)

    def _index_of(self, wanted: Any) -> int:
        if not isinstance(wanted, str):
            return whole("episode", wanted, len(self.episodes) - 1)
        place = self.episodes._core.find(wanted)
        if place is None:
            raise ArgumentError(f"episode '{wanted}' is not in the split {self.config.split}")
        return place

    # --- observations ------------------------------------------------------------------------------

    def observe(self) -> dict[str, Any]:
        """Copies by name, shape (n, ...), and a tuple of n texts."""
        return {**self._numbers(), **self.pictures(self.config.observe)}

    def observe_again(self, seen: dict[str, Any], agents: NDArray[np.intp]) -> None:
        """Updates an observation after a reset of only these agents; the others' images are not rendered
        again."""
        seen.update(self._numbers())
        for name, redrawn in self.pictures(self.config.observe, agents).items():
            seen[name][agents] = redrawn

    def _numbers(self) -> dict[str, Any]:
        pose = np.empty((self.n, 2), np.float32)
        pose[:, 0] = self.arrays["heading"]
        pose[:, 1] = self.arrays["elevation"]
        seen: dict[str, Any] = {
            "candidate_mask": self.arrays["candidate_mask"].copy(),
            "candidates": self.arrays["candidates"].copy(),
            "pose": pose,
        }
        if self.config.actions == "map":
            seen["nodes"] = self.arrays["nodes"].copy()
            seen["node_mask"] = self.arrays["node_mask"].copy()
        if self.config.text:
            seen["instruction"] = tuple(self.texts)
        if self.vocabulary is not None:
            seen["tokens"] = self.tokens.copy()
        return seen

    def pictures(
        self, names: Sequence[str], agents: Optional[NDArray[np.intp]] = None
    ) -> dict[str, NDArray[Any]]:
        """The current images of all agents, or of these, by name."""
        if not names:
            return {}
        drawn = self.renderer()._draw(
            self._views if agents is None else self._views_of(agents),
            width=self.config.width,
            height=self.config.height,
            vfov=self.config.vfov,
            colour="rgb8" if "rgb" in names else None,
            layers=tuple(_LAYERS[name][0] for name in names if name != "rgb"),
        )
        return {n: drawn["colour" if n == "rgb" else _LAYERS[n][0]] for n in names}

    def _views_of(self, agents: Any) -> ViewArrays:
        poses = ("scan", "viewpoint", "heading", "elevation")
        return ViewArrays(*(self.arrays[name][agents] for name in poses))

    def render(self, mode: Optional[str]) -> Optional[list[Any]]:
        """The result of a render mode for each agent; None for no mode."""
        if mode is None:
            return None
        if not self._begun:
            raise ArgumentError("render(): reset() has to come first")
        if mode == "rgb_array":
            return list(self.pictures(("rgb",))["rgb"])
        return [self._describe(agent) for agent in range(self.n)]

    def _describe(self, agent: int) -> str:
        """An agent's state as text: render_mode "ansi"."""
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
