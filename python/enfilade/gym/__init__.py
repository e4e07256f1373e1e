"""Every benchmark as a Gymnasium environment.

>>> import gymnasium, enfilade.gym
>>> env = gymnasium.make("enfilade/R2R-v0", data="homes", split="train")
>>> envs = gymnasium.make_vec("enfilade/R2R-v0", 256, data="homes", split="train")
>>> env = gymnasium.make("enfilade/R2R-CE-v0", data="homes", split="train")
>>> config = enfilade.gym.EnvConfig("homes", "train", observe=("rgb", "depth"))
>>> env = gymnasium.make("enfilade/REVERIE-v0", config=config)
"""

from __future__ import annotations

from typing import Any

import gymnasium

from enfilade._arguments import deprecated
from enfilade.gym._config import ContinuousEnvConfig, EnvConfig, Transition
from enfilade.gym._env import VlnEnv
from enfilade.gym._old import OLD_CLASSES, OLD_IDS
from enfilade.gym._vector import VlnVectorEnv

__all__ = [
    "ENV_TASKS",
    "ContinuousEnvConfig",
    "EnvConfig",
    "Transition",
    "VlnEnv",
    "VlnVectorEnv",
    "register",
]

ENV_TASKS = {
    "enfilade/R2R-v0": "r2r",
    "enfilade/R2R-Last-v0": "r2r-last",
    "enfilade/R2R-Back-v0": "r2r-back",
    "enfilade/R4R-v0": "r4r",
    "enfilade/RxR-v0": "rxr",
    "enfilade/REVERIE-v0": "reverie",
    "enfilade/CVDN-v0": "cvdn",
    "enfilade/SOON-v0": "soon",
    "enfilade/R2R-CE-v0": "r2r-ce",
    "enfilade/RxR-CE-v0": "rxr-ce",
}
"""The ids of environments, one per benchmark, and their tasks. Those of r2r-ce and rxr-ce are continuous."""


def register() -> None:
    """Registers the environments with Gymnasium; importing this module does so."""
    for name, task in ENV_TASKS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name,
                entry_point="enfilade.gym:VlnEnv",
                vector_entry_point="enfilade.gym:VlnVectorEnv",
                kwargs={"task": task},
            )
    for name, (old_task, _) in OLD_IDS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name,
                entry_point="enfilade.gym._old:OldEnv",
                vector_entry_point="enfilade.gym._old:OldVectorEnv",
                kwargs={"old": name, **({} if old_task is None else {"task": old_task})},
            )


register()


def __getattr__(name: str) -> Any:
    if name == "CONTINUOUS_ENV_TASKS":
        deprecated("enfilade.gym.CONTINUOUS_ENV_TASKS", "enfilade.gym.ENV_TASKS")
        return {name: task for name, task in ENV_TASKS.items() if task.endswith("-ce")}
    if name not in OLD_CLASSES:
        raise AttributeError(f"module 'enfilade.gym' has no attribute '{name}'")
    deprecated(f"enfilade.gym.{name}", f"enfilade.gym.{OLD_CLASSES[name].__name__}")
    return OLD_CLASSES[name]
