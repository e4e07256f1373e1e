"""Agents: their poses, sensors and actions."""

from __future__ import annotations

from habitat_sim.agent import agent as agent
from habitat_sim.agent import controls as controls
from habitat_sim.agent.agent import Agent, AgentConfiguration, AgentState, SixDOFPose
from habitat_sim.agent.controls import (
    ActionSpec,
    ActuationSpec,
    ObjectControls,
    PyRobotNoisyActuationSpec,
    SceneNodeControl,
)

__all__ = [
    "ActionSpec", "ActuationSpec", "Agent", "AgentConfiguration", "AgentState", "ObjectControls",
    "PyRobotNoisyActuationSpec", "SceneNodeControl", "SixDOFPose",
]  # fmt: skip
