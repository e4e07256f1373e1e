"""Agents."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np
from enfilade._eyes import habitat as native

from habitat_sim._draw import check
from habitat_sim._fields import finite, numbers
from habitat_sim._missing import NotThere
from habitat_sim._rotations import IDENTITY, Xyzw, to_quaternion, to_xyzw
from habitat_sim.agent.controls import ActionSpec, ActuationSpec
from habitat_sim.scene import SceneNode, SceneNodeType
from habitat_sim.sensor import Sensor, SensorSpec, make_sensor
from habitat_sim.sensors.noise_models import noise_of
from habitat_sim.utils.common import quat_rotate_vector, quat_to_coeffs

__all__ = ["Agent", "AgentConfiguration", "AgentState", "SixDOFPose"]


def _default_actions() -> dict[Any, ActionSpec]:
    return {
        "move_forward": ActionSpec("move_forward", ActuationSpec(0.25)),
        "turn_left": ActionSpec("turn_left", ActuationSpec(10.0)),
        "turn_right": ActionSpec("turn_right", ActuationSpec(10.0)),
    }


def _origin() -> Any:
    return np.zeros(3)


def _no_turn() -> Any:
    return to_quaternion(IDENTITY)


@dataclass(eq=False)
class SixDOFPose:
    """A place, metres, and a direction, in the world."""

    position: Any = field(default_factory=_origin)
    rotation: Any = field(default_factory=_no_turn)


@dataclass(eq=False)
class AgentState:
    """An agent's place and direction, and those of its sensors by name, in the world.

    `position` and `rotation` (a numpy-quaternion) may also be set to lists; x, y, z, w then.
    """

    position: Any = field(default_factory=_origin)
    rotation: Any = field(default_factory=_no_turn)
    sensor_states: dict[str, SixDOFPose] = field(default_factory=dict)


@dataclass
class AgentConfiguration:
    """An agent: its size in metres, its sensors and its actions by key.

    The numbers from `mass` on are for physics. habitat-lab 0.1.7 sets them; they are kept as they are given, and
    nothing uses them.
    """

    height: float = 1.5
    radius: float = 0.1
    sensor_specifications: list[SensorSpec] = field(default_factory=list)
    action_space: dict[Any, ActionSpec] = field(default_factory=_default_actions)
    body_type: str = "cylinder"
    mass: float = 32.0
    linear_acceleration: float = 20.0
    angular_acceleration: float = 4 * math.pi
    linear_friction: float = 0.5
    angular_friction: float = 1.0
    coefficient_of_restitution: float = 0.0


class Ground:
    """Where agents may go: the floor of a simulator's pathfinder."""

    def __init__(self, pathfinder: Any = None, slide: bool = True) -> None:
        self.pathfinder, self.slide = pathfinder, slide

    @property
    def floor(self) -> Optional[native.Floor]:
        """None: everywhere."""
        return None if self.pathfinder is None else self.pathfinder._floor


