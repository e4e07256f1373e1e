"""habitat_sim and magnum, the drop-ins: names, structures, scenes and the pathfinder, in a small room. What the
real Habitat-Sim answers is compared by habitat_sim.check."""

from __future__ import annotations

import copy
import importlib
import json
import math
import pickle
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

np = pytest.importorskip("numpy")
pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")

pytest.register_assert_rewrite("habitat_rooms")

import habitat_sim  # noqa: E402
import magnum as mn  # noqa: E402
from habitat_rooms import camera, configuration, put, settings  # noqa: E402
from habitat_sim.utils.common import (  # noqa: E402
    angle_between_quats,
    quat_from_angle_axis,
    quat_from_coeffs,
    quat_from_magnum,
    quat_from_two_vectors,
    quat_rotate_vector,
    quat_to_angle_axis,
    quat_to_coeffs,
    quat_to_magnum,
    random_quaternion,
)

pytest_plugins = ["habitat_rooms"]


# --- names ----------------------------------------------------------------------------------------

AT_IMPORT = """
magnum.Matrix4.identity_init magnum.Vector3.zero_init magnum.trade.ImporterManager magnum.trade.MeshData magnum.Color4
magnum.Matrix3 magnum.Matrix4 magnum.MutableImageView2D magnum.Quaternion magnum.Range2D magnum.Range3D magnum.Vector2
magnum.Vector3 magnum.math.join habitat_sim.ReplayRenderer habitat_sim.ReplayRendererConfiguration
habitat_sim._ext.habitat_sim_bindings.Configuration habitat_sim.gfx.DebugLineRender habitat_sim.logging.logger
habitat_sim.metadata.MetadataMediator habitat_sim.nav.PathFinder habitat_sim.physics.ArticulatedObjectManager
habitat_sim.physics.CollisionGroupHelper habitat_sim.physics.CollisionGroups habitat_sim.physics.JointMotorSettings
habitat_sim.physics.ManagedArticulatedObject habitat_sim.physics.ManagedBulletArticulatedObject
habitat_sim.physics.ManagedRigidObject habitat_sim.physics.MotionType habitat_sim.physics.RaycastResults
habitat_sim.physics.RigidConstraintSettings habitat_sim.physics.RigidConstraintType
habitat_sim.physics.RigidObjectManager habitat_sim.scene.SemanticRegion habitat_sim.scene.SceneNode
habitat_sim.sensor.CameraSensor habitat_sim.sim.SimulatorBackend habitat_sim.simulator.Simulator
habitat_sim.utils.common.orthonormalize_rotation_shear habitat_sim.utils.profiling_utils.RangeContext
habitat_sim.PyRobotNoisyActuationSpec habitat_sim.bindings.SensorFactory habitat_sim.errors.GreedyFollowerError
habitat_sim.agent.agent.Agent habitat_sim.agent.controls.ActuationSpec habitat_sim.geo.FRONT
habitat_sim.nav.greedy_geodesic_follower.GreedyGeodesicFollower habitat_sim.utils.quat_rotate_vector
habitat_sim.utils.datasets_download.main habitat_sim.cuda_enabled habitat_sim.bindings.built_with_bullet
habitat_sim.audio_enabled habitat_sim.RigidState
"""


@pytest.mark.parametrize("name", AT_IMPORT.split())
def test_names_that_habitat_lab_imports_are_there(name: str) -> None:
    found: Any = sys.modules[name.partition(".")[0]]
    for part in name.split(".")[1:]:
        found = getattr(found, part)
    assert found is not None


def test_what_habitat_lab_makes_when_it_is_imported() -> None:
    importlib.import_module("corrade")
    manager = mn.trade.ImporterManager()
    assert isinstance(copy.deepcopy(manager), mn.trade.ImporterManager)
    with pytest.raises(NotImplementedError, match="habitat_sim.Simulator opens scenes"):
        manager.load_and_instantiate("AnySceneImporter")


