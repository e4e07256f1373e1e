"""The C++ reference: a page a public header, out of Doxygen's XML and the headers' own text."""

from __future__ import annotations

import html
import itertools
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Optional

from markdown_tree import ROOT, Fault
from pygments.lexers import CppLexer
from pygments.token import STANDARD_TYPES, Token

# Doxygen's complaints about a comment, in every version; others come and go with the version.
_WRONG_COMMENT = re.compile(
    r"Unsupported xml/html tag|unable to resolve|is not found in the argument list|unknown command"
    r"|end of (comment|file) (block )?while|expected whitespace after|has multiple @param", re.I)  # fmt: skip
_KIND = {"class": "class", "struct": "struct", "union": "union", "enum": "enum", "function": "function",
         "variable": "constant", "typedef": "alias", "define": "macro", "friend": "friend"}  # fmt: skip


@dataclass
class Symbol:
    """A name of a public header, with what its comment says."""

    kind: str  # Doxygen's
    name: str
    scope: str  # "graph", "graph::NavGraph"; without "enfilade"
    file: str
    line: int
    declaration: str
    text: str  # HTML of the comment, empty if there is none
    doxygen_id: str
    arguments: str = ""
    first: int = 0  # lines of the whole declaration
    last: int = 0
    shared: str = ""  # the comment above the lines that this one continues, if it has none of its own
    members: list[Symbol] = field(default_factory=list)

    @property
    def full_name(self) -> str:
        return f"{self.scope}::{self.name}" if self.scope else self.name


@dataclass
class Header:
    """A public header and the symbols of its namespaces, in its own order."""

    path: str  # "enfilade/graph/nav_graph.h"
    text: str = ""
    symbols: list[Symbol] = field(default_factory=list)

    @property
    def library(self) -> str:
        return self.path.split("/")[1]

    @property
    def page(self) -> str:
        return f"reference/cpp/{self.library}/{Path(self.path).stem}"


def public_headers() -> list[Path]:
    """Headers right in a library's folder: what others may include."""
    return sorted((ROOT / "enfilade").glob("*/*.h"))


# --- reading ----------------------------------------------------------------------------------------------


def run_doxygen(work: Path) -> list[Fault]:
    """Writes the XML into work/xml. Returns what is wrong with the comments."""
    shutil.rmtree(work, ignore_errors=True)  # XML of headers that are gone
    work.mkdir(parents=True)
    files = " ".join(str(h.relative_to(ROOT)) for h in public_headers())
    here = Path(__file__).resolve().parent
    configuration = (here / "Doxyfile").read_text()
    configuration += f'INPUT_FILTER = "awk -f \'{here}/doxygen_filter.awk\'"\n'
    configuration += f"INPUT = {files}\nOUTPUT_DIRECTORY = {work}\n"
    done = subprocess.run(["doxygen", "-"], input=configuration, capture_output=True, text=True, cwd=ROOT)
    if done.returncode != 0:
        raise SystemExit(f"doxygen failed:\n{done.stderr}")
    faults = set()
    for line in done.stderr.splitlines():
        found = re.match(rf"(?:{re.escape(str(ROOT))}/)?(\S+?):(\d+): (.*)", line)
        if found and _WRONG_COMMENT.search(found[3]):
            faults.add(Fault(found[1], int(found[2]), found[3].replace("warning: ", "")))
    return sorted(faults, key=lambda f: (f.file, f.line))


