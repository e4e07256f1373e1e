"""Files with computed names are written below a folder, never outside: enfilade::OutputFolder of C++."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from enfilade._errors import FileError


def is_name(name: str) -> bool:
    """Whether a text is a path of a file below a folder, with `/` between folders.

    Unlike in C++ a part may begin with a dot: folders of users are copied, with all that is in them.
    """
    parts = name.split("/")
    return all(part not in ("", ".", "..") for part in parts) and not any(
        c == "\\" or ord(c) < 32 or ord(c) == 127 for c in name
    )


def output_file(folder: Path, name: str) -> Path:
    """The path of the file `name` below `folder`. Makes its folders. Removes a link in place of the file.

    Raises FileError for a name that leads elsewhere, and for a link among its folders.
    """
    if not is_name(name):
        raise FileError(f"{folder}: {name[:40]!r} is not a name of a file in this folder")
    folder.mkdir(parents=True, exist_ok=True)
    *folders, last = name.split("/")
    for one in folders:
        folder = folder / one
        if folder.is_symlink():
            raise FileError(f"{folder}: a link stands in the place of a folder")
        folder.mkdir(exist_ok=True)
    file = folder / last
    if file.is_symlink():
        file.unlink()
    return file


@contextlib.contextmanager
def whole_file(folder: Path, name: str) -> Iterator[Path]:
    """A new temporary file beside output_file(), which gets its name at the end, if nothing is raised."""
    file, part = output_file(folder, name), output_file(folder, name + ".part")
    part.unlink(missing_ok=True)
    yield part
    part.replace(file)


def write_whole(folder: Path, name: str, content: bytes) -> None:
    """Writes output_file() whole or not at all."""
    with whole_file(folder, name) as part:
        part.write_bytes(content)
