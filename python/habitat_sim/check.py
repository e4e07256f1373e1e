"""Compares habitat_sim with what the real Habitat-Sim answered: `python -m habitat_sim.check --help`."""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Optional

from . import _check_api as api
from . import _check_navigation as navigation
from . import _check_streamvln as streamvln
from . import _check_views as views
from ._check_scenes import (
    CheckError,
    Job,
    check_scenes,
    make_episodes,
    make_scenes,
    read_json,
)
from ._check_tally import Tally


@dataclass(frozen=True)
class Section:
    """A folder of recordings, and what checks it."""

    needs: str  # a pattern of the files without which nothing was recorded
    parts: Callable[[Path], list[str]]
    check: Callable[[Job, str, Tally], None]
    folder: Optional[str] = None  # where its files are; without: in the folder of its name


MESHES = Section("*", navigation.mesh_parts, navigation.check_mesh)
WALKS = Section("*_walks.npz", navigation.walk_parts, navigation.check_walks)
SECTIONS = {
    "api": Section(api.FILE, api.api_parts, api.check_api, "."),
    "nav": MESHES,
    "nav_v0.3.3": MESHES,
    "nav_config": MESHES,
    "walks": WALKS,
    "walks_v0.3.3": WALKS,
    "follower": Section(
        "greedy_follower.jsonl.gz", navigation.follower_parts, navigation.check_follower
    ),
    "sensors": Section("poses.json", views.sensor_parts, views.check_sensors),
    "semantic": Section("*_scene.json", views.semantic_parts, views.check_semantic),
    "lab": Section("vln_episodes.jsonl.gz", views.lab_parts, views.check_lab),
    "streamvln": Section(streamvln.FILE, streamvln.streamvln_parts, streamvln.check_streamvln, "lab"),
}
"""Every folder that can be compared. A new one is a row here."""

ABOUT = f"""\
Compares every recording of FOLDER with what habitat_sim answers to the same questions.
FOLDER is one of vectors of the real Habitat-Sim: scenes.json and the folders of its recordings.

Sections: {", ".join(SECTIONS)}.
"""

MORE = f"""\
A value is one scalar, point or row that was asked:
  api.json           each name, default and member of an enumeration. A refused name is there if it
                     says so in words. What is left out on purpose is counted apart
  navmeshes.json     each number, point and SHA-256; times are left out
  *.navmesh.gz       the whole file, byte for byte
  *_queries.npz      each point and number; the points of one path; each row of a view from above
  *_walks.npz        each position, rotation and collision
  greedy_follower    each word of actions, and where and how it ends
  sensors            each position, shape and type; each picture: depth within
                     {views.DEPTH_ERROR * 1000:g} mm or {views.DEPTH_STEPS} steps of the recorded z-buffer (14 mm at 48 m)
                     at {views.DEPTH_SHARE:.1%} of pixels, colour within {views.COLOUR_ERROR} of 255 levels at {views.COLOUR_SHARE:.0%}
  semantic           each name, number, point and box's corner
  lab                each field of each step; pictures by shape, type and mean
  streamvln_stub     each field of each result: the actions of its texts again, without habitat-lab
Numbers are equal to the bit. A question that raises an error is a mismatch.
What cannot run here is left out, says why, and does not count as equal: a package is not installed,
or habitat_sim raises NotImplementedError.

Scenes: DIR has mp3d/SCAN/SCAN.glb (z up, SCAN.house beside it), yup/SCAN.glb with
homes.scene_dataset_config.json, connectivity/, and vlnce/ for lab and streamvln. Without --scenes they are made
in a temporary folder by the command in scenes.json. Their SHA-256 have to be the recorded ones.

Exit status: 0 all is equal; 1 mismatches, or with --strict anything left out; 2 nothing could be compared.

To ask another habitat_sim, copy check.py and _check_*.py into a folder: python -m FOLDER.check ...

Examples:
  python -m habitat_sim.check reference/habitat
  python -m habitat_sim.check reference/habitat --only nav,walks --program build/enfilade
  python -m habitat_sim.check holdout --scenes SCENES --strict
"""


def main(arguments: Optional[list[str]] = None) -> int:
    """The program. Returns the exit status."""
    chosen = _parser().parse_args(arguments)
    try:
        return _check(chosen)
    except CheckError as e:
        print(f"habitat_sim.check: {e}", file=sys.stderr)
        return 2


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m habitat_sim.check",
        description=ABOUT,
        epilog=MORE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="the recordings")
    parser.add_argument(
        "--scenes", type=Path, metavar="DIR", help="the recorded scenes; else they are made"
    )
    parser.add_argument(
        "--program", metavar="ENFILADE", help="the program that makes them (enfilade on PATH)"
    )
    parser.add_argument("--only", type=_sections, metavar="SECTIONS", help="nav,walks,...: these alone")
    parser.add_argument("--strict", action="store_true", help="exit status 1 if anything is left out")
    parser.add_argument(
        "--jobs", type=_jobs, default=os.cpu_count() or 1, help="processes (one a core)"
    )
    return parser


def _sections(text: str) -> list[str]:
    names = text.split(",")
    for name in names:
        if name not in SECTIONS:
            raise argparse.ArgumentTypeError(f"{name!r} is not one of {', '.join(SECTIONS)}")
    return names


