"""habitat_sim, the drop-in: labels, clip planes and noise of sensors, in a small room."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any, Callable, Iterator

import pytest

np = pytest.importorskip("numpy")
pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")

pytest.register_assert_rewrite("habitat_rooms")

import habitat_sim  # noqa: E402
from habitat_rooms import BOXES, camera, configuration, put  # noqa: E402
from habitat_sim.sensors import noise_models  # noqa: E402

pytest_plugins = ["habitat_rooms"]


# --- labels ---------------------------------------------------------------------------------------

FLOOR, WALL = 5, 7


def z_up(p: Any) -> Any:
    return np.stack([p[:, 0], -p[:, 2], p[:, 1]], -1)


def minus_y_up(p: Any) -> Any:
    return p * np.float32([1, -1, -1])


def write_labels(file: Path, placed: Callable[[Any], Any], colours: bool = True) -> None:
    """The room's faces with their objects: the floor, the wall, and none for the floor apart."""
    corner = np.dtype([("p", "<f4", 3), *([("c", "u1", 3)] if colours else [])])
    face = np.dtype([("n", "u1"), ("v", "<i4", 3), ("id", "<i4")])
    corners, faces = np.zeros(24, corner), np.zeros(36, face)
    for k, ((points, triangles), identity) in enumerate(zip(BOXES, (FLOOR, WALL, -1))):
        corners["p"][8 * k : 8 * k + 8] = placed(points)
        faces["v"][12 * k : 12 * k + 12] = triangles.astype(np.int32) + 8 * k
        faces["id"][12 * k : 12 * k + 12] = identity
    faces["n"] = 3
    rgb = "property uchar red\nproperty uchar green\nproperty uchar blue\n" if colours else ""
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 24\nproperty float x\nproperty float y\n"
        f"property float z\n{rgb}element face 36\nproperty list uchar int vertex_indices\n"
        "property int object_id\nend_header\n"
    )
    file.write_bytes(head.encode() + corners.tobytes() + faces.tobytes())


def dataset(folder: Path, **attributes: Any) -> str:
    """A scene dataset of the folder."""
    file = folder / "some.scene_dataset_config.json"
    file.write_text(
        json.dumps({"stages": {"default_attributes": attributes, "paths": {".glb": ["*.glb"]}}})
    )
    return str(file)


Z_UP = {"up": [0, 0, 1], "front": [0, 1, 0]}
Y_UP = {"up": [0, 1, 0], "front": [0, 0, -1]}
SEMANTIC_Y_UP = {"semantic_up": [0, 1, 0], "semantic_front": [0, 0, -1]}


def seen(scene: Path, place: Any = (0, 0, 1), **more: Any) -> dict[str, Any]:
    sensors = [camera("depth", "DEPTH"), camera("labels", "SEMANTIC"), camera("again", "SEMANTIC")]
    with habitat_sim.Simulator(configuration(scene, sensors=sensors, **more)) as sim:
        put(sim, list(place))
        return dict(sim.get_sensor_observations())


def lies_in_place(labels: dict[str, Any]) -> bool:
    shown, depth = labels["labels"], labels["depth"]
    assert shown.dtype == np.uint32 and (shown == labels["again"]).all()
    return bool(
        ((shown > 0) == (depth > 0)).all()
        and shown[12, 16] == WALL
        and shown[-1, 16] == FLOOR
        and shown[0].max() == 0
    )


@pytest.mark.parametrize(
    ("glb", "attributes", "placed", "right"),
    [("room.glb", None, minus_y_up, True), ("room.glb", None, z_up, False),
     ("room.glb", {**Z_UP, **SEMANTIC_Y_UP}, z_up, True), ("room.glb", {**Z_UP, "semantic_up": [0, 1, 0]}, z_up, True),
     ("yup/room.glb", Y_UP, z_up, True), ("yup/room.glb", {**Y_UP, **SEMANTIC_Y_UP}, z_up, True),
     ("yup/room.glb", Y_UP, minus_y_up, False)],
)  # fmt: skip
def test_labels_lie_where_habitat_shows_them(
    rooms: Path, tmp_path: Path, glb: str, attributes: Any, placed: Any, right: bool
) -> None:
    shutil.copy(rooms / glb, tmp_path / "room.glb")
    write_labels(tmp_path / "room_semantic.ply", placed)
    more = {}
    if attributes is not None:
        more["scene_dataset_config_file"] = dataset(tmp_path, **attributes)
    assert lies_in_place(seen(tmp_path / "room.glb", **more)) == right


