"""A drop-in for the module of Habitat-Sim: scenes, navigation, agents and cameras, on the CPU.

Names of physics, objects and audio can be imported, inherited and annotated with; using one raises
NotImplementedError. Differences: docs/python_habitat_sim.md.
"""

from __future__ import annotations

from habitat_sim import (
    agent,
    bindings,
    errors,
    geo,
    gfx,
    logging,
    metadata,
    nav,
    physics,
    scene,
    sensor,
    sensors,
    sim,
    simulator,
    utils,
)
from habitat_sim.agent import *  # noqa: F403
from habitat_sim.bindings import audio_enabled, built_with_bullet, cuda_enabled
from habitat_sim.gfx import ReplayRenderer, ReplayRendererConfiguration
from habitat_sim.metadata import MetadataMediator
from habitat_sim.nav import *  # noqa: F403
from habitat_sim.physics import RigidState
from habitat_sim.registry import registry
from habitat_sim.scene import *  # noqa: F403
from habitat_sim.sensor import *  # noqa: F403
from habitat_sim.sim import *  # noqa: F403
from habitat_sim.simulator import Configuration, Simulator

__version__ = "0.3.3"
stage_id = 0

__all__ = [
    *agent.__all__, *nav.__all__, *scene.__all__, *sensor.__all__, *sim.__all__, "Configuration",
    "MetadataMediator", "ReplayRenderer", "ReplayRendererConfiguration", "RigidState", "Simulator", "agent",
    "audio_enabled", "bindings", "built_with_bullet", "cuda_enabled", "errors", "geo", "gfx", "logging", "metadata", "nav", "physics", "registry", "scene",
    "sensor", "sensors", "sim", "simulator", "stage_id", "utils",
]  # fmt: skip
