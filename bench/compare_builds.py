#!/usr/bin/env python3
"""Two builds of bench_render in turn: walks from a full and from an empty cache, and all 36 views.

    bench/compare_builds.py BEFORE AFTER --images STORES --scans a,b,c

BEFORE and AFTER are bench_render programs of two commits. They run one after the other, several
times, so that what else the machine does meets both; the best of all rounds counts. Prints frames a
second of all threads by the clock, and CPU nanoseconds a pixel of one pinned thread, which other
programs disturb least. With --images-after the second program reads other stores (decoded ones, for
instance) of the same scans.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

RUNS = {
    "hot walk": ["walk", "--cache", "hot", "--batch", "10"],
    "cold walk": ["walk", "--cache", "cold", "--batch", "10"],
    "36-view sweep": ["sweep"],
}


def run(program, images, scans, arguments):
    """Rows of one run by what they measured: (frames a second, CPU nanoseconds a pixel or None)."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "rows.json")
        command = [program, *arguments, "--images", images, "--scans", scans, "--json", str(path)]
        done = subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}: exit status {done.returncode}; its message is above")
        rows = json.loads(path.read_text())["rows"]
    return {
        (f"{row['width']}x{row['height']}", row["outputs"]): (
            max(row["per_second"]),
            row.get("cpu_ns_per_pixel"),
        )
        for row in rows
    }


def better(a, b):
    """The best of two results of one row; a may be missing."""
    if a is None:
        return b
    cpu = [one for one in (a[1], b[1]) if one is not None]
    return max(a[0], b[0]), min(cpu, default=None)


def ratio(before, after):
    return "-" if before is None or after is None else f"{before / after:.2f} x"


def number(value, digits):
    return "-" if value is None else f"{value:.{digits}f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", help="a bench_render")
    parser.add_argument("after", help="a bench_render")
    parser.add_argument("--images", required=True, help="folder of stores, or of scans")
    parser.add_argument("--images-after", help="another one for the second program")
    parser.add_argument("--scans", required=True, help="ids with commas between")
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--outputs", default="rgb")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()

    programs = {
        "before": (options.before, options.images),
        "after": (options.after, options.images_after or options.images),
    }
    print(f"load {os.getloadavg()[0]:.1f} before; best of {options.rounds} rounds in turn")
    print(
        f"{'':<15}{'size':<10}{'outputs':<11}{'frames/s before':>16}{'after':>8}{'gain':>9}"
        f"{'CPU ns/pixel before':>21}{'after':>8}{'gain':>9}"
    )
    for name, arguments in RUNS.items():
        arguments = [*arguments, "--size", options.size, "--outputs", options.outputs, "--reps", "3"]
        best = {}
        for _ in range(options.rounds):
            for side, (program, images) in programs.items():
                for key, result in run(program, images, options.scans, arguments).items():
                    best[key, side] = better(best.get((key, side)), result)
        for key in dict.fromkeys(key for key, _ in best):
            before, after = best[key, "before"], best[key, "after"]
            print(
                f"{name:<15}{key[0]:<10}{key[1]:<11}{before[0]:>16.0f}{after[0]:>8.0f}"
                f"{ratio(after[0], before[0]):>9}{number(before[1], 2):>21}"
                f"{number(after[1], 2):>8}{ratio(before[1], after[1]):>9}",
                flush=True,
            )


if __name__ == "__main__":
    main()