@pytest.mark.parametrize(
    "name",
    ["physics.ManagedRigidObject", "metadata.MetadataMediator", "gfx.DebugLineRender", "sensor.AudioSensorSpec",
     "agent.PyRobotNoisyActuationSpec", "nav.GreedyGeodesicFollowerImpl"],
)  # fmt: skip
def test_what_is_not_there_says_so_when_it_is_used(name: str) -> None:
    module, kind = name.split(".")
    missing = getattr(getattr(habitat_sim, module), kind)
    assert pickle.loads(pickle.dumps(missing)) is missing is copy.deepcopy(missing)
    own = type("Own", (missing,), {})
    for use in (missing, own, lambda: missing.create(), lambda: missing["a"], lambda: list(missing)):
        with pytest.raises(NotImplementedError, match=f"{kind}: .*use "):
            use()
    assert not hasattr(missing, "create") and not isinstance(1, missing)


def test_methods_that_are_not_there_say_so(sim: Any) -> None:
    for name in ("get_rigid_object_manager", "cast_ray", "gfx_replay_manager", "semantic_color_map"):
        assert name in dir(habitat_sim.Simulator) and not hasattr(sim, name)
        with pytest.raises(NotImplementedError, match=rf"SimulatorBackend\.{name}: Enfilade has no"):
            getattr(sim, name)
    with pytest.raises(NotImplementedError, match="navmesh_visualization"):
        sim.navmesh_visualization = True
    with pytest.raises(NotImplementedError, match="no library of objects"):
        sim.get_object_template_manager().load_configs("objects")
    with pytest.raises(NotImplementedError, match="SceneNode.rotate"):
        sim.get_agent(0).scene_node.rotate(1)


# --- structures -----------------------------------------------------------------------------------


def test_fields_take_what_habitats_take() -> None:
    spec = habitat_sim.CameraSensorSpec()
    assert (
        spec.hfov == mn.Deg(90)
        and list(spec.position) == [0, 1.5, 0]
        and list(spec.resolution) == [128, 128]
    )
    spec.hfov, spec.position, spec.resolution = 79, [0, 0.88, 0], np.array([480, 640])
    assert float(spec.hfov) == 79 and spec.position[1] == np.float32(0.88)
    height, width = spec.resolution
    assert (height, width) == (480, 640) and spec.is_visual_sensor_spec()
    spec.hfov, spec.position = mn.Rad(math.pi / 3), mn.Vector3(1, 2, 3)
    assert spec.hfov == mn.Deg(60) and spec == copy.deepcopy(spec) != habitat_sim.CameraSensorSpec()
    assert habitat_sim.SimulatorConfiguration() == habitat_sim.SimulatorConfiguration()
    assert isinstance(spec, habitat_sim.VisualSensorSpec) and isinstance(spec, habitat_sim.SensorSpec)
    assert (
        int(habitat_sim.SensorType.SEMANTIC) == 5
        and str(habitat_sim.SensorType.COLOR) == "SensorType.COLOR"
    )


@pytest.mark.parametrize(
    ("name", "value", "error", "words"),
    [("position", (0, 1, 0), TypeError, "position .*list or array of 3 numbers"),
     ("position", [0, 1], TypeError, "3 numbers"),
     ("position", "abc", TypeError, "3 numbers"),
     ("resolution", [1.5, 2], TypeError, "2 integers"),
     ("resolution", [0, 2], ValueError, "1 to 8192"),
     ("hfov", "90", TypeError, "hfov '90': a number"),
     ("sensor_type", 2, TypeError, "a SensorType"),
     ("gpu2gpu_transfer", 1, TypeError, "True or False"),
     ("noise_model_kwargs", [], TypeError, "a dictionary"),
     ("hvof", 90, AttributeError, "CameraSensorSpec has no field 'hvof'")],
)  # fmt: skip
def test_fields_refuse_wrong_values(name: str, value: Any, error: Any, words: str) -> None:
    with pytest.raises(error, match=words):
        setattr(habitat_sim.CameraSensorSpec(), name, value)


