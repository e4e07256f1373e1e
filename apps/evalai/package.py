#!/usr/bin/env python3
"""Makes the archive that the host of an EvalAI challenge uploads as its evaluation script.

    python3 apps/evalai/package.py --connectivity DATA/connectivity --phases phases.json -o evaluation.zip

In it: the package that workers import, the program `enfilade` with every library that it needs, the loader and the C
library included, the graphs, the phases. So the worker needs Python and a Linux kernel of this machine's
architecture, and nothing of its distribution. Secret annotations do not belong in it: EvalAI takes
them as `test_annotation_file` of each phase. The same inputs give the same bytes.
"""

import argparse
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import main

HERE = Path(__file__).resolve().parent
PROGRAM = HERE.parent.parent / "build" / "release" / "bin" / "enfilade"
LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the earliest that archives know
LOADER = "ld.so"  # main.py looks for it


def libraries_of(program):
    """Every library that the program is linked to, by the name that it asks for, and the loader."""
    listed = subprocess.run(["ldd", str(program)], capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        raise SystemExit(f"{program}: {listed.stderr.strip() or listed.stdout.strip()}")
    missing = re.findall(r"^\s*(\S+) => not found", listed.stdout, re.MULTILINE)
    if missing:
        raise SystemExit(f"{program}: needs {', '.join(missing)}, not on this machine")
    found = dict(re.findall(r"^\s*(\S+) => (/\S+) \(", listed.stdout, re.MULTILINE))
    loader = re.search(r"^\s*(/\S*/ld\S+) \(", listed.stdout, re.MULTILINE)
    if loader is None:
        raise SystemExit(f"{program}: linked to no loader; ldd says:\n{listed.stdout}")
    found[LOADER] = loader.group(1)
    return found


def contents(options):
    """What the archive has: names in it, and files."""
    files = {name: HERE / name for name in ("__init__.py", "main.py")}
    files["bin/enfilade"] = options.program
    files.update({f"lib/{name}": Path(file) for name, file in libraries_of(options.program).items()})
    names = ("*_connectivity.json", "*_connectivity.json.gz")
    graphs = sorted(file for name in names for file in options.connectivity.glob(name))
    scans = options.connectivity / "scans.txt"
    if not graphs or not scans.exists():
        raise SystemExit(f"{options.connectivity}: no scans.txt with SCAN_connectivity.json beside it")
    files.update({f"connectivity/{file.name}": file for file in [scans, *graphs]})
    if options.phases:
        files["phases.json"] = options.phases
    return files


def write(files, output):
    with zipfile.ZipFile(output, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, file in sorted(files.items()):
            entry = zipfile.ZipInfo(name, LONG_AGO)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, file.read_bytes())


def run():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--program", type=Path, default=PROGRAM, help="default: %(default)s")
    parser.add_argument("--connectivity", type=Path, required=True, help="folder of the graphs")
    parser.add_argument("--phases", type=Path, help="phases of the challenge: docs/service_evaluation.md")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the archive")
    options = parser.parse_args()
    for file in filter(None, [options.program, options.phases]):
        if not file.is_file():
            parser.error(f"{file}: no such file")
    if options.phases:
        try:
            main.load_phases(options.phases)
        except RuntimeError as error:
            parser.exit(3, f"{error}\n")
    write(contents(options), options.output)
    print(f"{options.output}: {options.output.stat().st_size / 1e6:.1f} MB", file=sys.stderr)


if __name__ == "__main__":
    run()
