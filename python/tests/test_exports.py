"""`enfilade export` and `convert`: what they write is read here by readers of our own, which follow the
descriptions of the files (docs/exports.md) and what the projects' code does with them."""

from __future__ import annotations

import gzip
import json
import math
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from programs import run

np = pytest.importorskip("numpy")

Home = dict[str, Any]


def h5py() -> Any:
    return pytest.importorskip("h5py", reason="h5py is not installed")


@pytest.fixture(scope="session")
def home(tmp_path_factory: pytest.TempPathFactory) -> Home:
    """A flat, synthetic, with coarse pictures and labelled mesh; and what its connectivity file says."""
    folder = tmp_path_factory.mktemp("exports") / "homes"
    run("homes", "-o", folder, "--preset", "small", "--homes", 1, "--size", 64, "--parts", "house")
    scan = (folder / "connectivity/scans.txt").read_text().split()[0]
    entries = json.loads((folder / f"connectivity/{scan}_connectivity.json").read_text())
    at = {
        e["image_id"]: np.array([e["pose"][3], e["pose"][7], e["pose"][11]])
        for e in entries
        if e["included"]
    }
    near: dict[str, list[str]] = {vp: [] for vp in at}
    for e in entries:
        if e["included"]:
            near[e["image_id"]] = [
                other["image_id"]
                for other, free in zip(entries, e["unobstructed"])
                if free and other["included"]
            ]
    return {
        "folder": folder,
        "scan": scan,
        "at": at,
        "near": near,
        "keys": {f"{scan}_{vp}" for vp in at},
    }


def export(home: Home, form: str, to: Path, *more: object) -> str:
    return run("export", "--as", form, "--data", home["folder"], "-o", to, *more)


def angles(home: Home, a: str, b: str) -> tuple[float, float, float]:
    """World heading and elevation from a to b, and metres."""
    dx, dy, dz = home["at"][b] - home["at"][a]
    flat = math.hypot(dx, dy)
    return math.atan2(dx, dy) % (2 * math.pi), math.atan2(dz, flat), math.hypot(flat, dz)


