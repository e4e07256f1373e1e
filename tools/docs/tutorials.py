#!/usr/bin/env python3
"""Runs a tutorial as its reader would: writes its files, runs its commands, compares what they print.

    tutorials.py docs/tutorials/first_agent.md --build build/release [--python PYTHON] [--update] [--keep FOLDER]

What to do with a block stands behind its language, where no reader of the page sees it:

    ```sh run                 commands; each block in one bash, all blocks in one folder
    ```python file=agent.py   written to that file
    ```text output            what the commands before it print. "..." stands for anything within a line, and a
                              line "..." for any lines; numbers of seconds need it
    ```text output loose      the same with other numbers allowed: what a network learns differs between processors

`<!-- needs: python torch -->` says what must be built; where it is not, the status is 77 and the last line says why.
`![words](../images/x.svg)<!-- x.svg -->` is a picture that the commands have made. --update writes outputs and
pictures anew from what came. Standard library only.
"""

from __future__ import annotations

import argparse
import difflib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

SKIPPED = 77
_BLOCK = re.compile(r"^```([\w+-]*)[ \t]*([^\n]*)\n(.*?)^```[ \t]*$", re.M | re.S)
_PICTURE = re.compile(r"!\[[^\]]*\]\(([^)\s]+)\)<!-- (\S+) -->")


@dataclass
class Block:
    """A fenced block that the runner cares about."""

    what: str  # "run", "output" or "file"
    file: str
    loose: bool
    text: str
    line: int
    begin: int  # of the text within the page
    end: int


def blocks_of(page: str) -> list[Block]:
    blocks = []
    for found in _BLOCK.finditer(page):
        words = found[2].split()
        file = next((word[5:] for word in words if word.startswith("file=")), "")
        what = "file" if file else next((word for word in words if word in ("run", "output")), "")
        if what:
            line = page.count("\n", 0, found.start()) + 1
            blocks.append(Block(what, file, "loose" in words, found[3], line, found.start(3), found.end(3)))
    return blocks


def matches(wanted: str, came: str, loose: bool = False) -> bool:
    """Whether it is what was wanted, "..." standing for anything; loose: with other numbers, intervals or none."""
    if loose:
        return matches(_without_numbers(wanted), _without_numbers(came))
    pattern = ""
    for line in wanted.rstrip().split("\n"):
        if line.strip() == "...":
            pattern += r"(?:[^\n]*\n)*?"
        else:
            pattern += ".*?".join(re.escape(part) for part in line.rstrip().split("...")) + "\n"
    tidy = "\n".join(line.rstrip() for line in came.rstrip().split("\n")) + "\n"
    return re.fullmatch(pattern, tidy) is not None


def _without_numbers(text: str) -> str:
    text = re.sub(r" *\[-?[\d.]+, -?[\d.]+\]", "", text)
    return re.sub(r"[ \t]+", " ", re.sub(r"-?\d+(\.\d+)?", "0", text))


