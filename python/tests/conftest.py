"""Where tests find data. Real data and recordings are never in the repository: tests that need them
skip, and say so."""

from __future__ import annotations

import functools
import os
import subprocess
from pathlib import Path
from typing import Any, Callable, Iterator

import enfilade
import pytest
from made_tasks import make_tasks
from old_simulator import make_simulator


@pytest.fixture(scope="session", autouse=True)
def _no_cache_of_the_user(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Tests neither read nor fill the user's cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of the real graphs and annotations."""
    folder = os.environ.get("ENFILADE_DATA")
    if not folder:
        pytest.skip("ENFILADE_DATA is not set: no real navigation graphs")
    return Path(folder)


@pytest.fixture(scope="session")
def program() -> str:
    """The program `enfilade`."""
    found = os.environ.get("ENFILADE_COMMAND") or os.environ.get("ENFILADE_PROGRAM")
    if not found:
        pytest.skip("neither ENFILADE_COMMAND nor ENFILADE_PROGRAM is set: no program `enfilade`")
    return found


@pytest.fixture(scope="session")
def web_program(program: str) -> str:
    """The same of a build that speaks HTTP."""
    helped = subprocess.run([program, "ask", "--help"], capture_output=True, text=True)
    if "speaks no HTTP" in helped.stderr:
        pytest.skip("this build speaks no HTTP")
    return program


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A small synthetic data set, made here: graphs and annotations, no pictures."""
    folder = tmp_path_factory.mktemp("small")
    enfilade.write_small_dataset(str(folder))
    return str(folder)


@pytest.fixture(scope="session")
def made(small: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set with a tiny split of each benchmark, SYNTHETIC."""
    folder = tmp_path_factory.mktemp("tasks")
    make_tasks(small, folder)
    return folder


@pytest.fixture(scope="session")
def homes(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Model homes with pictures, synthetic, as the notebooks make them: half a minute of one core."""
    from enfilade import synth

    folder = str(tmp_path_factory.mktemp("homes"))
    report = synth.write_homes(folder, homes=3, face_size=64)
    assert report.homes == 3 and report.paths > 0 and report.instructions == 3 * report.paths
    return folder


@pytest.fixture(scope="session")
def connectivity(data: Path) -> str:
    return str(data / "connectivity")


@pytest.fixture
def make(connectivity: str) -> Callable[..., Any]:
    """Makes a MatterSim.Simulator of the real graphs, without pictures."""
    return functools.partial(make_simulator, connectivity)


@pytest.fixture(scope="session")
def reference(data: Path) -> Path:
    """The folder of what was recorded of the old simulator: ENFILADE_REFERENCE, or `reference`
    beside ENFILADE_DATA."""
    folder = Path(os.environ.get("ENFILADE_REFERENCE") or data.parent / "reference")
    if not folder.is_dir():
        pytest.skip(f"{folder} is no folder: no recordings of the old simulator")
    return folder
