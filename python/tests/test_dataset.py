"""A folder of data by one name, and the short programs that it makes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import enfilade
import pytest
from enfilade import synth

np = pytest.importorskip("numpy")

EXAMPLES = Path(__file__).parents[2] / "examples" / "python"


def test_a_folder_has_everything(homes: str) -> None:
    d = enfilade.Dataset(homes)
    assert d.folder == Path(homes) and d.synthetic
    assert d.splits == ["train", "val_seen", "val_unseen", "test"]
    assert d.graphs.scans == d.panoramas.scans
    episodes = d.episodes("val_unseen")
    assert len(episodes) and episodes.graphs.scans == d.graphs.scans
    scan = d.graphs.scans[0]
    viewpoint = next(filter(d.graphs[scan].included, d.graphs[scan].viewpoints))
    assert isinstance(d.region(scan, viewpoint), int) and d.region(scan, "nowhere") is None
    assert d.simulator(3).batch_size == 3


def test_a_preset_says_whether_there_are_pictures(tmp_path: Path) -> None:
    graphs, short = tmp_path / "graphs", tmp_path / "short"
    report = synth.write_homes(graphs, preset="graphs", homes=3)
    assert report.homes == 3 and report.paths > 0
    assert not list(graphs.glob("store/*"))
    enfilade.write_small_dataset(short, buildings=3)
    assert (graphs / "homes.json").read_bytes() == (short / "homes.json").read_bytes()
    synth.write_homes(tmp_path / "drawn", preset="small", homes=1, face_size=8)
    assert list((tmp_path / "drawn").glob("store/*"))


def test_a_picture_is_the_renderers(homes: str) -> None:
    d = enfilade.Dataset(homes)
    scan = d.graphs.scans[0]
    viewpoint = next(filter(d.graphs[scan].included, d.graphs[scan].viewpoints))
    picture = d.render(scan, viewpoint, 1.0, -0.1, width=64, height=48)
    drawn = d.renderer().render([scan], [viewpoint], 1.0, -0.1, width=64, height=48)
    assert picture.shape == (48, 64, 3) and picture.dtype == np.uint8
    assert (picture == drawn["rgb"][0]).all()
    with pytest.raises(enfilade.UnknownNameError, match="nowhere"):
        d.render(scan, "nowhere")


def test_two_views_of_a_wall_are_one_wall(homes: str) -> None:
    """Points of two cameras at one place, where both see the same direction."""
    from enfilade import camera

    d = enfilade.Dataset(homes)
    graph = d.graphs[d.graphs.scans[0]]
    viewpoint = next(filter(graph.included, graph))
    here = graph.positions[graph.index(viewpoint)]
    vfov = 1.2
    drawn = d.renderer().render([graph.scan] * 2, [viewpoint] * 2, [0.0, 0.4], width=96, height=72,
                                vfov=vfov, rgb=None, layers=("depth",))["depth"]  # fmt: skip
    points = camera.unproject(drawn[0], vfov, here, 0.0)
    pixels, depth = camera.project(points, 96, 72, vfov, here, 0.4)
    inside = (pixels > 1).all(-1) & (pixels[..., 0] < 95) & (pixels[..., 1] < 71)
    column, row = pixels[inside].astype(int).T
    apart = np.abs(drawn[1][row, column] - depth[inside])
    assert inside.sum() > 2000 and np.median(apart) < 0.02


def test_what_is_missing_says_how_to_get_it(small: str, tmp_path: Path) -> None:
    parts = {part.name: part for part in enfilade.Dataset(small).examine()}
    assert parts["connectivity"].present and "scans" in parts["connectivity"].found
    assert not parts["panoramas"].present and "niessner" in parts["panoramas"].advice
    assert not any(part.present for part in enfilade.Dataset(tmp_path).examine())


def test_the_environment_may_name_the_folder(small: str) -> None:
    code = "import enfilade; print(enfilade.Dataset().folder)"
    named = dict(os.environ, ENFILADE_DATA=small)
    out = subprocess.run([sys.executable, "-c", code], env=named, capture_output=True, text=True)
    assert out.stdout.strip() == small
    del named["ENFILADE_DATA"]
    out = subprocess.run([sys.executable, "-c", code], env=named, capture_output=True, text=True)
    assert "ENFILADE_DATA" in out.stderr and out.returncode == 1


def test_a_wrong_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(enfilade.FileError, match="absent"):
        enfilade.Dataset(tmp_path / "absent")
    with pytest.raises(enfilade.FileError, match="scans.txt"):
        _ = enfilade.Dataset(tmp_path).graphs


@pytest.fixture
def beside_homes(homes: str, tmp_path: Path) -> Path:
    (tmp_path / "homes").symlink_to(homes)
    return tmp_path


def run_example(name: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, EXAMPLES / f"{name}.py"], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_render_in_three_lines(beside_homes: Path) -> None:
    run_example("render", beside_homes)
    assert np.load(beside_homes / "v.npy").shape == (480, 640, 3)


def test_step_in_a_few_lines(beside_homes: Path) -> None:
    assert run_example("step", beside_homes).count("'") == 4  # two viewpoint ids


def test_score_in_three_lines(beside_homes: Path) -> None:
    d = enfilade.Dataset(beside_homes / "homes")
    stays = [
        {"instr_id": e.instruction_id, "trajectory": [[e.path[0], e.heading, 0.0]]}
        for e in d.episodes("val_unseen")
    ]
    (beside_homes / "results.json").write_text(json.dumps(stays))
    assert "nav_error" in run_example("score", beside_homes)
