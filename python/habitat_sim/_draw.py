"""Pictures of scenes, drawn on the CPU."""

from __future__ import annotations

import math
from typing import Any, Iterable, NamedTuple, Optional

import numpy as np
from enfilade._eyes import habitat as native
from numpy.typing import NDArray

from habitat_sim._missing import NotThere
from habitat_sim._rotations import Xyzw
from habitat_sim._scene_files import SceneFile
from habitat_sim.sensor import (
    CameraSensorSpec,
    FisheyeSensorDoubleSphereSpec,
    Sensor,
    SensorSpec,
    SensorSubType,
    SensorType,
)


class _View(NamedTuple):
    """What several sensors may share."""

    place: tuple[float, float, float]
    turn: Xyzw
    lens: native.Lens


_LENSES = {
    SensorSubType.PINHOLE: CameraSensorSpec,
    SensorSubType.EQUIRECTANGULAR: SensorSpec,
    SensorSubType.FISHEYE: FisheyeSensorDoubleSphereSpec,
}
_MEASURED = (SensorType.COLOR, SensorType.DEPTH, SensorType.SEMANTIC)


def check(spec: SensorSpec) -> None:
    """Raises NotImplementedError for sensors that are not drawn, ValueError for lenses that cannot be."""
    if not isinstance(spec, _LENSES.get(spec.sensor_subtype, ())):
        raise NotThere(
            f"sensor_subtype of '{spec.uuid}': Enfilade has no {spec.sensor_subtype} as "
            f"{type(spec).__name__}; use PINHOLE as CameraSensorSpec"
        )
    if spec.sensor_type not in _MEASURED:
        raise NotThere(
            f"sensor_type of '{spec.uuid}': Enfilade has no {spec.sensor_type}; use COLOR or DEPTH"
        )
    black = CameraSensorSpec().clear_color
    if getattr(spec, "clear_color", black) != black:
        raise NotThere(f"clear_color of '{spec.uuid}': Enfilade has {black!r} only; leave it")
    try:
        _lens(spec)
    except ValueError as error:
        raise ValueError(f"sensor '{spec.uuid}': {error}") from None


def _lens(spec: Any) -> native.Lens:
    height, width = spec.resolution
    drawn = spec.near, spec.far
    if spec.sensor_subtype == SensorSubType.PINHOLE:
        return native.Lens.pinhole(width, height, math.radians(float(spec.hfov)), drawn)
    cube = spec.cubemap_size or 0
    if spec.sensor_subtype == SensorSubType.EQUIRECTANGULAR:
        return native.Lens.equirectangular(width, height, cube, drawn)
    middle = spec.principal_point_offset
    if middle is None:
        middle = (width / 2, height / 2)
    return native.Lens.fisheye(
        width, height, tuple(spec.focal_length), tuple(middle), spec.xi, spec.alpha, cube, drawn
    )


class Drawer:
    """Draws a scene; it is opened at the first picture. None: an empty scene."""

    def __init__(self, scene: Optional[SceneFile]) -> None:
        self._scene = scene
        self._open: Optional[native.Sensors] = None
        self._labels: Optional[native.Sensors] = None

    def draw(self, sensors: Iterable[Sensor]) -> dict[str, NDArray[Any]]:
        """Pictures by name: colour uint8 (h, w, 4), depth float32 (h, w), semantic uint32 (h, w)."""
        views: dict[_View, list[Sensor]] = {}
        for sensor in sensors:
            lens = _lens(sensor.specification())
            views.setdefault(_View(*sensor.node._in_world(), lens), []).append(sensor)
        seen: dict[str, NDArray[Any]] = {}
        for view, sharing in views.items():
            pictures = self._pictures(view, {one.specification().sensor_type for one in sharing})
            for sensor in sharing:  # each has a picture of its own
                picture = pictures[sensor.specification().sensor_type]
                if sensor._noise is not None:
                    picture = sensor._noise(picture)
                if id(picture) in map(id, seen.values()):
                    picture = picture.copy()
                seen[sensor.uuid] = picture
        return seen

    def _pictures(self, view: _View, kinds: set[SensorType]) -> dict[SensorType, NDArray[Any]]:
        shape = view.lens.height, view.lens.width
        made: dict[SensorType, NDArray[Any]] = {}
        if SensorType.SEMANTIC in kinds:
            made[SensorType.SEMANTIC] = self._semantic(view)
        if SensorType.COLOR in kinds:
            made[SensorType.COLOR] = np.empty((*shape, 4), np.uint8)
        if SensorType.DEPTH in kinds:
            made[SensorType.DEPTH] = np.empty(shape, np.float32)
        colour, depth = made.get(SensorType.COLOR), made.get(SensorType.DEPTH)
        if colour is None and depth is None:
            return made
        if self._scene is not None:
            if self._open is None:
                self._open = native.Sensors(self._scene.path, self._scene.up)
            self._open.draw(view.lens, view.place, view.turn, colour, depth)
            return made
        if colour is not None:
            colour[...] = (0, 0, 0, 255)
        if depth is not None:
            depth[...] = 0
        return made

    def _semantic(self, view: _View) -> NDArray[Any]:
        """The labels' object_id; zeros for a scene without labels."""
        seen = np.zeros((view.lens.height, view.lens.width), np.uint32)
        file = None if self._scene is None else self._scene.labels()
        if file is not None:
            if self._labels is None:
                self._labels = native.Sensors(*file, labels=True)
            self._labels.draw(view.lens, view.place, view.turn, None, None, seen)
        return seen
