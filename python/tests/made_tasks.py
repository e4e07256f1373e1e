"""A tiny data set of every benchmark, and results for it. SYNTHETIC: made here, over made graphs."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import enfilade
from enfilade import goals

CORNERS = ("left_top", "right_top", "right_bottom", "left_bottom")


def walks(graph: Any, n: int, least: int = 4) -> list[list[str]]:
    """Shortest paths of some viewpoints."""
    ids = [v for v in graph if graph.included(v)]
    found = []
    for a in ids:
        for b in reversed(ids):
            path = graph.path(a, b)
            if path and len(path) >= least:
                found.append(path)
                break
        if len(found) == n:
            break
    return found


def make_tasks(small: str, folder: Path) -> None:
    """Writes a tiny split of each benchmark into a folder, over the graphs of another data set."""
    shutil.copytree(Path(small) / "connectivity", folder / "connectivity")
    graphs = enfilade.Graphs(folder / "connectivity")
    scan = graphs.scans[0]
    paths = walks(graphs[scan], 3)
    assert len(paths) == 3

    def write(name: str, records: list[Any], lines: bool = False) -> None:
        file = folder / name
        file.parent.mkdir(exist_ok=True)
        text = "\n".join(map(json.dumps, records)) if lines else json.dumps(records)
        file.write_text(text)

    common = [
        {"path_id": i, "scan": scan, "heading": 1.0, "path": p, "instructions": ["Go.", "Walk."]}
        for i, p in enumerate(paths)
    ]
    write("r4r/R4R_val_unseen.json", common)
    write("r2r/R2R_val_unseen.json", [{**c, "instructions": ["A.", "B.", "C.", "D."]} for c in common])
    back = [{**c, "midstop": c["path"][2]} for c in common]
    write("r2r-back/R2R_val_unseen.json", back)
    write(
        "rxr/rxr_val_unseen_guide.jsonl",
        [
            {
                "path_id": i, "split": "val_unseen", "scan": scan, "heading": 0.5, "path": p,
                "instruction_id": 100 + i, "annotator_id": 1, "language": "hi-IN", "edit_distance": 0.0,
                "instruction": "Turn around",
                "timed_instruction": [
                    {"word": "Turn", "start_time": 0.5, "end_time": 0.75}, {"word": "around"}
                ],
            }
            for i, p in enumerate(paths)
        ],
        lines=True,
    )  # fmt: skip
    write(
        "cvdn/val_unseen.json",
        [
            {
                "inst_idx": i, "scan": scan, "target": "plant", "game_idx": i, "nav_history": [p[0]],
                "start_pano": {"heading": 1.2, "elevation": 0.0, "pano": p[0]}, "nav_camera": [],
                "dialog_history": [
                    {"nav_idx": 0, "role": "navigator", "message": "Left?"},
                    {"nav_idx": 0, "role": "oracle", "message": "Yes."},
                ],
                "end_panos": [p[-1]], "player_path": p, "planner_path": p,
            }
            for i, p in enumerate(paths)
        ],
    )  # fmt: skip
    corner = {name: {"heading": h, "elevation": e} for name, h, e in zip(
        CORNERS, (1.0, 2.0, 2.0, 1.0), (0.5, 0.5, -0.5, -0.5))}  # fmt: skip
    write(
        "soon/val_unseen_instrs.json",
        [
            {
                "path": [p], "instructions": [["plant", "green", "by a door", "hall", "Find the plant."]],
                "bboxes": [{
                    "scan": scan, "image_id": p[-1], "heading": 0.0, "elevation": 0.0, "obj_name": "plant",
                    "target": {"center": {"heading": 1.5, "elevation": 0.0}, **corner},
                }],
            }
            for p in paths
        ],
    )  # fmt: skip
    write_reverie(folder, "val_unseen", [(scan, path) for path in paths])


def write_reverie(folder: Path, split: str, paths: list[tuple[str, Any]]) -> None:
    """A split of REVERIE whose paths all end where object 7 is seen, and the boxes. SYNTHETIC."""
    (folder / "reverie").mkdir(exist_ok=True)
    records = [
        {
            "id": f"{i}_7", "path_id": i, "scan": scan, "heading": 0.1, "path": list(path), "objId": 7,
            "distance": 5.0, "instructions": ["Clean the pot"], "instructions_l": ["Clean"],
        }
        for i, (scan, path) in enumerate(paths)
    ]  # fmt: skip
    (folder / "reverie" / f"REVERIE_{split}.json").write_text(json.dumps(records))
    seen = {"7": {"name": "plant#pot", "visible_pos": [12, 13], "bbox2d": [[1, 2, 3, 4], [5, 6, 7, 8]]}}
    file = folder / "reverie" / "BBoxes.json"
    boxes = json.loads(file.read_text()) if file.exists() else {}
    boxes.update({f"{scan}_{path[-1]}": {path[-1]: seen} for scan, path in paths})
    file.write_text(json.dumps(boxes))


SPLITS = {"r2r": "val_unseen", "r2r-back": "val_unseen", "r4r": "val_unseen", "rxr": "val_unseen",
          "reverie": "val_unseen", "cvdn": "val_unseen", "soon": "val_unseen_instrs"}  # fmt: skip


def results_of(episodes: enfilade.Episodes, right: bool = True) -> list[dict[str, Any]]:
    """What an agent would hand in that walks the reference path, or that stays."""
    found = []
    for e in episodes:
        path: Any = [[v, 0.0, 0.0] for v in (e.path if right else e.path[:1])]
        row: dict[str, Any] = {"instr_id": e.instruction_id, "trajectory": path}
        if isinstance(e.goal, goals.Object):
            row["pred_objid"] = e.goal.id if right else None
        if isinstance(e.goal, goals.TurningPoint):
            row["midstop"] = e.goal.viewpoint if right else None
        if isinstance(e.goal, goals.Boxes):
            h, v = e.goal.boxes[0].centre
            point = {"obj_heading": [h / 2 / math.pi], "obj_elevation": [(v + math.pi) / 2 / math.pi]}
            row["trajectory"] = {"path": [[p[0]] for p in path], **(point if right else {
                "obj_heading": None, "obj_elevation": None})}  # fmt: skip
        found.append(row)
    return found
