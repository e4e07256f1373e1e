"""The examples with their source, what they print, and the pictures that they make."""

from __future__ import annotations

import ast
import hashlib
import html
import json
import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Optional

from markdown_tree import ROOT

PICTURES = {".png", ".jpg", ".jpeg", ".svg"}
_HOMES = ("--homes", "3", "--kind", "flat", "--size", "64", "--samples", "1")
_LANGUAGE = {".cpp": "cpp", ".py": "python", ".html": "html", ".sh": "sh", ".ts": "ts", ".txt": "text"}


@dataclass
class Run:
    """What came of running an example, or why it was not run."""

    command: str = ""
    output: str = ""
    pictures: list[str] = field(default_factory=list)
    not_run: str = ""


def example_files() -> list[Path]:
    """All of examples/, the notebooks aside, which are made of the scripts."""
    folder = ROOT / "examples"
    return sorted(f for f in folder.rglob("*") if f.suffix in {".cpp", ".py", ".html", ".sh"} and "notebooks" not in f.parts)


def page_of(file: Path) -> str:
    """`examples/python/rl.py` is explained by `examples/python/rl.md`; names without suffix may be shared."""
    relative = file.relative_to(ROOT)
    return str(relative.with_name(relative.stem + ".md")) if file.suffix != ".html" else f"{relative}.md"


