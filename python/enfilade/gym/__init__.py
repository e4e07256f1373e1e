"""Room-to-Room and later benchmarks as Gymnasium environments.

>>> import gymnasium, enfilade.gym
>>> env = gymnasium.make("RoomToRoom-v0", config=enfilade.gym.EnvConfig("data", "train"))
>>> envs = gymnasium.make_vec("RoomToRoom-v0", 256, config=enfilade.gym.EnvConfig("data", "train"))
>>> walk = enfilade.gym.ContinuousEnvConfig("data", "train")
>>> env = gymnasium.make("Enfilade/ContinuousRoomToRoom-v0", config=walk)
>>> env = gymnasium.make("enfilade/REVERIE-v0", config=enfilade.gym.EnvConfig("data", "train"))
"""

from __future__ import annotations

import gymnasium

from enfilade.gym._config import EnvConfig, Transition
from enfilade.gym._continuous import ContinuousEnvConfig
from enfilade.gym._continuous_env import ContinuousRoomToRoomEnv, ContinuousRoomToRoomVectorEnv
from enfilade.gym._env import RoomToRoomEnv
from enfilade.gym._vector import RoomToRoomVectorEnv

__all__ = [
    "CONTINUOUS_ENV_TASKS",
    "ENV_TASKS",
    "ContinuousEnvConfig",
    "ContinuousRoomToRoomEnv",
    "ContinuousRoomToRoomVectorEnv",
    "EnvConfig",
    "RoomToRoomEnv",
    "RoomToRoomVectorEnv",
    "Transition",
    "register",
]

ENV_ID = "RoomToRoom-v0"

ENV_TASKS = {
    ENV_ID: None,
    "enfilade/R2R-v0": "r2r",
    "enfilade/R2RLast-v0": "r2r-last",
    "enfilade/R2RBack-v0": "r2r-back",
    "enfilade/R4R-v0": "r4r",
    "enfilade/RxR-v0": "rxr",
    "enfilade/REVERIE-v0": "reverie",
    "enfilade/CVDN-v0": "cvdn",
    "enfilade/SOON-v0": "soon",
}
"""The ids of environments, and the task that each sets; None: the config's."""

CONTINUOUS_ENV_TASKS = {
    "Enfilade/ContinuousRoomToRoom-v0": "r2r-ce",
    "Enfilade/ContinuousRoomAcrossRoom-v0": "rxr-ce",
}
"""The same for continuous environments; they take a ContinuousEnvConfig."""


def register() -> None:
    """Registers the environments with Gymnasium; importing this module does so."""
    for name, task in ENV_TASKS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name,
                entry_point="enfilade.gym:RoomToRoomEnv",
                vector_entry_point="enfilade.gym:RoomToRoomVectorEnv",
                kwargs={} if task is None else {"task": task},
            )
    for name, task in CONTINUOUS_ENV_TASKS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name,
                entry_point="enfilade.gym:ContinuousRoomToRoomEnv",
                vector_entry_point="enfilade.gym:ContinuousRoomToRoomVectorEnv",
                kwargs={"task": task},
            )


register()
