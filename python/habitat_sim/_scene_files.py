"""Which files a scene has, and which of their axes points up."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional

from habitat_sim._missing import NotThere
from habitat_sim.logging import logger


@dataclass(frozen=True)
class SceneFile:
    """A mesh file; `up` is its axis: "y" or "z". `semantic` is the file of labels, "" for none, whose up and front
    are those that the scene dataset gives it, or the scene's."""

    path: str
    up: str
    semantic: str = ""
    semantic_axes: tuple[float, ...] = (0, 0, 1, 0, 1, 0)

    @property
    def navmesh(self) -> str:
        """The navigation mesh beside it."""
        return os.path.splitext(self.path)[0] + ".navmesh"

    @property
    def house(self) -> str:
        """The file of labels beside it, z up whatever the mesh is."""
        return os.path.splitext(self.path)[0] + ".house"

    def labels(self) -> Optional[tuple[str, str]]:
        """The mesh of labels, and the axis by which Habitat turns it; None without one.

        Raises NotImplementedError for files and axes that Enfilade does not draw.
        """
        if not self.semantic:
            return None
        if not self.semantic.endswith(".ply"):
            raise NotThere(
                f"semantic_asset '{self.semantic}': Enfilade draws labels of .ply files only"
            )
        up = _UP.get(self.semantic_axes)
        if up is None:
            x = self.semantic_axes
            raise NotThere(
                f"semantic_up {list(x[:3])} and semantic_front {list(x[3:])} of stages{_AXES}"
            )
        return self.semantic, up


# Habitat takes a .glb to be z up, but y up in a scene dataset that has default_attributes without an axis.
_UP: dict[tuple[float, ...], str] = {(0, 0, 1, 0, 1, 0): "z", (0, 1, 0, 0, 0, -1): "y"}
_AXES = "; Enfilade has up [0, 1, 0] and front [0, 0, -1], or up [0, 0, 1] and front [0, 1, 0]"
_NAME = "%%CONFIG_NAME_AS_ASSET_FILENAME%%"  # stands for the scene's name


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

    def axis(name: str, usual: list[int]) -> list[Any]:
        given = defaults.get(name, usual)
        if not (isinstance(given, list) and all(isinstance(x, (int, float)) for x in given)):
            raise ValueError(f"{dataset}: {name} {given!r} of stages is not a list of numbers")
        return given

    if "default_attributes" in stages:
        axes = axis("up", [0, 1, 0]) + axis("front", [0, 0, -1])
    else:
        axes = [0, 0, 1, 0, 1, 0]
    up = _UP.get(tuple(axes))
    if up is None:
        raise NotThere(f"{dataset}: up {axes[:3]} and front {axes[3:]} of stages{_AXES}")
    if "semantic_up" in defaults or "semantic_front" in defaults:
        axes = axis("semantic_up", [0, 1, 0]) + axis("semantic_front", [0, 0, -1])
    asset = defaults.get("semantic_asset", "")
    if not isinstance(asset, str):
        raise ValueError(f"{dataset}: semantic_asset {asset!r} of stages is not text")
    return SceneFile(path, up, _semantic(path, asset, Path(dataset).parent), tuple(axes))


def _semantic(path: str, asset: str, folder: Path) -> str:
    """The file of labels that a dataset in `folder` names, else the one beside the scene; "" for none."""
    stem = os.path.splitext(path)[0]
    if asset:
        wanted = asset.replace(_NAME, os.path.splitext(os.path.basename(stem))[0])
        for place in (folder, Path(path).parent):
            if (place / wanted).is_file():
                return str(place / wanted)
        if _NAME not in asset:
            logger.warning(f"semantic_asset '{asset}': no such file; the semantic sensor sees zeros")
            return ""
    beside = stem + "_semantic.ply"
    return beside if os.path.exists(beside) else ""


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
