"""Actions: what they are called, and how far they move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from habitat_sim._missing import refused

__all__ = [
    "ActionSpec",
    "ActuationSpec",
    "ObjectControls",
    "PyRobotNoisyActuationSpec",
    "SceneNodeControl",
]


@dataclass
class ActuationSpec:
    """How far an action moves: `amount` in metres or degrees. A `constraint` is refused when it is acted."""

    amount: float
    constraint: Optional[float] = None


@dataclass
class ActionSpec:
    """An action: the name of its motion, as move_forward or turn_left, and how far it moves."""

    name: str
    actuation: Optional[ActuationSpec] = None


_noise = "Enfilade has no noisy actions; use ActuationSpec"
_own = "Enfilade has no actions of one's own; move agents by Agent.set_state()"

PyRobotNoisyActuationSpec = refused("habitat_sim.agent.PyRobotNoisyActuationSpec", _noise)
ObjectControls = refused("habitat_sim.agent.ObjectControls", _own)
SceneNodeControl = refused("habitat_sim.agent.SceneNodeControl", _own)
