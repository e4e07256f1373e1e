"""The configuration of an environment: plain data, so that it can be pickled to workers."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Callable, Union

import numpy as np
from numpy.typing import NDArray

from enfilade._arguments import whole
from enfilade._errors import ArgumentError
from enfilade._renderer import CACHES

ACTIONS = ("viewpoint", "six", "panoramic", "map")
EXPERTS = ("spl", "ndtw")
REWARDS = ("progress", "success", "none")
LAYERS = ("rgb", "depth", "class", "instance")


@dataclass(frozen=True)
class Transition:
    """One step of n agents, for a reward function."""

    distance_before: NDArray[np.float64]  #: (n,) to the goal along the graph, metres
    distance: NDArray[np.float64]  #: (n,) after the step
    stopped: NDArray[np.bool_]  #: (n,)
    success: NDArray[np.bool_]  #: (n,) stopped where the goal is reached
    answered: NDArray[np.bool_]  #: (n,) stopped with a right answer, where the task asks for one


@dataclass(frozen=True)
class EnvConfig:
    """Episodes, observations, actions and reward of an environment.

    Args:
        data: folder of graphs and annotations, and of pictures where `observe` wants some.
        split: "train", "val_seen", "val_unseen", ...
        task: the benchmark: "r2r", "r4r", "rxr", "reverie", "cvdn", "soon", ...; environments whose ids
            name a benchmark set it.
        actions: "viewpoint": 0 stops, k walks to candidate k and looks along the way; "six": left,
            right, up, down (30 degrees), forward, stop; "panoramic": 0 stops, k walks to candidate k
            of all neighbours and looks as the one of 36 views that has it; "map": 0 stops, k walks
            to node k of what the agent has seen so far, unless it was there before. An action that
            is not possible leaves the agent where it is.
        reward: "progress" (metres nearer to the goal, 2 for a successful stop, -2 for another),
            "success" (1 for a successful stop), "none", or a function of a Transition that gives (n,) numbers; it has
            to be importable by its name for the config to be pickled.
        max_steps: actions after which an episode is truncated.
        answer_reward: added to a reward that has a name, for a stop with a right answer (answer()), where
            the task asks for one; a function finds Transition.answered instead.
        success_distance: metres along the graph, of goals that a distance decides.
        text: whether observations have the instruction's text, which not every library takes.
        observe: any of "rgb", "depth", "class", "instance".
        width, height, vfov: of the camera, pixels and radians. They also decide what "six" can
            reach.
        vocabulary: file of words (R2R's train_vocab.txt), for token ids; None: no tokens.
        tokens: length of the row of ids.
        max_candidates: rows of the candidates, the present viewpoint included.
        backend: of the renderer: "cpu", "cpu-scalar", "gl" or "cuda".
        cache: of the renderer: "private", or "shared" by the environments of all processes.
        seed: of the episodes, until reset(seed=...) gives another.
    """

    data: Union[str, os.PathLike[str]]
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
        if self.actions not in ACTIONS:
            raise ArgumentError(f"actions '{self.actions}': one of {', '.join(ACTIONS)} is wanted")
        if not callable(self.reward) and self.reward not in REWARDS:
            raise ArgumentError(
                f"reward {self.reward!r}: one of {', '.join(REWARDS)} or a function is wanted"
            )
        if isinstance(self.observe, str):
            raise ArgumentError(f"observe '{self.observe}': a tuple is wanted: ('{self.observe}',)")
        for layer in self.observe:
            if layer not in LAYERS:
                raise ArgumentError(f"observe '{layer}': any of {', '.join(LAYERS)} are wanted")
        if self.cache not in CACHES:
            raise ArgumentError(f"cache '{self.cache}': one of {', '.join(CACHES)} is wanted")
        for name in ("max_steps", "width", "height", "tokens", "max_candidates"):
            whole(name, getattr(self, name))
        if self.tokens < 1:
            raise ArgumentError(f"tokens {self.tokens}: at least 1 is wanted")
        whole("seed", self.seed, 2**64 - 1)
