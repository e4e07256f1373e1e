"""Which mesh file a scene is, and which of its axes points up."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional

from habitat_sim._missing import NotThere


@dataclass(frozen=True)
class SceneFile:
    """A mesh file; `up` is its axis: "y" or "z"."""

    path: str
    up: str

    @property
    def navmesh(self) -> str:
        """The navigation mesh beside it."""
        return os.path.splitext(self.path)[0] + ".navmesh"

    @property
    def house(self) -> str:
        """The file of labels beside it, z up whatever the mesh is."""
        return os.path.splitext(self.path)[0] + ".house"


# Habitat takes every .glb to be z up, unless a scene dataset says otherwise.
_BY_PATH = ([0, 0, 1], [0, 1, 0])
_UP = {(0, 0, 1, 0, 1, 0): "z", (0, 1, 0, 0, 0, -1): "y"}


def find_scene(scene_id: str, dataset: str) -> Optional[SceneFile]:
    """The file of a scene, which is a path, or the name of a stage of the dataset; None for an empty scene.

    Raises FileNotFoundError, and NotImplementedError for what Enfilade does not open.
    """
    if scene_id in ("", "NONE"):
        return None
    stages = {} if dataset in ("", "default") else _stages(dataset)
    path = scene_id if os.path.exists(scene_id) else _named(scene_id, stages, Path(dataset).parent)
    if path is None:
        where = f", and no stage of {dataset}" if stages else ""
        raise FileNotFoundError(f"scene_id '{scene_id}': no such file{where}")
    if not path.endswith(".glb"):
        raise NotThere(
            f"scene_id '{scene_id}': Enfilade opens .glb files; an instance of a scene is none"
        )
    defaults = stages.get("default_attributes", {})
    axes = [defaults.get(key, value) for key, value in zip(("up", "front"), _BY_PATH)]
    up = _UP.get(tuple(axes[0] + axes[1]))
    if up is None:
        raise NotThere(
            f"{dataset}: up {axes[0]} and front {axes[1]} of stages; Enfilade has up [0, 1, 0] and "
            "front [0, 0, -1], or up [0, 0, 1] and front [0, 1, 0]"
        )
    return SceneFile(path, up)


def _stages(dataset: str) -> dict[str, Any]:
    try:
        text = Path(dataset).read_text()
    except OSError as error:
        raise FileNotFoundError(f"scene_dataset_config_file '{dataset}': {error.strerror}") from error
    try:
        stages = json.loads(text)["stages"]
        return dict(stages)
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f'{dataset}: a JSON object with "stages" is wanted') from error


def _named(scene_id: str, stages: dict[str, Any], folder: Path) -> Optional[str]:
    for pattern in stages.get("paths", {}).get(".glb", []):
        for file in sorted(folder.glob(pattern)):
            files = [file] if file.is_file() else sorted(file.glob("*.glb"))
            for one in files:
                if scene_id in (one.stem, one.name):
                    return str(one)
    return None
