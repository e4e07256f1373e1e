"""The Python reference: a page a public module, out of the sources' and stubs' docstrings; nothing is imported."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import griffe
from markdown_tree import ROOT, Fault

SOURCES = ROOT / "python"

# Their names are those of other projects; docs/python_habitat_sim.md has a table of all.
WITHOUT_PAGES = {"corrade", "habitat_sim", "magnum"}


def public_modules() -> list[str]:
    """Packages and modules of python/ whose names have no underscore."""
    names = []
    for file in sorted(SOURCES.glob("*/**/*.py")):
        parts = file.relative_to(SOURCES).with_suffix("").parts
        parts = parts[:-1] if parts[-1] == "__init__" else parts
        package = (SOURCES / parts[0] / "__init__.py").exists()
        if package and parts[0] not in WITHOUT_PAGES and not any(part.startswith("_") for part in parts):
            names.append(".".join(parts))
    return names


class Comments(griffe.Extension):
    """`#: words` behind an attribute is its docstring; `<scan>` in any docstring is text, not a tag."""

    def on_object(self, *, obj: griffe.Object, **_: object) -> None:
        if obj.docstring:
            parts = re.split(r"(`[^`]*`)", obj.docstring.value)
            parts[::2] = [re.sub(r"<(?=[A-Za-z])", "&lt;", part) for part in parts[::2]]
            obj.docstring.value = "".join(parts)

    def on_attribute(self, *, attr: griffe.Attribute, **_: object) -> None:
        if attr.docstring or not attr.lineno or not isinstance(attr.filepath, Path):
            return
        lines = attr.filepath.read_text(encoding="utf-8").splitlines()
        line = (attr.endlineno or attr.lineno) - 1  # of a stub, where source and stub were merged
        found = re.search(rf"\b{attr.name}\b.*#: (.*)$", lines[line]) if line < len(lines) else None
        if found:
            attr.docstring = griffe.Docstring(found[1], lineno=attr.lineno, endlineno=attr.lineno, parent=attr)


def load() -> griffe.GriffeLoader:
    """All public packages."""
    loader = griffe.GriffeLoader(search_paths=[SOURCES], extensions=griffe.Extensions(Comments()), allow_inspection=False)
    for package in sorted({name.split(".")[0] for name in public_modules()}):
        loader.load(package)
    loader.resolve_aliases(implicit=False, external=False)
    return loader


def exported(module: griffe.Module) -> list[griffe.Object | griffe.Alias]:
    """What __all__ names; without one, what is defined here and has no underscore."""
    if module.exports is not None:
        names = [str(name) for name in module.exports]
    else:
        names = [n for n, it in module.members.items() if not n.startswith("_") and not it.is_alias and not it.is_module]
    return [module[name] for name in names if not name.startswith("__") and name in module.members]


def _resolved(thing: griffe.Object | griffe.Alias) -> bool:
    try:
        return thing.filepath is not None
    except griffe.AliasResolutionError:
        return False


def _silent(thing: griffe.Object | griffe.Alias, name: str) -> Iterator[Fault]:
    where = _file_of(thing)
    if not thing.docstring and not (thing.is_attribute and "." not in name):
        yield Fault(where, thing.lineno or 1, f"{name} has no docstring")
    if not thing.is_class:
        return
    for member, it in thing.members.items():
        if member.startswith("_") or not _resolved(it) or it.docstring:
            continue
        if it.is_attribute and "property" not in it.labels:
            continue  # the class's docstring speaks of its fields
        inherited = any(member in base.members for base in _bases(thing))
        if not inherited:
            yield Fault(_file_of(it), it.lineno or 1, f"{name}.{member} has no docstring")


def _file_of(thing: griffe.Object | griffe.Alias) -> str:
    """Where its line is: a source that has a stub is merged with that, and keeps its own name."""
    file = Path(str(thing.filepath))
    for candidate in (file, file.with_suffix(".pyi")):
        lines = candidate.read_text(encoding="utf-8").splitlines() if candidate.exists() else []
        near = " ".join(lines[max(0, (thing.lineno or 1) - 1) : (thing.endlineno or 1)])
        if re.search(rf"\b{thing.name}\b", near):
            file = candidate
            break
    return str(file.relative_to(ROOT)) if file.is_relative_to(ROOT) else str(file)


def _bases(thing: griffe.Object | griffe.Alias) -> list[griffe.Class]:
    """Known base classes. A Gymnasium method that is overridden is documented there."""
    try:
        return list(thing.mro())
    except Exception:  # griffe raises several kinds where a base is of a package that is not loaded
        return []


def undocumented(loader: griffe.GriffeLoader) -> Iterator[Fault]:
    """Public names without a docstring."""
    for name in public_modules():
        module = loader.modules_collection[name]
        file = str(Path(str(module.filepath)).relative_to(ROOT))
        if not module.docstring:
            yield Fault(file, 1, f"the module {name} has no docstring")
        for thing in exported(module):
            if not _resolved(thing):
                yield Fault(file, 1, f"{name}.{thing.name} is not found in sources or stubs")
            else:
                yield from _silent(thing, f"{name}.{thing.name}")


def write(loader: griffe.GriffeLoader, stage: Path) -> list[str]:
    """Returns the pages."""
    pages = []
    for name in public_modules():
        module = loader.modules_collection[name]
        docstring = module.docstring.value if module.docstring else ""
        lines = [f"# {name}", "", _examples_as_code(docstring), ""]
        things = [thing for thing in exported(module) if _resolved(thing)]
        if things:
            lines += ["| name | what it is |", "|---|---|"]
            for thing in things:
                lines.append(f"| [`{thing.name}`](#{name}.{thing.name}) | {_first_sentence(thing)} |")
        for thing in things:
            lines += ["", f"::: {name}.{thing.name}"]
        page = f"reference/python/{name}.md"
        (stage / page).parent.mkdir(parents=True, exist_ok=True)
        (stage / page).write_text("\n".join(lines) + "\n", encoding="utf-8")
        pages.append(page)
    return pages


def _examples_as_code(text: str) -> str:
    """Doctest lines become a code block."""


    def block(found: re.Match[str]) -> str:
        return "```python\n" + re.sub(r"^(>>>|\.\.\.) ", "", found[0], flags=re.M).rstrip() + "\n```\n"

    return re.sub(r"(?:^(?:>>>|\.\.\.) .*\n?)+", block, text, flags=re.M)


def _first_sentence(thing: griffe.Object | griffe.Alias) -> str:
    text = " ".join((thing.docstring.value if thing.docstring else "").split("\n\n")[0].split())
    return re.split(r"(?<=[.:;])\s+(?=[A-Z`])", text, maxsplit=1)[0].replace("|", "\\|")
