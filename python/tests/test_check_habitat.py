"""`python -m habitat_sim.check`: recordings of the real Habitat-Sim, and made ones."""

from __future__ import annotations

import gzip
import json
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")
habitat_sim = pytest.importorskip("habitat_sim", reason="the drop-in habitat_sim is not there")
check_scenes = pytest.importorskip("habitat_sim._check_scenes", reason="this habitat_sim has no check")

from habitat_sim import _check_streamvln as streamvln  # noqa: E402
from habitat_sim._check_tally import Tally  # noqa: E402
from habitat_sim.check import SECTIONS, check_part  # noqa: E402

# A floor of 6 x 5 m with a block on it: corners x, y, z (y up), and boxes of them.
BOXES = [((-3.0, -0.2, -2.5), (3.0, 0.0, 2.5)), ((-0.5, 0.0, -0.5), (0.6, 1.0, 0.4))]
FACES = [
    0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3, 0, 4, 5, 0, 5, 1,
    2, 3, 7, 2, 7, 6, 0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5,
]  # fmt: skip


def check(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "habitat_sim.check", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


def tiny_glb() -> bytes:
    """A mesh of boxes, y up, as a binary glTF."""
    corners = [[(low, high)[i >> 2 & 1][0], (low, high)[i >> 1 & 1][1], (low, high)[i & 1][2]]
               for low, high in BOXES for i in range(8)]  # fmt: skip
    points = np.array(corners, np.float32)
    indices = np.concatenate([np.array(FACES, np.uint32) + 8 * i for i in range(len(BOXES))])
    binary = points.tobytes() + indices.tobytes()
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.6, 0.7, 1.0]}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": len(points),
                "type": "VEC3",
                "min": points.min(0).tolist(),
                "max": points.max(0).tolist(),
            },
            {"bufferView": 1, "componentType": 5125, "count": len(indices), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": indices.nbytes},
        ],
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary))
    chunks = (
        struct.pack("<I4s", len(text), b"JSON"),
        text,
        struct.pack("<I4s", len(binary), b"BIN\0"),
        binary,
    )
    return head + b"".join(chunks)


def queries(finder: Any) -> dict[str, Any]:
    """Some of the arrays of a *_queries.npz, of a mesh."""
    random = np.random.default_rng(5)
    point = random.uniform(-3, 3, (40, 3)).astype(np.float32)
    path_end = random.uniform(-2, 2, (40, 3)).astype(np.float32)
    finder.seed(3)
    drawn = [list(finder.get_random_navigable_point()) for _ in range(4)]
    paths = []
    for start, end in zip(point, path_end):
        path = habitat_sim.ShortestPath()
        path.requested_start, path.requested_end = start, end
        finder.find_path(path)
        paths.append(path)
    return {
        "random_seeds": np.array([3], np.uint32),
        "random_points": np.array([drawn], np.float32),
        "point": point,
        "snap_island_index": np.zeros(40, np.int32),
        "snap": np.array([list(finder.snap_point(p)) for p in point], np.float32),
        "is_navigable": np.array([finder.is_navigable(p) for p in point]),
        "obstacle_dist": np.array([finder.distance_to_closest_obstacle(p) for p in point], np.float32),
        "path_start": point,
        "path_end": path_end,
        "path_distance": np.array([path.geodesic_distance for path in paths], np.float32),
        "path_points": np.array([len(path.points) for path in paths], np.int32),
        "path_point_list": np.array([list(p) for path in paths for p in path.points], np.float32),
        "step_from": point,
        "step_to": path_end,
        "step_sliding": np.array(
            [list(finder.try_step(a, b)) for a, b in zip(point, path_end)], np.float32
        ),
    }


def walk(glb: Path) -> dict[str, Any]:
    """The arrays of a walk of 30 actions against the block."""
    actions = np.array([[0, 0, 0, 1, 0, 0, 0, 0, 3, 0] * 3], np.uint8)
    names = ("move_forward", "turn_left", "turn_right", "look_up", "look_down")
    eye = [check_scenes.camera("rgb", "COLOR", 8, 8)]
    with check_scenes.simulator(glb, sensors=eye) as sim:
        settings = habitat_sim.NavMeshSettings()
        settings.set_defaults()
        sim.recompute_navmesh(sim.pathfinder, settings)
        agent = sim.get_agent(0)
        begin = habitat_sim.AgentState()
        begin.position = np.array([0.1, 0.0, 2.0])
        agent.set_state(begin, True)
        position, collided = [], []
        for action in actions[0]:
            collided.append(bool(agent.act(names[action])))
            position.append(np.array(agent.get_state().position, np.float32))
    assert any(collided) and not all(collided)
    group = "r2r-ce_turn15_slide_"
    return {
        group + "start": np.array([[0.1, 0.0, 2.0]], np.float32),
        group + "start_rotation": np.array([[0, 0, 0, 1]], np.float32),
        group + "actions": actions,
        group + "position": np.array([position]),
        group + "collided": np.array([collided]),
    }


