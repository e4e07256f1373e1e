#!/usr/bin/env python3
"""Builds Enfilade's documentation as one site: guides, tutorials, examples, C++ and Python reference.

    site.py -o build/docs [--build build/release] [--python PYTHON] [--no-runs] [--keep-going]

Broken links and public names without a comment are printed as FILE:LINE and fail. Needs doxygen and requirements.txt.
"""

from __future__ import annotations

import argparse
import html
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Optional
from urllib.parse import unquote

import architecture
import cpp_reference
import examples
import markdown_tree as tree
import python_reference
from markdown_tree import ROOT, Fault

HERE = Path(__file__).resolve().parent
DOCS = ROOT / "docs"
_TEXT_LIMIT = 200_000  # bytes of a source that a page shows


class Stage:
    """The folder that MkDocs reads: the pages of the tree with their links made to fit the site."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        self._sources: set[Path] = set()  # files of the tree that a page shows
        self.index: Optional[cpp_reference.Index] = None  # for names in code; set before pages are added

    def place(self, path: Path) -> str:
        """Where a file or folder of the tree stands on the site."""
        relative = path.relative_to(ROOT)
        if path.is_dir():
            readme = path / "README.md"
            if readme.exists():
                return self.place(readme)
            self._sources.add(path)
            return f"files/{relative}/index.md" if path != DOCS / "design" else "design/index.md"
        if path.is_relative_to(DOCS):
            return str(path.relative_to(DOCS))
        if path.suffix == ".md":
            return f"project/{relative}".replace("README.md", "readme.md")  # no page of a folder
        if path in set(cpp_reference.public_headers()):
            return cpp_reference.Header(str(relative)).page + ".md"
        if path in set(examples.example_files()):
            return examples.page_of(path)
        self._sources.add(path)
        return f"files/{relative}" if path.suffix in {".svg", ".png", ".jpg"} else f"files/{relative}.md"

    def add_page(self, page: Path) -> str:
        """Copies a page of the tree. Returns its place."""
        place = self.place(page)
        text = page.read_text(encoding="utf-8")
        here = Path(place).parent

        def moved(target: str) -> Optional[str]:
            if tree.is_external(target):
                return None
            path, anchor = tree.resolve(page, target)
            if path == page:
                return None
            to = os.path.relpath(self.place(path), here) if path.is_relative_to(ROOT) else target
            return f"{to}#{anchor}" if anchor else to

        text = self._linked_names(tree.rewrite_links(text, moved), place)
        text = re.sub(r"^(```)([\w+-]+) +(.*)$", self._fence, text, flags=re.M)
        wide = "---\nhide: [navigation, toc]\n---\n" if page == DOCS / "README.md" else ""
        self._write(place, wide + _lists_apart(text))
        return place

    @staticmethod
    def _fence(found: re.Match[str]) -> str:
        """What the tutorials' runner reads behind the language becomes a title."""
        file = re.search(r"\bfile=(\S+)", found[3])
        title = file[1] if file else "output" if "output" in found[3].split() else ""
        return f'{found[1]}{found[2]} title="{title}"' if title else f"{found[1]}{found[2]}"

    def _linked_names(self, text: str, place: str) -> str:
        """Code that names a public header, an example or a type becomes a link to it."""
        inside = [(m.start(), m.end()) for m in re.finditer(r"\[[^\[\]]*\]\([^)]*\)", text)]
        headings = [(m.start(), m.end()) for m in re.finditer(r"^#.*$", text, re.M)]
        for code in sorted(tree.inline_code_of(text), key=lambda c: -c.begin):
            if any(a <= code.begin < b for a, b in inside + headings):
                continue
            to = self._explained(code.target, types="```python" not in text)
            if to:
                relative = os.path.relpath(to, Path(place).parent)
                text = f"{text[: code.begin]}[{text[code.begin : code.end]}]({relative}){text[code.end :]}"
        return text

    def _explained(self, code: str, types: bool) -> Optional[str]:
        """The page of a header or example; of a C++ type, unless the page speaks Python."""
        if re.match(r"^(enfilade/\w+/\w+\.h|examples/[\w/]+\.\w+)$", code):
            path = ROOT / code
            if path in set(cpp_reference.public_headers()) | set(examples.example_files()):
                return self.place(path)
        name = code.removeprefix("enfilade::").removesuffix("()")
        if types and self.index and re.match(r"^([a-z]\w*::)*[A-Z]\w*[a-z]\w*$", name):
            found = self.index.find(name)
            return found.replace(".html#", ".md#") if found else None
        return None

    def add_sources(self) -> None:
        """Pages for what is linked and is no page: sources, folders."""
        done: set[Path] = set()
        while self._sources - done:
            path = sorted(self._sources - done)[0]
            done.add(path)
            place = self.place(path)
            if path.is_dir():
                self._write(place, self._folder(path, place))
            elif not place.endswith(".md"):
                self._copy(path, place)
            else:
                text = path.read_text(encoding="utf-8", errors="replace")[:_TEXT_LIMIT].rstrip()
                language = {"cpp": "cpp", "h": "cpp", "py": "python", "ts": "ts", "sh": "sh", "cmake": "cmake"}
                name = path.relative_to(ROOT)
                fence = "`" * 6
                self._write(place, f"# `{name}`\n\n{fence}{language.get(path.suffix[1:], 'text')}\n{text}\n{fence}\n")

    def _folder(self, path: Path, place: str) -> str:
        lines = [f"# `{path.relative_to(ROOT)}/`" if path != DOCS / "design" else "# Design", ""]
        if path == DOCS / "design":
            lines += ["Decisions, one page each: the question, the choices, the decision, and what would change our mind.", ""]
        for file in sorted(path.iterdir()):
            if file.suffix == ".md":
                lines.append(f"- [{tree.title_of(file)}]({os.path.relpath(self.place(file), Path(place).parent)})")
            else:
                lines.append(f"- `{file.name}`")
        return "\n".join(lines) + "\n"

    def add_files(self, folder: Path) -> None:
        """Pictures and other files beside the pages."""
        for file in tree.tracked_files():
            if file.is_relative_to(folder) and file.suffix != ".md":
                self._copy(file, self.place(file))

    def _write(self, place: str, text: str) -> None:
        target = self.folder / place
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")

    def _copy(self, file: Path, place: str) -> None:
        target = self.folder / place
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, target)


