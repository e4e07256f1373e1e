"""Where tests find data. Real data and recordings are never in the repository: tests that need them
skip, and say so."""

from __future__ import annotations

import os
from pathlib import Path

import enfilade
import pytest


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of the real graphs and annotations."""
    folder = os.environ.get("ENFILADE_DATA")
    if not folder:
        pytest.skip("ENFILADE_DATA is not set: no real navigation graphs")
    return Path(folder)


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A small synthetic data set, made here: graphs and annotations, no pictures."""
    folder = tmp_path_factory.mktemp("small")
    enfilade.write_small_dataset(str(folder))
    return str(folder)


@pytest.fixture(scope="session")
def connectivity(data: Path) -> str:
    return str(data / "connectivity")


@pytest.fixture(scope="session")
def reference(data: Path) -> Path:
    """The folder of what was recorded of the old simulator: ENFILADE_REFERENCE, or `reference`
    beside ENFILADE_DATA."""
    folder = Path(os.environ.get("ENFILADE_REFERENCE") or data.parent / "reference")
    if not folder.is_dir():
        pytest.skip(f"{folder} is no folder: no recordings of the old simulator")
    return folder