def api() -> dict[str, Any]:
    """Some of what api.json has, of this module."""
    settings, camera = habitat_sim.NavMeshSettings(), habitat_sim.CameraSensorSpec()
    spec = habitat_sim.AgentConfiguration().action_space["turn_left"]
    return {
        "version": habitat_sim.__version__,
        "built_with_bullet": False,
        "NavMeshSettings": {"cell_size": settings.cell_size},
        "NavMeshSettings.set_defaults": {"agent_radius": settings.agent_radius},
        "CameraSensorSpec": {"hfov": str(camera.hfov), "position": "Vector(0, 1.5, 0)", "channels": 4},
        "AgentConfiguration": {
            "radius": 0.1,
            "action_space": {"turn_left": ["turn_left", spec.actuation.amount, None]},
        },
        "AgentState": str(habitat_sim.AgentState()),
        "SensorSubType": {name: int(one) for name, one in habitat_sim.SensorSubType.__members__.items()},
        "methods": {"Simulator": ["cast_ray", "step"], "Agent": ["act"], "SceneNode": ["rotate"]},
        "move_functions": ["move_up", "pyrobot_noisy_turn_left"],
        "modules": {"simulator": ["Any", "Simulator", "np"], "geo": ["OBB", "Ray"]},
        "geo": {"FRONT": "Vector(-0, -0, -1)"},
        "utils.common": ["quat_from_coeffs"],
    }