class Declarations:
    """The text of declarations, as the headers lay them out."""

    def __init__(self) -> None:
        self._lines: dict[str, list[str]] = {}

    def lines(self, file: str) -> list[str]:
        if file not in self._lines:
            self._lines[file] = (ROOT / file).read_text(encoding="utf-8").splitlines()
        return self._lines[file]

    def at(self, file: str, line: int) -> str:
        """The declaration that has this line (1 is the first), without its body and comments."""
        lines, first = self.lines(file), self.first_line(file, line) - 1
        text = "\n".join(self._code(text) for text in lines[first : first + 30])
        return self._without_body(text)

    def first_line(self, file: str, line: int) -> int:
        """Where that declaration begins: its template line, or the type that stands on a line of its own."""
        lines, first = self.lines(file), line - 1
        while first > 0 and not re.search(r"([;{}:\\]|^\s*)$|^\s*//|^#", self._code(lines[first - 1])):
            first -= 1
        return first + 1

    @staticmethod
    def _code(line: str) -> str:
        """Without the comment at its end; a line of comment alone is left."""
        return line if re.match(r"\s*//", line) else re.sub(r"\s*//.*$", "", line)

    @staticmethod
    def _without_body(text: str) -> str:
        depth, end = 0, len(text)
        for i, c in enumerate(text):
            if c in "([":
                depth += 1
            elif c in ")]":
                depth -= 1
            elif depth == 0 and (c in ";{" or (c == ":" and "::" not in text[i - 1 : i + 2] and ")" in text[:i])):
                end = i
                break
        lines = [line for line in text[:end].rstrip().splitlines() if not re.match(r"\s*//", line)]
        indent = min((len(line) - len(line.lstrip()) for line in lines if line.strip()), default=0)
        return "\n".join(line[indent:] for line in lines)


def _text_of(element: ElementTree.Element) -> str:
    """HTML of the comment of a class, function, file..."""
    parts = [_html(child) for tag in ("briefdescription", "detaileddescription", "inbodydescription")
             for child in [element.find(tag)] if child is not None]  # fmt: skip
    return "\n".join(part for part in parts if part)


_PLAIN = {"computeroutput": "code", "bold": "strong", "emphasis": "em", "itemizedlist": "ul", "orderedlist": "ol",
          "listitem": "li", "superscript": "sup", "subscript": "sub", "verbatim": "pre"}  # fmt: skip
_SIGNS = {"mdash": "&mdash;", "ndash": "&ndash;", "linebreak": "<br>", "nonbreakablespace": "&nbsp;", "times": "&times;",
          "le": "&le;", "ge": "&ge;", "deg": "&deg;", "plusmn": "&plusmn;", "lt": "&lt;", "gt": "&gt;"}  # fmt: skip
_SECTIONS = {"return": "Returns", "pre": "Precondition", "post": "Postcondition", "warning": "Warning", "note": "Note",
             "see": "See", "param": "Parameters", "exception": "Throws", "templateparam": "Template parameters"}  # fmt: skip


def _inside(element: ElementTree.Element) -> str:
    text = html.escape(element.text or "", quote=False)
    return text + "".join(_html(e) + html.escape(e.tail or "", quote=False) for e in element)


def _html(element: ElementTree.Element) -> str:
    tag = element.tag
    if tag in _PLAIN:
        return f"<{_PLAIN[tag]}>{_inside(element)}</{_PLAIN[tag]}>"
    if tag in _SIGNS:
        return _SIGNS[tag]
    if tag == "para":
        return _paragraph(element)
    if tag == "ref":
        return f'<a data-cpp="{element.get("refid")}">{_inside(element)}</a>'
    if tag == "ulink":
        return f'<a href="{html.escape(element.get("url", ""))}">{_inside(element)}</a>'
    if tag == "simplesect":
        label = _SECTIONS.get(element.get("kind", ""), element.get("kind", "").capitalize())
        return f'<div class="en-section"><span class="en-label">{label}</span><div>{_inside(element)}</div></div>'
    if tag == "parameterlist":
        rows = []
        for item in element.findall("parameteritem"):
            names = ", ".join(_code_or_words(_inside(n)) for n in item.iter("parametername"))
            words = "".join(_inside(p) for d in item.findall("parameterdescription") for p in d.findall("para"))
            rows.append(f"<div>{names} {words}</div>")
        label = _SECTIONS.get(element.get("kind", ""), "")
        return f'<div class="en-section"><span class="en-label">{label}</span><div>{"".join(rows)}</div></div>'
    if tag == "programlisting":
        lines = ["".join(line.itertext()) for line in element.findall("codeline")]
        return f'<pre><code>{html.escape(chr(10).join(lines))}</code></pre>'
    return _inside(element).strip() if tag.endswith("description") else _inside(element)


def _code_or_words(name: str) -> str:
    """`\\throws as render()`, `\\throws FileError, InvalidInput`: Doxygen takes the first word for a name."""
    word, stop = re.fullmatch(r"(.*?)([,;:.]?)", name, re.S).groups()  # type: ignore[union-attr]
    return (word if word in ("as", "see", "what", "the", "any", "for", "if") else f"<code>{word}</code>") + stop