class Agent:
    """A body with sensors. It stands where set_state() puts it, on the floor or off it.

    Its first action that moves the body, a turn too, puts it onto the floor.
    """

    def __init__(
        self,
        scene_node: SceneNode,
        agent_config: Optional[AgentConfiguration] = None,
        ground: Optional[Ground] = None,
    ) -> None:
        scene_node.type = SceneNodeType.AGENT
        self._scene_node = scene_node
        self.agent_config = agent_config or AgentConfiguration()
        self.initial_state = AgentState()
        self._ground = ground or Ground()
        self._sensors: dict[str, Sensor] = {}
        self.reconfigure(self.agent_config)

    def reconfigure(self, agent_config: AgentConfiguration, reconfigure_sensors: bool = True) -> None:
        """Takes another configuration."""
        self.agent_config = agent_config
        if reconfigure_sensors:
            self._sensors = {}
            for spec in agent_config.sensor_specifications:
                self._add_sensor(spec)

    def _add_sensor(self, spec: SensorSpec) -> None:
        sensor = make_sensor(spec, self.scene_node)
        check(sensor.specification())
        sensor._noise = noise_of(sensor.specification())
        if sensor.uuid in self._sensors:
            raise ValueError(f"uuid '{sensor.uuid}': another sensor of the agent has this name")
        self._sensors[sensor.uuid] = sensor

    @property
    def scene_node(self) -> SceneNode:
        """The body's pose."""
        return self._scene_node

    @property
    def sensors(self) -> dict[str, Sensor]:
        """The sensors by name."""
        return self._sensors

    @property
    def _pose(self) -> tuple[tuple[float, float, float], Xyzw]:
        return self.scene_node._place, self.scene_node._turn

    def act(self, action_id: Any) -> bool:
        """Does an action of the action space. Returns whether a wall stopped the body.

        Raises ValueError for an action that the agent does not have.
        """
        space = self.agent_config.action_space
        if action_id not in space:
            raise ValueError(f"action {action_id!r}: one of {', '.join(map(repr, space))} is wanted")
        name, spec = space[action_id].name, space[action_id].actuation
        if spec is None:
            raise ValueError(f"action {action_id!r}: '{name}' has no actuation, so it moves nothing")
        if not isinstance(spec, ActuationSpec):
            raise TypeError(f"action {action_id!r}: its actuation {spec!r} is not an ActuationSpec")
        if spec.constraint is not None:
            raise NotThere(
                f"action {action_id!r}: Enfilade has no constraints of actions; leave it None"
            )
        if name.startswith("pyrobot_noisy_"):
            raise NotThere(f"action {action_id!r}: Enfilade has no noisy actions; use {name[14:]}")
        if native.moves_body(name):
            ground = self._ground
            node = self.scene_node
            node._place, node._turn, collided = native.act(
                *self._pose, name, spec.amount, ground.floor, ground.slide
            )
            return collided
        for sensor in self._sensors.values():
            node = sensor.node
            node._place, node._turn, _ = native.act(
                node._place, node._turn, name, spec.amount, None, True
            )
        return False

    def _find_action(self, name: str) -> tuple[Any, ActuationSpec]:
        """The first action with a motion: its key, and how far it moves."""
        for key, spec in self.agent_config.action_space.items():
            if spec.name == name and spec.actuation is not None:
                return key, spec.actuation
        raise ValueError(f"action_space: no action '{name}', which the follower needs")

    def get_state(self) -> AgentState:
        """Where the agent and its sensors are. Positions are float32."""
        poses = {uuid: SixDOFPose(*_world(sensor.node)) for uuid, sensor in self._sensors.items()}
        return AgentState(*_world(self.scene_node), poses)

    def set_state(
        self,
        state: AgentState,
        reset_sensors: bool = True,
        infer_sensor_states: bool = True,
        is_initial: bool = False,
    ) -> None:
        """Puts the agent somewhere, as it stands there: nothing is moved onto the floor.

        Args:
            state: `sensor_states` counts without `infer_sensor_states`.
            reset_sensors: puts sensors back to where their specifications have them.
            infer_sensor_states: sensors keep their places on the body.
            is_initial: Simulator.reset() goes back to this state.

        Raises ValueError for numbers that are not finite, and for rotations of a length other than 1.
        """
        place, turn = _place("position", state.position), to_xyzw("rotation", state.rotation)
        poses = {}
        if not infer_sensor_states:
            for uuid, pose in state.sensor_states.items():
                if uuid not in self._sensors:
                    raise ValueError(
                        f"sensor_states '{uuid}': one of {', '.join(self._sensors)} is wanted"
                    )
                at = _place(f"sensor_states['{uuid}'].position", pose.position)
                facing = to_xyzw(f"sensor_states['{uuid}'].rotation", pose.rotation)
                poses[uuid] = _relative(place, turn, at, facing)
        self.scene_node._place, self.scene_node._turn = place, turn
        if reset_sensors:
            for sensor in self._sensors.values():
                sensor.set_transformation_from_spec()
        for uuid, (at, facing) in poses.items():
            node = self._sensors[uuid].node
            node._place, node._turn = at, facing
        if is_initial:
            self.initial_state = self.get_state()

    @property
    def state(self) -> AgentState:
        """get_state()."""
        return self.get_state()

    @state.setter
    def state(self, new_state: AgentState) -> None:
        self.set_state(new_state)

    def close(self) -> None:
        """Drops the sensors."""
        self._sensors = {}


def _world(node: SceneNode) -> tuple[Any, Any]:
    place, turn = node._in_world()
    return np.array(place, np.float32), to_quaternion(turn)


def _place(name: str, value: Any) -> tuple[float, float, float]:
    given = numbers(name, value, 3)
    finite(name, given)
    x, y, z = given.astype(np.float32).tolist()
    return x, y, z


def _relative(
    place: tuple[float, float, float], turn: Xyzw, at: tuple[float, float, float], facing: Xyzw
) -> tuple[tuple[float, float, float], Xyzw]:
    """A pose in the world as seen from another."""
    back = to_quaternion(turn).inverse()
    moved = quat_rotate_vector(back, np.subtract(at, place))
    turned = quat_to_coeffs(back * to_quaternion(facing))
    x, y, z = moved.astype(np.float32).tolist()
    a, b, c, d = turned.astype(np.float32).tolist()
    return (x, y, z), (a, b, c, d)
