"""Sensors: their specifications, and where they are."""

from __future__ import annotations

from typing import Any, Callable, Optional

import magnum as mn

from habitat_sim._fields import (
    Code,
    Field,
    Structure,
    boolean,
    colour,
    degrees,
    maybe,
    number,
    one_of,
    size,
    table,
    text,
    vector2,
    vector3,
    whole,
)
from habitat_sim._missing import AUDIO, NotThere, refused
from habitat_sim.scene import SceneNode, SceneNodeType

__all__ = [
    "AudioSensor", "AudioSensorSpec", "CameraSensor", "CameraSensorSpec", "CubeMapSensorBase",
    "CubeMapSensorBaseSpec", "EquirectangularSensor", "EquirectangularSensorSpec", "FisheyeSensor",
    "FisheyeSensorDoubleSphereSpec", "FisheyeSensorModelType", "FisheyeSensorSpec", "Observation",
    "RLRAudioPropagationChannelLayout", "RLRAudioPropagationChannelLayoutType",
    "RLRAudioPropagationConfiguration", "Sensor", "SensorFactory", "SensorSpec", "SensorSubType", "SensorType",
    "VisualSensor", "VisualSensorSpec",
]  # fmt: skip


class SensorType(Code):
    """What a sensor measures."""

    NONE = 0
    CUSTOM = 1
    COLOR = 2
    DEPTH = 3
    SEMANTIC = 5
    AUDIO = 6


class SensorSubType(Code):
    """How a sensor sees."""

    NONE = 0
    CUSTOM = 1
    PINHOLE = 2
    ORTHOGRAPHIC = 3
    FISHEYE = 4
    EQUIRECTANGULAR = 5
    IMPULSERESPONSE = 6


class FisheyeSensorModelType(Code):
    """Models of fisheye lenses."""

    DOUBLE_SPHERE = 0


class SemanticSensorTarget(Code):
    """What a semantic sensor measures."""

    SEMANTIC_ID = 0


class SensorSpec(Structure):
    """A sensor: its name, what it measures, and where it is on the body.

    habitat-lab 0.1.7 makes all cameras by SensorSpec(): `parameters` then has "hfov", "near" and "far" as text.
    """

    uuid = Field(text, "")
    sensor_type = Field(one_of(SensorType), SensorType.NONE)
    sensor_subtype = Field(one_of(SensorSubType), SensorSubType.NONE)
    position = Field(vector3, [0.0, 1.5, 0.0])
    orientation = Field(vector3, [0.0, 0.0, 0.0])
    noise_model = Field(text, "None")
    noise_model_kwargs = Field(table, {})
    resolution = Field(size, [128, 128])
    gpu2gpu_transfer = Field(boolean, False)
    parameters = Field(table, {})

    def is_visual_sensor_spec(self) -> bool:
        """Whether the sensor sees."""
        return isinstance(self, VisualSensorSpec)


class VisualSensorSpec(SensorSpec):
    """A sensor that sees. `resolution` is height and width; near and far are in metres."""

    sensor_type = Field(one_of(SensorType), SensorType.COLOR)
    channels = Field(whole, 4)
    clear_color = Field(colour, [0.0, 0.0, 0.0, 1.0])
    near = Field(number, 0.01)
    far = Field(number, 1000.0)
    semantic_target = Field(one_of(SemanticSensorTarget), SemanticSensorTarget.SEMANTIC_ID)


class CameraSensorSpec(VisualSensorSpec):
    """A camera. `hfov` is its horizontal field of view: a Deg, or a number of degrees."""

    uuid = Field(text, "rgba_camera")
    sensor_subtype = Field(one_of(SensorSubType), SensorSubType.PINHOLE)
    hfov = Field(degrees, 90.0)
    ortho_scale = Field(number, 0.1)


class CubeMapSensorBaseSpec(VisualSensorSpec):
    """A sensor whose pictures are looked up in a cube map."""

    cubemap_size = Field(maybe(whole), None)


class EquirectangularSensorSpec(CubeMapSensorBaseSpec):
    """A camera that sees all around."""

    uuid = Field(text, "equirectangular")
    sensor_subtype = Field(one_of(SensorSubType), SensorSubType.EQUIRECTANGULAR)


