"""Model homes (SYNTHETIC) on Habitat's floor, as habitat-lab opens them. A plugin of pytest, for its fixtures."""

from __future__ import annotations

import gzip
import json
import math
import os
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from programs import run

EPISODES = int(os.environ.get("ENFILADE_HABITAT_EPISODES", "20"))
PATHS_OF_A_HOME = 20


def z_up(glb: bytes) -> bytes:
    """A GLB whose +y is up as one whose +z is: its nodes become children of one that is turned."""
    (size,) = struct.unpack_from("<I", glb, 12)
    gltf, rest = json.loads(glb[20 : 20 + size]), glb[20 + size :]
    scene = gltf["scenes"][gltf.get("scene", 0)]
    half = math.sqrt(0.5)
    gltf["nodes"].append({"rotation": [half, 0, 0, half], "children": scene["nodes"]})
    scene["nodes"] = [len(gltf["nodes"]) - 1]
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<IIIII", 0x46546C67, 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    return head + text + rest


@dataclass(frozen=True)
class FloorHomes:
    """`data` is the data set; `scenes` has mp3d/SCAN/SCAN.glb, z up, with the navigation mesh beside it."""

    data: Path
    scenes: Path
    split: str
    episodes: list[dict[str, Any]]  # at most EPISODES of the split, evenly chosen, as the file has them
    file: Path  # of these

    def mesh(self, scan: str) -> Path:
        """The home's own mesh, y up."""
        return next(self.data.glob(f"v1/scans/{scan}/matterport_mesh/*/*.glb"))

    def navmesh(self, scan: str) -> Path:
        return self.data / "navmesh" / "r2r-ce" / f"{scan}.navmesh"

    def options(self) -> list[str]:
        """Of habitat-lab's configuration of VLN: these episodes in their order, small pictures."""
        sensors = "habitat.simulator.agents.main_agent.sim_sensors"
        return [
            f"habitat.dataset.data_path={self.file}", f"habitat.dataset.scenes_dir={self.scenes}",
            "habitat.simulator.scene_dataset=default", "habitat.simulator.habitat_sim_v0.gpu_device_id=-1",
            "habitat.environment.iterator_options.shuffle=False",
            "habitat.environment.iterator_options.max_scene_repeat_steps=-1",
            *(f"{sensors}.{s}_sensor.{side}=16" for s in ("rgb", "depth") for side in ("width", "height")),
        ]  # fmt: skip


def read_packed(file: Path) -> Any:
    with gzip.open(file, "rt", encoding="utf-8") as packed:
        return json.load(packed)


@pytest.fixture(scope="session")
def floor_homes(tmp_path_factory: pytest.TempPathFactory) -> FloorHomes:
    folder = tmp_path_factory.mktemp("floor")
    data, scenes = folder / "homes", folder / "scenes"
    homes = 3 + EPISODES // (2 * PATHS_OF_A_HOME)  # an instruction or more a path, in several splits
    run(
        "homes", "-o", data, "--homes", homes, "--seed", 11, "--size", 0, "--paths", PATHS_OF_A_HOME,
        "--parts", "mesh", "--tasks", "r2r",
    )  # fmt: skip
    run("continuous", data, "--navmesh", "habitat")
    files = [f for f in (data / "vlnce").glob("*.json.gz") if not f.name.endswith("_gt.json.gz")]
    whole = {f.name[: -len(".json.gz")]: read_packed(f) for f in files}
    split = max(
        (name for name in whole if all("goals" in e for e in whole[name]["episodes"])),
        key=lambda name: len(whole[name]["episodes"]),
    )
    every = whole[split]["episodes"]
    count = min(EPISODES, len(every))
    chosen = [every[k * len(every) // count] for k in range(count)]
    made = FloorHomes(data, scenes, split, chosen, folder / "episodes.json.gz")
    with gzip.open(made.file, "wt", encoding="utf-8") as packed:
        json.dump({"episodes": chosen, "instruction_vocab": whole[split]["instruction_vocab"]}, packed)
    for scan in {Path(e["scene_id"]).stem for e in chosen}:
        place = scenes / "mp3d" / scan
        place.mkdir(parents=True)
        (place / f"{scan}.glb").write_bytes(z_up(made.mesh(scan).read_bytes()))
        (place / f"{scan}.navmesh").write_bytes(made.navmesh(scan).read_bytes())
    return made
