#!/usr/bin/env python3
"""Draws docs/images/architecture.svg: the libraries by their arrows, with the steps of docs/architecture.md's flows.

    architecture.py [--check]      --check: only say whether the file is what would be drawn

The arrows are those of tests/includes/include_arrows.cpp; what is in a library, the words of docs/README.md. The colours can be
read on light and on dark pages. Standard library only.
"""

from __future__ import annotations

import html
import math
import re
import sys
from collections import defaultdict

from markdown_tree import ROOT

PICTURE = ROOT / "docs/images/architecture.svg"
FLOWS = {"A": "#1f6fd0", "B": "#c2410c", "C": "#2e7d32", "D": "#8e24aa"}
WIDTH, BOX, HEIGHT, GAP = 1000, 184, 62, 46  # of the picture; of a box; between rows


def arrows() -> dict[str, set[str]]:
    """Which libraries each includes directly; those that are not there yet are left out."""
    text = (ROOT / "tests/includes/include_arrows.cpp").read_text(encoding="utf-8")
    table = text[text.index("kArrows{") :]
    rows = re.findall(r"\{\"(\w+)\", \{([^}]*)\}\}", table[: table.index("};\n")])
    there = {name for name, _ in rows if list((ROOT / "enfilade" / name).glob("*.h"))}
    return {name: set(re.findall(r"\w+", below)) & there for name, below in rows if name in there}


def reduced(direct: dict[str, set[str]]) -> dict[str, set[str]]:
    """Without the arrows that follow from others."""

    def reach(name: str) -> set[str]:
        return direct[name] | {far for near in direct[name] for far in reach(near)}

    return {name: {to for to in below if not any(to in reach(other) for other in below - {to})}
            for name, below in direct.items()}  # fmt: skip


def words() -> dict[str, str]:
    """What is in each library, in a few words: the table of docs/README.md up to its first pause."""
    text = (ROOT / "docs/README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[(\w+)\]\(\w+\.md\) \| ([^|]*) \|", text, re.M)
    plain = {name: re.sub(r"\[([^\]]*)\]\([^)]*\)|`", r"\1", what) for name, what in rows}
    return {name: what.strip() for name, what in plain.items()}


def steps() -> dict[str, list[str]]:
    """The marks of each library: flow and number of the step that names one of its files."""
    text = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    found: dict[str, list[str]] = defaultdict(list)
    for flow, part in re.findall(r"^## ([A-D]): .*?\n(.*?)(?=^## |\Z)", text, re.M | re.S):
        for number, step in re.findall(r"^(\d+)\. (.*?)(?=^\d+\. |\Z)", part, re.M | re.S):
            for path in re.findall(r"`(enfilade/\w+|web|apps)/", step):
                library, mark = path.removeprefix("enfilade/"), f"{flow}{number}"
                if mark not in found[library]:
                    found[library].append(mark)
    return found


def rows_of(direct: dict[str, set[str]]) -> list[list[str]]:
    """Libraries by the length of the longest way down; each row in the order of what it stands on."""
    depth: dict[str, int] = {}

    def measure(name: str) -> int:
        if name not in depth:
            depth[name] = 1 + max((measure(below) for below in direct[name]), default=-1)
        return depth[name]

    for name in direct:
        measure(name)
    rows = [[n for n in direct if depth[n] == k] for k in range(max(depth.values()) + 1)]
    place: dict[str, float] = {}
    for row in rows:
        # fsum: a plain sum depends on the order of the set, which is another one in each process, and ties would fall either way.
        row.sort(key=lambda n: math.fsum(place[b] for b in direct[n]) / len(direct[n]) if direct[n] else 0.5)
        for k, name in enumerate(row):
            place[name] = (k + 0.5) / len(row)
    return rows


def lines_of(text: str, most: int = 28) -> list[str]:
    """Two lines at most."""
    out = [""]
    for word in text.split():
        if len(out[-1]) + len(word) >= most:
            if len(out) == 2:
                out[-1] = out[-1].rstrip(",;:") + " …"
                break
            out.append("")
        out[-1] += f"{word} "
    return [line.strip() for line in out]


def draw() -> str:
    direct = arrows()
    shown, said, marks = reduced(direct), words(), steps()
    rows = rows_of(direct)
    on_top = [("apps", "command line"), ("python", "bindings"), ("web", "pages")]
    total = (len(rows) + 1) * (HEIGHT + GAP) + 10
    middle: dict[str, tuple[float, float]] = {}
    for k, row in enumerate(rows):
        y = total - (k + 1) * (HEIGHT + GAP) + GAP / 2
        for i, name in enumerate(row):
            middle[name] = (WIDTH * (i + 0.5) / len(row), y)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {total}" font-family="system-ui, sans-serif">',
           "<!-- Drawn by tools/docs/architecture.py. -->",
           '<defs><marker id="a" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
           '<path d="M0 0L8 4L0 8z" fill="#8793a3"/></marker></defs>', '<g fill="none" stroke="#8793a3" stroke-width="1.3">']  # fmt: skip
    for name, below in shown.items():
        x, y = middle[name]
        for to in sorted(below):
            tx, ty = middle[to]
            bend = (ty - y - HEIGHT) / 2
            out.append(f'<path marker-end="url(#a)" d="M{x:.0f} {y + HEIGHT:.0f}C{x:.0f} {y + HEIGHT + bend:.0f} '
                       f'{tx:.0f} {ty - bend:.0f} {tx:.0f} {ty - 2:.0f}"/>')  # fmt: skip
    out.append("</g>")
    for name, (x, y) in middle.items():
        out += box(name, lines_of(said.get(name, "")), marks.get(name, []), x, y)
    for i, (name, what) in enumerate(on_top):
        out += box(f"{name}/", [what], marks.get(name, []), WIDTH * (i + 0.5) / len(on_top), 8, dashed=True)
    return "\n".join([*out, "</svg>", ""])


def box(name: str, text: list[str], marks: list[str], x: float, y: float, dashed: bool = False) -> list[str]:
    left = x - BOX / 2
    style = ' stroke-dasharray="4 3"' if dashed else ""
    out = [f'<rect x="{left:.0f}" y="{y:.0f}" width="{BOX}" height="{HEIGHT}" rx="7" fill="#eef3fa" stroke="#5b7ba6"{style}/>',
           f'<text x="{left + 10:.0f}" y="{y + 20:.0f}" font-size="15" font-weight="600" fill="#10243c">{name}</text>']  # fmt: skip
    for k, line in enumerate(text):
        out.append(f'<text x="{left + 10:.0f}" y="{y + 37 + 14 * k:.0f}" font-size="11" fill="#33455c">{html.escape(line)}</text>')
    for k, mark in enumerate(reversed(marks)):
        cx = left + BOX - 16 - 25 * k
        out += [f'<rect x="{cx - 11:.0f}" y="{y + 5:.0f}" width="22" height="16" rx="8" fill="{FLOWS[mark[0]]}"/>',
                f'<text x="{cx:.0f}" y="{y + 17:.0f}" font-size="11" font-weight="600" text-anchor="middle" fill="#fff">{mark}</text>']  # fmt: skip
    return out


def main() -> int:
    picture = draw()
    if "--check" in sys.argv[1:]:
        if PICTURE.exists() and PICTURE.read_text(encoding="utf-8") == picture:
            return 0
        print(f"{PICTURE.relative_to(ROOT)}:1: is not what the arrows and pages say: run tools/docs/architecture.py")
        return 1
    PICTURE.write_text(picture, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
