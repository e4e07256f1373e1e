#!/usr/bin/env python3
"""Checks docs/threats.md: each attack names a test or a fuzzer that shows what holds, and all of them exist."""

import re
import sys

from asvs import ROOT, known_tests, not_there, report

PAGE = ROOT / "docs" / "threats.md"


def attacks():
    """(attack, names of what shows it) of the tables whose last column is "test"."""
    shown = False
    for line in PAGE.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("| ").split(" | ")]
        if not line.startswith("|"):
            shown = False
        elif cells[-1] == "test":
            shown = True
        elif shown and not line.startswith("|---"):
            yield cells[0], re.findall("`([^`]+)`", cells[-1])


def faults():
    tests, all_attacks = known_tests(), list(attacks())
    if not all_attacks:
        yield "no table of attacks"
    for attack, names in all_attacks:
        if not names:
            yield f"{attack}: nothing shows it"
        yield from (f"{attack}: no test and no file {name}" for name in not_there(names, tests))


if __name__ == "__main__":
    sys.exit(report("threats.md", faults()))
