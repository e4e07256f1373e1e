"""Navigation meshes of habitat_sim that were made before."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

np = pytest.importorskip("numpy")
pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")

pytest.register_assert_rewrite("habitat_rooms")

import habitat_sim  # noqa: E402
from enfilade._eyes import habitat as native  # noqa: E402
from habitat_rooms import settings  # noqa: E402
from habitat_sim.nav._mesh_cache import made_mesh  # noqa: E402

pytest_plugins = ["habitat_rooms"]


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "enfilade" / "navmesh"


def test_a_mesh_is_made_once(rooms: Path, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = str(rooms / "room.glb")
    made = made_mesh(scene, "z", settings(), "latest")
    assert len(list(cache.iterdir())) == 1
    with monkeypatch.context() as patch:
        patch.setattr(native.Floor, "make", None)  # calling it would raise
        kept = made_mesh(scene, "z", settings(), "latest")
    assert kept.file() == made.file() and kept.bounds == made.bounds
    assert kept.bounds != native.Floor.read(made.file(), "a").bounds  # a file's are those of its tile


@pytest.mark.parametrize("other", [("y", 0.1, "latest"), ("z", 0.2, "latest"), ("z", 0.1, "0.3.3")])
def test_another_question_is_another_mesh(rooms: Path, cache: Path, other: Any) -> None:
    up, radius, navigation = other
    made_mesh(str(rooms / "room.glb"), "z", settings(), "latest")
    try:
        made_mesh(str(rooms / "room.glb"), up, settings(radius), navigation)
    except habitat_sim.nav._path_finder.InvalidInput:  # on its side it may have no floor
        assert up == "y"
        return
    assert len(list(cache.iterdir())) == 2


def test_a_damaged_one_is_made_anew(rooms: Path, cache: Path) -> None:
    made = made_mesh(str(rooms / "room.glb"), "z", settings(), "latest")
    (kept,) = cache.iterdir()
    kept.write_bytes(kept.read_bytes()[:200])
    assert made_mesh(str(rooms / "room.glb"), "z", settings(), "latest").file() == made.file()
    assert len(kept.read_bytes()) == 24 + len(made.file())


def test_a_cache_that_cannot_be_written_is_no_error(rooms: Path, cache: Path) -> None:
    cache.parent.mkdir()
    cache.write_text("a file where the folder should be")
    assert made_mesh(str(rooms / "room.glb"), "z", settings(), "latest").islands > 0
