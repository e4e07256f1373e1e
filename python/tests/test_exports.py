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

np = pytest.importorskip("numpy")

Home = dict[str, Any]


def run(*arguments: object) -> str:
    """The program's standard output; it has to succeed."""
    program = os.environ.get("ENFILADE_COMMAND") or os.environ.get("ENFILADE_PROGRAM")
    if not program:
        pytest.skip("ENFILADE_COMMAND names no program")
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=1200)
    assert done.returncode == 0, done.stderr
    return done.stdout


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