def test_labels_are_the_datasets_file(
    rooms: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    shutil.copy(rooms / "yup" / "room.glb", tmp_path / "room.glb")
    (tmp_path / "labels").mkdir()
    write_labels(tmp_path / "labels" / "room_objects.ply", z_up)
    for asset in ("labels/room_objects.ply", "labels/%%CONFIG_NAME_AS_ASSET_FILENAME%%_objects.ply"):
        file = dataset(tmp_path, semantic_asset=asset, **Y_UP)
        assert lies_in_place(seen(tmp_path / "room.glb", scene_dataset_config_file=file))
    assert not caplog.records
    file = dataset(tmp_path, semantic_asset="none.ply", **Y_UP)
    assert not seen(tmp_path / "room.glb", scene_dataset_config_file=file)["labels"].any()
    assert "semantic_asset 'none.ply': no such file" in caplog.text


def test_faces_without_an_object_are_65535(rooms: Path, tmp_path: Path) -> None:
    shutil.copy(rooms / "room.glb", tmp_path / "room.glb")
    write_labels(tmp_path / "room_semantic.ply", minus_y_up)
    apart = seen(tmp_path / "room.glb", (22, 0, 5))
    assert set(np.unique(apart["labels"])) == {0, 65535}
    assert ((apart["labels"] > 0) == (apart["depth"] > 0)).all()


def test_bad_labels_are_named(rooms: Path, tmp_path: Path) -> None:
    shutil.copy(rooms / "room.glb", tmp_path / "room.glb")
    scene, labels = tmp_path / "room.glb", tmp_path / "room_semantic.ply"
    labels.write_text("ply\n")
    with pytest.raises(ValueError, match="room_semantic.ply"):
        seen(scene)
    write_labels(labels, z_up, colours=False)
    with pytest.raises(ValueError, match="no red, green and blue, which Habitat-Sim requires"):
        seen(scene)
    file = dataset(tmp_path, semantic_asset="room.glb", **Z_UP)
    with pytest.raises(NotImplementedError, match="room.glb': Enfilade draws labels of .ply"):
        seen(scene, scene_dataset_config_file=file)
    file = dataset(tmp_path, **Z_UP, semantic_up=[1, 0, 0])
    with pytest.raises(NotImplementedError, match=r"semantic_up \[1, 0, 0\] and semantic_front"):
        seen(scene, scene_dataset_config_file=file)
    for attributes in ({**Z_UP, "semantic_asset": 5}, {**Z_UP, "semantic_up": 5}, {"up": [[1]]}):
        file = dataset(tmp_path, **attributes)
        with pytest.raises(ValueError, match="some.scene_dataset_config.json: .* of stages is not"):
            seen(scene, scene_dataset_config_file=file)


# --- clip planes ----------------------------------------------------------------------------------


def test_near_and_far_cut(rooms: Path) -> None:
    old = habitat_sim.SensorSpec()  # of habitat-lab 0.1.7
    old.uuid, old.sensor_type, old.resolution = "old", habitat_sim.SensorType.DEPTH, [24, 32]
    old.position = [0, 1.25, 0]
    old.parameters.update(near="3.5", far="100")
    around = habitat_sim.EquirectangularSensorSpec()
    around.uuid, around.sensor_type, around.far = "around", habitat_sim.SensorType.DEPTH, 2.9
    around.resolution, around.position = [32, 64], [0, 1.25, 0]
    sensors = [
        camera("whole", "DEPTH"), camera("far", "DEPTH", far=2.9), camera("rgb", far=2.9),
        camera("near", "DEPTH", near=3.1), old, around,
    ]  # fmt: skip
    with habitat_sim.Simulator(configuration(rooms / "room.glb", sensors=sensors)) as sim:
        put(sim, [0, 0, 1])
        shown = sim.get_sensor_observations()
        whole = shown["whole"]
        assert whole[12, 16] == pytest.approx(3, abs=1e-3)
        assert (shown["far"] == np.where(whole < 2.9, whole, 0)).all()
        assert not shown["rgb"][12, 16, :3].any() and shown["rgb"][-1, 16, 0] > 50
        near = shown["near"]
        assert ((near == 0) | (near >= 3.1)).all() and near[12, 16] < 4  # the wall's back is not drawn
        assert 0 < near[15, 16] != whole[15, 16]  # but the floor behind it is
        assert ((shown["old"] == 0) | (shown["old"] >= 3.5)).all() and shown["old"].any()
        assert shown["around"].max() < 2.9 and shown["around"][31].min() > 1.2
        for wrong in ({"near": 0.0}, {"near": 2.0, "far": 1.0}, {"far": float("inf")}):
            with pytest.raises(ValueError, match="'wrong': sensor: near .* not 0 < near < far"):
                sim.add_sensor(camera("wrong", **wrong))


# --- noise ----------------------------------------------------------------------------------------

NOISE = {
    "GaussianNoiseModel": {"intensity_constant": 0.1, "mean": 0, "sigma": 1}, "PoissonNoiseModel": {},
    "SaltAndPepperNoiseModel": {"s_vs_p": 0.5, "amount": 0.05}, "SpeckleNoiseModel": {"sigma": 0.5},
}  # fmt: skip


@pytest.fixture
def no_new_models() -> Iterator[None]:
    kept = dict(habitat_sim.registry._models)
    yield
    habitat_sim.registry._models.clear()
    habitat_sim.registry._models.update(kept)


@pytest.mark.parametrize("name", NOISE)
def test_noise_models_change_colours(rooms: Path, name: str) -> None:
    sensors = [camera("noisy", noise_model=name, noise_model_kwargs=NOISE[name]), camera("clean")]
    with habitat_sim.Simulator(configuration(rooms / "room.glb", sensors=sensors)) as sim:
        put(sim, [0, 0, 1])
        np.random.seed(3)
        first = sim.get_sensor_observations()
        second = sim.get_sensor_observations()
        np.random.seed(3)
        third = sim.get_sensor_observations()
    assert first["noisy"].dtype == np.uint8 and first["noisy"].shape == (24, 32, 4)
    assert (first["noisy"] != second["noisy"]).any() and (first["noisy"] == third["noisy"]).all()
    assert (first["clean"] == second["clean"]).all() and (first["noisy"] != first["clean"]).any()


def test_noise_is_that_of_habitats_models() -> None:
    grey = np.full((200, 200, 4), 100, np.uint8)
    before = grey.copy()

    def noise(name: str, **more: Any) -> Any:
        return noise_models.make_sensor_noise_model(name, more)(grey).astype(float)

    np.random.seed(0)
    gaussian = noise("GaussianNoiseModel", intensity_constant=0.1, mean=0.5)
    assert gaussian.mean() == pytest.approx(100 + 0.05 * 255 - 0.5, abs=0.5)
    assert gaussian.std() == pytest.approx(0.1 * 255, rel=0.02)
    speckle = noise("SpeckleNoiseModel", intensity_constant=0.1)
    assert speckle.std() == pytest.approx(10, rel=0.02)
    assert set(np.unique(noise("PoissonNoiseModel"))) <= {0, 255}  # of one photon for full light
    salted = noise("SaltAndPepperNoiseModel", amount=0.2, s_vs_p=0.25)
    assert (salted == 0).mean() == pytest.approx(0.15, abs=0.02) and (salted == 1).any()
    assert (salted[-1] == 100).all() and (salted[..., -1] == 100).all()
    assert (noise("None") == grey).all() and (grey == before).all()
    assert noise_models.GaussianNoiseModel(gpu_device_id=2).gpu_device_id == 2


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [({"noise_model": "Fog"}, ValueError, "sensor 'rgb': noise_model 'Fog': one of GaussianNoiseModel, None,"),
     ({"noise_model": "RedwoodDepthNoiseModel"}, NotImplementedError, "table of a depth camera; use noise_model 'None'"),
     ({"noise_model_kwargs": {"a": 1}}, TypeError, "sensor 'rgb': .* unexpected keyword argument 'a'"),
     ({"noise_model": "SpeckleNoiseModel", "noise_model_kwargs": {"sigma": -1}}, ValueError, r"sigma -1: .* \[0, inf\]"),
     ({"noise_model": "SpeckleNoiseModel", "noise_model_kwargs": {"mean": "1"}}, TypeError, "mean '1': a number"),
     ({"noise_model": "SaltAndPepperNoiseModel", "noise_model_kwargs": {"amount": 2}}, ValueError, "amount 2"),
     ({"noise_model": "PoissonNoiseModel", "sensor_type": habitat_sim.SensorType.DEPTH}, ValueError,
      "noise_model of 'rgb': PoissonNoiseModel is not for SensorType.DEPTH")],
)  # fmt: skip
def test_noise_that_is_not_there_is_named(rooms: Path, change: Any, error: Any, words: str) -> None:
    with pytest.raises(error, match=words):
        habitat_sim.Simulator(configuration(rooms / "room.glb", sensors=[camera(**change)]))


