"""The examples run, on synthetic data, as scripts and as notebooks."""

from __future__ import annotations

import importlib
import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples" / "python"

# What an example needs beside the package, as imported and as called.
NEEDS = {
    "walk_and_see": {"PIL": "Pillow"},
    "extract_features": {"torch": "torch"},
    "imitation": {"torch": "torch"},
    "panoramic_imitation": {"torch": "torch"},
    "rl": {"stable_baselines3": "Stable-Baselines3"},
    "rl_cluster": {"torch": "torch", "ray.rllib": "Ray's RLlib"},
    "port": {},
}
# A piece of what each prints.
SAYS = {
    "walk_and_see": "(4, 480, 640, 3)",
    "extract_features": "(36, 128)",
    "imitation": "after",
    "panoramic_imitation": "after",
    "rl": "after",
    "rl_cluster": "after 8 iterations",
    "port": "every viewpoint",
}
# Those that learn for a minute run once: as notebooks, where those can run.
LEARNERS = {"imitation", "panoramic_imitation", "rl", "rl_cluster"}
NOTEBOOKS = all(importlib.util.find_spec(name) for name in ("nbformat", "nbclient", "ipykernel"))


def skip_without_what_it_needs(example: str) -> None:
    for module, name in NEEDS[example].items():
        try:
            importlib.import_module(module)
        except ImportError:  # also of what it needs itself
            pytest.skip(f"{name} is not installed")


@pytest.mark.parametrize("example", [name for name in SAYS if not NOTEBOOKS or name not in LEARNERS])
def test_a_script_runs(homes: str, small: str, tmp_path: Path, example: str) -> None:
    skip_without_what_it_needs(example)
    of_homes = example in ("walk_and_see", "extract_features", "rl", "rl_cluster")
    arguments = [homes if of_homes else small]
    if example in ("walk_and_see", "extract_features"):
        arguments.append(str(tmp_path / "out"))
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / f"{example}.py"), *arguments], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert SAYS[example] in done.stdout


def test_the_notebooks_are_made_of_the_scripts() -> None:
    pytest.importorskip("jupytext", reason="jupytext is not installed")
    command = [sys.executable, str(ROOT / "python" / "tools" / "make_notebooks.py"), "--check"]
    assert subprocess.run(command).returncode == 0, "run python/tools/make_notebooks.py"


@pytest.mark.parametrize("example", NEEDS)
def test_a_notebook_runs(
    homes: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, example: str
) -> None:
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed")
    skip_without_what_it_needs(example)
    (tmp_path / "homes").symlink_to(homes)  # made already
    for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR"):
        monkeypatch.setenv(name, str(tmp_path / "jupyter"))  # not the user's own
    notebook = nbformat.read(EXAMPLES / "notebooks" / f"{example}.ipynb", as_version=4)
    where = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(notebook, timeout=900, startup_timeout=300, resources=where).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert outputs and all(output.output_type != "error" for output in outputs)
    assert SAYS[example] in "".join(str(output) for output in outputs)