def introduction(file: Path) -> tuple[str, str]:
    """Title and words of an example: its first comment, docstring or Markdown cell."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".py":
        module = ast.parse(text)
        words = ast.get_docstring(module) or ""
        heading = re.match(r"#\s+(.*)\n*", words)
        return (heading[1], words[heading.end() :]) if heading else (file.stem, words)
    if file.suffix == ".html":
        comment = re.search(r"<!--(.*?)-->", text, re.S)
    else:
        mark = "//" if file.suffix == ".cpp" else "#"
        comment = re.match(rf"(?:#!.*\n)?((?:{mark}.*\n)+)", text)
    words = re.sub(r"^\s*(//|#)?[ \t]*", "", comment[1], flags=re.M).strip() if comment else ""
    title, _, rest = words.partition(": ")
    if rest and len(title) < 40:
        return f"{title}", rest[0].upper() + rest[1:]
    return file.stem.replace("_", " "), words


class Runner:
    """Runs examples with the programs of a build, once for each state of source and programs."""

    def __init__(self, build: Optional[Path], work: Path, pythons: list[Path]) -> None:
        self._build, self._pythons, self._work = build, pythons, work
        self._homes: Optional[Path] = None

    def run(self, file: Path) -> Run:
        if self._build is None:
            return Run(not_run="there is no build of Enfilade beside this site (`./enfilade.sh test` makes one)")
        if file.suffix == ".cpp":
            program = self._build / "examples" / f"example_{file.stem}"
            if not program.exists():
                return Run(not_run=f"`{program.name}` is not built (`EN_BUILD_EXAMPLES`)")
            return self._once(file, [str(program)], f"{program.name}", [program], {})
        if file.suffix == ".py":
            return self._run_python(file)
        return Run(not_run="it is a web page: it wants `enfilade serve`")

    def _run_python(self, file: Path) -> Run:
        modules = list((self._build or Path()).glob("python/enfilade/_core*.so"))
        if not modules or not self._pythons:
            return Run(not_run="the Python package is not built (`EN_BUILD_PYTHON`)")
        usage = re.search(r"`python (\S+\.py[^`]*)`", file.read_text(encoding="utf-8"))
        words = re.sub(r"\s*\[[^\]]*\]", "", usage[1]).split() if usage else [file.name]
        homes = self._data()
        if "DATA" in words and homes is None:
            return Run(not_run="`enfilade` is not built, so there are no model homes")
        arguments = [str(homes) if word == "DATA" else word.lower() for word in words[1:]]
        shown = " ".join(["python", file.name, *("homes" if word == "DATA" else word.lower() for word in words[1:])])
        environment = {"PYTHONPATH": f"{self._build}/python", "PYTHONDONTWRITEBYTECODE": "1"}
        run = Run()
        for python in self._pythons:  # the first that has what the example imports
            run = self._once(file, [str(python), str(file), *arguments], shown, modules, environment)
            if not run.not_run:
                break
        return run

    def _data(self) -> Optional[Path]:
        """Three model homes, made once."""
        program = (self._build or Path()) / "bin" / "enfilade"
        if not program.exists():
            return None
        if self._homes is None:
            folder = self._work / "homes"
            if not (folder / "homes.json").exists():
                shutil.rmtree(folder, ignore_errors=True)
                subprocess.run([program, "homes", *_HOMES, "-o", folder], check=True, capture_output=True)
            self._homes = folder
        return self._homes

    def _once(self, file: Path, command: list[str], shown: str, made_of: list[Path], more: dict[str, str]) -> Run:
        state = file.read_bytes() + repr((command[0], [(p.name, p.stat().st_mtime_ns) for p in made_of])).encode()
        folder = self._work / "runs" / f"{file.stem}-{hashlib.sha256(state).hexdigest()[:16]}"
        record = folder / "run.json"
        if not record.exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            record.write_text(json.dumps(asdict(self._run(command, shown, folder, more))))
        return Run(**json.loads(record.read_text()))

    @staticmethod
    def _run(command: list[str], shown: str, folder: Path, more: dict[str, str]) -> Run:
        with tempfile.TemporaryDirectory() as scratch:
            done = subprocess.run(command, cwd=scratch, env={**os.environ, **more}, capture_output=True, text=True, timeout=900)
            missing = re.search(r"ModuleNotFoundError: No module named '(\w+)'", done.stderr)
            if missing:
                return Run(shown, not_run=f"this machine's Python lacks `{missing[1]}`")
            if done.returncode != 0:
                raise SystemExit(f"{shown} failed with {done.returncode}:\n{done.stdout}{done.stderr}")
            pictures = sorted(p for p in Path(scratch).rglob("*") if p.suffix in PICTURES)
            for picture in pictures:
                shutil.copy(picture, folder / picture.name)
            return Run(shown, done.stdout.replace(scratch + "/", ""), [str(folder / p.name) for p in pictures])


def write(stage: Path, runner: Runner) -> list[str]:
    """Writes the pages. Returns them, the overview first."""
    overview = ["# Examples", "", "One idea a file. What each prints stands below it, from the run that made this site;"
                " their buildings are model homes, which are **synthetic**.", "", "| example | what it shows |", "|---|---|"]  # fmt: skip
    pages = []
    for file in example_files():
        title, words = introduction(file)
        page = page_of(file)
        target = stage / page
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(_page(file, title, words, runner.run(file), target.parent), encoding="utf-8")
        pages.append(page)
        plain = re.sub(r"^As a program: `[^`]*`(?:,[^.]*\.)?", "", " ".join(words.split())).strip()
        first = re.split(r"(?<=[.:])\s", plain, maxsplit=1)[0]
        overview.append(f"| [{title}]({os.path.relpath(page, 'examples')}) `{file.relative_to(ROOT / 'examples')}` | {first} |")
    (stage / "examples/index.md").write_text("\n".join(overview) + "\n", encoding="utf-8")
    return ["examples/index.md", *pages]


def _page(file: Path, title: str, words: str, run: Run, folder: Path) -> str:
    relative = file.relative_to(ROOT)
    out = [f"# {title}", "", words, ""]
    for picture in run.pictures:
        shutil.copy(picture, folder / f"{file.stem}-{Path(picture).name}")
        out += [f"![{html.escape(Path(picture).name)}, as the example wrote it]({file.stem}-{Path(picture).name})", ""]
    language = _LANGUAGE.get(file.suffix, "text")
    source = file.read_text(encoding="utf-8").rstrip()
    out += [f'```{language} title="{relative}"', source, "```", ""]
    notebook = ROOT / "examples/python/notebooks" / f"{file.stem}.ipynb"
    if file.suffix == ".py" and notebook.exists():
        out += [f"As a notebook: `{notebook.relative_to(ROOT)}`.", ""]
    out += ["## What it prints", ""]
    if run.not_run:
        out += [f"Not run for this copy of the site: {run.not_run}.", ""]
    else:
        out += [f'```text title="{run.command}"', run.output.rstrip() or "(nothing)", "```", ""]
    return "\n".join(out)