def test_vectors_are_magnums() -> None:
    v = mn.Vector3(1, 2, 3)
    assert list(v) == v.tolist() == [1, 2, 3] and len(v) == 3 and v[-1] == v.z == 3
    assert np.array(v).dtype == np.float32 and np.asarray([v, v]).shape == (2, 3)
    assert (
        v + v == 2 * v == v * 2.0
        and v - v == mn.Vector3.zero_init()
        and -v / 2 == mn.Vector3(-0.5, -1, -1.5)
    )
    assert isinstance(np.ones(3) - v, np.ndarray) and v != mn.Vector3(1, 2, 4)
    assert (
        v.length() == pytest.approx(math.sqrt(14))
        and v.normalized().is_normalized()
        and repr(v) == "Vector(1, 2, 3)"
    )
    assert mn.math.dot(v, v) == v.dot() == 14
    assert mn.math.cross(mn.Vector3.x_axis(), mn.Vector3.y_axis()) == mn.Vector3.z_axis()
    v.y = 7
    assert v == mn.Vector3([1, 7, 3]) and copy.deepcopy(v) == v
    for wrong in (lambda: v[3], lambda: mn.Vector3(1, 2), lambda: mn.Vector2i(1.5, 2)):
        with pytest.raises((IndexError, TypeError)):
            wrong()
    box = mn.math.join(mn.Range3D([0, 0, 0], [1, 1, 1]), mn.Range3D([-1, 0, 0], [0, 0, 2]))
    assert (
        box == mn.Range3D([-1, 0, 0], [1, 1, 2])
        and box.size() == mn.Vector3(2, 1, 2)
        and box.contains([0, 0, 0])
    )


def test_rotations_agree() -> None:
    turn = mn.Quaternion.rotation(mn.Deg(90), mn.Vector3.y_axis())
    assert turn.transform_vector(habitat_sim.geo.FRONT) == habitat_sim.geo.LEFT
    assert turn * turn.inverted() == mn.Quaternion.identity_init() and (
        turn * turn
    ).scalar == pytest.approx(0, abs=1e-7)
    own = quat_from_angle_axis(math.pi / 2, habitat_sim.geo.UP)
    assert np.allclose(quat_rotate_vector(own, habitat_sim.geo.FRONT), [-1, 0, 0])
    assert quat_to_magnum(own) == turn and np.allclose(
        quat_to_coeffs(quat_from_magnum(turn)), quat_to_coeffs(own)
    )
    assert quat_to_coeffs(quat_from_coeffs([0, 0.6, 0, 0.8])).tolist() == [0, 0.6, 0, 0.8]
    angle, axis = quat_to_angle_axis(own)
    assert angle == pytest.approx(math.pi / 2) and np.allclose(axis, [0, 1, 0])
    for b in ([0, 0, -1], [0, 0, 1], [1, 2, 3]):
        turned = quat_rotate_vector(quat_from_two_vectors([0, 0, -1], b), [0, 0, -1])
        assert np.allclose(turned, np.array(b) / np.linalg.norm(b))
    assert angle_between_quats(own, quat_from_angle_axis(-math.pi / 2, [0, 3, 0])) == pytest.approx(
        math.pi
    )
    assert abs(random_quaternion()) == pytest.approx(1)


# --- scenes ---------------------------------------------------------------------------------------


def test_scenes_are_opened_by_path_and_by_dataset(rooms: Path, tmp_path: Path) -> None:
    dataset = str(rooms / "yup" / "rooms.scene_dataset_config.json")
    # As in StageAttributesManager of Habitat-Sim: y up by default_attributes that have no axis, else z up.
    no_axis, no_defaults = tmp_path / "a.json", tmp_path / "b.json"
    no_axis.write_text(json.dumps({"stages": {"default_attributes": {}}}))
    no_defaults.write_text(json.dumps({"stages": {}}))
    areas = []
    for scene, more in (
        (rooms / "room.glb", {}),
        (rooms / "yup" / "room.glb", {"scene_dataset_config_file": dataset}),
        ("room", {"scene_dataset_config_file": dataset}),
        (rooms / "yup" / "room.glb", {"scene_dataset_config_file": str(no_axis)}),
        (rooms / "room.glb", {"scene_dataset_config_file": str(no_defaults)}),
    ):
        with habitat_sim.Simulator(configuration(scene, settings(), **more)) as sim:
            low, high = sim.pathfinder.get_bounds()
            assert low[1] == pytest.approx(-0.5, abs=0.01) and high[0] == pytest.approx(24, abs=0.01)
            areas.append(sim.pathfinder.navigable_area)
            assert sim.curr_scene_name == str(scene) and sim.semantic_scene.objects == []
    assert areas[0] == pytest.approx(areas[1], rel=0.02) and areas[1] == areas[2] and areas[0] > 90


