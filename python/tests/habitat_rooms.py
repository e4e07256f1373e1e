"""A small room that tests of habitat_sim write, and simulators of it. A plugin of pytest, for its fixtures."""

from __future__ import annotations

import json
import math
import struct
from pathlib import Path
from typing import Any, Iterator

import habitat_sim
import numpy as np
import pytest
from habitat_sim.utils.common import quat_from_angle_axis


def _box(low: Any, high: Any) -> tuple[Any, Any]:
    """Corners and triangles of a box, Habitat's frame."""
    corners = [[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]
    return np.array(corners, np.float32), np.array(triangles, np.uint32)


BOXES = [
    _box([-5, -0.5, -5], [5, 0, 5]),
    _box([-5, 0, -2.2], [3, 2.5, -2]),
    _box([20, -0.5, 0], [24, 0, 4]),
]


def write_room(file: Path, up: str) -> None:
    """A floor of 10 m x 10 m at height 0, with a red wall from x = -5 to 3 at z = -2, and another floor apart."""
    data, views, accessors, primitives = b"", [], [], []
    for k, (corners, triangles) in enumerate(BOXES):
        if up == "z":
            corners = np.stack([corners[:, 0], -corners[:, 2], corners[:, 1]], -1)
        for array in (corners, triangles):
            raw = array.tobytes()
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(raw)})
            data += raw
        accessors += [
            {"bufferView": 2 * k, "componentType": 5126, "count": 8, "type": "VEC3",
             "min": corners.min(0).tolist(), "max": corners.max(0).tolist()},
            {"bufferView": 2 * k + 1, "componentType": 5125, "count": triangles.size, "type": "SCALAR"},
        ]  # fmt: skip
        primitives.append({"attributes": {"POSITION": 2 * k}, "indices": 2 * k + 1, "material": k % 2})
    materials = [{"pbrMetallicRoughness": {"baseColorFactor": c}} for c in ([1, 1, 1, 1], [1, 0, 0, 1])]
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}], "materials": materials, "accessors": accessors,
        "bufferViews": views, "buffers": [{"byteLength": len(data)}],
    }  # fmt: skip
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(data))
    json_head, data_head = (
        struct.pack("<II", len(text), 0x4E4F534A),
        struct.pack("<II", len(data), 0x004E4942),
    )
    file.write_bytes(head + json_head + text + data_head + data)


@pytest.fixture(scope="session")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """room.glb, z up; and beside it yup/room.glb, y up, with a scene dataset."""
    folder = tmp_path_factory.mktemp("rooms")
    write_room(folder / "room.glb", "z")
    (folder / "yup").mkdir()
    write_room(folder / "yup" / "room.glb", "y")
    stages = {
        "default_attributes": {"up": [0, 1, 0], "front": [0, 0, -1]},
        "paths": {".glb": ["*.glb"]},
    }
    (folder / "yup" / "rooms.scene_dataset_config.json").write_text(json.dumps({"stages": stages}))
    return folder


@pytest.fixture(scope="session")
def floor(rooms: Path) -> Path:
    """The room's navigation mesh, in a file that is not beside it."""
    file = rooms / "kept" / "room.navmesh"
    file.parent.mkdir()
    with habitat_sim.Simulator(configuration(rooms / "room.glb", settings())) as sim:
        assert sim.pathfinder.save_nav_mesh(str(file))
    return file


def settings(radius: float = 0.1) -> Any:
    made = habitat_sim.NavMeshSettings()
    made.set_defaults()
    made.agent_radius = radius
    return made


def camera(
    uuid: str = "rgb", kind: str = "COLOR", size: tuple[int, int] = (24, 32), **more: Any
) -> Any:
    spec = habitat_sim.CameraSensorSpec()
    spec.uuid, spec.sensor_type = uuid, getattr(habitat_sim.SensorType, kind)
    spec.resolution, spec.position = list(size), [0.0, 1.25, 0.0]
    for name, value in more.items():
        setattr(spec, name, value)
    return spec


def configuration(
    scene: Any, mesh: Any = None, sensors: Any = (), **more: Any
) -> habitat_sim.Configuration:
    config = habitat_sim.SimulatorConfiguration()
    config.scene_id, config.navmesh_settings = str(scene), mesh
    for name, value in more.items():
        setattr(config, name, value)
    agent = habitat_sim.agent.AgentConfiguration()
    agent.sensor_specifications = list(sensors)
    spec, by = habitat_sim.ActionSpec, habitat_sim.ActuationSpec
    agent.action_space = {
        0: spec("stop"), 1: spec("move_forward", by(0.25)), 2: spec("turn_left", by(15.0)),
        3: spec("turn_right", by(15.0)), 4: spec("look_up", by(30.0)), 5: spec("look_down", by(30.0)),
    }  # fmt: skip
    return habitat_sim.Configuration(config, [agent])


@pytest.fixture
def sim(rooms: Path, floor: Path) -> Iterator[Any]:
    """The room, with its navigation mesh and two cameras."""
    cameras = [camera(), camera("depth", "DEPTH")]
    with habitat_sim.Simulator(configuration(rooms / "room.glb", sensors=cameras)) as made:
        assert made.pathfinder.load_nav_mesh(str(floor))
        yield made


def put(sim: Any, position: Any, yaw: float = 0.0) -> None:
    """Puts the agent somewhere, turned to the left by `yaw` degrees."""
    state = habitat_sim.AgentState()
    state.position, state.rotation = (
        position,
        quat_from_angle_axis(math.radians(yaw), habitat_sim.geo.UP),
    )
    sim.get_agent(0).set_state(state)
