"""Exported expert trajectories, read as their readers read them: StreamVLN's and NaVILA's loaders, and `lerobot`.

`ENFILADE_LEROBOT_PYTHON` names the Python of an environment with lerobot 0.4 or later.
`ENFILADE_LEROBOT21_PYTHON` names one with lerobot 0.3, which reads version 2.1. docs/exports.md has the commands."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from programs import run

np = pytest.importorskip("numpy")
image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")

from enfilade import continuous_episodes  # noqa: E402

SPLIT = "val_unseen"


@pytest.fixture(scope="module")
def free(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("readers") / "homes"
    run("homes", "-o", folder, "--preset", "graphs", "--homes", 3, "--paths", 1)
    run("continuous", folder, "--task", "r2r-ce")
    return folder


@pytest.fixture(scope="module")
def streamvln(free: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("streamvln")
    run("export", "--as", "streamvln", "--data", free, "--split", SPLIT, "-o", folder)
    return folder


def experts(free: Path) -> list[Any]:
    episodes = continuous_episodes(free, "r2r-ce", SPLIT)
    return [(episode, episodes.expert(place)) for place, episode in enumerate(episodes)]


def test_streamvln_loads_rounds_of_frames_and_actions(free: Path, streamvln: Path) -> None:
    """As its VLNActionDataset: frames by sorted names, the first action cut, a stop added."""
    frames_per_round, future = 32, 4
    entries = json.loads((streamvln / "annotations.json").read_text())
    of = {str(episode.id): (episode, expert) for episode, expert in experts(free)}
    assert {str(entry["id"]) for entry in entries} == set(of)
    for entry in entries:
        episode, expert = of[str(entry["id"])]
        assert entry["instructions"] == [episode.instruction]
        rgb = streamvln / entry["video"] / "rgb"
        names = sorted(os.listdir(rgb))
        assert entry["actions"][0] == -1 and len(entry["actions"]) >= 4
        actions = [*entry["actions"][1:], 0]
        assert actions == expert.actions.tolist()
        assert len(names) == len(actions)
        words = {"0": "STOP", "1": "up", "2": "left", "3": "right"}
        text = [words[str(action)] for action in actions]
        assert text.count("STOP") == 1 and text[-1] == "STOP"
        for begin in range(0, len(actions), frames_per_round):
            for step in range(begin, min(begin + frames_per_round, len(actions)), future):
                with image.open(rgb / names[step]) as picture:
                    assert picture.convert("RGB").size == (640, 480)
        # The place of a picture in the sorted list is its action's.
        assert [int(Path(name).stem) for name in names] == list(range(1, len(names) + 1))


def test_navila_loads_the_frames_so_far_and_an_answer(
    free: Path, streamvln: Path, tmp_path: Path
) -> None:
    """As its vlnce data set: annotations.json, and frames below the split's folder."""
    run("export", "--as", "navila", "--data", free, "--split", SPLIT, "-o", tmp_path)
    entries = json.loads((tmp_path / "R2R/annotations.json").read_text())
    pictures = tmp_path / "R2R" / SPLIT
    of = {str(episode.id): (episode, expert) for episode, expert in experts(free)}
    videos = {
        str(e["id"]): streamvln / e["video"]
        for e in json.loads((streamvln / "annotations.json").read_text())
    }
    done: dict[str, list[int]] = {ident: [] for ident in of}
    for entry in entries:
        assert {"video_id", "frames", "q", "a"} <= set(entry)
        ident = entry["video_id"].rsplit("-", 1)[0]
        episode, _ = of[ident]
        assert entry["q"] == episode.instruction
        paths = [pictures / frame for frame in entry["frames"]]
        assert len(paths) == len(done[ident]) + 1, "all pictures so far, the present one last"
        for k in (0, len(paths) - 1):
            with image.open(paths[k]) as picture:
                assert picture.convert("RGB").size == (640, 480)
            assert paths[k].read_bytes() == (videos[ident] / f"rgb/{k + 1:03d}.jpg").read_bytes()
        # What its evaluation asks of an answer: one of four words, and a number for three of them.
        answer = entry["a"]
        kinds = [word for word in ("stop", "forward", "left", "right") if word in answer]
        assert len(kinds) == 1, answer
        if kinds == ["stop"]:
            done[ident].append(0)
            continue
        found = re.search(r"(?:forward|turn left|turn right) (\d+) (cm|degree)", answer)
        assert found, answer
        one, unit = (25, "cm") if kinds == ["forward"] else (15, "degree")
        amount = int(found.group(1))
        assert found.group(2) == unit and amount % one == 0 and one <= amount <= 3 * one
        done[ident] += [{"forward": 1, "left": 2, "right": 3}[kinds[0]]] * (amount // one)
    assert done == {ident: expert.actions.tolist() for ident, (_, expert) in of.items()}


# --- lerobot itself -------------------------------------------------------------------------------


def read_by_lerobot(folder: Path, variable: str, scratch: Path) -> dict[str, Any]:
    python = os.environ.get(variable)
    if not python:
        pytest.skip(f"{variable} names no Python with lerobot")
    words = [python, Path(__file__).with_name("lerobot_reader.py"), folder, scratch / "read.npz"]
    # Caches in the test's folder, and nothing from the network.
    caches = {"HF_HOME": str(scratch / "hf"), "HF_HUB_OFFLINE": "1", "HF_DATASETS_OFFLINE": "1"}
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(
        list(map(str, words)),
        capture_output=True,
        text=True,
        timeout=1200,
        env={**environment, **caches},
    )
    assert done.returncode == 0, done.stderr[-3000:]
    read = dict(np.load(scratch / "read.npz"))
    return {**read, "about": json.loads(str(read["about"]))}


def check_frames(read: dict[str, Any], free: Path, streamvln: Path, off: float) -> None:
    """Every frame against the experts and StreamVLN's pictures; `off` is the most of a picture's mean."""
    about = read["about"]
    entries = {str(e["id"]): e for e in json.loads((streamvln / "annotations.json").read_text())}
    pictures, row = [], 0
    for place, (episode, expert) in enumerate(experts(free)):
        actions = expert.actions.tolist()
        rows = slice(row, row + len(actions))
        assert read["action"][rows].ravel().tolist() == actions
        assert set(about["tasks"][rows]) == {episode.instruction}
        assert (read["episode_index"][rows] == place).all()
        assert read["frame_index"][rows].ravel().tolist() == list(range(len(actions)))
        assert read["timestamp"][rows].ravel() == pytest.approx(np.arange(len(actions)) / 5)
        assert read["observation.state"][row][:3] == pytest.approx(episode.start, abs=1e-5)
        rgb = streamvln / entries[str(episode.id)]["video"] / "rgb"
        pictures += [rgb / name for name in sorted(os.listdir(rgb))]
        # The action ahead is the next row's; beyond the end the last is repeated, and marked.
        ahead = [[row + k, a, b, 0] for k, (a, b) in enumerate(zip(actions, actions[1:]))]
        ahead.append([row + len(actions) - 1, actions[-1], actions[-1], 1])
        assert read["pairs"][rows].tolist() == ahead
        row += len(actions)
    assert about["frames"] == row == len(read["action"]) and about["fps"] == 5
    assert read["index"].ravel().tolist() == list(range(row))
    for k, file in enumerate(pictures):
        with image.open(file) as opened:
            shown = np.asarray(opened.convert("RGB"))
        assert np.abs(shown.reshape(-1, 3).mean(0) / 255 - read["means"][k]).max() <= off
        for where in np.flatnonzero(read["some"] == k):
            apart = np.abs(shown.astype(int) - read["pictures"][where])
            assert apart.max() == 0 if off < 1e-4 else apart.mean() < 4
    whole = np.concatenate([expert.actions for _, expert in experts(free)])
    assert read["stats/action/mean"].ravel() == pytest.approx([whole.mean()])
    assert read["stats/action/std"].ravel() == pytest.approx([whole.std()])
    assert read["stats/observation.images.rgb/mean"].shape == (3, 1, 1)
    assert read["stats/observation.images.rgb/mean"].ravel() == pytest.approx(
        read["means"].mean(0), abs=0.01
    )


@pytest.mark.parametrize("videos", [False, True])
def test_lerobot_reads_what_was_exported(
    free: Path, streamvln: Path, tmp_path: Path, videos: bool
) -> None:
    pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    if not os.environ.get("ENFILADE_LEROBOT_PYTHON"):
        pytest.skip("ENFILADE_LEROBOT_PYTHON names no Python with lerobot")
    if videos:
        pytest.importorskip("av", reason="PyAV (av) is not installed")
    run("export", "--as", "lerobot", "--data", free, "--split", SPLIT, "-o", tmp_path / "set",
        "--python", sys.executable, *(["--videos"] if videos else []))  # fmt: skip
    read = read_by_lerobot(tmp_path / "set", "ENFILADE_LEROBOT_PYTHON", tmp_path)
    assert read["about"]["version"] == "3.0"
    check_frames(read, free, streamvln, 0.02 if videos else 1e-5)
    assert read["stats/observation.state/q50"].shape == (4,)


def test_lerobot_of_old_reads_version_2_1(free: Path, streamvln: Path, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    if not os.environ.get("ENFILADE_LEROBOT21_PYTHON"):
        pytest.skip("ENFILADE_LEROBOT21_PYTHON names no Python with lerobot 0.3")
    run("export", "--as", "lerobot", "--lerobot-version", "2.1", "--data", free, "--split", SPLIT,
        "-o", tmp_path / "set", "--python", sys.executable)  # fmt: skip
    read = read_by_lerobot(tmp_path / "set", "ENFILADE_LEROBOT21_PYTHON", tmp_path)
    assert read["about"]["version"] == "2.1"
    check_frames(read, free, streamvln, 1e-5)
