"""The Markdown pages of the tree: their headings, links and the paths they name, and what is broken in them.

Standard library only: the tests run it where there is no PyPI.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Callable, Optional

ROOT = Path(__file__).resolve().parents[2]

_FENCE = re.compile(r"^(`{3,}|~{3,})([^\n]*)\n(.*?)^\1[ \t]*$", re.M | re.S)
_CODE = re.compile(r"(`+)(?!`)(.+?)(?<!`)\1(?!`)", re.S)
_COMMENT = re.compile(r"<!--.*?-->", re.S)
_LINK = re.compile(r"\]\(\s*<?([^()\s<>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
_HTML_LINK = re.compile(r"<(?:a|img|source)\b[^>]*?\b(?:href|src|srcset)=\"([^\"]+)\"")
_HEADING = re.compile(r"^(#{1,6})\s+(.+?)\s*#*\s*$", re.M)
_EXTERNAL = re.compile(r"^[a-z][a-z0-9+.-]*:")
# Code that is a path of this tree: it begins with one of its folders, or is a file at its root.
# `enfilade/R2R-v0` is an environment of Gymnasium.
_PATH = re.compile(r"^(?:(?:apps|bench|cmake|docs|enfilade|examples|python|tests|tools|web)/(?![\w-]+-v\d+$)[\w.*/{},+-]*|[A-Z]\w+\.md)$")


@dataclass(frozen=True)
class Fault:
    """Something broken, and where."""

    file: str
    line: int
    message: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.message}"


@dataclass(frozen=True)
class Link:
    """A link's target and its place in the text."""

    target: str
    begin: int
    end: int


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", "\0", text)


def without_code(text: str) -> str:
    """The text with code and comments blanked out, of the same length."""
    text = _FENCE.sub(lambda m: _blank(m[0]), text)
    text = _COMMENT.sub(lambda m: _blank(m[0]), text)
    return _CODE.sub(lambda m: _blank(m[0]), text)


def links_of(text: str) -> Iterator[Link]:
    """Links and pictures, in Markdown and in HTML."""
    plain = without_code(text)
    for pattern in (_LINK, _HTML_LINK):
        for found in pattern.finditer(plain):
            yield Link(found[1], found.start(1), found.end(1))


def inline_code_of(text: str) -> Iterator[Link]:
    """What stands in backticks within a paragraph."""
    hidden = _FENCE.sub(lambda m: _blank(m[0]), text)
    hidden = _COMMENT.sub(lambda m: _blank(m[0]), hidden)
    for found in _CODE.finditer(hidden):
        yield Link(found[2], found.start(), found.end())


def github_slug(heading: str, separator: str = "-", **_: object) -> str:
    """A heading's anchor, as GitHub makes it."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", separator)


def heading_lines(text: str) -> Iterator[tuple[int, str]]:
    """Level and text of each heading, without code blocks' comments."""
    hidden = _FENCE.sub(lambda m: _blank(m[0]), text)
    for found in _HEADING.finditer(hidden):
        yield len(found[1]), found[2]


@cache
def anchors_of(page: Path) -> frozenset[str]:
    """What `#...` may follow the page's name."""
    text = page.read_text(encoding="utf-8")
    anchors: set[str] = set(re.findall(r"<a (?:id|name)=\"([^\"]+)\"", text))
    for _, heading in heading_lines(text):
        slug, number = github_slug(heading), 0
        while (name := slug if not number else f"{slug}-{number}") in anchors:
            number += 1
        anchors.add(name)
    return frozenset(anchors)


def title_of(page: Path) -> str:
    """The first heading, or the file's name."""
    headings = heading_lines(page.read_text(encoding="utf-8"))
    return next((text for _, text in headings), page.name)


def line_of(text: str, position: int) -> int:
    return text.count("\n", 0, position) + 1


def is_external(target: str) -> bool:
    return bool(_EXTERNAL.match(target))


def resolve(page: Path, target: str) -> tuple[Path, str]:
    """The file or folder that a link of `page` leads to, and the anchor in it."""
    path, _, anchor = target.partition("#")
    return ((page.parent / path).resolve() if path else page), anchor


