#!/usr/bin/env python3
"""Makes a scan from each mesh of some folders, and prints what became of each file.

  tests/corpus/meshes.py build/release/bin/enfilade FOLDER... [--parts skybox] [--limit SECONDS]

Each file has a process of its own, `enfilade scan-mesh FILE --room`, with depth of 16 pixels at ten
viewpoints. The table has a row per file: read or refused, seconds of the whole process, triangles,
and the first error or the number of warnings. "no scan" is read, but too large for a scan. A crash,
or a file over the limit, makes the exit code 1.
`--parts skybox` also computes light. That takes minutes on a surface of 100,000 m2, which files in
millimetres have without `--options "--scale 0.001"`.
docs/mesh.md names folders that have such files.
"""

import argparse
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import time

SUFFIXES = {".glb", ".gltf", ".obj", ".ply"}


def find_meshes(folders: list[pathlib.Path]) -> list[pathlib.Path]:
    """The mesh files in and below the folders, sorted. A file stands for itself."""
    found: set[pathlib.Path] = set()
    for folder in folders:
        files = folder.rglob("*") if folder.is_dir() else [folder]
        found.update(f for f in files if f.suffix.lower() in SUFFIXES and f.is_file())
    return sorted(found)


def run_one(program: str, mesh: pathlib.Path, limit: float, options: list[str]) -> dict:
    """Runs the program on one mesh; the fields of its row."""
    with tempfile.TemporaryDirectory() as made:
        command = [program, "scan-mesh", str(mesh), "--room", "-o", f"{made}/data"]
        command += ["--scan", "one", "--size", "16", "--limit", "10", *options]
        begin = time.monotonic()
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, errors="replace", timeout=limit, check=False
            )
        except subprocess.TimeoutExpired:
            return {"result": "hangs", "seconds": limit, "triangles": "", "why": f"over {limit:g} s"}
        seconds = time.monotonic() - begin
    triangles = re.search(r": (\d+) triangles", done.stdout)
    row = {"seconds": seconds, "triangles": triangles.group(1) if triangles else ""}
    if done.returncode == 0:
        odd = len(re.findall(r"^(?:warning|note): ", done.stderr, re.MULTILINE))
        return {**row, "result": "read", "why": f"{odd} warnings" if odd else ""}
    if done.returncode not in (2, 3):  # the program's own; 1 is a sanitizer's
        return {**row, "result": "crashes", "why": f"exit code {done.returncode}"}
    told = re.compile(r"warning: |note: |\d+ errors?, ")
    lines = [line for line in done.stderr.splitlines() if line and not told.match(line)]
    why = lines[0] if lines else "without a word"
    result = "no scan" if row["triangles"] else "refused"
    return {**row, "result": result, "why": why.replace(str(mesh), mesh.name)[:200]}


def main() -> int:
    """Prints the table; 1 if a file crashes the program or is over the limit."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("program", help="the program enfilade")
    parser.add_argument("folders", nargs="+", type=pathlib.Path, help="folders of mesh files")
    parser.add_argument("--limit", type=float, default=10, help="seconds per file, 10 by default")
    parser.add_argument("--parts", default="depth", help="of the scan, depth by default")
    parser.add_argument("--options", default="", help="further options of scan-mesh")
    arguments = parser.parse_args()
    meshes = find_meshes(arguments.folders)
    if not meshes:
        print("no mesh file (.glb, .gltf, .obj, .ply) is there", file=sys.stderr)
        return 2
    options = ["--parts", arguments.parts, *shlex.split(arguments.options)]
    counts: dict[str, int] = {}
    slowest, slowest_mesh = 0.0, None
    print("| file | result | seconds | triangles | why |\n|---|---|---|---|---|")
    for mesh in meshes:
        row = run_one(arguments.program, mesh, arguments.limit, options)
        counts[row["result"]] = counts.get(row["result"], 0) + 1
        if row["seconds"] > slowest:
            slowest, slowest_mesh = row["seconds"], mesh
        why = row["why"].replace("|", "\\|")
        print(f"| {mesh} | {row['result']} | {row['seconds']:.1f} | {row['triangles']} | {why} |", flush=True)
    total = ", ".join(f"{n} {result}" for result, n in sorted(counts.items()))
    print(f"\n{len(meshes)} files: {total}; the slowest took {slowest:.1f} s ({slowest_mesh})")
    return 1 if counts.keys() & {"crashes", "hangs"} else 0


if __name__ == "__main__":
    sys.exit(main())