def from_views(heading: float, elevation: float) -> Any:
    """(36, 3): how far to the right and above the middle of each view, and the angle of both."""
    views = np.arange(36)
    right = heading - views % 12 * math.radians(30)
    right = (right + math.pi) % (2 * math.pi) - math.pi
    up = elevation - (views // 12 - 1) * math.radians(30)
    return np.stack([right, up, np.sqrt(right**2 + up**2)], axis=1)


def test_duet_candidates(home: Home, tmp_path: Path) -> None:
    export(home, "duet-candidates", tmp_path)
    table = json.loads((tmp_path / "scanvp_candview_relangles.json").read_text())
    assert set(table) == home["keys"]
    for vp, near in home["near"].items():
        found = table[f"{home['scan']}_{vp}"]
        assert set(found) == set(near)
        for other, (view, angle, right, up) in found.items():
            assert isinstance(view, int) and all(isinstance(x, float) for x in (angle, right, up))
            expected = from_views(*angles(home, vp, other)[:2])
            assert expected[:, 2].min() == pytest.approx(expected[view, 2], abs=1e-5)
            assert [right, up, angle] == pytest.approx(expected[view], abs=1e-5)


def test_langnav(home: Home, tmp_path: Path) -> None:
    export(home, "langnav", tmp_path / "adj_loc_dict.json")
    table = json.loads((tmp_path / "adj_loc_dict.json").read_text())
    assert set(table) == home["keys"]
    for vp, near in home["near"].items():
        candidates = table[f"{home['scan']}_{vp}"]
        assert len(candidates) == len(near), "its environment asserts as many as the graph's neighbours"
        assert {c["viewpointId"] for c in candidates} == set(near)
        for c in candidates:
            heading, elevation, _ = angles(home, vp, c["viewpointId"])
            assert c["scanId"] == home["scan"] and c["idx"] >= 1
            assert math.cos(c["normalized_heading"] - heading) == pytest.approx(1, abs=1e-9)
            assert c["elevation"] == pytest.approx(elevation, abs=1e-5)
            assert c["distance"] == pytest.approx(
                from_views(heading, elevation)[c["pointId"], 2], abs=1e-5
            )
            assert c["position"] == pytest.approx(home["at"][c["viewpointId"]], abs=1e-5)


def test_navgpt(home: Home, tmp_path: Path) -> None:
    export(home, "navgpt", tmp_path)
    table = json.loads((tmp_path / f"{home['scan']}_navigable.json").read_text())
    assert {vp: set(found) for vp, found in table.items()} == {
        vp: set(n) for vp, n in home["near"].items()
    }
    for vp, found in table.items():
        for other, c in found.items():
            heading, elevation, distance = angles(home, vp, other)
            assert math.cos(c["heading"] - heading) == pytest.approx(1, abs=1e-9)
            assert [c["elevation"], c["distance"]] == pytest.approx([elevation, distance], abs=1e-5)


def test_networkx(home: Home, tmp_path: Path) -> None:
    nx = pytest.importorskip("networkx", reason="networkx is not installed")
    export(home, "networkx", tmp_path, "--python", sys.executable)
    graphs = pickle.loads((tmp_path / "connectivity_graphs.pkl").read_bytes())
    graph = graphs[home["scan"]]
    assert type(graph) is nx.Graph and set(graph.nodes) == set(home["at"])
    assert {frozenset(e) for e in graph.edges} == {
        frozenset((a, b)) for a, n in home["near"].items() for b in n
    }
    for a, b, weight in graph.edges(data="weight"):
        assert weight == pytest.approx(angles(home, a, b)[2], abs=1e-9)
        assert graph[a][b] is graph[b][a], "one dictionary an edge, as networkx has it"
    for vp, (x, y, z) in home["at"].items():
        assert graph.nodes[vp]["world_position"] == pytest.approx([x, y, z], abs=1e-5)
        assert graph.nodes[vp]["position"] == pytest.approx([x, z, -y], abs=1e-5)
    lengths = dict(nx.all_pairs_dijkstra_path_length(graph, weight="weight"))
    distances = json.loads((tmp_path / f"distances/{home['scan']}.json").read_text())
    paths = json.loads((tmp_path / f"paths/{home['scan']}.json").read_text())
    assert {a: set(to) for a, to in distances.items()} == {a: set(to) for a, to in lengths.items()}
    for a, to in distances.items():
        assert to == pytest.approx(lengths[a], abs=1e-9)
        for b, path in paths[a].items():
            assert path[0] == a and path[-1] == b
            assert nx.path_weight(graph, path, "weight") == pytest.approx(to[b], abs=1e-9)
    other = graph.copy()
    other.add_edge("new", path[0], weight=1.0)
    assert nx.shortest_path_length(other, "new", path[0], weight="weight") == 1 and "new" not in graph


def test_networkx_without_a_list_of_scans(home: Home, tmp_path: Path) -> None:
    pytest.importorskip("networkx", reason="networkx is not installed")
    connectivity, store, scan = tmp_path / "connectivity", tmp_path / "stores/store", home["scan"]
    connectivity.mkdir()
    store.mkdir(parents=True)
    name = f"{scan}_connectivity.json"
    (connectivity / name).symlink_to(home["folder"] / "connectivity" / name)
    (store / f"{scan}.enfilade").symlink_to(home["folder"] / "store" / f"{scan}.enfilade")
    export(home, "networkx", tmp_path / "whole", "--python", sys.executable)
    whole = (tmp_path / "whole/connectivity_graphs.pkl").read_bytes()
    for given in (("--connectivity", connectivity, "--scans", scan), ("--data", tmp_path / "stores")):
        to = tmp_path / given[0]
        run("export", "--as", "networkx", *given, "-o", to, "--python", sys.executable)
        assert {file.name for file in to.iterdir()} == {"connectivity_graphs.pkl", "distances", "paths"}
        assert (to / "connectivity_graphs.pkl").read_bytes() == whole


def test_networkx_of_a_graph_with_a_one_way_edge(home: Home, tmp_path: Path) -> None:
    nx = pytest.importorskip("networkx", reason="networkx is not installed")
    file = f"connectivity/{home['scan']}_connectivity.json"
    entries = json.loads((home["folder"] / file).read_text())
    index = next(i for i, e in enumerate(entries) if e["included"] and any(e["unobstructed"]))
    other = entries[index]["unobstructed"].index(True)
    entries[index]["unobstructed"][other] = False
    (tmp_path / "connectivity").mkdir()
    (tmp_path / file).write_text(json.dumps(entries))
    (tmp_path / "connectivity/scans.txt").write_text(home["scan"] + "\n")
    connectivity = tmp_path / "connectivity"
    python = ("--python", sys.executable)
    run("export", "--as", "networkx", "--connectivity", connectivity, "-o", tmp_path, *python)
    graph = pickle.loads((tmp_path / "connectivity_graphs.pkl").read_bytes())[home["scan"]]
    assert type(graph) is nx.DiGraph
    a, b = entries[index]["image_id"], entries[other]["image_id"]
    assert graph.has_edge(b, a) and not graph.has_edge(a, b)
    assert b in graph.predecessors(a) and graph.succ[b][a] is graph.pred[a][b] is graph.adj[b][a]
    whole = {(v, w) for v, near in home["near"].items() for w in near}
    assert set(graph.edges) == whole - {(a, b)} == set(graph.reverse().reverse().edges)
    graph.remove_edge(b, a)
    assert b not in graph.pred[a] and nx.is_weakly_connected(graph)


def check_attributes(dataset: Any, home: Home, size: tuple[int, int, int]) -> None:
    attributes = dataset.attrs
    assert f"{attributes['scanId']}_{attributes['viewpointId']}" == dataset.name[1:]
    assert isinstance(attributes["scanId"], str) and attributes["scanId"] == home["scan"]
    assert (attributes["image_w"], attributes["image_h"], attributes["vfov"]) == size


def test_duet_hdf5(home: Home, tmp_path: Path) -> None:
    save_file = pytest.importorskip(
        "safetensors.numpy", reason="safetensors is not installed"
    ).save_file
    random = np.random.default_rng(1)
    views = {key: random.standard_normal((36, 12)).astype(np.float32) for key in home["keys"]}
    logits = {key: random.standard_normal((36, 5)).astype(np.float32) for key in home["keys"]}
    save_file(views, tmp_path / "views.safetensors")
    save_file(logits, tmp_path / "logits.safetensors")
    for name, dtype in {"f16": np.float16, "f32": np.float32, "f64": np.float64}.items():
        file = tmp_path / f"{name}.hdf5"
        export(home, "duet-hdf5", file, "--features", tmp_path / "views.safetensors", "--logits",
               tmp_path / "logits.safetensors", "--type", name)  # fmt: skip
        with h5py().File(file, "r") as root:
            assert set(root) == home["keys"]
            for key, dataset in root.items():
                assert (
                    dataset.shape == (36, 17)
                    and dataset.dtype == dtype
                    and dataset.compression == "gzip"
                )
                check_attributes(dataset, home, (640, 480, 60))
                read = dataset[...][:, :12].astype(np.float32)  # as HAMT and DUET read it
                assert (read == views[key].astype(dtype).astype(np.float32)).all()
                assert (dataset[...][:, 12:] == logits[key].astype(dtype)).all()
    assert not list(tmp_path.glob("*.parts"))


def test_object_hdf5(home: Home, tmp_path: Path) -> None:
    save_file = pytest.importorskip(
        "safetensors.numpy", reason="safetensors is not installed"
    ).save_file
    scan, (first, second, *_) = home["scan"], sorted(home["at"])
    random = np.random.default_rng(2)
    views = {key: random.standard_normal((36, 4)).astype(np.float32) for key in home["keys"]}
    save_file(views, tmp_path / "views.safetensors")
    chair = {"name": "chair", "visible_pos": [3, 14, 15, 27],
             "bbox2d": [[0, 0, 5, 5], [10, 20, 100, 200], [0, 0, 50, 60], [1, 2, 30, 40]]}  # fmt: skip
    hidden = {"name": "bed", "visible_pos": [], "bbox2d": []}
    many = {str(i): {"name": "cup", "visible_pos": [i], "bbox2d": [[1, 2, 3, 4]]} for i in range(25)}
    boxes = {f"{scan}_{first}": {"7": hidden, "12": chair}, f"{scan}_{second}": many}
    (tmp_path / "BBoxes.json").write_text(json.dumps(boxes))
    export(home, "object-hdf5", tmp_path / "o.hdf5", "--features", tmp_path / "views.safetensors",
           "--boxes", tmp_path / "BBoxes.json")  # fmt: skip
    with h5py().File(tmp_path / "o.hdf5", "r") as root:
        assert set(root) == set(boxes), "absent where there is no object"
        one, other = root[f"{scan}_{first}"], root[f"{scan}_{second}"]
        check_attributes(one, home, (640, 480, 60))
        assert one.shape == (1, 4) and one.dtype == np.float32
        mean = views[f"{scan}_{first}"][[14, 15, 27]].mean(axis=0)
        assert one[0] == pytest.approx(mean, abs=1e-6)
        # The middle of the largest box is 260 pixels left of the picture's and 120 above it.
        focal = 240 / math.tan(math.radians(30))
        direction = [
            math.radians(60) + math.atan(-260 / focal),
            math.atan(120 / math.hypot(260, focal)),
        ]
        assert one.attrs["directions"].shape == (1, 2)
        assert one.attrs["directions"][0] == pytest.approx(direction, abs=1e-6)
        assert one.attrs["sizes"].tolist() == [[100, 200]]
        assert one.attrs["bboxes"].tolist() == [[10, 20, 100, 200]]
        assert list(one.attrs["obj_ids"]) == ["12"]
        assert other.shape == (20, 4) and list(other.attrs["obj_ids"]) == [str(i) for i in range(20)]
        assert other.attrs["viewindexs"].tolist() == list(range(20))


def rendered(home: Home, viewpoint: str, to: Path, size: int, field: int, outputs: str) -> Any:
    """The twelve level views, as values."""
    image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    pictures = []
    for step in range(12):
        file = to / f"{step}.png"
        run("render", home["scan"], viewpoint, "--data", home["folder"], "--size", f"{size}x{size}", "--vfov", field,
            "--heading", 30 * step, "--outputs", outputs, "--raw", "-o", file)  # fmt: skip
        pictures.append(np.array(image.open(file)))
    return np.stack(pictures)


def test_gridmm(home: Home, tmp_path: Path) -> None:
    save_file = pytest.importorskip(
        "safetensors.numpy", reason="safetensors is not installed"
    ).save_file
    tokens = {key: np.full((36, 50, 4), i, np.float32) for i, key in enumerate(sorted(home["keys"]))}
    save_file(tokens, tmp_path / "tokens.safetensors")
    export(home, "gridmm", tmp_path, "--features", tmp_path / "tokens.safetensors")
    with h5py().File(tmp_path / "clip_p32.hdf5", "r") as root:
        assert set(root) == home["keys"] and all(root[k].dtype == np.float16 for k in root)
        assert all((root[k][...] == tokens[k]).all() and root[k].shape == (36, 50, 4) for k in root)
    info = json.loads((tmp_path / "viewpoint_info.json").read_text())
    assert set(info) == home["keys"]
    for vp, xyz in home["at"].items():
        assert [info[f"{home['scan']}_{vp}"][axis] for axis in "xyz"] == pytest.approx(xyz, abs=1e-5)
    vp = sorted(home["at"])[0]
    with h5py().File(tmp_path / "depth.hdf5", "r") as root:
        assert set(root) == home["keys"]
        dataset = root[f"{home['scan']}_{vp}"]
        assert dataset.shape == (36, 128, 128) and dataset.dtype == np.uint16
        check_attributes(dataset, home, (128, 128, 60))
        depth = dataset[...][:, : 128 * 128].astype(np.uint16)  # as its readers do
        centres = np.array([9 + i * 18 for i in range(7)])
        patches = depth[:, centres][:, :, centres].reshape(36, -1)
        assert patches.shape == (36, 49) and (patches > 0).mean() > 0.9
        assert (depth[12:24] == rendered(home, vp, tmp_path, 128, 60, "depth")).all()


def test_bevbert(home: Home, tmp_path: Path) -> None:
    save_file = pytest.importorskip(
        "safetensors.numpy", reason="safetensors is not installed"
    ).save_file
    random = np.random.default_rng(3)
    tokens = {key: random.standard_normal((12, 196, 6)).astype(np.float32) for key in home["keys"]}
    save_file(tokens, tmp_path / "tokens.safetensors")
    export(home, "bevbert-grid", tmp_path, "--features", tmp_path / "tokens.safetensors")
    vp = sorted(home["at"])[0]
    key = f"{home['scan']}_{vp}"
    with h5py().File(tmp_path / "vit_b16_224_clip_patch.hdf5", "r") as root:
        assert set(root) == home["keys"]
        assert root[key].shape == (12, 196, 6) and root[key].dtype == np.float16
        assert all((root[k][...] == tokens[k].astype(np.float16)).all() for k in root)
    depth = rendered(home, vp, tmp_path, 224, 90, "depth").astype(np.float64) / 4000
    depth = np.minimum(depth, 10).reshape(12, 14, 16, 14, 16)
    count = (depth > 0).sum(axis=(2, 4))
    mean = depth.sum(axis=(2, 4)) / np.maximum(count, 1)
    with h5py().File(tmp_path / "depth_14x14.hdf5", "r") as root:
        assert set(root) == home["keys"]
        assert root[key].shape == (12, 14, 14) and root[key].dtype == np.float32
        assert root[key][...] * 10 == pytest.approx(mean, abs=2e-4)  # depth was rounded to 0.25 mm
    with h5py().File(tmp_path / "semantic41_14x14.hdf5", "r") as root:
        assert root[key].shape == (12, 14, 14) and root[key].dtype == np.uint8
        classes = rendered(home, vp, tmp_path, 14, 90, "class").astype(int)
        classes[(classes == 0) | (classes > 40)] = 40
        assert (root[key][...] == classes % 40).all() and len(np.unique(classes)) > 3


def test_reverie_boxes(home: Home, tmp_path: Path) -> None:
    """Boxes of the mesh against pictures of instances, whose texels are some ten pixels wide."""
    export(home, "reverie-boxes", tmp_path / "BBox", "--meshes", home["folder"])
    files = {file.stem: json.loads(file.read_text()) for file in (tmp_path / "BBox").iterdir()}
    assert set(files) == home["keys"]
    seen = 0
    for key, content in files.items():
        vp = key.removeprefix(home["scan"] + "_")
        assert set(content) == {vp}
        for ident, found in content[vp].items():
            assert (
                ident.isdigit() and found["name"] and len(found["visible_pos"]) == len(found["bbox2d"])
            )
            assert (
                found["visible_pos"] == sorted(set(found["visible_pos"]))
                and found["visible_pos"][-1] < 36
            )
            seen += len(found["bbox2d"])
            for x, y, w, h in found["bbox2d"]:
                assert x >= 0 and y >= 0 and w > 0 and h > 0 and x + w <= 640 and y + h <= 480
    assert seen > 20
    export(home, "reverie-boxes", tmp_path / "BBoxes.json", "--meshes", home["folder"])
    flat = json.loads((tmp_path / "BBoxes.json").read_text())
    assert flat == {
        key: content[key.removeprefix(home["scan"] + "_")] for key, content in files.items()
    }
    # Back and forth between the three forms.
    run("convert", tmp_path / "BBoxes.json", tmp_path / "again", "--to", "folder")
    again = {file.stem: json.loads(file.read_text()) for file in (tmp_path / "again").iterdir()}
    assert again == files
    run("convert", tmp_path / "again", tmp_path / "nested.json", "--to", "nested")
    assert json.loads((tmp_path / "nested.json").read_text()) == files
    run("convert", tmp_path / "nested.json", tmp_path / "flat.json")
    assert json.loads((tmp_path / "flat.json").read_text()) == flat


FRAMES = [b"\xff\xd8 left \xff\xd9", b"\xff\xd8 forward \xff\xd9", b"\xff\xd8 stop \xff\xd9"]


def make_parts(folder: Path) -> None:
    """What the program renders of two episodes with one instruction, of three pictures and of one."""
    parts = folder / "enfilade_export.parts"
    states = [[1.5, -2.0, 0.1, 0.25], [1.5, -2.0, 0.1, 0.5], [1.5, -1.75, 0.1, 0.5]]
    pixels = {
        "min": [0, 0.1, 0.2],
        "max": [1, 0.9, 0.8],
        "mean": [0.5, 0.4, 0.3],
        "std": [0.1, 0.2, 0.3],
    }
    for index, count in enumerate((3, 1)):
        part = parts / f"{index:06d}"
        part.mkdir(parents=True)
        for k, frame in enumerate(FRAMES[-count:]):
            (part / f"frame_{k:06d}.jpg").write_bytes(frame)
        rows = {"actions": [2, 1, 0][-count:], "states": states[-count:], "pixels": pixels}
        (parts / f"{index:06d}.rows.json").write_text(json.dumps(rows))
    episodes = [{"instruction": "Geh über den Flur.", "length": length} for length in (3, 1)]
    split = {"split": "train", "width": 64, "height": 48, "chunk": 1000, "episodes": episodes}
    (parts / "episodes.json").write_text(json.dumps(split))


def lines_of(file: Path) -> list[Any]:
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]