def _paragraph(element: ElementTree.Element) -> str:
    """HTML allows no block in a paragraph, Doxygen does."""
    blocks = ("simplesect", "parameterlist", "itemizedlist", "orderedlist", "programlisting", "verbatim")
    out, line = [], html.escape(element.text or "", quote=False)
    for child in element:
        if child.tag in blocks:
            out += [f"<p>{line.strip()}</p>" if line.strip() else "", _html(child)]
            line = ""
        else:
            line += _html(child)
        line += html.escape(child.tail or "", quote=False)
    return "".join([*out, f"<p>{line.strip()}</p>" if line.strip() else ""])


class Reader:
    """Doxygen's XML as Headers."""

    def __init__(self, xml: Path) -> None:
        self._xml = xml
        self._declarations = Declarations()

    def headers(self) -> list[Header]:
        headers = {str(h.relative_to(ROOT)): Header(str(h.relative_to(ROOT))) for h in public_headers()}
        members: dict[str, Symbol] = {}
        for file in sorted(self._xml.glob("*.xml")):
            compound = ElementTree.parse(file).getroot().find("compounddef")
            if compound is None or compound.get("prot", "public") != "public":
                continue
            location = compound.find("location")
            header = headers.get(location.get("file", "")) if location is not None else None
            if compound.get("kind") in ("file", "namespace"):  # who lists what differs between versions
                for symbol in self._members(compound):
                    if symbol.file in headers:
                        members[symbol.doxygen_id] = symbol
                if header and compound.get("kind") == "file":
                    header.text = _text_of(compound)
            elif compound.get("kind") in ("class", "struct", "union") and header:
                header.symbols.append(self._class(compound))
        for symbol in members.values():
            headers[symbol.file].symbols.append(symbol)
        for header in headers.values():
            header.symbols = sorted(filter(self._is_public, header.symbols), key=lambda s: s.line)
            header.symbols = self._nested(header.symbols)
        return list(headers.values())

    @staticmethod
    def _is_public(symbol: Symbol) -> bool:
        hidden = re.search(r"(^|::)detail(::|$)|@|^std", symbol.scope) or "@" in symbol.name
        return not hidden and "<" not in symbol.name

    def _nested(self, symbols: list[Symbol]) -> list[Symbol]:
        """Classes of classes become members."""
        outer = {s.full_name: s for s in symbols if s.kind in ("class", "struct", "union")}
        for symbol in symbols:
            if symbol.scope in outer:
                outer[symbol.scope].members.append(symbol)
        for symbol in outer.values():
            symbol.members.sort(key=lambda s: s.line)
        top = [s for s in symbols if s.scope not in outer]
        for siblings in [top, *(s.members for s in symbols)]:
            self._share(siblings)
        return top

    def _share(self, siblings: list[Symbol]) -> None:
        """A comment speaks of the lines below it too, up to an empty line: parse_x() and to_json() under load_x()."""
        for before, symbol in zip(siblings, siblings[1:]):
            said = before.text or before.shared
            lines = {"function", "typedef", "variable", "define"}
            line_by_line = symbol.kind in lines and (before.kind in lines or symbol.kind == "function")
            trailing = "///<" in self._declarations.lines(before.file)[before.last - 1]
            if said and not symbol.text and line_by_line and not trailing and symbol.first == before.last + 1:
                symbol.shared = said

    def _class(self, compound: ElementTree.Element) -> Symbol:
        scope, _, name = compound.findtext("compoundname", "").removeprefix("enfilade::").rpartition("::")
        symbol = self._symbol(compound, compound.get("kind", ""), name, scope)
        symbol.members = list(self._members(compound))
        return symbol

    def _members(self, compound: ElementTree.Element) -> Iterator[Symbol]:
        for member in compound.iter("memberdef"):
            kind, name = member.get("kind", ""), member.findtext("name", "")
            friend = kind == "friend" or member.find("friend") is not None
            if member.get("prot") != "public" or friend:
                continue
            qualified = member.findtext("qualifiedname") or name
            scope = qualified.removeprefix("enfilade::").rpartition("::")[0]
            if kind == "define" and not name.startswith("EN_"):
                continue
            if kind == "enum":
                symbol = self._symbol(member, kind, name, scope)
                for value in member.findall("enumvalue"):
                    words = value.findtext("initializer", "")
                    symbol.members.append(Symbol("enumvalue", value.findtext("name", ""), symbol.full_name, symbol.file,
                                                 symbol.line, f"{value.findtext('name', '')} {words}".strip(),
                                                 _text_of(value), value.get("id", "")))  # fmt: skip
                yield symbol
            else:
                yield self._symbol(member, kind, name, scope)

    def _symbol(self, element: ElementTree.Element, kind: str, name: str, scope: str) -> Symbol:
        location = element.find("location")
        assert location is not None
        file = location.get("declfile") or location.get("file", "")
        line = int(location.get("declline") or location.get("line", "1"))
        declaration = self._declarations.at(file, line) if kind != "define" else self._macro(file, line)
        first = self._declarations.first_line(file, line)
        body = int(location.get("bodyend", "-1")) if location.get("bodyfile") == file else -1
        last = max(first + declaration.count("\n"), body)
        return Symbol(kind, name, scope, file, line, declaration, _text_of(element), element.get("id", ""),
                      element.findtext("argsstring", "") or "", first, last)  # fmt: skip

    def _macro(self, file: str, line: int) -> str:
        found = re.match(r"#define\s+(\w+(?:\([^)]*\))?)", self._declarations.lines(file)[line - 1])
        return f"#define {found[1]}" if found else ""