def write_walks_of_a_stub(folder: Path) -> None:
    """lab/streamvln_stub.json, of this module: two walks down the room, the second to and fro."""
    texts = ["go ↑↑↑↑", "STOP", "↑↑↑↑", "↑↑↑↑", "←" * 12, "↑↑↑↑", "none"]
    goals, told = ([-2.0, 0.0, -1.0], [-2.0, 0.0, 1.0]), ("Walk on.", "Walk to and fro.")
    episodes = [
        {
            "episode_id": k + 7,
            "scene_id": "mp3d/tiny/tiny.glb",
            "start_position": [-2.0, 0.0, 2.0],
            "start_rotation": [0.0, 0.0, 0.0, 1.0],
            "goals": [{"position": goal, "radius": 3.0}],
            "instruction": {"instruction_text": words},
        }
        for k, (goal, words) in enumerate(zip(goals, told))
    ]
    (folder / "scenes/vlnce").mkdir()
    other = {**episodes[0], "episode_id": 8}  # the second's id, in another split
    for split, some in (("train", [other]), ("val", episodes)):
        with gzip.open(folder / f"scenes/vlnce/{split}.json.gz", "wt") as file:
            json.dump({"episodes": some}, file)
    job = check_scenes.Job(folder, "streamvln", folder / "scenes")
    answers, results = iter(texts), []
    for episode in episodes:
        wanted = {"scene_id": "tiny", "episode_id": episode["episode_id"]}
        results.append(streamvln._result(job, wanted, episode, streamvln._actions(answers)))
    (folder / "lab").mkdir()
    (folder / "lab/streamvln_stub.json").write_text(json.dumps({"texts": texts, "results": results}))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small recording of this module itself, and its scene in scenes/."""
    folder = tmp_path_factory.mktemp("recorded")
    glb = tiny_glb()
    z_up = check_scenes.z_up(glb)
    scene = folder / "scenes/mp3d/tiny/tiny.glb"
    scene.parent.mkdir(parents=True)
    scene.write_bytes(z_up)
    homes = {"tiny": {"glb_sha256": check_scenes.sha256(glb), "z_up_sha256": check_scenes.sha256(z_up)}}
    (folder / "scenes.json").write_text(json.dumps({"homes": homes}))
    (folder / "nav").mkdir()
    with check_scenes.simulator(scene) as sim:
        settings, finder = habitat_sim.NavMeshSettings(), habitat_sim.PathFinder()
        settings.set_defaults()
        assert sim.recompute_navmesh(finder, settings)
    made = check_scenes.saved_mesh(finder)
    (folder / "nav/tiny_r2r-ce.navmesh.gz").write_bytes(gzip.compress(made))
    known = {
        "ok": True,
        "settings": {"agent_radius": settings.agent_radius, "agent_height": settings.agent_height},
        "bytes": len(made),
        "bounds": [[float(x) for x in corner] for corner in finder.get_bounds()],
        "navigable_area": finder.navigable_area,
        "island_area": [finder.island_area(i) for i in range(finder.num_islands)],
    }
    about = {"form": "mp3d", "habitat_sim_version": "0.3.3", "scenes": {"tiny": {"r2r-ce": known}}}
    (folder / "nav/navmeshes.json").write_text(json.dumps(about))
    np.savez_compressed(folder / "nav/tiny_r2r-ce_queries.npz", **queries(finder))
    (folder / "walks").mkdir()
    np.savez_compressed(folder / "walks/tiny_walks.npz", **walk(scene))
    (folder / "api.json").write_text(json.dumps(api()))
    write_walks_of_a_stub(folder)
    return folder


def last_line(done: subprocess.CompletedProcess[str]) -> str:
    return done.stdout.splitlines()[-1]


def test_equal_answers_are_no_mismatches(recorded: Path) -> None:
    done = check(recorded, "--scenes", recorded / "scenes")
    assert done.returncode == 0, done.stdout + done.stderr
    values, mismatches = (int(word) for word in last_line(done).split()[::2])
    assert values > 300 and mismatches == 0
    assert "follower: not recorded here" in done.stdout
    assert "nav: done" in done.stderr
    assert "api: 31 values, 0 mismatches; 2 names left out on purpose" in done.stdout
    assert "streamvln: 16 values, 0 mismatches" in done.stdout


def test_a_part_that_cannot_run_is_left_out(recorded: Path) -> None:
    arguments = (recorded, "--scenes", recorded / "scenes", "--only", "nav")
    done = check(*arguments)
    assert "left out: home_islands: there is no" not in done.stdout  # it was not recorded
    file = recorded / "nav/navmeshes.json"
    text = file.read_text()
    file.write_text(text.replace('"ok": true', '"ok": true, "home_islands": {"0": 1}'))
    try:
        done, strict = check(*arguments), check(*arguments, "--strict")
    finally:
        file.write_text(text)
    assert "left out: home_islands: there is no" in done.stdout
    assert (done.returncode, strict.returncode) == (0, 1)


@pytest.mark.parametrize(
    ("file", "name", "at"),
    [
        ("nav/tiny_r2r-ce_queries.npz", "snap", (1, 0)),
        ("nav/tiny_r2r-ce_queries.npz", "step_sliding", (7, 2)),
        ("walks/tiny_walks.npz", "r2r-ce_turn15_slide_position", (0, 12, 0)),
        ("walks/tiny_walks.npz", "r2r-ce_turn15_slide_collided", (0, 3)),
    ],
)
def test_a_changed_number_is_found(recorded: Path, file: str, name: str, at: tuple[int, ...]) -> None:
    path = recorded / file
    before = path.read_bytes()
    with np.load(path) as arrays:
        changed = {key: arrays[key].copy() for key in arrays.files}
    value = changed[name][at]
    changed[name][at] = (
        not value if value.dtype == bool else np.nextafter(np.nan_to_num(value), np.float32(9))
    )
    np.savez_compressed(path, **changed)
    try:
        done = check(recorded, "--scenes", recorded / "scenes", "--only", path.parent.name)
    finally:
        path.write_bytes(before)
    assert done.returncode == 1, done.stdout + done.stderr
    assert last_line(done).endswith(" 1 mismatches")
    index = at if value.dtype == bool else at[:-1]
    assert f"{file}: {name}[{', '.join(map(str, index))}]: wanted" in done.stdout


def check_changed(recorded: Path, name: str, change: Any) -> Tally:
    """What is found after a change of a JSON file."""
    file = recorded / name
    text = file.read_text()
    known = json.loads(text)
    change(known)
    file.write_text(json.dumps(known))
    section = "api" if name == "api.json" else "streamvln"
    tally = Tally()
    try:
        for part in SECTIONS[section].parts(file.parent):
            tally.add(check_part(check_scenes.Job(recorded, section, recorded / "scenes"), part))
    finally:
        file.write_text(text)
    return tally


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("CameraSensorSpec", "channels"), 3, "CameraSensorSpec.channels: wanted 3, found 4"),
        (("CameraSensorSpec", "hfov"), "Deg(60)", "CameraSensorSpec.hfov: wanted Deg(60), found Deg(90)"),
        (("NavMeshSettings.set_defaults", "agent_radius"), 0.1, "set_defaults.agent_radius: wanted 0.1, "),
        (("AgentConfiguration", "colour"), "red", "AgentConfiguration.colour: wanted red, found missing"),
        (("AgentConfiguration", "action_space", "turn_left", 1), 15.0, "action_space.turn_left"),
        (("SensorSubType", "FISHEYE"), 9, "SensorSubType.FISHEYE: wanted 9, found 4"),
        (("SensorSubType", "LIDAR"), 9, "SensorSubType.LIDAR: wanted 9, found None"),
        (("methods", "Agent", 0), "fly", "methods.Agent.fly: wanted there, found missing"),
        (("methods", "Pilot"), ["act"], "methods.Pilot.act: wanted there, found missing"),
        (("modules", "geo", 0), "np", "modules.geo.np: wanted there, found missing"),
        (("utils.common", 0), "quat", "utils.common.quat: wanted there, found missing"),
        (("move_functions", 0), "swim", "move_functions.swim: wanted there, found missing: "),
        (("AgentState",), "", "AgentState: wanted , found AgentState("),
        (("geo", "FRONT"), "Vector(0, 0, 1)", "geo.FRONT: wanted Vector(0, 0, 1), "),
        (("built_with_bullet",), True, "built_with_bullet: wanted True, found False"),
    ],
)
def test_a_changed_name_or_default_is_found(
    recorded: Path, place: tuple[Any, ...], value: Any, words: str
) -> None:
    def change(known: Any) -> None:
        for key in place[:-1]:
            known = known[key]
        known[place[-1]] = value

    found = check_changed(recorded, "api.json", change)
    assert found.mismatches == 1 and words in found.shown[0]


def test_a_member_that_was_not_recorded_is_found(recorded: Path) -> None:
    found = check_changed(recorded, "api.json", lambda known: known["SensorSubType"].pop("FISHEYE"))
    assert found.shown == ["api.json: SensorSubType.FISHEYE: wanted None, found 4"]


def test_a_name_refused_without_words_is_not_there() -> None:
    from habitat_sim import _check_api as names
    from habitat_sim._missing import RefusedAttribute

    class Owner:
        silent, told = RefusedAttribute(" "), RefusedAttribute("use another")

    tally = Tally()
    names._names("methods.Owner", ["silent", "told"], Owner, tally)
    assert (tally.values, tally.mismatches) == (2, 1)
    assert tally.shown == ["api.json: methods.Owner.silent: wanted there, found refused without words"]


def test_a_stubs_walks_are_measured(recorded: Path) -> None:
    known = json.loads((recorded / "lab/streamvln_stub.json").read_text())
    first, second = known["results"]
    # One metre of three; two metres, turned around, and one back: to the goal, which lay at one.
    assert (first["success"], first["os"], first["spl"], first["steps"]) == (1, 1, 1, 5)
    assert first["ne"] == pytest.approx(2, abs=0.02)
    assert (second["success"], second["steps"]) == (1, 25)
    assert second["ne"] == pytest.approx(0, abs=0.05) and second["spl"] == pytest.approx(1 / 3, abs=0.02)


@pytest.mark.parametrize("field", ["success", "spl", "os", "ne", "steps"])
def test_a_changed_result_is_found(recorded: Path, field: str) -> None:
    def change(known: Any) -> None:
        known["results"][1][field] += 1e-9 if isinstance(known["results"][1][field], float) else 1

    found = check_changed(recorded, "lab/streamvln_stub.json", change)
    assert found.mismatches == 1
    assert found.shown[0].startswith(f"lab/streamvln_stub.json: results[1].{field}: wanted")


def test_a_result_of_another_episode_is_found(recorded: Path) -> None:
    def change(known: Any) -> None:
        known["results"][0]["episode_id"] = 99

    found = check_changed(recorded, "lab/streamvln_stub.json", change)
    assert found.shown == ["lab/streamvln_stub.json: results[0].episode_id: wanted 99, found None"]


def test_without_episodes_a_stub_is_left_out(recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "mp3d").symlink_to(recorded / "scenes/mp3d")
    done = check(recorded, "--scenes", tmp_path, "--only", "streamvln")
    assert done.returncode == 2 and "left out: there are no episodes in" in done.stdout


def test_a_folder_that_is_none(tmp_path: Path) -> None:
    done = check(tmp_path)
    assert done.returncode == 2 and "no folder of recordings: it has no scenes.json" in done.stderr
    (tmp_path / "scenes.json").write_text('{"homes": {"a": {}}}')
    done = check(tmp_path)
    assert done.returncode == 2 and "it has no recordings of api, nav" in done.stderr
    done = check(tmp_path, "--only", "nav,jumps")
    assert done.returncode == 2 and "'jumps' is not one of api, nav" in done.stderr


def test_other_scenes_are_refused(recorded: Path, tmp_path: Path) -> None:
    scene = tmp_path / "mp3d/tiny/tiny.glb"
    scene.parent.mkdir(parents=True)
    scene.write_bytes(tiny_glb())
    done = check(recorded, "--scenes", tmp_path)
    assert done.returncode == 2 and "other scenes than those recorded" in done.stderr
    done = check(recorded)
    assert done.returncode == 2 and "name a folder with --scenes" in done.stderr
