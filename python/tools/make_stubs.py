"""Writes the type stubs of the extension module: run it when bindings change.

    PYTHONPATH=build/NAME/python python python/tools/make_stubs.py

Needs nanobind. With --check it writes nothing; its exit status is 0 if the stubs are up to date, else 1.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path

HEADER = "# Made by python/tools/make_stubs.py.\n"


def make_stubs() -> str:
    from nanobind.stubgen import StubGen

    generator = StubGen(importlib.import_module("enfilade._core"), quiet=True)
    generator.put(generator.module)
    # The drop-in's names have stubs of their own, in MatterSim/.
    # Memory to draw into may be of any library; strict checkers require the parameter of PathLike.
    lines = [
        line.replace("Annotated[NDArray, ", "Annotated[Any, ").replace("PathLike", "PathLike[str]")
        for line in generator.get().splitlines()
        if line != "from enfilade._core import mattersim as mattersim"
    ]
    return HEADER + "\n".join(lines).strip() + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare only")
    check = parser.parse_args().check
    file = Path(__file__).parent.parent / "enfilade" / "_core.pyi"
    stubs = make_stubs()
    if check:
        return 0 if file.exists() and file.read_text() == stubs else 1
    file.write_text(stubs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