# --- the rule ---------------------------------------------------------------------------------------------


def _needs_comment(symbol: Symbol, parent: Optional[Symbol]) -> bool:
    """A field and an enumerator are covered by their type's comment; an accessor without arguments by its name,
    which costs O(1) by the house's convention; operators, and what the compiler makes, by the language."""
    if symbol.name.startswith("operator") or symbol.kind == "enumvalue":
        return False
    if parent is None or symbol.kind in ("class", "struct", "union", "enum", "typedef"):
        return True
    if symbol.kind == "variable":
        return False
    arguments = symbol.arguments
    special = symbol.name.startswith("~") or re.search(r"=\s*(default|delete)", arguments + symbol.declaration)
    moves = symbol.name == parent.name and re.match(rf"\((const )?{re.escape(symbol.name)}\s*&", arguments)
    nothing = symbol.name == parent.name and arguments.startswith("()")
    accessor = re.match(r"\(\)\s*const", arguments)
    inherited = re.search(r"\b(override|final)\b", arguments + symbol.declaration)
    return not (special or moves or nothing or accessor or inherited)


def undocumented(headers: list[Header]) -> Iterator[Fault]:
    """Public names without a comment."""

    def walk(symbols: list[Symbol], parent: Optional[Symbol]) -> Iterator[Fault]:
        overloads = {s.name for s in symbols if s.text or s.shared}  # one comment serves the overloads beside it
        for symbol in symbols:
            if not symbol.text and symbol.name not in overloads and _needs_comment(symbol, parent):
                yield Fault(symbol.file, symbol.line, f"{_KIND[symbol.kind]} {symbol.full_name} has no comment (///)")
            yield from walk(symbol.members, symbol)

    for header in headers:
        if not header.text:
            yield Fault(header.path, 1, "the header does not say what it is (/// \\file)")
        yield from walk(header.symbols, None)


# --- writing ----------------------------------------------------------------------------------------------


def first_sentence(text: str) -> str:
    """Of HTML; for tables."""
    plain = re.sub(r"<div class=\"en-section\">.*", "", text, flags=re.S)
    plain = re.sub(r"</?p>|<a [^>]*>|</a>", " ", plain)
    return re.split(r"(?<=[^.][.:;])\s+(?=[A-Z<`])", " ".join(plain.split()), maxsplit=1)[0]


