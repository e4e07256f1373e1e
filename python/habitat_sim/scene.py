"""Scenes: the poses of bodies and sensors, and what a scene means."""

from __future__ import annotations

from typing import Any, Optional

import magnum as mn
import numpy as np
from enfilade._eyes import habitat as native

from habitat_sim._fields import Code, one_of, vector3
from habitat_sim._missing import DRAWING, RefusedAttribute, refused
from habitat_sim._rotations import IDENTITY, Xyzw
from habitat_sim._semantics import (
    Mp3dObjectCategory,
    Mp3dRegionCategory,
    SemanticCategory,
    SemanticLevel,
    SemanticObject,
    SemanticRegion,
    SemanticScene,
)

__all__ = [
    "Mp3dObjectCategory", "Mp3dRegionCategory", "SceneGraph", "SceneNode", "SceneNodeType", "SemanticCategory",
    "SemanticLevel", "SemanticObject", "SemanticRegion", "SemanticScene",
]  # fmt: skip


class SceneNodeType(Code):
    """What a node is of."""

    EMPTY = 0
    SENSOR = 1
    AGENT = 2
    CAMERA = 3
    OBJECT = 4


class SceneNode:
    """A pose, relative to that of another node. Poses are set by states and actions."""

    def __init__(
        self, parent: Optional[SceneNode] = None, kind: SceneNodeType = SceneNodeType.EMPTY
    ) -> None:
        self._parent = parent
        self.type = kind
        self._place: tuple[float, float, float] = (0.0, 0.0, 0.0)
        self._turn: Xyzw = IDENTITY

    def create_child(self) -> SceneNode:
        """A node at the same place, that moves with this one."""
        return SceneNode(self)

    @property
    def parent(self) -> Optional[SceneNode]:
        """The node that this one moves with; None for a body."""
        return self._parent

    @property
    def type(self) -> SceneNodeType:
        """What it is of."""
        return self._type

    @type.setter
    def type(self, kind: SceneNodeType) -> None:
        self._type = one_of(SceneNodeType)("type", kind)

    @property
    def translation(self) -> mn.Vector3:
        """The place, metres, in the parent's frame."""
        return mn.Vector3(self._place)

    @translation.setter
    def translation(self, place: Any) -> None:
        x, y, z = vector3("translation", place)
        self._place = (x, y, z)

    @property
    def rotation(self) -> mn.Quaternion:
        """The direction, in the parent's frame."""
        x, y, z, w = self._turn
        return mn.Quaternion((x, y, z), w)

    @rotation.setter
    def rotation(self, turn: mn.Quaternion) -> None:
        if not isinstance(turn, mn.Quaternion):
            raise TypeError(f"rotation {turn!r}: a magnum.Quaternion is wanted")
        if not turn.is_normalized():
            raise ValueError(f"rotation {turn!r}: the length is {turn.length():g}, it has to be 1")
        self._turn = turn.xyzw

    @property
    def absolute_translation(self) -> mn.Vector3:
        """The place in the world."""
        return mn.Vector3(self._in_world()[0])

    def transformation_matrix(self) -> mn.Matrix4:
        """The pose in the parent's frame."""
        return _matrix(self._place, self._turn)

    def absolute_transformation_matrix(self) -> mn.Matrix4:
        """The pose in the world."""
        return _matrix(*self._in_world())

    @property
    def transformation(self) -> mn.Matrix4:
        """The pose in the parent's frame."""
        return self.transformation_matrix()

    def absolute_transformation(self) -> mn.Matrix4:
        """The pose in the world."""
        return self.absolute_transformation_matrix()

    def _in_world(self) -> tuple[tuple[float, float, float], Xyzw]:
        if self._parent is None:
            return self._place, self._turn
        return native.in_world(*self._parent._in_world(), self._place, self._turn)

    _words = "nodes only have a pose here; set translation and rotation"
    compute_cumulative_bb = RefusedAttribute(DRAWING)
    cumulative_bb = RefusedAttribute(DRAWING)
    drawable_semantic_id = RefusedAttribute(DRAWING)
    mesh_bb = RefusedAttribute(DRAWING)
    node_sensor_suite = RefusedAttribute("use Agent.sensors")
    node_sensors = RefusedAttribute("use Agent.sensors")
    object_semantic_id = RefusedAttribute(DRAWING)
    reset_transformation = RefusedAttribute(_words)
    rotate = RefusedAttribute(_words)
    rotate_local = RefusedAttribute(_words)
    rotate_x = RefusedAttribute(_words)
    rotate_x_local = RefusedAttribute(_words)
    rotate_y = RefusedAttribute(_words)
    rotate_y_local = RefusedAttribute(_words)
    rotate_z = RefusedAttribute(_words)
    rotate_z_local = RefusedAttribute(_words)
    scale = RefusedAttribute(_words)
    scale_local = RefusedAttribute(_words)
    scaling = RefusedAttribute(_words)
    scene = RefusedAttribute(DRAWING)
    semantic_id = RefusedAttribute(DRAWING)
    set_parent = RefusedAttribute(_words)
    subtree_sensor_suite = RefusedAttribute("use Agent.sensors")
    subtree_sensors = RefusedAttribute("use Agent.sensors")
    translate = RefusedAttribute(_words)
    translate_local = RefusedAttribute(_words)


def _matrix(place: Any, turn: Xyzw) -> mn.Matrix4:
    rows = np.eye(4)
    rows[:3, :3] = np.asarray(mn.Quaternion(turn[:3], turn[3]).to_matrix())
    rows[:3, 3] = place
    return mn.Matrix4(rows)


SceneGraph = refused("habitat_sim.scene.SceneGraph", DRAWING)
