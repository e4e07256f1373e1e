"""Makes examples/python/notebooks/ from the scripts beside it: run it when they change.

    python python/tools/make_notebooks.py

Needs jupytext. Scripts are in its percent format. Cells tagged active-py belong to the script only, those
tagged active-ipynb to the notebook only. Notebooks hold no outputs. With --check it writes nothing; its
exit status is 0 if the notebooks are up to date, else 1.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import jupytext
import nbformat

SCRIPTS = Path(__file__).resolve().parents[2] / "examples" / "python"


def notebook_of(script: Path) -> str:
    notebook = jupytext.reads(script.read_text(), fmt="py:percent")
    # Cells that are active in the script only arrive as raw cells.
    notebook.cells = [cell for cell in notebook.cells if cell.cell_type != "raw"]
    for number, cell in enumerate(notebook.cells):
        cell.id, cell.metadata = f"cell-{number}", {}
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    nbformat.validate(notebook)
    return nbformat.writes(notebook, indent=1) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare only")
    check = parser.parse_args().check
    status = 0
    for script in sorted(SCRIPTS.glob("*.py")):
        if "# %%" not in script.read_text():
            continue  # a program of a few lines, and no notebook
        file = SCRIPTS / "notebooks" / f"{script.stem}.ipynb"
        text = notebook_of(script)
        if not check:
            file.parent.mkdir(exist_ok=True)
            file.write_text(text)
        elif not file.exists() or file.read_text() != text:
            print(f"{file.name} is not what {script.name} makes", file=sys.stderr)
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())
