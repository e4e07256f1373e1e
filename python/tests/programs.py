"""Runs the program `enfilade` for tests."""

from __future__ import annotations

import os
import subprocess

import pytest


def run(*arguments: object) -> str:
    """The program's standard output; it has to succeed."""
    program = os.environ.get("ENFILADE_COMMAND") or os.environ.get("ENFILADE_PROGRAM")
    if not program:
        pytest.skip("ENFILADE_COMMAND names no program")
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=1200)
    assert done.returncode == 0, done.stderr
    return done.stdout
