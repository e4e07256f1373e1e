"""packaging/habitat, the wheel of the drop-in habitat_sim."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

tomllib = pytest.importorskip("tomllib", reason="Python before 3.11 has no tomllib")

ROOT = Path(__file__).parents[2]
NAMES = ("corrade", "habitat_sim", "magnum")


def read(file: str) -> Any:
    return tomllib.loads((ROOT / file).read_text(encoding="utf-8"))


def test_it_has_what_the_other_wheel_has_not() -> None:
    wheel = read("packaging/habitat/pyproject.toml")["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert wheel["force-include"] == {f"../../python/{name}": name for name in NAMES}
    whole = read("pyproject.toml")["tool"]["scikit-build"]["wheel"]["packages"]
    here = {file.parent.name for file in ROOT.glob("python/*/__init__.py")}
    assert here == {*NAMES, *(Path(package).name for package in whole)}


def test_it_belongs_to_this_version() -> None:
    own, whole = read("packaging/habitat/pyproject.toml")["project"], read("pyproject.toml")["project"]
    assert own["version"] == whole["version"]
    assert f"enfilade=={whole['version']}" in own["dependencies"]
    assert own["requires-python"] == whole["requires-python"]
    assert own["name"] in whole["optional-dependencies"]["habitat"]
