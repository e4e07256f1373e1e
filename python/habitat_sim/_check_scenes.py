"""The scenes of a folder of recordings, and what is opened of them. For habitat_sim.check."""

from __future__ import annotations

import contextlib
import gzip
import hashlib
import json
import re
import shlex
import shutil
import struct
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional

import habitat_sim
import numpy as np

from ._check_tally import LeftOutError

DATASET = {
    "stages": {
        "default_attributes": {"up": [0, 1, 0], "front": [0, 0, -1]},
        "paths": {".glb": ["*.glb"]},
    }
}
"""The scene dataset that turns nothing: y up."""

BODIES = {"r2r-ce": (0.1, 1.5), "rxr-ce": (0.18, 0.88), "stretch": (0.17, 1.41)}
"""Radius and height, metres, where no navmeshes.json has them."""


class CheckError(Exception):
    """The check cannot begin. The message says why."""


@dataclass(frozen=True)
class Job:
    """What every part of a section needs."""

    recordings: Path
    folder: str  # of the section
    scenes: Path

    @property
    def here(self) -> Path:
        return self.recordings / self.folder

    def glb(self, scan: str, form: str = "mp3d") -> Path:
        """A scene's file. Raises LeftOutError if there is none."""
        file = self.scenes / ("yup" if form == "config" else f"mp3d/{scan}") / f"{scan}.glb"
        if not file.is_file():
            raise LeftOutError(f"there is no {file}")
        return file


def read_json(file: Path) -> Any:
    """Raises CheckError, naming the file."""
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as e:
        raise CheckError(f"{file}: {e}") from None


def read_lines(file: Path) -> list[Any]:
    """The values of a .jsonl.gz."""
    with gzip.open(file, "rt", encoding="utf-8") as lines:
        return [json.loads(line) for line in lines]


def sha256(data: Any) -> str:
    """Of bytes, or of an array's."""
    return hashlib.sha256(data if isinstance(data, bytes) else data.tobytes()).hexdigest()


def z_up(glb: bytes) -> bytes:
    """A .glb with y up as one with z up: every position and normal (x, y, z) becomes (x, -z, y)."""
    length = struct.unpack_from("<I", glb, 12)[0]
    tree = json.loads(glb[20 : 20 + length])
    binary = bytearray(glb[28 + length :])
    primitives = [p for mesh in tree["meshes"] for p in mesh["primitives"]]
    turned = {
        p["attributes"][name]
        for p in primitives
        for name in ("POSITION", "NORMAL")
        if name in p["attributes"]
    }
    for accessor in (tree["accessors"][i] for i in turned):
        view = tree["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        steps = (view.get("byteStride", 12), 4)
        points: Any = np.ndarray((accessor["count"], 3), np.float32, binary, start, steps)
        points[:] = np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=-1)
        if "min" in accessor:
            low, high = accessor["min"], accessor["max"]
            accessor["min"], accessor["max"] = [low[0], -high[2], low[1]], [high[0], -low[2], high[1]]
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary))
    return b"".join(
        [
            head,
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(binary), b"BIN\0"),
            binary,
        ]
    )


def check_scenes(recorded: dict[str, Any], scenes: Path) -> None:
    """Raises CheckError for a scene that is missing, or not the recorded one."""
    for scan, known in recorded["homes"].items():
        _check_bytes(scenes / "mp3d" / scan / f"{scan}.glb", known["z_up_sha256"])
        y_up = scenes / "yup" / f"{scan}.glb"
        if y_up.exists():
            _check_bytes(y_up, known["glb_sha256"])


def make_scenes(recorded: dict[str, Any], folder: Path, program: Optional[str]) -> None:
    """Makes the scenes that were recorded with the program `enfilade`. Raises CheckError."""
    words = shlex.split(recorded.get("command", ""))
    if words[:2] != ["enfilade", "homes"]:
        raise CheckError(
            'scenes.json: "command" is not one of `enfilade homes`: name a folder with --scenes'
        )
    found = program or shutil.which("enfilade")
    if found is None:
        raise CheckError(
            "the program enfilade is not on PATH: name it with --program, or a folder with --scenes"
        )
    homes = folder / "homes"
    if "-o" in words:  # into our folder, whatever it says
        del words[words.index("-o") : words.index("-o") + 2]
    if "--homes" in words:  # as many as the last one that is wanted: homes do not depend on later ones
        at = words.index("--homes") + 1
        last = [int(n) for scan in recorded["homes"] for n in re.findall(r"^home(\d+)$", scan)]
        words[at] = str(max([int(words[at]), *last]))
    _run([found, "homes", "-o", str(homes), *words[2:]])
    (folder / "yup").mkdir()
    (folder / "yup/homes.scene_dataset_config.json").write_text(json.dumps(DATASET), encoding="utf-8")
    for scan, known in recorded["homes"].items():
        files = sorted((homes / "v1/scans" / scan / "matterport_mesh").glob("*/*.glb"))
        if not files:
            raise CheckError(f"scenes.json: {scan} is none of the homes that its command makes")
        _check_bytes(files[0], known["glb_sha256"])
        shutil.copy(files[0], folder / "yup" / f"{scan}.glb")
        opened = folder / "mp3d" / scan
        opened.mkdir(parents=True)
        (opened / f"{scan}.glb").write_bytes(z_up(files[0].read_bytes()))
        house = homes / "v1/scans" / scan / "house_segmentations" / f"{scan}.house"
        if house.exists():
            shutil.copy(house, opened / house.name)
    shutil.copytree(homes / "connectivity", folder / "connectivity")
    check_scenes(recorded, folder)