def _lists_apart(text: str) -> str:
    """GitHub's lists as Python-Markdown wants them: an empty line before, what belongs to an item 4 columns in."""
    out: list[str] = []
    indent = 0  # of the item's text in GitHub's Markdown; 0: no list
    blocks = False  # the item has more than its first paragraph
    for line, plain in zip(text.split("\n"), tree.without_code(text).split("\n")):
        before = out[-1] if out else ""
        item = re.match(r"([-*+]|\d+\.) ", plain)
        if item:
            if before.strip() and (blocks or not indent) and (indent or item[1] in "-*+" or item[1] == "1."):
                out.append("")
            indent, blocks = len(item[0]), False
        elif indent and line.startswith(" " * indent):
            blocks |= not before.strip()
            line = " " * (4 - indent) + line if blocks and indent < 4 else line
        elif line.strip():
            indent = 0 if not before.strip() else indent
        out.append(line)
    return "\n".join(out)


# --- navigation -------------------------------------------------------------------------------------------


def navigation(stage: Stage, cpp: dict[str, list[str]], python: list[str], shown: list[str]) -> list[object]:
    """The headings of docs/README.md are the site's sections, its links their pages; then the generated ones."""
    index = DOCS / "README.md"
    text = index.read_text(encoding="utf-8")
    sections: list[tuple[str, list[str]]] = []
    seen: set[str] = set()
    position = [(m.start(), m[1]) for m in re.finditer(r"^## (.+)$", text, re.M)]
    links = list(tree.links_of(text))
    for (begin, name), (end, _) in zip(position, [*position[1:], (len(text), "")]):
        pages = []
        for link in sorted((k for k in links if begin < k.begin < end), key=lambda k: k.begin):
            path = tree.resolve(index, link.target)[0] if not tree.is_external(link.target) else None
            for file in _pages_of(path):
                place = stage.place(file)
                if place not in seen and place != "README.md":
                    seen.add(place)
                    pages.append(place)
        if pages:
            sections.append((name, pages))
    nav: list[object] = [{"Home": "README.md"}, *({name: pages} for name, pages in sections)]
    libraries = [{library: [f"reference/cpp/{library}/index.md", *pages]} for library, pages in cpp.items()]
    nav += [{"Examples": list(shown)}, {"C++": ["reference/cpp/index.md", *libraries]},
            {"Python": ["reference/python/index.md", *python]}]  # fmt: skip
    rest = sorted(set(_all_pages(stage)) - seen - {"README.md"})
    nav.append({"Project": [page for page in rest if page.startswith("project/")]})
    return nav