def test_scenes_that_are_not_there_are_named(rooms: Path, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="scene_id 'none.glb': no such file"):
        habitat_sim.Simulator(configuration("none.glb"))
    with pytest.raises(FileNotFoundError, match="scene_dataset_config_file"):
        habitat_sim.Simulator(configuration("a", scene_dataset_config_file="none.json"))
    dataset = tmp_path / "a.json"
    dataset.write_text("{}")
    with pytest.raises(ValueError, match='a.json: a JSON object with "stages"'):
        habitat_sim.Simulator(configuration("a", scene_dataset_config_file=str(dataset)))
    dataset.write_text(json.dumps({"stages": {"default_attributes": {"up": [1, 0, 0]}}}))
    with pytest.raises(NotImplementedError, match="up \\[1, 0, 0\\]"):
        habitat_sim.Simulator(configuration(rooms / "room.glb", scene_dataset_config_file=str(dataset)))
    (tmp_path / "a.ply").write_text("")
    with pytest.raises(NotImplementedError, match="a.ply': Enfilade opens .glb"):
        habitat_sim.Simulator(configuration(tmp_path / "a.ply"))
    for name, value in (("enable_physics", True), ("enable_hbao", True), ("enable_gfx_replay_save", True),
                        ("scene_light_setup", "")):  # fmt: skip
        with pytest.raises(NotImplementedError, match=name):
            habitat_sim.Simulator(configuration(rooms / "room.glb", **{name: value}))
    config = configuration(rooms / "room.glb")
    config.enable_batch_renderer = True
    with pytest.raises(NotImplementedError, match="enable_batch_renderer"):
        habitat_sim.Simulator(config)
    with pytest.raises(ValueError, match="default_agent_id 1: the configuration has 1 agents"):
        habitat_sim.Simulator(configuration(rooms / "room.glb", default_agent_id=1))


# A home of one level and two rooms, with a turned box in the first and one in none.
HOUSE = """ASCII 1.1
H home - 0 1 1 1 2 2 2 2 1 1 0 0 0 0 0 -5 -5 0 5 5 3 0 0 0 0 0
L 0 2 - 0 0 1 -5 -5 0 5 5 3 0 0 0 0 0
R 0 0 0 0 k 0 0 0 -5 -5 0 0 5 3 3 0 0 0 0
R 1 0 0 0 - 0 0 0 0 -5 0 5 5 3 3 0 0 0 0
P 0 0 1 - 0 0 0 0 0 3 0 0 0 0
S 0 0 0 F 0 0 0 0 0 1 -5 -5 0 0 5 0 0 0 0 0 0
V 0 0 - 0 0 0 0 0 1 0 0 0
P view 0 0 0 1 1 1 0 0 0 0 0
C 0 213 chest#of#drawers 13 chest_of_drawers 0 0 0 0 0
C 1 4 floor 2 floor 0 0 0 0 0
O 0 0 0 -2 -3 1 {axes} 1 2 0.5 0 0 0 0 0 0 0 0
O 1 -1 -1 0 0 0 1 0 0 0 1 0 1 1 1 0 0 0 0 0 0 0 0
E 0 0 7 1 0 0 0 0 0 0 1 1 1 0 0 0 0 0
E 1 -1 8 1 0 0 0 0 0 0 1 1 1 0 0 0 0 0
"""


def labelled(rooms: Path, folder: Path, text: str) -> Any:
    """A simulator of the room with a .house file beside it."""
    shutil.copy(rooms / "room.glb", folder / "home.glb")
    (folder / "home.house").write_text(text)
    return habitat_sim.Simulator(configuration(folder / "home.glb"))