def test_lerobot_tables_have_columns_types_and_values(tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    import pyarrow.parquet as parquet
    from enfilade.exports import main

    make_parts(tmp_path)
    assert main(["lerobot", str(tmp_path), "--version", "2.1"]) == 0
    first, second = (
        parquet.read_table(tmp_path / f"data/chunk-000/episode_{k:06d}.parquet") for k in (0, 1)
    )
    whole = dict.fromkeys(("frame_index", "episode_index", "index", "task_index"), pa.int64())
    assert {field.name: field.type for field in first.schema} == {
        "observation.images.rgb": pa.struct([("bytes", pa.binary()), ("path", pa.string())]),
        "observation.state": pa.list_(pa.field("element", pa.float32())),
        "action": pa.int64(),
        "timestamp": pa.float32(),
        **whole,
    }
    assert first.schema == second.schema
    single = [np.float32(x).item() for x in (0.1, 0.2, 0.4)]
    assert first.to_pydict() == {
        "observation.images.rgb": [
            {"bytes": frame, "path": f"frame_{k:06d}.jpg"} for k, frame in enumerate(FRAMES)
        ],
        "observation.state": [
            [1.5, -2, single[0], 0.25],
            [1.5, -2, single[0], 0.5],
            [1.5, -1.75, single[0], 0.5],
        ],
        "action": [2, 1, 0],
        "timestamp": [0, single[1], single[2]],
        "frame_index": [0, 1, 2],
        "episode_index": [0, 0, 0],
        "index": [0, 1, 2],
        "task_index": [0, 0, 0],
    }
    assert second["observation.images.rgb"].to_pylist() == [
        {"bytes": FRAMES[2], "path": "frame_000000.jpg"}
    ]
    of_second = {name: second[name].to_pylist() for name in ("action", "timestamp", *whole)}
    assert of_second == {"action": [0], "timestamp": [0], "frame_index": [0], "episode_index": [1],
                         "index": [3], "task_index": [0]}  # fmt: skip
    # Columns are neither packed nor encoded, and may be null, as `datasets` needs them.
    about = parquet.ParquetFile(tmp_path / "data/chunk-000/episode_000000.parquet")
    assert about.schema.column(0).max_definition_level == 2
    assert about.metadata.row_group(0).column(0).compression == "UNCOMPRESSED"
    features = json.loads(first.schema.metadata[b"huggingface"])["info"]["features"]
    assert list(features) == first.column_names
    assert features["observation.images.rgb"] == {"_type": "Image"}
    assert features["timestamp"] == {"dtype": "float32", "_type": "Value"}


def test_lerobot_meta_describes_the_tables(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    from enfilade.exports import write_lerobot

    make_parts(tmp_path)
    assert write_lerobot(tmp_path, "2.1") == 2
    instruction = "Geh über den Flur."
    meta = tmp_path / "meta"
    assert lines_of(meta / "tasks.jsonl") == [{"task_index": 0, "task": instruction}]
    assert lines_of(meta / "episodes.jsonl") == [
        {"episode_index": 0, "tasks": [instruction], "length": 3},
        {"episode_index": 1, "tasks": [instruction], "length": 1},
    ]
    stats = lines_of(meta / "episodes_stats.jsonl")
    assert [entry["episode_index"] for entry in stats] == [0, 1]
    first = stats[0]["stats"]
    action = {
        "min": [0],
        "max": [2],
        "mean": [1],
        "std": [pytest.approx(math.sqrt(2 / 3))],
        "count": [3],
    }
    assert first["action"] == action
    assert first["observation.state"]["min"] == pytest.approx([1.5, -2, 0.1, 0.25])
    assert first["observation.state"]["mean"] == pytest.approx([1.5, -5.75 / 3, 0.1, 1.25 / 3])
    assert first["observation.images.rgb"]["mean"] == [[[0.5]], [[0.4]], [[0.3]]]
    assert first["observation.images.rgb"]["count"] == [3]
    assert stats[1]["stats"]["index"] == {"min": [3], "max": [3], "mean": [3], "std": [0], "count": [1]}
    info = json.loads((meta / "info.json").read_text())
    features = info.pop("features")
    assert info == {
        "codebase_version": "v2.1",
        "robot_type": "vln-ce",
        "total_episodes": 2,
        "total_frames": 4,
        "total_tasks": 1,
        "total_videos": 0,
        "total_chunks": 1,
        "chunks_size": 1000,
        "fps": 5,
        "splits": {"train": "0:2"},
        "data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
        "video_path": None,
    }
    assert features["observation.images.rgb"] == {
        "dtype": "image", "shape": [48, 64, 3], "names": ["height", "width", "channel"]}  # fmt: skip
    assert features["observation.state"]["names"] == ["x", "y", "z", "heading"]
    assert features["action"] == {"dtype": "int64", "shape": [1], "names": ["action"]}
    assert features["index"] == {"dtype": "int64", "shape": [1], "names": None}


@pytest.mark.parametrize("version", ["2.1", "3.0"])
def test_lerobot_goes_on_where_it_stopped(
    version: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    from enfilade import _lerobot
    from enfilade.exports import main, write_lerobot

    monkeypatch.setattr(_lerobot, "_DATA_MEGABYTES", 0)  # an episode per table
    make_parts(tmp_path / "whole")
    write_lerobot(tmp_path / "whole", version)
    make_parts(tmp_path)
    parts = tmp_path / "enfilade_export.parts"
    rows = parts / "000001.rows.json"
    rows.rename(parts / "away")
    words = ["lerobot", str(tmp_path), "--version", version]
    assert main(words) == 3 and "000001" in capsys.readouterr().err
    assert not (parts / "000000").exists(), "the first is a table"
    (parts / "away").rename(rows)
    assert write_lerobot(tmp_path, version) == write_lerobot(tmp_path, version) == 2
    kept = {"000000.json", "000001.json", "episodes.json", "tables.json"}
    assert {file.name for file in parts.iterdir()} == kept
    for file in (tmp_path / "whole").rglob("*.*"):
        if file.is_file():
            assert (tmp_path / file.relative_to(tmp_path / "whole")).read_bytes() == file.read_bytes()


def test_lerobot_3_has_tables_of_many_episodes(tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    import pyarrow.parquet as parquet
    from enfilade.exports import main

    make_parts(tmp_path)
    assert main(["lerobot", str(tmp_path)]) == 0
    file = tmp_path / "data/chunk-000/file-000.parquet"
    assert [other.name for other in file.parent.iterdir()] == [file.name]
    table = parquet.read_table(file)
    assert table.schema.field("observation.state").type == pa.list_(pa.float32(), 4)
    assert table["episode_index"].to_pylist() == [0, 0, 0, 1]
    assert table["index"].to_pylist() == [0, 1, 2, 3]
    assert table["action"].to_pylist() == [2, 1, 0, 0]
    assert table["task_index"].to_pylist() == [0, 0, 0, 0]
    pictures = [picture["bytes"] for picture in table["observation.images.rgb"].to_pylist()]
    assert pictures == [*FRAMES, FRAMES[2]]
    assert parquet.ParquetFile(file).num_row_groups == 2, "one per episode"


def test_lerobot_3_meta_describes_the_tables(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    import pyarrow.parquet as parquet
    from enfilade.exports import write_lerobot

    make_parts(tmp_path)
    assert write_lerobot(tmp_path) == 1
    meta = tmp_path / "meta"
    tasks = pandas.read_parquet(meta / "tasks.parquet")
    assert tasks.iloc[0].name == "Geh über den Flur." and tasks.index.name == "task"
    assert tasks["task_index"].tolist() == [0] and list(tasks.columns) == ["task_index"]
    first, second = parquet.read_table(meta / "episodes/chunk-000/file-000.parquet").to_pylist()
    assert [first[name] for name in ("episode_index", "tasks", "length")] == [0, [tasks.index[0]], 3]
    assert (first["dataset_from_index"], first["dataset_to_index"]) == (0, 3)
    assert (second["dataset_from_index"], second["dataset_to_index"]) == (3, 4)
    for name in ("data/chunk_index", "data/file_index", "meta/episodes/chunk_index"):
        assert first[name] == second[name] == 0
    assert first["stats/action/max"] == [2] and first["stats/action/q50"] == [1]
    assert first["stats/action/count"] == [3] and second["stats/action/count"] == [1]
    assert first["stats/observation.images.rgb/mean"] == [[[0.5]], [[0.4]], [[0.3]]]
    assert not any(name.startswith("videos/") for name in first)
    stats = json.loads((meta / "stats.json").read_text())
    actions = np.array([2, 1, 0, 0])
    assert stats["action"]["mean"] == pytest.approx([actions.mean()])
    assert stats["action"]["std"] == pytest.approx([actions.std()])
    assert stats["action"]["min"] == [0] and stats["action"]["count"] == [4]
    assert stats["action"]["q50"] == pytest.approx([0.75]), "the mean of 1 (thrice) and 0"
    assert stats["observation.images.rgb"]["max"] == [[[1]], [[0.9]], [[0.8]]]
    info = json.loads((meta / "info.json").read_text())
    features = info.pop("features")
    assert info == {
        "codebase_version": "v3.0",
        "robot_type": "vln-ce",
        "total_episodes": 2,
        "total_frames": 4,
        "total_tasks": 1,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": 5,
        "splits": {"train": "0:2"},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": None,
    }
    assert features["observation.images.rgb"]["dtype"] == "image"
    assert features["observation.state"]["shape"] == [4]


def test_lerobot_keeps_versions_apart(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    from enfilade import ArgumentError, FileError
    from enfilade.exports import write_lerobot

    for version, other in (("2.1", "3.0"), ("3.0", "2.1")):
        folder = tmp_path / version
        make_parts(folder)
        write_lerobot(folder, version)
        with pytest.raises(FileError, match=f"tables of version {version}; give the same"):
            write_lerobot(folder, other)
        (folder / "enfilade_export.parts/tables.json").unlink()  # a folder of an earlier version
        with pytest.raises(FileError, match=f"tables of version {version}; take another"):
            write_lerobot(folder, other)
    assert write_lerobot(tmp_path / "2.1", "2.1") == 2
    for wrong in (("3.1",), ("2.1", True)):
        with pytest.raises(ArgumentError):
            write_lerobot(folder, *wrong)


def test_lerobot_3_has_a_video_of_many_episodes(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    av = pytest.importorskip("av", reason="PyAV (av) is not installed")
    image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    import pyarrow.parquet as parquet
    from enfilade.exports import write_lerobot

    make_parts(tmp_path)
    colours = iter([(200, 40, 40), (40, 200, 40), (40, 40, 200), (120, 120, 120)])
    for file in sorted((tmp_path / "enfilade_export.parts").glob("*/*.jpg")):
        image.new("RGB", (64, 64), next(colours)).save(file)
    split = tmp_path / "enfilade_export.parts/episodes.json"
    split.write_text(split.read_text().replace('"height": 48', '"height": 64'))
    assert write_lerobot(tmp_path, videos=True) == 1
    video = tmp_path / "videos/observation.images.rgb/chunk-000/file-000.mp4"
    with av.open(str(video)) as container:
        frames = list(container.decode(video=0))
        assert [float(frame.pts * frame.time_base) for frame in frames] == pytest.approx(
            [0, 0.2, 0.4, 0.6]
        )
        shown = [frame.to_ndarray(format="rgb24")[32, 32] for frame in frames]
    assert (
        np.abs(np.array(shown, int) - [(200, 40, 40), (40, 200, 40), (40, 40, 200), (120,) * 3]).max()
        < 12
    )
    _, second = parquet.read_table(tmp_path / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    key = "videos/observation.images.rgb/"
    assert second[key + "from_timestamp"] == pytest.approx(0.6)
    assert second[key + "to_timestamp"] == pytest.approx(0.8)
    assert second[key + "file_index"] == second[key + "chunk_index"] == 0
    columns = parquet.read_table(tmp_path / "data/chunk-000/file-000.parquet").column_names
    assert "observation.images.rgb" not in columns and "action" in columns
    info = json.loads((tmp_path / "meta/info.json").read_text())
    assert info["features"]["observation.images.rgb"]["dtype"] == "video"
    assert info["video_path"].format(
        video_key="observation.images.rgb", chunk_index=0, file_index=0
    ) == str(video.relative_to(tmp_path))


def test_lerobot_renders_nothing_without_pyarrow(tmp_path: Path) -> None:
    program = os.environ.get("ENFILADE_COMMAND") or os.environ.get("ENFILADE_PROGRAM")
    if not program:
        pytest.skip("ENFILADE_COMMAND names no program")
    run("homes", "-o", tmp_path / "homes", "--preset", "graphs", "--homes", 1, "--paths", 1)
    words = [program, "export", "--as", "lerobot", "--data", tmp_path / "homes", "-o", tmp_path / "out"]
    (tmp_path / "pyarrow.py").write_text("raise ImportError('No module named pyarrow')\n")
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    for python, message in ((sys.executable, 'pip install "enfilade[lerobot]"'), ("/none", "--python")):
        done = subprocess.run(
            [*map(str, words), "--python", python],
            capture_output=True, text=True, env={**os.environ, "PYTHONPATH": path},
        )  # fmt: skip
        assert done.returncode == 2 and message in done.stderr
        assert not (tmp_path / "out").exists()


def test_mapgpt_views(home: Home, tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    export(home, "mapgpt-views", tmp_path / "views")
    for vp in home["at"]:
        folder = tmp_path / "views" / home["scan"] / vp
        assert {file.name for file in folder.iterdir()} == {f"{view}.jpg" for view in range(36)}
    for view in range(36):
        picture = image.open(folder / f"{view}.jpg")
        assert (picture.format, picture.size, picture.mode) == ("JPEG", (640, 480), "RGB")
    (folder / "3.jpg").unlink()
    os.rename(folder, tmp_path / "away")
    said = export(home, "mapgpt-views", tmp_path / "views")
    assert f"of which {len(home['at']) - 1} were there" in said and (folder / "3.jpg").exists()


def test_convert_features_results_and_annotations(home: Home, tmp_path: Path) -> None:
    save_file = pytest.importorskip(
        "safetensors.numpy", reason="safetensors is not installed"
    ).save_file
    random = np.random.default_rng(4)
    views = {key: random.standard_normal((36, 3)).astype(np.float32) for key in home["keys"]}
    save_file(views, tmp_path / "a.safetensors")
    run("convert", tmp_path / "a.safetensors", tmp_path / "b.tsv")
    run("convert", tmp_path / "b.tsv", tmp_path / "c.hdf5")
    with h5py().File(tmp_path / "c.hdf5", "r") as root:
        assert all((root[key][...] == views[key]).all() for key in views) and len(root) == len(views)

    results = [{"instr_id": "1_2_0", "trajectory": [["v", 0.25, 0.0]], "predObjId": 2}]
    (tmp_path / "r.json").write_text(json.dumps(results))
    run("convert", tmp_path / "r.json", tmp_path / "duet.json", "--to", "duet")
    duet = json.loads((tmp_path / "duet.json").read_text())
    assert duet == [{"instr_id": "1_2_0", "trajectory": [["v", 0.25, 0.0]], "pred_objid": 2}]

    path = {"path_id": 7, "scan": "s", "heading": 0.5, "path": ["a", "b"], "distance": 3.25,
            "instructions": ["Go.", "Walk.", "Gehe."]}  # fmt: skip
    (tmp_path / "R2R_train.json").write_text(json.dumps([path, path | {"path_id": 8}]))
    run("convert", tmp_path / "R2R_train.json", tmp_path / "lines.jsonl")
    lines = [json.loads(line) for line in (tmp_path / "lines.jsonl").read_text().splitlines()]
    assert lines == [path, path | {"path_id": 8}]
    run("convert", tmp_path / "lines.jsonl", tmp_path / "list.json.gz")
    assert json.loads(gzip.decompress((tmp_path / "list.json.gz").read_bytes())) == lines
