"""The page of habitat_sim, the drop-in: its code runs, it names every call, and the tests that it names exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

np = pytest.importorskip("numpy")
pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")

pytest.register_assert_rewrite("habitat_rooms")

import habitat_sim  # noqa: E402
from habitat_rooms import configuration, write_room  # noqa: E402

pytest_plugins = ["habitat_rooms"]

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "python_habitat_sim.md").read_text()

WITHOUT_EFFECT = {
    "create_renderer": False, "force_separate_semantic_scene_graph": True, "frustum_culling": False,
    "gpu_device_id": -1, "leave_context_with_background_renderer": True, "load_semantic_mesh": False,
    "override_scene_light_defaults": True, "physics_config_file": "none.json", "requires_textures": False,
    "use_semantic_textures": False,
}  # fmt: skip


def test_the_pages_code_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_room(tmp_path / "room.glb", "z")
    blocks = re.findall(r"^```python\n(.*?)^```$", TEXT, re.M | re.S)
    assert blocks
    for number, block in enumerate(blocks):
        exec(compile(block, f"python_habitat_sim.md, block {number}", "exec"), {})


@pytest.mark.parametrize(
    "kind",
    [habitat_sim.Simulator, habitat_sim.PathFinder, habitat_sim.SimulatorConfiguration,
     habitat_sim.GreedyGeodesicFollower],
)  # fmt: skip
def test_the_page_names_every_call(kind: type) -> None:
    missing = [name for name in dir(kind) if name[0] != "_" and not re.search(rf"\b{name}\b", TEXT)]
    assert missing == []


def test_the_tests_of_the_page_exist() -> None:
    python = "".join(file.read_text() for file in Path(__file__).parent.glob("test_*habitat*.py"))
    folder = ROOT / "enfilade" / "continuous" / "habitat"
    cpp = "".join(file.read_text() for file in folder.glob("*_test.cpp"))
    ours = set(re.findall(r"`(test_\w+)`", TEXT))
    theirs = set(re.findall(r"`(Habitat\w+)\.(\w+)`", TEXT))
    assert len(ours) > 20 and len(theirs) > 10
    assert [name for name in ours if f"def {name}(" not in python] == []
    assert [name for name in theirs if f"({', '.join(name)})" not in cpp] == []


@pytest.mark.parametrize(("name", "value"), WITHOUT_EFFECT.items())
def test_fields_without_effect_are_accepted(rooms: Path, name: str, value: object) -> None:
    with habitat_sim.Simulator(configuration(rooms / "room.glb", **{name: value})) as sim:
        assert getattr(sim.config.sim_cfg, name) == value
        assert getattr(habitat_sim.SimulatorConfiguration(), name) != value
