"""The examples run, on synthetic data."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples" / "python"


@pytest.fixture(scope="module")
def homes(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Model homes with pictures: in ENFILADE_HOMES, or made here (17 s of one core)."""
    if os.environ.get("ENFILADE_HOMES"):
        return os.environ["ENFILADE_HOMES"]
    from enfilade import synth

    folder = str(tmp_path_factory.mktemp("homes"))
    report = synth.write_homes(folder, homes=3, face_size=32)
    assert report.homes == 3 and report.paths > 0 and report.instructions == 3 * report.paths
    return folder


def run(name: str, *arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / name), *arguments], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_walk_and_see(homes: str, tmp_path: Path) -> None:
    np = pytest.importorskip("numpy")
    assert "deep" in run("walk_and_see.py", homes, str(tmp_path / "seen.npy"))
    assert np.load(tmp_path / "seen.npy").shape == (4, 480, 640, 3)


def test_extract_features(homes: str, tmp_path: Path) -> None:
    pytest.importorskip("torch", reason="torch is not installed")
    assert "(36, 128)" in run("extract_features.py", homes, str(tmp_path / "features.tsv"))


def test_imitation(small: str) -> None:
    pytest.importorskip("torch", reason="torch is not installed")
    assert "after" in run("imitation.py", small)


def test_rl(small: str) -> None:
    pytest.importorskip("stable_baselines3", reason="Stable-Baselines3 is not installed")
    assert "after" in run("rl.py", small)


def test_port(small: str) -> None:
    assert "every viewpoint" in run("port.py", small)