def make_episodes(scenes: Path, program: Optional[str]) -> None:
    """Derives the episodes for habitat-lab of homes that make_scenes() has made: SCENES/vlnce/."""
    _run([str(program or shutil.which("enfilade")), "continuous", str(scenes / "homes")])
    (scenes / "homes/vlnce").rename(scenes / "vlnce")


def _run(command: list[str]) -> None:
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace")
    except OSError as e:
        raise CheckError(f"{command[0]}: {e.strerror}") from None
    if done.returncode != 0:
        raise CheckError(f"{shlex.join(command)}: {done.stderr.strip()[-400:]}")


def _check_bytes(file: Path, wanted: str) -> None:
    try:
        found = sha256(file.read_bytes())
    except OSError as e:
        raise CheckError(f"{file}: {e.strerror}") from None
    if found != wanted:
        raise CheckError(
            f"{file}: its SHA-256 is {found}, but {wanted} in scenes.json: these are other scenes than those recorded"
        )


def choose_navigation(folder: str) -> None:
    """Chooses the navigation that a section was recorded with. Raises LeftOutError if there is no choice."""
    name = "0.3.3" if folder.endswith("_v0.3.3") else "latest"
    if hasattr(habitat_sim.nav, "navigation"):
        habitat_sim.nav.navigation = name
    elif name != "latest":
        raise LeftOutError("this habitat_sim has only one navigation")


def settings_of(job: Job, body: str) -> Any:
    """NavMeshSettings of a body: its radius and height are those of the recorded navmeshes.json."""
    settings = habitat_sim.NavMeshSettings()
    settings.set_defaults()
    settings.agent_radius, settings.agent_height = body_size(job, body)
    return settings


def body_size(job: Job, body: str) -> tuple[float, float]:
    """Radius and height, metres."""
    for file in sorted(job.recordings.glob("nav*/navmeshes.json")):
        for bodies in read_json(file)["scenes"].values():
            if body in bodies:
                known = bodies[body]["settings"]
                return known["agent_radius"], known["agent_height"]
    if body not in BODIES:
        raise CheckError(f"{job.folder}: no navmeshes.json has the body {body}")
    return BODIES[body]


def action_space(turn: float) -> dict[str, Any]:
    """The recorded agents' actions."""
    amounts = {
        "move_forward": 0.25,
        "turn_left": turn,
        "turn_right": turn,
        "look_up": 30.0,
        "look_down": 30.0,
    }
    spec, amount = habitat_sim.agent.ActionSpec, habitat_sim.agent.ActuationSpec
    return {name: spec(name, amount(much)) for name, much in amounts.items()}


@contextlib.contextmanager
def simulator(
    glb: Path,
    dataset: Optional[Path] = None,
    size: tuple[float, float] = BODIES["r2r-ce"],
    sliding: bool = True,
    turn: float = 15.0,
    sensors: Any = (),
    semantic: bool = False,
) -> Iterator[Any]:
    """A simulator of a scene with one agent."""
    chosen = habitat_sim.SimulatorConfiguration()
    chosen.scene_id = str(glb)
    if dataset is not None:
        chosen.scene_dataset_config_file = str(dataset)
    chosen.enable_physics = False
    chosen.allow_sliding = sliding
    chosen.gpu_device_id = -1
    chosen.load_semantic_mesh = semantic
    agent = habitat_sim.agent.AgentConfiguration()
    agent.radius, agent.height = size
    agent.sensor_specifications = list(sensors)
    agent.action_space = action_space(turn)
    sim = habitat_sim.Simulator(habitat_sim.Configuration(chosen, [agent]))
    try:
        yield sim
    finally:
        sim.close()


def camera(name: str, kind: str, height: int, width: int, hfov: float = 90.0) -> Any:
    """The specification of a pinhole camera at 1.25 m."""
    spec = habitat_sim.CameraSensorSpec()
    spec.uuid = name
    spec.sensor_type = getattr(habitat_sim.SensorType, kind)
    spec.sensor_subtype = habitat_sim.SensorSubType.PINHOLE
    spec.resolution = [height, width]
    spec.hfov = hfov
    spec.position = [0.0, 1.25, 0.0]
    spec.channels = 4 if kind == "COLOR" else 1
    return spec


def unpacked(file: Path) -> bytes:
    """The content of a .gz."""
    return gzip.decompress(file.read_bytes())


def load_mesh(finder: Any, data: bytes) -> bool:
    """Loads the bytes of a .navmesh. Returns what load_nav_mesh() did."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "recorded.navmesh"
        file.write_bytes(data)
        return bool(finder.load_nav_mesh(str(file)))


def saved_mesh(finder: Any) -> bytes:
    """The bytes of the file that save_nav_mesh() writes."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "made.navmesh"
        finder.save_nav_mesh(str(file))
        return file.read_bytes()


def viewpoints(scenes: Path, scan: str) -> Any:
    """Where people stand in a home, on the floor, in Habitat's frame. Raises LeftOutError."""
    file = scenes / "connectivity" / f"{scan}_connectivity.json"
    if not file.is_file():
        raise LeftOutError(f"home_islands: there is no {file}")
    nodes = read_json(file)
    return np.array(
        [[n["pose"][3], n["pose"][11] - n["height"], -n["pose"][7]] for n in nodes], np.float32
    )