def test_the_house_beside_a_scene_says_what_it_means(rooms: Path, tmp_path: Path) -> None:
    with labelled(rooms, tmp_path, HOUSE.format(axes="0.6 0.8 0 -0.8 0.6 0")) as sim:
        scene = sim.semantic_scene
    assert scene.aabb == mn.Range3D([-5, 0, -5], [5, 3, 5]) == scene.levels[0].aabb
    (level,), (kitchen, other), (drawers, floor) = scene.levels, scene.regions, scene.categories
    assert level.id == "0" and level.regions == [kitchen, other] and kitchen.level is level
    assert kitchen.id == "0_0" and kitchen.aabb == mn.Range3D([-5, 0, -5], [0, 3, 5])
    assert (kitchen.category.name(), kitchen.category.index()) == ("kitchen", 15)
    assert (other.category.name(), other.category.index()) == ("no label", -1)
    assert (drawers.name(), drawers.index()) == ("chest_of_drawers", 13)
    assert (drawers.name("mpcat40"), drawers.index("mpcat40")) == ("chest_of_drawers", 13)
    assert (drawers.name("raw"), drawers.index("raw")) == ("chest of drawers", 213)
    with pytest.raises(ValueError, match="mapping 'b': '' or 'mpcat40' or 'raw' is wanted"):
        floor.name("b")
    chest, apart = scene.objects
    assert kitchen.objects == [chest] and (chest.id, chest.semantic_id) == ("0_0_0", 0)
    assert chest.region is kitchen and chest.category is drawers
    assert chest.obb.center == mn.Vector3(-2, 1, 3) and chest.obb.sizes == mn.Vector3(2, 4, 1)
    assert chest.obb.half_extents == mn.Vector3(1, 2, 0.5)
    assert chest.aabb == mn.Range3D([-4.2, 0, 0], [0.2, 1.5, 5])  # Habitat's: with the origin
    assert apart.id == "_1" and apart.region is None and apart.category is None
    assert scene.semantic_index_map == {7: 0} and scene.semantic_index_to_object_index(8) == -1
    assert scene.get_regions_for_point([-1, 1, 1]) == [0] == scene.get_regions_for_point([-1, 2, 4])
    points = [[1, 1, 1], [2, 1, 1], [-1, 1, 1], [9, 9, 9]]
    assert scene.get_regions_for_points(points) == [(1, 0.5), (0, 0.25)]


@pytest.mark.parametrize(
    "axes", [((1, 0, 0), (0, 1, 0)), ((-1, 0, 0), (0, -1, 0)), ((0, 0.6, 0.8), (1, 0, 0)),
             ((-0.6, 0.8, 0), (0, 0, -1)), ((0, 0, 1), (0, -1, 0)), ((-1, 0, 0), (0, 0, 1))],
)  # fmt: skip
def test_boxes_of_objects_are_turned(rooms: Path, tmp_path: Path, axes: Any) -> None:
    words = " ".join(str(x) for axis in axes for x in axis)
    with labelled(rooms, tmp_path, HOUSE.format(axes=words)) as sim:
        x, y, z, w = sim.semantic_scene.objects[0].obb.rotation
    turn = mn.Quaternion((x, y, z), w)
    for local, (a, b, c) in zip(np.eye(3), axes):
        assert turn.transform_vector(local) == mn.Vector3(a, c, -b)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [("ASCII 1.1", "ASCII 1.0", "line 1: 'ASCII 1.1' is wanted"),
     ("H home", "H home a", "line 2: an H line of 29 words is wanted")],
)  # fmt: skip
def test_house_files_without_a_head_are_named_in_the_log(
    rooms: Path, tmp_path: Path, caplog: Any, old: str, new: str, words: str
) -> None:
    with labelled(rooms, tmp_path, changed(old, new)) as sim:
        assert_without_meaning(sim)
        assert sim.get_sensor_observations() == {} and len(sim.agents) == 1
    (record,) = caplog.records
    assert (record.name, record.levelname) == ("habitat_sim", "ERROR")
    assert record.getMessage().startswith(f"semantic_scene is empty: {tmp_path / 'home.house'}, {words}")