class Index:
    """Where each name is explained."""

    def __init__(self, headers: list[Header]) -> None:
        self.by_doxygen: dict[str, str] = {}
        self.by_name: dict[str, list[tuple[str, str]]] = defaultdict(list)
        self.anchors: dict[int, str] = {}
        for header in headers:
            self._add(header, header.symbols, set())

    def _add(self, header: Header, symbols: list[Symbol], taken: set[str]) -> None:
        for symbol in symbols:
            anchor = base = re.sub(r"[^\w.~]+", "_", symbol.full_name.replace("::", "."))
            number = 1
            while anchor in taken:
                number += 1
                anchor = f"{base}-{number}"
            taken.add(anchor)
            self.anchors[id(symbol)] = anchor
            place = f"{header.page}.html#{anchor}"
            self.by_doxygen[symbol.doxygen_id] = place
            if symbol.kind in ("class", "struct", "union", "enum", "typedef"):
                self.by_name[symbol.name].append((symbol.full_name, place))
            self._add(header, symbol.members, taken)

    def find(self, name: str, scope: str = "") -> Optional[str]:
        """The place of a name as seen from a scope; None where it is none or several."""
        short = name.rpartition("::")[2]
        places = dict(reversed(self.by_name.get(short, [])))
        while True:
            full = f"{scope}::{name}" if scope else name
            if full in places:
                return places[full]
            if not scope:
                break
            scope = scope.rpartition("::")[0]
        fits = [p for full, p in places.items() if full == name or full.endswith(f"::{name}")]
        return fits[0] if len(fits) == 1 else None


class Writer:
    """Pages below stage/reference/cpp."""

    def __init__(self, headers: list[Header], stage: Path) -> None:
        self._headers, self._stage = headers, stage
        self.index = Index(headers)
        self._lexer = CppLexer()

    def write(self) -> dict[str, list[str]]:
        """Returns the pages by library."""
        libraries: dict[str, list[str]] = defaultdict(list)
        for header in self._headers:
            file = self._stage / f"{header.page}.md"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(self._page(header), encoding="utf-8")
            libraries[header.library].append(f"{header.page}.md")
        for library in libraries:
            self._library(library)
        return libraries

    def _library(self, library: str) -> None:
        guide = ROOT / "docs" / f"{library}.md"
        lines = [f"# {library}: headers", ""]
        see = f"`enfilade::{library}`" + (f"; the guide: [{library}](../../../{library}.md)." if guide.exists() else ".")
        lines += [see, "", "| header | what is in it |", "|---|---|"]
        for header in self._headers:
            if header.library == library:
                name = Path(header.path).name
                words = self._resolved(first_sentence(header.text), f"{header.library}/index")
                lines.append(f"| [`{name}`]({Path(name).stem}.md) | {words} |")
        names = [(s, h) for h in self._headers if h.library == library for s in h.symbols
                 if s.kind != "define" and not s.name.startswith("operator")]  # fmt: skip
        lines += ["", "## Names", "", '<div class="en-names">']
        for symbol, header in sorted(names, key=lambda row: (row[0].name.lower(), row[0].line)):
            lines.append(f'<a href="{Path(header.path).stem}.html#{self.index.anchors[id(symbol)]}">'
                         f"<code>{html.escape(symbol.name)}</code></a>")  # fmt: skip
        (self._stage / f"reference/cpp/{library}/index.md").write_text("\n".join([*lines, "</div>", ""]), encoding="utf-8")

    def _page(self, header: Header) -> str:
        out = ["---", f"title: {Path(header.path).name}", "---", f"# `{Path(header.path).name}`", "",
               self._resolved(header.text, header.page), "",
               self._code(f'#include "{header.path}"', "", header.page, own=None), ""]  # fmt: skip
        for symbol in header.symbols:
            if not any(symbol in _continued(other, header.symbols) for other in header.symbols):
                out += self._entry(symbol, header, 2, header.symbols)
        return "\n".join(out) + "\n"

    def _entry(self, symbol: Symbol, header: Header, level: int, siblings: list[Symbol]) -> list[str]:
        kind = _KIND[symbol.kind] if level == 2 or symbol.members else ""
        badge = f' <small class="en-kind">{kind}</small>' if kind else ""
        anchor = self.index.anchors[id(symbol)]
        heading = f'{"#" * level} `{symbol.name}`{badge} {{ #{anchor} data-toc-label="{symbol.name}" }}'
        out = [heading, "", self._code(symbol.declaration, symbol.scope, header.page, anchor)]
        for other in _continued(symbol, siblings):
            out[-1] += f'<a id="{self.index.anchors[id(other)]}"></a>'
            out[-1] += self._code(other.declaration, other.scope, header.page, anchor)
        out.append("")
        if symbol.text or symbol.shared:
            out += [self._resolved(symbol.text or symbol.shared, header.page), ""]
        rows: list[Symbol] = []
        done: list[Symbol] = []
        for member in symbol.members:
            if _goes_without_saying(member, symbol) or member in done:
                continue
            if _fits_a_row(member):
                rows.append(member)
            else:
                out += self._rows(rows, symbol, header)
                rows = []
                done += _continued(member, symbol.members)
                out += self._entry(member, header, min(level + 1, 6), symbol.members)
        return out + self._rows(rows, symbol, header)

    def _rows(self, members: list[Symbol], parent: Symbol, header: Header) -> list[str]:
        """Fields, enumerators and accessors, those of one line together."""
        lines: dict[tuple[int, str], list[Symbol]] = {}
        for member in members:
            lines.setdefault((member.line, member.declaration), []).append(member)
        out = ['<div class="en-fields">']
        for (_, declaration), same in lines.items():
            ids = "".join(f'<a id="{self.index.anchors[id(m)]}"></a>' for m in same)
            words = next((m.text for m in same if m.text), "")
            code = self._code(declaration, parent.full_name, header.page, self.index.anchors[id(parent)], block=False)
            out.append(f"<div>{ids}{code}<div>{self._resolved(words, header.page)}</div></div>")
        return [*out, "</div>", ""] if lines else []

    def _relative(self, place: str, page: str) -> str:
        return "../" * page.count("/") + place

    def _resolved(self, text: str, page: str) -> str:
        """Doxygen's references as links; those that lead out of the public headers as text."""

        def link(found: re.Match[str]) -> str:
            place = self.index.by_doxygen.get(found[1])
            return f'<a href="{self._relative(place, page)}">' if place else '<a class="en-none">'

        text = re.sub(r"<a data-cpp=\"([^\"]+)\">", link, text)
        return re.sub(r"<a class=\"en-none\">(.*?)</a>", r"\1", text, flags=re.S)

    def _code(self, text: str, scope: str, page: str, own: Optional[str] = "", block: bool = True) -> str:
        """Highlighted C++ with links from the names of types to their entries, but for the entry `own`; none
        at all if that is None."""
        out = []
        for token, value in self._lexer.get_tokens(text):
            kind = STANDARD_TYPES.get(token, "")
            words = html.escape(value, quote=False)
            place = self.index.find(value, scope) if own is not None and token in Token.Name else None
            if place and not place.endswith(f"#{own}") and not out_of_std(out):
                words = f'<a href="{self._relative(place, page)}">{words}</a>'
            out.append(f'<span class="{kind}">{words}</span>' if kind and words.strip() else words)
        code = "".join(out).strip()
        if not block:
            return f'<code class="highlight">{code}</code>'
        return f'<div class="highlight en-declaration"><pre><code>{code}</code></pre></div>'


