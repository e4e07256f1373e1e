"""Room-to-Room as Gymnasium environments.

>>> import gymnasium, enfilade.gym
>>> env = gymnasium.make("RoomToRoom-v0", config=enfilade.gym.EnvConfig("data", "train"))
>>> envs = gymnasium.make_vec("RoomToRoom-v0", 256, config=enfilade.gym.EnvConfig("data", "train"))
"""

from __future__ import annotations

import gymnasium

from enfilade.gym._config import EnvConfig, Transition
from enfilade.gym._env import RoomToRoomEnv
from enfilade.gym._vector import RoomToRoomVectorEnv

__all__ = ["EnvConfig", "RoomToRoomEnv", "RoomToRoomVectorEnv", "Transition", "register"]

ENV_ID = "RoomToRoom-v0"


def register() -> None:
    """Registers RoomToRoom-v0 with Gymnasium; importing this module does so."""
    if ENV_ID not in gymnasium.registry:
        gymnasium.register(
            ENV_ID,
            entry_point="enfilade.gym:RoomToRoomEnv",
            vector_entry_point="enfilade.gym:RoomToRoomVectorEnv",
        )


register()