class Tutorial:
    def __init__(self, page: Path, build: Path, python: list[str]) -> None:
        """python: the command that starts it, as in ["env", "NAME=VALUE", "/usr/bin/python3"]"""
        self.page, self.build, self.python = page, build.resolve(), python
        self.text = page.read_text(encoding="utf-8")
        self.blocks = blocks_of(self.text)
        needs = re.search(r"<!-- needs: (.*?) -->", self.text)
        self.needs = needs[1].split() if needs else []

    def missing(self) -> str:
        """Why it cannot be run here; empty if it can."""
        cache = (self.build / "CMakeCache.txt").read_text(encoding="utf-8")
        if not (self.build / "bin/enfilade").exists():
            return "the program enfilade is not built"
        if "python" in self.needs and not list(self.build.glob("python/enfilade/_core*.so")):
            return "the Python package is not built: EN_BUILD_PYTHON is off"
        if "torch" in self.needs and "EN_WITH_TORCH:BOOL=ON" not in cache:
            return "EN_WITH_TORCH is off"
        if "cmake" in self.needs and not re.search(r"EN_SANITIZE:STRING=\n", cache):
            return "its C++ is not built with sanitizers"
        return ""

    def environment(self, folder: Path) -> dict[str, str]:
        programs = folder / ".bin"
        programs.mkdir()
        (programs / "enfilade").symlink_to(self.build / "bin/enfilade")
        # A link would lose the environment that it belongs to.
        for name in ("python", "python3"):
            (programs / name).write_text(f'#!/bin/sh\nexec {shlex.join(self.python)} "$@"\n')
            (programs / name).chmod(0o755)
        kept = {k: v for k, v in os.environ.items() if not k.startswith("ENFILADE_")}
        return {**kept, "PATH": f"{programs}:{os.environ['PATH']}", "PYTHONPATH": f"{self.build}/python",
                "PYTHONDONTWRITEBYTECODE": "1", "HOME": str(folder / ".home"), "COLUMNS": "100"}  # fmt: skip

    def run(self, folder: Path, update: bool) -> int:
        """The number of blocks that did not do what the page says."""
        environment, came, wrong, changes = self.environment(folder), "", 0, []
        (folder / ".home").mkdir()
        if "cmake" in self.needs:
            subprocess.run(["cmake", "--install", self.build, "--prefix", folder / ".home/enfilade"], check=True, stdout=subprocess.DEVNULL)
        for block in self.blocks:
            where = f"{self.page}:{block.line}"
            if block.what == "file":
                (folder / block.file).parent.mkdir(parents=True, exist_ok=True)
                (folder / block.file).write_text(block.text, encoding="utf-8")
            elif block.what == "run":
                print(f"{where}: {block.text.strip()}", flush=True)
                done = subprocess.run(["bash", "-euo", "pipefail", "-c", block.text], cwd=folder, env=environment,
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)  # fmt: skip
                came = done.stdout.replace(str(folder), "~")
                if done.returncode != 0:
                    print(f"{came}\n{where}: this failed with status {done.returncode}")
                    return wrong + 1
            elif not matches(block.text, came, block.loose):
                if update:
                    changes.append((block, came.rstrip() + "\n"))
                    continue
                wrong += 1
                print(f"{where}: the page says something else than the commands:")
                print("".join(difflib.unified_diff(block.text.splitlines(True), came.splitlines(True), "page", "output")))
        wrong += self.pictures(folder, update)
        for block, new in reversed(changes):
            self.text = self.text[: block.begin] + new + self.text[block.end :]
        if changes:
            self.page.write_text(self.text, encoding="utf-8")
        return wrong

    def pictures(self, folder: Path, update: bool) -> int:
        wrong = 0
        for link, made in _PICTURE.findall(self.text):
            if not (folder / made).exists():
                print(f"{self.page}: the commands have not made the picture {made}")
                wrong += 1
            elif update:
                shutil.copyfile(folder / made, self.page.parent / link)
        return wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=Path)
    parser.add_argument("--build", type=Path, required=True, help="a finished build of Enfilade")
    parser.add_argument("--python", default=sys.executable, help="the Python that its package was built for")
    parser.add_argument("--python-environment", metavar="NAME=VALUE", nargs="*", default=[], help="for that Python only")
    parser.add_argument("--update", action="store_true", help="write outputs and pictures into the page")
    parser.add_argument("--keep", type=Path, help="work in this new folder, and leave it")
    arguments = parser.parse_args()
    python = ["env", *arguments.python_environment, os.path.abspath(arguments.python)]
    tutorial = Tutorial(arguments.page.resolve(), arguments.build, python)
    reason = tutorial.missing()
    if reason:
        print(f"the tutorial is skipped: {reason}")
        return SKIPPED
    if arguments.keep:
        arguments.keep.mkdir(parents=True)
        return 1 if tutorial.run(arguments.keep.resolve(), arguments.update) else 0
    with tempfile.TemporaryDirectory() as folder:
        return 1 if tutorial.run(Path(folder).resolve(), arguments.update) else 0


if __name__ == "__main__":
    sys.exit(main())
