"""The configurations of environments: plain data, so that they can be pickled to workers."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field, replace
from typing import Any, Callable, Optional, Union

import numpy as np
from numpy.typing import NDArray

from enfilade._arguments import whole
from enfilade._continuous import TASKS
from enfilade._errors import ArgumentError
from enfilade._layers import checked_layer
from enfilade._renderer import CACHES

ACTIONS = ("viewpoint", "six", "panoramic", "map")
EXPERTS = ("spl", "ndtw")
REWARDS = ("progress", "success", "none")


@dataclass(frozen=True)
class Transition:
    """One step of n agents, for a reward function."""

    distance_before: NDArray[np.float64]  #: (n,) metres along the graph to the goal, before the step
    distance: NDArray[np.float64]  #: (n,) metres, after the step
    stopped: NDArray[np.bool_]  #: (n,) by the action stop
    success: NDArray[np.bool_]  #: (n,) stopped at the goal
    answered: NDArray[np.bool_]  #: (n,) stopped with a right answer, in tasks with answers


@dataclass(frozen=True)
class EnvConfig:
    """Episodes, observations, actions and reward of an environment.

    Args:
        data: folder of graphs and annotations, and of images if `observe` names any; None: the one that the
            environment variable ENFILADE_DATA names.
        split: "train", "val_seen", "val_unseen", ...
        task: the benchmark: "r2r", "r4r", "rxr", "reverie", "cvdn", "soon", ...; environment ids with a
            benchmark's name set it.
        actions: "viewpoint": 0 stops, k moves to candidate k and faces along the edge. "six": left,
            right, up, down (30 degrees), forward, stop. "panoramic": 0 stops, k moves to candidate k of
            all neighbours and faces as that of the 36 views which shows it. "map": 0 stops, k moves to
            node k of the map, if unvisited. An invalid action does not move the agent.
        reward: "progress" (metres nearer to the goal, 2 for a successful stop, -2 for another),
            "success" (1 for a successful stop), "none", or a function of a Transition that returns (n,)
            numbers. To pickle the config, the function has to be importable by its name.
        max_steps: actions after which an episode is truncated.
        answer_reward: added to a named reward for a stop with a right answer (answer()), in tasks with
            answers; a function has Transition.answered instead.
        success_distance: metres along the graph, for goals that a distance decides.
        text: whether observations have the instruction's text; some libraries do not support it.
        observe: any of "rgb", "depth", "semantic", "instance".
        width, height, vfov: of the camera, pixels and radians. They also determine the neighbours that
            "six" can reach.
        vocabulary: file of words (R2R's train_vocab.txt), for token ids; None: no tokens.
        tokens: length of the row of ids.
        max_candidates: rows of the candidates, the current viewpoint included.
        backend: the renderer's: "cpu", "cpu-scalar", "gl" or "cuda".
        cache: the renderer's: "private", or "shared" by the environments of all processes.
        seed: of the order of episodes, until reset(seed=...).
    """

    data: Union[None, str, os.PathLike[str]] = None
    split: str = "train"
    actions: str = "viewpoint"
    reward: Union[str, Callable[[Transition], NDArray[np.float64]]] = "progress"
    max_steps: int = 40
    success_distance: float = 3.0
    observe: tuple[str, ...] = ()
    width: int = 640
    height: int = 480
    vfov: float = math.radians(60)
    vocabulary: Union[None, str, os.PathLike[str]] = None
    tokens: int = 80
    max_candidates: int = 16
    backend: str = "cpu"
    cache: str = "private"
    seed: int = 1
    task: str = "r2r"
    answer_reward: float = 0.0
    text: bool = True

    def __post_init__(self) -> None:
        if self.task in TASKS:
            raise ArgumentError(f"task '{self.task}' is continuous: a ContinuousEnvConfig is wanted")
        if self.actions not in ACTIONS:
            raise ArgumentError(f"actions '{self.actions}': one of {', '.join(ACTIONS)} is wanted")
        _check_shared(self)
        if self.cache not in CACHES:
            raise ArgumentError(f"cache '{self.cache}': one of {', '.join(CACHES)} is wanted")
        for name in ("max_steps", "width", "height", "tokens", "max_candidates"):
            whole(name, getattr(self, name))
        if self.tokens < 1:
            raise ArgumentError(f"tokens {self.tokens}: at least 1 is wanted")


@dataclass(frozen=True)
class ContinuousEnvConfig:
    """Episodes, observations and reward of a continuous environment.

    Args:
        data: folder of the data set, with navigation meshes and episodes (`enfilade continuous`); None: the
            one that the environment variable ENFILADE_DATA names.
        split: "train", "val_seen", "val_unseen", ...
        task: "r2r-ce": 4 actions; "rxr-ce": 6 actions. Environment ids with a task's name set it.
        reward: "progress" (metres nearer to the goal by the shortest path, 2 for a stop within 3 m, -2 for
            another), "success" (1 for a stop within 3 m), "none", or a function of a Transition that
            returns (n,) numbers. To pickle the config, the function has to be importable by its name.
        max_steps: actions after which an episode is truncated.
        text: whether observations have the instruction's text; some libraries do not support it.
        simulator: options of ContinuousSimulator that differ from the task's: {"slide": False}.
        seed: of the order of episodes, until reset(seed=...).
        observe: images, any of "rgb", "depth" (metres), "semantic", "instance" (enfilade.eyes).
        sizes: (width, height) of images by name; default: VLN-CE's.
        vfov: vertical field of view of images, radians.
        eyes: options of enfilade.eyes.Eyes: {"meshes": "glb"}; without "meshes" the data are synthetic homes.
    """

    data: Union[None, str, os.PathLike[str]] = None
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
        _check_shared(self)
        if whole("max_steps", self.max_steps) < 1:
            raise ArgumentError("max_steps 0: at least 1 is wanted")


AnyConfig = Union[EnvConfig, ContinuousEnvConfig]


def config_of(config: Optional[AnyConfig], task: Optional[str], options: dict[str, Any]) -> AnyConfig:
    """A config with these options; None: a new one, of the task's world."""
    if task is not None:
        options = {"task": task, **options}
    if config is not None:
        return replace(config, **options) if options else config
    return ContinuousEnvConfig(**options) if task in TASKS else EnvConfig(**options)


def _check_shared(config: AnyConfig) -> None:
    """The checks of fields that both configs have."""
    if not callable(config.reward) and config.reward not in REWARDS:
        raise ArgumentError(
            f"reward {config.reward!r}: one of {', '.join(REWARDS)} or a function is wanted"
        )
    if isinstance(config.observe, str):
        raise ArgumentError(f"observe '{config.observe}': a tuple is wanted: ('{config.observe}',)")
    for word in config.observe:
        checked_layer("observe", word)
    whole("seed", config.seed, 2**64 - 1)