class FisheyeSensorSpec(CubeMapSensorBaseSpec):
    """A fisheye camera. Lengths are in pixels."""

    uuid = Field(text, "fisheye")
    sensor_subtype = Field(one_of(SensorSubType), SensorSubType.FISHEYE)
    sensor_model_type = Field(one_of(FisheyeSensorModelType), FisheyeSensorModelType.DOUBLE_SPHERE)
    focal_length = Field(vector2, [0.0, 0.0])
    principal_point_offset = Field(maybe(vector2), None)


class FisheyeSensorDoubleSphereSpec(FisheyeSensorSpec):
    """A fisheye camera of two spheres."""

    alpha = Field(number, 0.59)
    xi = Field(number, -0.18)


class Sensor:
    """A sensor of an agent: its specification, and its pose on the body (`node`)."""

    def __init__(self, spec: SensorSpec, body: Optional[SceneNode]) -> None:
        self._spec = spec
        self.node = SceneNode(body, SceneNodeType.SENSOR)
        self._noise: Optional[Callable[[Any], Any]] = None
        self.set_transformation_from_spec()

    def specification(self) -> SensorSpec:
        """The specification."""
        return self._spec

    @property
    def uuid(self) -> str:
        """The name."""
        return self._spec.uuid

    def set_transformation_from_spec(self) -> None:
        """Goes back to where the specification has it: turned about the body's x, then y, then z."""
        x, y, z = self._spec.orientation
        turn = mn.Quaternion()
        for angle, axis in (
            (x, mn.Vector3.x_axis()),
            (y, mn.Vector3.y_axis()),
            (z, mn.Vector3.z_axis()),
        ):
            if angle != 0:
                turn = mn.Quaternion.rotation(mn.Rad(angle), axis) * turn
        self.node.translation = self._spec.position
        self.node.rotation = turn


class VisualSensor(Sensor):
    """A sensor that sees."""


class CameraSensor(VisualSensor):
    """A camera."""


class CubeMapSensorBase(VisualSensor):
    """A sensor whose pictures are looked up in a cube map."""


class EquirectangularSensor(CubeMapSensorBase):
    """A camera that sees all around."""


class FisheyeSensor(CubeMapSensorBase):
    """A fisheye camera."""


_SENSORS = (
    (EquirectangularSensorSpec, EquirectangularSensor),
    (FisheyeSensorSpec, FisheyeSensor),
    (CameraSensorSpec, CameraSensor),
)


def _camera(old: SensorSpec) -> CameraSensorSpec:
    """The camera that habitat-lab 0.1.7 means."""
    spec = CameraSensorSpec()
    for name in SensorSpec._names():
        if name != "sensor_subtype":
            setattr(spec, name, getattr(old, name))
    for name in ("hfov", "near", "far"):
        if name in old.parameters:
            setattr(spec, name, float(old.parameters[name]))
    return spec


def make_sensor(spec: SensorSpec, body: SceneNode) -> Sensor:
    """The sensor of a specification, on a body. Raises NotImplementedError for what Enfilade does not have."""
    if not isinstance(spec, SensorSpec):
        raise TypeError(f"sensor_specifications: {spec!r} is not a SensorSpec")
    if type(spec) is SensorSpec:
        spec = _camera(spec)
    for kind, sensor in _SENSORS:
        if isinstance(spec, kind):
            if spec.gpu2gpu_transfer:
                raise NotThere(
                    f"gpu2gpu_transfer of '{spec.uuid}': pictures are numpy arrays here; use False"
                )
            return sensor(spec, body)
    raise NotThere(f"sensor '{spec.uuid}': Enfilade has no {type(spec).__name__}; use CameraSensorSpec")


_draw = "Enfilade makes the sensors of AgentConfiguration.sensor_specifications; add them there"

AudioSensor = refused("habitat_sim.sensor.AudioSensor", AUDIO)
AudioSensorSpec = refused("habitat_sim.sensor.AudioSensorSpec", AUDIO)
Observation = refused("habitat_sim.sensor.Observation", "use Simulator.get_sensor_observations()")
RLRAudioPropagationChannelLayout = refused("habitat_sim.sensor.RLRAudioPropagationChannelLayout", AUDIO)
RLRAudioPropagationChannelLayoutType = refused(
    "habitat_sim.sensor.RLRAudioPropagationChannelLayoutType", AUDIO
)
RLRAudioPropagationConfiguration = refused("habitat_sim.sensor.RLRAudioPropagationConfiguration", AUDIO)
SensorFactory = refused("habitat_sim.sensor.SensorFactory", _draw)
