"""The simulator: a scene with agents."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field
from typing import Any, Dict, Iterable, Mapping, Optional, Union

from enfilade._eyes import habitat as native
from magnum import Vector3
from numpy import ndarray

from habitat_sim._fields import whole
from habitat_sim._missing import NotThere
from habitat_sim.agent import Agent, AgentConfiguration, AgentState
from habitat_sim.geo import UP
from habitat_sim.logging import LoggingContext, logger
from habitat_sim.metadata import MetadataMediator
from habitat_sim.nav import GreedyGeodesicFollower
from habitat_sim.scene import SceneNode
from habitat_sim.sensor import Sensor, SensorFactory, SensorSpec, SensorType
from habitat_sim.sim import SimulatorBackend, SimulatorConfiguration
from habitat_sim.utils.common import quat_from_angle_axis

__all__ = [
    "Agent", "AgentConfiguration", "AgentState", "Configuration", "GreedyGeodesicFollower", "LoggingContext",
    "MetadataMediator", "ObservationDict", "Sensor", "SensorFactory", "SensorSpec", "SensorType", "Simulator",
    "SimulatorBackend", "SimulatorConfiguration", "Vector3", "logger", "quat_from_angle_axis",
]  # fmt: skip

ObservationDict = Dict[str, Union[bool, ndarray, Any]]


@dataclass
class Configuration:
    """A scene, and its agents."""

    sim_cfg: SimulatorConfiguration
    agents: list[AgentConfiguration] = field(default_factory=list)
    metadata_mediator: Any = None
    enable_batch_renderer: bool = False


class Simulator(SimulatorBackend):
    """A scene with agents, which see and move.

    Each agent begins at a random point of the floor, with a random turn, by `random_seed`; without a
    navigation mesh at the origin. One thread at a time.

    Raises FileNotFoundError for a scene that is not there, NotImplementedError for what Enfilade does not
    have.
    """

    def __init__(self, config: Configuration) -> None:
        _check(config)
        self.agents: list[Agent] = []
        self.__random = random.Random()
        super().__init__(config.sim_cfg)
        self.__begin(config)

    def reconfigure(self, config: Configuration) -> None:
        """Takes another configuration; an equal one changes nothing."""
        _check(config)
        if self.agents and config == self.config:
            return
        self._open_scene(config.sim_cfg)
        self.__begin(config)

    def __begin(self, config: Configuration) -> None:
        self.config = config
        self.seed(config.sim_cfg.random_seed)
        self.agents = [Agent(SceneNode(), one, self._ground) for one in config.agents]
        for index in range(len(self.agents)):
            self.initialize_agent(index)

    def close(self, destroy: bool = True) -> None:
        """Drops the agents, and with `destroy` the scene. reconfigure() brings them back."""
        self.agents = []
        if destroy:
            self._close_scene()

    def __enter__(self) -> Simulator:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close(destroy=True)

    def seed(self, new_seed: int) -> None:
        """Seeds the C library's generator, which random points come from, and that of turns."""
        native.seed(whole("new_seed", new_seed) % 2**32)
        self.__random.seed(new_seed)

    def get_agent(self, agent_id: int) -> Agent:
        """An agent by its number."""
        if not 0 <= agent_id < len(self.agents):
            raise IndexError(f"agent_id {agent_id}: the simulator has {len(self.agents)} agents")
        return self.agents[agent_id]

    def __agent(self, agent_id: Optional[int]) -> Agent:
        return self.get_agent(self.config.sim_cfg.default_agent_id if agent_id is None else agent_id)

    def initialize_agent(self, agent_id: int, initial_state: Optional[AgentState] = None) -> Agent:
        """Puts an agent at its first state, to which reset() goes back; None: a random one."""
        agent = self.get_agent(agent_id)
        if initial_state is None:
            initial_state = AgentState()
            if self.pathfinder.is_loaded:
                place = self.pathfinder.get_random_navigable_point()
                if math.isfinite(place.x):
                    initial_state.position = place
                angle = self.__random.uniform(0, 2 * math.pi)
                initial_state.rotation = quat_from_angle_axis(angle, UP)
        agent.set_state(initial_state, is_initial=True)
        return agent

    def reset_agent(self, agent_id: int) -> None:
        """Puts an agent back to its first state."""
        agent = self.get_agent(agent_id)
        agent.set_state(agent.initial_state, is_initial=True)

    def reset(self, agent_ids: Union[None, int, list[int]] = None) -> Any:
        """Puts all agents back to their first states. Returns get_sensor_observations(agent_ids)."""
        for index in range(len(self.agents)):
            self.reset_agent(index)
        return self.get_sensor_observations(agent_ids)

    def get_sensor_observations(self, agent_ids: Union[None, int, Iterable[int]] = None) -> Any:
        """What an agent's sensors see, by name; for several agents, by number. None: the default agent.

        Colour is uint8 (h, w, 4), depth float32 (h, w) in metres, semantic uint32 (h, w).
        """
        if agent_ids is None or isinstance(agent_ids, int):
            return self._drawer().draw(self.__agent(agent_ids).sensors.values())
        return {
            index: self._drawer().draw(self.get_agent(index).sensors.values()) for index in agent_ids
        }

    def step(self, action: Any, dt: float = 1.0 / 60.0) -> Any:
        """Does an action of the default agent, or a dictionary of actions by agent. Returns what is seen then,
        and "collided": whether a wall stopped the body."""
        if not isinstance(action, Mapping):
            agent = self.__agent(None)
            collided = agent.act(action)
            return {**self.get_sensor_observations(), "collided": collided}
        stopped = {index: self.get_agent(index).act(one) for index, one in action.items()}
        seen = self.get_sensor_observations(list(stopped))
        return {index: {**seen[index], "collided": stopped[index]} for index in stopped}

    def last_state(self, agent_id: Optional[int] = None) -> AgentState:
        """The state of an agent; None: the default one."""
        return self.__agent(agent_id).get_state()

    def make_greedy_follower(
        self, agent_id: Optional[int] = None, goal_radius: Optional[float] = None, **options: Any
    ) -> GreedyGeodesicFollower:
        """A follower for an agent; options are those of GreedyGeodesicFollower."""
        return GreedyGeodesicFollower(self.pathfinder, self.__agent(agent_id), goal_radius, **options)

    @property
    def sensors(self) -> dict[str, Sensor]:
        """The sensors of the default agent, by name."""
        return self.__agent(None).sensors

    def add_sensor(self, sensor_spec: SensorSpec, agent_id: Optional[int] = None) -> None:
        """Adds a sensor to an agent; None: the default one."""
        self.__agent(agent_id)._add_sensor(sensor_spec)


def _check(config: Configuration) -> None:
    if not isinstance(config, Configuration):
        raise TypeError(f"config {config!r}: a habitat_sim.Configuration is wanted")
    if config.enable_batch_renderer:
        raise NotThere("enable_batch_renderer: Enfilade has no batch renderer; use False")
    if not 0 <= config.sim_cfg.default_agent_id < len(config.agents):
        raise ValueError(
            f"default_agent_id {config.sim_cfg.default_agent_id}: the configuration has "
            f"{len(config.agents)} agents"
        )