@pytest.mark.parametrize(
    ("old", "new", "left", "words"),  # left: how many levels, regions, categories, objects, segments
    [("R 1", "R 2", (1, 1, 0, 0, 0), "line 5: index '2': its place among the R lines, 1, is wanted"),
     ("R 1 0", "R 1 1", (1, 1, 0, 0, 0), "line 5: level '1': an integer from -1 to 0 is wanted"),
     ("0 k", "0 kk", (1, 0, 0, 0, 0), "line 4: label 'kk': one character is wanted"),
     ("k 0 0 0 -5", "k 0 0 0 nan", (1, 0, 0, 0, 0), "line 4: box 'nan': a number from "),
     ("k 0 0 0 -5", "k 0 0 0 1e39", (1, 0, 0, 0, 0), "line 4: box '1e39': a number from "),
     ("C 1 4", "C 1 4.5", (1, 2, 1, 0, 0), "line 11: mapping index '4.5': an integer"),
     ("C 1 4", "C 1", (1, 2, 1, 0, 0), "line 11: 10 words: a line C of 11 is wanted"),
     ("{axes}", "1 0 0 0 3 0", (1, 2, 2, 0, 0), "line 12: second axis '3': a number from -1.001 to 1.001"),
     ("O 1 -1 -1", "O 1 -1 2", (1, 2, 2, 1, 0), "line 13: category '2': an integer from -1 to 1 is wanted"),
     ("E 1 -1 8", "E 1 2 8", (1, 2, 2, 2, 1), "line 15: object '2': an integer from -1 to 1 is wanted")],
)  # fmt: skip
def test_a_bad_line_ends_a_house(
    rooms: Path, tmp_path: Path, caplog: Any, old: str, new: str, left: tuple[int, ...], words: str
) -> None:
    with labelled(rooms, tmp_path, changed(old, new)) as sim:
        scene = sim.semantic_scene
    lists = (scene.levels, scene.regions, scene.categories, scene.objects, scene.semantic_index_map)
    assert tuple(map(len, lists)) == left
    (record,) = caplog.records
    assert (record.name, record.levelname) == ("habitat_sim", "ERROR")
    assert record.getMessage().startswith(f"semantic_scene ends there: {tmp_path / 'home.house'}, {words}")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [("H home - 0 1", "H home - 0 2", ["line 2: count of P 3: the number of its lines is 2"]),
     ("H home - 0 1", "H home - x 1", ["line 2: count of I 'x': an integer from 0 to 2147483647 is wanted"]),
     ("V 0 0", "V 0 0 0", []),  # nothing uses these lines
     ("V 0", "X\nX 0", ["line 8: kind 'X': one of L, R, C, O, E, P, S, V, I is known; lines of other kinds: 2",
                     "line 2: count of V 1: the number of its lines is 0"])],
)  # fmt: skip
def test_what_nothing_uses_changes_no_house(
    rooms: Path, tmp_path: Path, caplog: Any, old: str, new: str, words: list[str]
) -> None:
    with labelled(rooms, tmp_path, changed(old, new)) as sim:
        assert len(sim.semantic_scene.objects) == 2 and sim.semantic_scene.semantic_index_map == {7: 0}
    assert [(one.levelname, one.getMessage()) for one in caplog.records] == [
        ("WARNING", f"{tmp_path / 'home.house'}, {what}") for what in words
    ]


def changed(old: str, new: str) -> str:
    """HOUSE with one place changed."""
    assert HOUSE.count(old) == 1
    return HOUSE.replace(old, new).replace("{axes}", "1 0 0 0 1 0")


def assert_without_meaning(sim: Any) -> None:
    scene = sim.semantic_scene
    assert (scene.levels, scene.regions, scene.categories, scene.objects) == ([], [], [], [])
    assert scene.aabb == mn.Range3D() and scene.semantic_index_map == {}


def test_a_house_that_is_no_file_is_named_in_the_log(rooms: Path, tmp_path: Path, caplog: Any) -> None:
    shutil.copy(rooms / "room.glb", tmp_path / "home.glb")
    (tmp_path / "home.house").mkdir()
    with habitat_sim.Simulator(configuration(tmp_path / "home.glb")) as sim:
        assert_without_meaning(sim)
    (record,) = caplog.records
    assert record.getMessage() == f"semantic_scene is empty: {tmp_path / 'home.house'}: Is a directory"


def test_an_empty_scene_has_nothing() -> None:
    with habitat_sim.Simulator(
        configuration("NONE", sensors=[camera(), camera("depth", "DEPTH")])
    ) as sim:
        assert not sim.pathfinder.is_loaded and not sim.recompute_navmesh(sim.pathfinder, settings())
        assert sim.get_agent(0).state.position.tolist() == [0, 0, 0]
        seen = sim.step(1)
        assert (
            not seen["collided"] and not seen["depth"].any() and (seen["rgb"] == [0, 0, 0, 255]).all()
        )
        assert sim.get_agent(0).state.position.tolist() == [0, 0, -0.25]