def tracked_files(pattern: str = "") -> list[Path]:
    """Files of the tree that are the project's: what Git knows or would add; without Git all but folders that
    .gitignore names."""
    command = ["git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        found = subprocess.run(command, capture_output=True, check=True, text=True).stdout.split("\0")
        files = [ROOT / name for name in found if name]
    except (OSError, subprocess.CalledProcessError):  # an unpacked archive
        lines = (ROOT / ".gitignore").read_text(encoding="utf-8").split()
        skip = {".git"} | {line.rstrip("/") for line in lines if line.endswith("/") and not line.startswith("/")}
        made = [ROOT / line.strip("/") for line in lines if line.startswith("/") and line.endswith("/")]
        files = [
            f
            for f in ROOT.rglob("*")
            if not skip & set(f.relative_to(ROOT).parts) and not any(f.is_relative_to(folder) for folder in made)
        ]
    return sorted(f for f in set(files) if f.is_file() and f.match(pattern or "*"))


def pages() -> list[Path]:
    """All Markdown files of the tree."""
    return tracked_files("*.md")


def is_path(code: str) -> bool:
    """Whether inline code names a path of the tree."""
    return bool(_PATH.match(code))


def path_exists(code: str) -> bool:
    """Whether the tree has the path, which may have wildcards and `{a,b}`."""
    variants = [code]
    while any("{" in v for v in variants):
        variants = [
            v.replace(group[0], choice, 1)
            for v in variants
            for group in [re.search(r"\{([^{}]*)\}", v)]
            if group
            for choice in group[1].split(",")
        ] or [v.replace("{", "").replace("}", "") for v in variants]
    return all(any(True for _ in ROOT.glob(v.rstrip("/"))) if "*" in v else (ROOT / v).exists() for v in variants)


def check_page(page: Path) -> Iterator[Fault]:
    """Links to nothing, and paths of files that are not there."""
    text, name = page.read_text(encoding="utf-8"), str(page.relative_to(ROOT))
    for link in links_of(text):
        if is_external(link.target):
            continue
        to, anchor = resolve(page, link.target)
        if not to.exists():
            yield Fault(name, line_of(text, link.begin), f"the link '{link.target}' leads to no file")
        elif anchor and to.suffix == ".md" and anchor not in anchors_of(to):
            yield Fault(name, line_of(text, link.begin), f"'{link.target}': that page has no heading '#{anchor}'")
    if page.name == "CHANGELOG.md":  # names what was
        return
    for code in inline_code_of(text):
        if is_path(code.target) and not path_exists(code.target):
            yield Fault(name, line_of(text, code.begin), f"the path '{code.target}' is not in the tree")


def check_navigation() -> Iterator[Fault]:
    """docs/README.md is the table of pages: it names each. Each library has one."""
    index = ROOT / "docs" / "README.md"
    named = {resolve(index, link.target)[0] for link in links_of(index.read_text(encoding="utf-8"))}
    for page in pages():
        # A folder's link stands for its pages.
        linked = page == index or page in named or page.parent in named
        if page.is_relative_to(ROOT / "docs") and not linked:
            yield Fault("docs/README.md", 1, f"no link leads to {page.relative_to(ROOT / 'docs')}")
    for library in sorted({header.parent for header in (ROOT / "enfilade").glob("*/*.h")}):
        if not (ROOT / "docs" / f"{library.name}.md").exists():
            yield Fault(f"docs/{library.name}.md", 1, f"is missing: the page of {library.relative_to(ROOT)}/")


def check() -> list[Fault]:
    """All that is broken in the pages, by file and line."""
    found = [fault for page in pages() for fault in check_page(page)]
    return sorted([*found, *check_navigation()], key=lambda f: (f.file, f.line))


def rewrite_links(text: str, change: Callable[[str], Optional[str]]) -> str:
    """The text with each link's target replaced by what `change` gives for it, if anything."""
    for link in sorted(links_of(text), key=lambda link: -link.begin):
        new = change(link.target)
        if new is not None:
            text = text[: link.begin] + new + text[link.end :]
    return text


if __name__ == "__main__":
    faults = check()
    for fault in faults:
        print(fault)
    raise SystemExit(1 if faults else 0)