def _pages_of(path: Optional[Path]) -> list[Path]:
    if path is None or not path.is_relative_to(DOCS):
        return []
    if path.is_dir():
        return [path, *sorted(path.glob("*.md"))]
    return [path] if path.suffix == ".md" else []


def _all_pages(stage: Stage) -> list[str]:
    return [str(p.relative_to(stage.folder)) for p in stage.folder.rglob("*.md")]


def write_reference_indices(stage: Stage, cpp: dict[str, list[str]], headers: list[cpp_reference.Header]) -> None:
    rows = ["# C++ reference", "", "Everything that `#include \"enfilade/...\"` may name, by library; `enfilade::enfilade`"
            " is the CMake target of all. Made from the headers.", "", "| library | headers |", "|---|---|"]  # fmt: skip
    for library in cpp:
        names = [h for h in headers if h.library == library]
        links = ", ".join(f"[{Path(h.path).stem}]({library}/{Path(h.path).stem}.md)" for h in names)
        rows.append(f"| [**{library}**]({library}/index.md) | {links} |")
    (stage.folder / "reference/cpp/index.md").write_text("\n".join(rows) + "\n", encoding="utf-8")
    rows = ["# Python reference", "", "Made from the docstrings and the stubs. How to install it, and first steps:"
            " [Python](../../python.md).", "", "| module | what it is |", "|---|---|"]  # fmt: skip
    for name in python_reference.public_modules():
        first = (stage.folder / f"reference/python/{name}.md").read_text(encoding="utf-8").split("\n")[2]
        rows.append(f"| [`{name}`]({name}.md) | {first} |")
    (stage.folder / "reference/python/index.md").write_text("\n".join(rows) + "\n", encoding="utf-8")


# --- the site itself --------------------------------------------------------------------------------------


def run_mkdocs(work: Path, site: Path, nav: list[object]) -> None:
    configuration = {"INHERIT": str(HERE / "mkdocs.yml"), "docs_dir": str(work / "stage"), "site_dir": str(site), "nav": nav}
    (work / "mkdocs.yml").write_text(json.dumps(configuration, indent=1), encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(HERE), "NO_MKDOCS_2_WARNING": "1", "DISABLE_MKDOCS_2_WARNING": "true",
                   "ENFILADE_PYTHON": str(python_reference.SOURCES)}  # fmt: skip
    done = subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "-q", "-f", str(work / "mkdocs.yml")],
                          env=environment, cwd=ROOT, capture_output=True, text=True)  # fmt: skip
    if done.returncode != 0:
        raise SystemExit(f"mkdocs failed:\n{done.stdout}{done.stderr}")


