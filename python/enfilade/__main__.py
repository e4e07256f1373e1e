"""`python -m enfilade` runs the program `enfilade` that was installed with this package."""

from __future__ import annotations

import os
import sys
import sysconfig
from pathlib import Path


def program() -> Path:
    """The program's file, from the first of pip's folders that has it. Raises SystemExit if none."""
    folders = [
        Path(sysconfig.get_path("scripts")),  # of the environment
        Path(sysconfig.get_path("scripts", "posix_user")),  # pip install --user
        Path(__file__).parents[1] / "bin",  # pip install --target
    ]
    for folder in folders:
        if os.access(folder / "enfilade", os.X_OK):
            return folder / "enfilade"
    raise SystemExit(
        f"enfilade: the program is in none of {', '.join(map(str, folders))}. A package that was built "
        "in place comes without it: ./enfilade.sh build makes it."
    )


if __name__ == "__main__":
    file = str(program())
    os.execv(file, [file, *sys.argv[1:]])