def _continued(symbol: Symbol, siblings: list[Symbol]) -> list[Symbol]:
    """Those below it that share its comment."""
    if symbol.kind in ("class", "struct", "union", "enum"):
        return []  # a function after its struct has an entry of its own
    after = siblings[[id(s) for s in siblings].index(id(symbol)) + 1 :]
    return list(itertools.takewhile(lambda other: other.shared, after))


def _goes_without_saying(symbol: Symbol, parent: Symbol) -> bool:
    """What every class has, and says nothing about."""
    if symbol.text or symbol.kind != "function":
        return False
    copies = symbol.name in (parent.name, "operator=") and re.match(rf"\((const )?{parent.name}\s*&", symbol.arguments)
    return bool(symbol.name.startswith("~") or copies or re.search(r"=\s*(default|delete)", symbol.arguments))


def _fits_a_row(symbol: Symbol) -> bool:
    if symbol.kind in ("variable", "enumvalue"):
        return True
    short = len(re.sub(r"<[^>]*>", "", symbol.text)) < 90 and "en-section" not in symbol.text
    return symbol.kind == "function" and short and len(symbol.declaration) < 90 and "\n" not in symbol.declaration


def out_of_std(before: list[str]) -> bool:
    """Whether what is written so far ends with `std::`."""
    return re.sub(r"<[^>]*>", "", "".join(before[-4:])).endswith("std::")