def test_programs_add_noise_models(rooms: Path, no_new_models: None) -> None:
    @habitat_sim.registry.register_noise_model(name="Dark")
    class DarkNoiseModel(noise_models.SensorNoiseModel):
        def __init__(self, gpu_device_id: int, share: float = 0.5) -> None:
            self.gpu_device_id, self.share = gpu_device_id, share

        @staticmethod
        def is_valid_sensor_type(sensor_type: Any) -> bool:
            return bool(sensor_type == habitat_sim.SensorType.DEPTH)

        def apply(self, sensor_observation: Any) -> Any:
            return sensor_observation * self.share

    assert habitat_sim.registry.get_noise_model("Dark") is DarkNoiseModel
    dark = camera("dark", "DEPTH", noise_model="Dark", noise_model_kwargs={"share": 0.25})
    sensors = [dark, camera("depth", "DEPTH")]
    with habitat_sim.Simulator(configuration(rooms / "room.glb", sensors=sensors)) as sim:
        put(sim, [0, 0, 1])
        shown = sim.get_sensor_observations()
    assert shown["depth"].any() and (shown["dark"] == shown["depth"] / 4).all()
    with pytest.raises(TypeError, match="a subclass of SensorNoiseModel is wanted"):
        habitat_sim.registry.register_noise_model(int)
    with pytest.raises(NotImplementedError, match="register_move_fn: Enfilade has Habitat's own"):
        habitat_sim.registry.register_move_fn(int)
    assert habitat_sim.registry.get_noise_model("None") is noise_models.NoSensorNoiseModel
