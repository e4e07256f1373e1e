"""Starts the program `enfilade-learn`, which `enfilade` calls for what needs PyTorch's library."""

from __future__ import annotations

import importlib.metadata
import os
import sys
from pathlib import Path

HERE = Path(__file__).parent


def fault() -> str:
    """Why the program cannot start here; empty if it can. It fits one minor version of PyTorch."""
    built = (HERE / "torch_version.txt").read_text().strip()
    try:
        found = importlib.metadata.version("torch")
    except importlib.metadata.PackageNotFoundError:
        return f"PyTorch {built}, which it was built for, is not in this environment: pip install torch=={built}"
    if found.split(".")[:2] == built.split(".")[:2]:
        return ""
    return (
        f"it was built for PyTorch {built}, and this environment has {found}. Build it again: "
        "pip install --no-build-isolation --force-reinstall --no-deps ./packaging/learn"
    )


def main() -> None:
    why = fault()
    if why:
        print(f"enfilade-learn: {why}", file=sys.stderr)
        raise SystemExit(3)
    program = HERE / "enfilade-learn"
    os.execv(program, [str(program), *sys.argv[1:]])