def test_the_navigation_mesh_is_the_file_beside_the_scene_or_made(
    rooms: Path, floor: Path, tmp_path: Path
) -> None:
    scene = tmp_path / "room.glb"
    scene.write_bytes((rooms / "room.glb").read_bytes())
    with habitat_sim.Simulator(configuration(scene)) as sim:
        assert not sim.pathfinder.is_loaded
        put(sim, [0, 0, -1.9])  # before the wall, which does not stop it
        assert not sim.step(1)["collided"] and sim.get_agent(0).state.position[2] == pytest.approx(
            -2.15
        )
    (tmp_path / "room.navmesh").write_bytes(floor.read_bytes())
    with habitat_sim.Simulator(configuration(scene)) as sim:
        assert sim.pathfinder.is_loaded and sim.pathfinder.nav_mesh_settings == settings()
        area = sim.pathfinder.navigable_area
    with habitat_sim.Simulator(configuration(scene, settings(0.4))) as sim:
        assert (
            sim.pathfinder.nav_mesh_settings == settings(0.4) and sim.pathfinder.navigable_area < area
        )
    (tmp_path / "room.navmesh").write_bytes(b"nothing")
    with habitat_sim.Simulator(configuration(scene)) as sim:
        assert not sim.pathfinder.is_loaded


def test_which_navigation_is_chosen_by_a_variable(rooms: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ask = "import habitat_sim; print(habitat_sim.nav.navigation)"
    for value, expected in (("0.3.3", "0.3.3"), ("", "latest")):
        monkeypatch.setenv("ENFILADE_HABITAT_NAVIGATION", value)
        done = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True)
        assert done.stdout.strip() == expected, done.stderr
    monkeypatch.setattr(habitat_sim.nav, "navigation", "0.1")
    with pytest.raises(ValueError, match="navigation '0.1': one of latest, 0.3.3"):
        habitat_sim.Simulator(configuration(rooms / "room.glb", settings()))


# --- the pathfinder -------------------------------------------------------------------------------


def test_an_empty_pathfinder_says_what_it_lacks(tmp_path: Path) -> None:
    finder = habitat_sim.PathFinder()
    assert not finder.is_loaded and finder.nav_mesh_settings is None
    assert not finder.load_nav_mesh(str(tmp_path / "none")) and not finder.save_nav_mesh(
        str(tmp_path / "none")
    )
    for ask in (finder.get_bounds, lambda: finder.snap_point([0, 0, 0]), lambda: finder.num_islands,
                lambda: finder.find_path(habitat_sim.ShortestPath()), finder.get_random_navigable_point):  # fmt: skip
        with pytest.raises(RuntimeError, match="no navigation mesh; load_nav_mesh"):
            ask()


def test_points_are_vectors_arrays_or_lists_but_no_tuples(sim: Any) -> None:
    finder = sim.pathfinder
    point = finder.get_random_navigable_point()
    assert isinstance(point, mn.Vector3) and list(point) == point.tolist()
    for same in (point, np.array(point), np.array(point, np.float64), point.tolist()):
        assert finder.is_navigable(same) and finder.snap_point(same) == point
        assert finder.island_radius(same) == finder.island_radius(finder.get_island(same))
    for wrong in (tuple(point), "abc", [0, 1], [[0, 1, 2]], None, 1):
        with pytest.raises(TypeError, match="3 numbers"):
            finder.is_navigable(wrong)
    with pytest.raises(TypeError, match="ShortestPath"):
        finder.find_path([point, point])
    low, high = finder.get_bounds()
    assert isinstance(low, mn.Vector3) and low[2] < high[2]