def _jobs(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 256:
        raise argparse.ArgumentTypeError(f"{text!r}: 1 to 256 are allowed")
    return int(text)


def _check(chosen: argparse.Namespace) -> int:
    work = _work(chosen.folder, chosen.only or list(SECTIONS))
    recorded = read_json(chosen.folder / "scenes.json")
    if not isinstance(recorded, dict) or not recorded.get("homes"):
        raise CheckError(f'{chosen.folder / "scenes.json"}: "homes" is missing or empty')
    with tempfile.TemporaryDirectory() as temporary:
        os.environ["XDG_CACHE_HOME"] = temporary  # no mesh of an earlier run
        scenes = chosen.scenes
        if scenes is None:
            scenes = Path(temporary)
            print("making the recorded scenes", file=sys.stderr, flush=True)
            make_scenes(recorded, scenes, chosen.program)
            if "lab" in work or "streamvln" in work:
                make_episodes(scenes, chosen.program)
        else:
            check_scenes(recorded, scenes)
        found = _compare(chosen.folder, scenes.resolve(), work, chosen.jobs)
    return _report(found, chosen.only or list(SECTIONS), chosen.strict)


def _work(folder: Path, names: list[str]) -> dict[str, list[str]]:
    """The parts of each section that was recorded. Raises CheckError for a folder that is not one of recordings."""
    if not (folder / "scenes.json").is_file():
        raise CheckError(f"{folder}: no folder of recordings: it has no scenes.json")
    work = {}
    for name in names:
        section = SECTIONS[name]
        here = folder / (section.folder or name)
        if here.is_dir() and any(here.glob(section.needs)):
            try:
                work[name] = section.parts(here)
            except (KeyError, OSError, TypeError, ValueError) as e:
                raise CheckError(f"{here}: it cannot be read: {_words(e)}") from None
    if not any(work.values()):
        raise CheckError(f"{folder}: it has no recordings of {', '.join(names)}")
    return work


def _compare(folder: Path, scenes: Path, work: dict[str, list[str]], jobs: int) -> dict[str, Tally]:
    """All parts, in several processes: C's random numbers are one state a process."""
    order = [(name, part) for name, parts in work.items() for part in parts]
    results: dict[tuple[str, str], Tally] = {}
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(order)), context) as pool:
        futures: dict[Future[Tally], tuple[str, str]] = {
            pool.submit(check_part, Job(folder, name, scenes), part): (name, part)
            for name, part in order
        }
        for future in _progress(futures, work):
            try:
                results[futures[future]] = future.result()
            except BrokenProcessPool:
                raise CheckError(f"a process crashed near {' '.join(futures[future])}") from None
    found = {name: Tally() for name in work}
    for name, part in order:
        found[name].add(results[name, part])
    return found


def check_part(job: Job, part: str) -> Tally:
    """One part of a section, in a process of its own."""
    tally = Tally()
    try:
        with tally.leaving_out():
            SECTIONS[job.folder].check(job, part, tally)
    except Exception as e:  # whatever a module raises that lacks something
        tally.values += 1
        tally.wrong(f"{job.folder}: {part}", "answers", _words(e))
    return tally


def _words(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"


def _progress(futures: dict[Any, tuple[str, str]], work: dict[str, list[str]]) -> Iterator[Any]:
    """The futures as they end. Shows a bar on a terminal, else a line for each section that ends."""
    bar, missing = sys.stderr.isatty(), {name: len(parts) for name, parts in work.items()}
    for done, future in enumerate(as_completed(futures), 1):
        yield future
        name, part = futures[future]
        missing[name] -= 1
        if bar:
            filled = 30 * done // len(futures)
            text = f"[{'#' * filled:.<30}] {done}/{len(futures)} {name} {part}"
            print(f"\r{text:<79.79}", end="", file=sys.stderr, flush=True)
        elif missing[name] == 0:
            print(f"{name}: done", file=sys.stderr, flush=True)
    if bar:
        print(f"\r{'':79}\r", end="", file=sys.stderr, flush=True)


def _report(found: dict[str, Tally], names: list[str], strict: bool) -> int:
    whole = Tally()
    for name in names:
        tally = found.get(name)
        if tally is None:
            print(f"{name}: not recorded here")
            continue
        counts = f"{tally.values} values, {tally.mismatches} mismatches"
        if tally.on_purpose:
            counts += f"; {tally.on_purpose} names left out on purpose"
        reasons = "; ".join(tally.left_out)
        print(f"{name}: {counts}" + (f"; left out: {reasons}" if reasons else ""))
        for line in tally.shown:
            print(f"  {line}")
        if tally.mismatches > len(tally.shown):
            print(f"  and {tally.mismatches - len(tally.shown)} more")
        whole.add(tally)
    print(f"{whole.values} values, {whole.mismatches} mismatches")
    if whole.values == 0:
        print("habitat_sim.check: nothing could be compared", file=sys.stderr)
        return 2
    return int(whole.mismatches > 0 or (strict and bool(whole.left_out)))


if __name__ == "__main__":
    sys.exit(main())
