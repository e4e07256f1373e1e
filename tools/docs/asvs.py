#!/usr/bin/env python3
"""Checks docs/asvs.md: every item of ASVS 4.0.3's level 2 is there once, and the tests and files that it names exist."""

import re
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = ROOT / "docs" / "asvs.md"

# By section, the numbers of its items at levels 1 and 2; what is not there was deleted or is of level 3.
ITEMS = """
1.1:1-7 1.2:1-4 1.4:1,4,5 1.5:1-4 1.6:1-4 1.7:1-2 1.8:1-2 1.9:1-2 1.10:1 1.11:1-2 1.12:2 1.14:1-6
2.1:1-12 2.2:1-3 2.3:1-3 2.4:1-5 2.5:1-7 2.6:1-3 2.7:1-6 2.8:1-7 2.9:1-3 2.10:1-4
3.1:1 3.2:1-4 3.3:1-4 3.4:1-5 3.5:1-3 3.7:1
4.1:1-3,5 4.2:1-2 4.3:1-3
5.1:1-5 5.2:1-8 5.3:1-10 5.4:1-3 5.5:1-4
6.1:1-3 6.2:1-6 6.3:1-2 6.4:1-2
7.1:1-4 7.2:1-2 7.3:1,3,4 7.4:1-3
8.1:1-4 8.2:1-3 8.3:1-8
9.1:1-3 9.2:1-4
10.2:1-2 10.3:1-3
11.1:1-8
12.1:1-3 12.2:1 12.3:1-6 12.4:1-2 12.5:1-2 12.6:1
13.1:1,3-5 13.2:1-3,5-6 13.3:1-2 13.4:1-2
14.1:1-4 14.2:1-6 14.3:2-3 14.4:1-7 14.5:1-4
"""


def numbers(text):
    """Those of "1-3,5"."""
    for part in text.split(","):
        first, _, last = part.partition("-")
        yield from range(int(first), int(last or first) + 1)


def wanted():
    for word in ITEMS.split():
        section, _, items = word.partition(":")
        yield from (f"{section}.{item}" for item in numbers(items))


def listed(cell):
    """The items of "1.2.3, 4.5.1–4.5.3"."""
    for part in cell.split(","):
        first, _, last = part.strip().partition("–")
        section, _, begin = first.rpartition(".")
        yield from (f"{section}.{k}" for k in numbers(f"{begin}-{(last or first).rpartition('.')[2]}"))


def rows():
    """(items, what shows them) of each row; None in tables that have no such column."""
    for line in PAGE.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if line.startswith("| ") and re.match(r"\d", cells[0]):
            yield list(listed(cells[0])), re.findall("`([^`]+)`", cells[2]) if len(cells) > 2 else None


def known_tests():
    """Suite.Name of GoogleTest, and names of CTest."""
    names = set()
    for folder in ("enfilade", "apps", "tests"):
        for file in (ROOT / folder).rglob("*_test.cpp"):
            tests = re.findall(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", file.read_text(), re.MULTILINE)
            names |= {f"{suite}.{name}" for suite, name in tests}
    for file in [*(ROOT / "tests").rglob("CMakeLists.txt"), *(ROOT / "tools").rglob("*.cmake")]:
        names |= set(re.findall(r"add_test\(NAME ([\w.]+)", file.read_text()))
    return names


def not_there(names, tests):
    """Names that are neither tests nor files."""
    return [name for name in names if name not in tests and not (ROOT / name).is_file()]


def report(page, faults):
    """Prints the faults of a page. Returns the exit code."""
    found = list(faults)
    for fault in found:
        print(f"docs/{page}: {fault}")
    return 1 if found else 0


def faults():
    tests, seen = known_tests(), Counter()
    for items, shown in rows():
        seen.update(items)
        if shown == []:
            yield f"{', '.join(items)}: nothing shows it"
        yield from (f"{', '.join(items)}: no test and no file {name}" for name in not_there(shown or [], tests))
    all_items = set(wanted())
    yield from (f"{item}: missing" for item in sorted(all_items - set(seen)))
    yield from (f"{item}: is no item of level 2" for item in sorted(set(seen) - all_items))
    yield from (f"{item}: {times} times" for item, times in seen.items() if times > 1)


if __name__ == "__main__":
    sys.exit(report("asvs.md", faults()))