def check_site(site: Path) -> list[Fault]:
    """Links and anchors of the finished pages, and that nothing is fetched from elsewhere when they are read."""
    ids: dict[Path, set[str]] = {}
    texts = {page: page.read_text(encoding="utf-8") for page in site.rglob("*.html")}
    for page, text in texts.items():
        ids[page] = {html.unescape(i) for i in re.findall(r"\b(?:id|name)=\"([^\"]+)\"", text)}
    faults = []
    for page, text in texts.items():
        if page.name == "404.html":  # served at any address
            continue
        name = str(page.relative_to(site))
        for fetched in re.findall(r"<(?:script|img|iframe)\b[^>]*\bsrc=\"(https?:[^\"]+)\"|<link\b[^>]*\bhref=\"(https?:[^\"]+)\"", text):
            faults.append(Fault(name, 1, f"fetches {''.join(fetched)} when it is read"))
        for target in set(re.findall(r"\b(?:href|src)=\"([^\"]*)\"", text)):
            target = html.unescape(target)
            if tree.is_external(target) or not target or target == "#":
                continue
            path, _, anchor = unquote(target).partition("#")
            to = Path(os.path.normpath(page.parent / path)) if path else page
            to = to / "index.html" if to.is_dir() else to
            if not to.exists():
                faults.append(Fault(name, 1, f"'{target}' leads to nothing"))
            elif anchor and to in ids and anchor not in ids[to] and not anchor.startswith("__"):
                faults.append(Fault(name, 1, f"'{target}': there is no such place on that page"))
    return faults


def report(faults: list[Fault], what: str, go_on: bool = False) -> None:
    for fault in faults:
        print(fault)
    if faults and not go_on:
        raise SystemExit(f"{len(faults)} {what}")


def build(arguments: argparse.Namespace) -> None:
    site = Path(arguments.output).resolve()
    work = Path(f"{site}-work")
    headers_faults = cpp_reference.run_doxygen(work / "doxygen")
    headers = cpp_reference.Reader(work / "doxygen/xml").headers()
    loader = python_reference.load()
    faults = [*tree.check(), *headers_faults, *cpp_reference.undocumented(headers), *python_reference.undocumented(loader)]
    if architecture.PICTURE.read_text(encoding="utf-8") != architecture.draw():
        picture = str(architecture.PICTURE.relative_to(ROOT))
        faults.append(Fault(picture, 1, "is not what arrows and pages say: run tools/docs/architecture.py"))
    wrong = "broken links, wrong comments or names without one"
    report(faults, wrong, arguments.keep_going)

    stage = Stage(work / "stage")
    writer = cpp_reference.Writer(headers, stage.folder)
    stage.index = writer.index
    cpp = writer.write()
    python = python_reference.write(loader, stage.folder)
    write_reference_indices(stage, cpp, headers)
    program = Path(arguments.build).resolve() if arguments.build and not arguments.no_runs else None
    # The link of an environment is kept: what it leads to has not its packages.
    pythons = [Path(os.path.abspath(python)) for python in arguments.python]
    shown = examples.write(stage.folder, examples.Runner(program, work, pythons))
    for page in tree.pages():
        if page.is_relative_to(DOCS) or not page.is_relative_to(ROOT / "examples"):
            stage.add_page(page)
    stage.add_files(DOCS)
    shutil.copytree(HERE / "theme", stage.folder, dirs_exist_ok=True)
    (stage.folder / "assets").mkdir(exist_ok=True)
    shutil.copyfile(ROOT / "web/src/icon.svg", stage.folder / "assets/icon.svg")
    nav = navigation(stage, cpp, python, shown)
    stage.add_sources()
    run_mkdocs(work, site, nav)
    report(check_site(site), "broken links in the finished pages")
    if faults:
        raise SystemExit(f"{len(faults)} {wrong}")
    print(f"{site}/index.html: {len(list(site.rglob('*.html')))} pages")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", default="build/docs", help="folder of the site; made anew")
    parser.add_argument("--build", help="folder of a build, whose examples are run")
    parser.add_argument("--python", action="append", default=[],
                        help="a Python that its package was built for, to run examples with; may be repeated")
    parser.add_argument("--no-runs", action="store_true", help="examples without their output")
    parser.add_argument("--keep-going", action="store_true", help="make the pages in spite of faults, then fail")
    build(parser.parse_args())


if __name__ == "__main__":
    main()