def test_questions_about_the_floor(sim: Any) -> None:
    finder = sim.pathfinder
    assert finder.num_islands >= 2 and finder.island_area() == finder.navigable_area
    assert sum(map(finder.island_area, range(finder.num_islands))) == pytest.approx(
        finder.navigable_area, rel=1e-5
    )
    home, away = finder.get_island([0.0, 0.0, 0.0]), finder.get_island([22.0, 0.0, 2.0])
    assert home >= 0 and away >= 0 and home != away and finder.get_island([50.0, 0.0, 0.0]) == -1
    finder.seed(3)
    points = [finder.get_random_navigable_point(island_index=away).tolist() for _ in range(5)]
    finder.seed(3)
    assert points == [finder.get_random_navigable_point(island_index=away).tolist() for _ in range(5)]
    assert all(19 < x < 25 for x, _, _ in points)
    near = finder.get_random_navigable_point_near([0.0, 0.0, 3.0], 3.0)
    assert math.hypot(near.x, near.z - 3) <= 3
    assert np.isnan(np.array(finder.snap_point([50.0, 0.0, 0.0]))).all()
    hit = finder.closest_obstacle_surface_point([0.0, 0.0, -1.5], 1.0)
    assert (
        hit.hit_dist
        == finder.distance_to_closest_obstacle([0.0, 0.0, -1.5], 1.0)
        == pytest.approx(0.4, abs=0.1)
    )
    assert hit.hit_normal[2] == pytest.approx(1) and hit.hit_pos[2] == pytest.approx(-1.9, abs=0.1)
    assert finder.distance_to_closest_obstacle([0.0, 0.0, 2.0], 0.5) == 0.5
    view, islands = finder.get_topdown_view(0.1, 0.0), finder.get_topdown_island_view(0.1, 0.0)
    assert (
        view.dtype == bool
        and view.shape == islands.shape
        and ((islands >= 0) == view).all()
        and view.any()
    )
    corners = finder.build_navmesh_vertices()
    assert len(corners) % 3 == 0 and finder.build_navmesh_vertex_indices() == list(range(len(corners)))
    onto = finder.try_step([0.0, 0.0, -1.8], [1.0, 0.0, -2.8])
    stopped = finder.try_step_no_sliding([0.0, 0.0, -1.8], [1.0, 0.0, -2.8])
    assert (
        onto.x > 0.5 > stopped.x
        and onto.z > -2
        and sim.step_filter([0.0, 0.0, -1.8], [1.0, 0.0, -2.8]) == onto
    )


def test_shortest_paths(sim: Any) -> None:
    path = habitat_sim.ShortestPath()
    path.requested_start, path.requested_end = np.array([0, 0, -1], np.float32), [0, 0, -3]
    assert sim.pathfinder.find_path(path)
    assert len(path.points) > 2 and path.geodesic_distance > 5 and path.points[0][0] == pytest.approx(0)
    legs = np.linalg.norm(np.diff(np.array(path.points), axis=0), axis=1)
    assert legs.sum() == pytest.approx(path.geodesic_distance, rel=1e-5)
    path.requested_end = mn.Vector3(22, 0, 2)
    assert (
        not sim.pathfinder.find_path(path) and path.geodesic_distance == math.inf and path.points == []
    )
    with pytest.raises(TypeError, match="requested_end"):
        path.requested_end = (0, 0, 0)


def test_paths_to_the_nearest_of_several_goals(sim: Any) -> None:
    path = habitat_sim.MultiGoalShortestPath()
    goals = np.array([[0, 0, -3], [3, 0, 0], [22, 0, 2]], np.float32)
    path.requested_start = [0, 0, -1]
    for same in (goals, goals.astype(np.float64), list(goals), [mn.Vector3(goal) for goal in goals]):
        path.requested_ends = same
        assert sim.pathfinder.find_path(path) and path.closest_end_point_index == 1
        assert path.geodesic_distance == pytest.approx(math.sqrt(10), abs=0.05)
    assert path.requested_ends == [mn.Vector3(goal) for goal in goals]
    path.requested_start = [0, 0, -3.2]
    assert sim.pathfinder.find_path(path) and path.closest_end_point_index == 0
    path.requested_ends = goals[2:]
    assert not sim.pathfinder.find_path(path) and path.geodesic_distance == math.inf
    path.requested_ends = []
    assert not sim.pathfinder.find_path(path)
    for wrong in (goals.tolist(), (goals[0],), goals[0], goals[:, :2], [(0, 0, 0)]):
        with pytest.raises(TypeError, match="requested_ends"):
            path.requested_ends = wrong
