"""The type stubs, against the module they describe and under a strict type checker."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import MatterSim
import Matterport3DSimulator
import enfilade
import pytest

ROOT = Path(__file__).parent.parent


def test_the_stubs_are_those_of_the_bindings() -> None:
    pytest.importorskip("nanobind", reason="nanobind is not installed: no stubs to compare")
    if sys.version_info < (3, 10):
        pytest.skip("Python 3.9 writes types in older words than the stubs, which 3.10 and later made")
    command = [sys.executable, str(ROOT / "tools" / "make_stubs.py"), "--check"]
    assert subprocess.run(command).returncode == 0, "run python/tools/make_stubs.py"


def test_the_drop_ins_stubs_name_what_it_has() -> None:
    text = (Path(MatterSim.__file__).parent / "__init__.pyi").read_text()
    for kind in (MatterSim.Simulator, MatterSim.SimState, MatterSim.ViewPoint):
        for name in vars(kind):
            assert name.startswith("_") or f"def {name}(" in text, name


def test_a_strict_type_checker_has_nothing_to_say(tmp_path: Path) -> None:
    """In a folder of its own: beside all that pip installs, mypy complains of its neighbours."""
    pytest.importorskip("mypy", reason="mypy is not installed")
    if sys.version_info < (3, 10):
        pytest.skip("Python 3.9 gets an older Gymnasium, whose types are others")
    packages = Path(enfilade.__file__).parent.parent
    names = ("enfilade", "MatterSim", "Matterport3DSimulator", "habitat_sim", "magnum", "corrade")
    for name in names:
        shutil.copytree(packages / name, tmp_path / name)
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", *names]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout


def test_type_checkers_of_users_find_the_packages() -> None:
    for package in (enfilade, MatterSim, Matterport3DSimulator):
        assert (Path(package.__file__).parent / "py.typed").exists()
