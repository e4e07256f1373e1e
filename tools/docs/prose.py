#!/usr/bin/env python3
"""Checks that prose is plain: words of the field, sentences of at most 25 words, lines of at most 120 characters.

Reads the pages of the documentation, the comments of C++ headers and the docstrings of the Python package, and for
forbidden words also messages: the string literals of C++ and Python, and the sources of web pages. The rule and its
glossary: docs/conventions.md, "Words".

Usage: tools/docs/prose.py [FILE...]     (none: the whole tree). Exit status: 0 clean, 1 faults, each named by line.
"""

from __future__ import annotations

import ast
import re
import sys
from dataclasses import dataclass
from pathlib import Path

from markdown_tree import ROOT, tracked_files

MOST_WORDS = 25  # the rule is 20; a list of names may take a few more
MOST_COLUMNS = 120

# What is forbidden, and what to write instead.
FORBIDDEN = [
    (r"\bfreely\b", "'continuous'"),
    (r"\bwalks? free\b", "'continuous'"),
    (r"\bwhoever\b", "'anyone who', or 'you'"),
    (r"\b(?:that|which|what) (?:is|are) none\b", "'unknown', 'invalid'"),
    (r"\bthat there (?:is|are) not\b", "'unknown', 'missing'"),
    (r"\bthere is not\b", "'there is no', 'missing'"),
    (r"\bis no (?:other )?one\b", "'is not'"),
    (r"\bsomebody\b", "'a user', 'another client'"),
    (r"\bnobody\b", "'no one', or the thing itself"),
    (r"\bbut for\b", "'except'"),
    (r"\bby turns\b", "'alternating'"),
    (r"\b(?:is|are|was|were) told\b", "'receives', 'the message says'"),
    (r"\bfor nothing\b", "'at no cost', 'in vain'"),
    (r"\bas it is, was\b", "a sentence"),
    (r"\bso many\b", "'the number of'"),
    (r"\bworked out\b", "'computed'"),
]
# Openings that turn a sentence round.
OPENINGS = [
    (r"^Of (?!course\b)[^.:;]{0,60}:", "begin with the thing, not with 'Of X:'"),
    (r"^Of (?:a|an|the|each|all|its|which|what|those|these|several|two)\b", "begin with the thing, not with 'Of'"),
    (r"^Who(?:ever)? (?!(?:is|was|are)\b[^.]*\?)", "begin with the thing: 'A user who', 'If you'"),
]
PATTERNS = [(re.compile(p, re.I), say) for p, say in FORBIDDEN]
FIRSTS = [(re.compile(p), say) for p, say in OPENINGS]

# Written by programs or from other people's texts: what they say is checked where it stands first.
GENERATED = {"docs/bad_input.md"}
# Histories and decisions of other times may keep long sentences; words count all the same.
SKIPPED = ("CHANGELOG.md", "tests/vectors/")


@dataclass(frozen=True)
class Fault:
    file: Path
    line: int
    what: str

    def __str__(self) -> str:
        return f"{self.file.relative_to(ROOT)}:{self.line}: {self.what}"


@dataclass(frozen=True)
class Text:
    """A piece of prose: the line that it begins on, and whether its sentences are measured."""

    line: int
    text: str
    measured: bool = True


def plain(text: str) -> str:
    """Markdown without its marks; code and addresses count as one word."""
    text = re.sub(r"<!--.*?-->", "", text, flags=re.S)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"`+[^`]+`+", "CODE", text)
    text = re.sub(r"https?://\S+", "ADDRESS", text)
    return re.sub(r"[*_]{1,2}(\S(?:.*?\S)?)[*_]{1,2}", r"\1", text)


def sentences(text: str) -> list[str]:
    """Sentences of a paragraph. A colon or a semicolon ends none: what it joins is read in one breath."""
    text = re.sub(r"\b(e\.g|i\.e|vs|etc|cf|al|Fig|Eq|Sec|Tab|no|approx)\.", r"\1", text)
    return [one.strip() for one in re.split(r"(?<=[.!?])[)\"'’]*\s+(?=[A-Z0-9(\"'`*])", text) if one.strip()]


def words(sentence: str) -> int:
    return sum(bool(re.search(r"[A-Za-z]", one)) for one in sentence.split())


def markdown(path: Path) -> list[Text]:
    texts: list[Text] = []
    held: list[str] = []
    first = 0
    fence = ""

    def flush() -> None:
        if held:
            texts.append(Text(first, plain(" ".join(held))))
            held.clear()

    on = True  # a glossary names the words that are forbidden
    for number, line in enumerate(path.read_text().splitlines(), 1):
        switch = re.fullmatch(r"<!-- prose: (on|off) -->", line.strip())
        on = switch[1] == "on" if switch else on
        if switch or not on:
            flush()
            continue
        mark = re.match(r"\s*(```+|~~~+)", line)
        if mark and (not fence or line.strip().startswith(fence)):
            flush()
            fence = "" if fence else mark[1]
            continue
        if fence:
            continue
        stripped = line.strip()
        if stripped.startswith("|"):
            flush()
            cells = stripped.strip("|").split("|")
            if not all(re.fullmatch(r"\s*:?-+:?\s*", one) for one in cells):
                texts += [Text(number, plain(one.strip())) for one in cells if one.strip()]
            continue
        item = re.match(r"(?:[-*+]|\d+\.)\s+(.*)", stripped)
        heading = re.match(r"#+\s+(.*)", stripped)
        if not stripped or item or heading or stripped.startswith("!["):
            flush()
        if heading:
            texts.append(Text(number, plain(heading[1])))
        elif stripped:
            if not held:
                first = number
            held.append(item[1] if item else stripped.lstrip("> "))
    flush()
    return texts


def header(path: Path) -> list[Text]:
    """Comments of a C++ header; one behind code ends with its line."""
    texts: list[Text] = []
    held: list[str] = []
    first = 0
    code = False

    def flush() -> None:
        if held:
            texts.append(Text(first, plain(" ".join(held))))
            held.clear()

    for number, line in enumerate(path.read_text().splitlines(), 1):
        comment = re.search(r"(?:^|\s)//[/!]?<?\s?(.*)$", line)
        if not comment or '"' in line[: comment.start()]:
            flush()
            continue
        said = comment[1].strip()
        if said.startswith("\\code"):
            code = True
        trailing = bool(line[: comment.start()].strip())
        if said.startswith("\\endcode"):
            code = False
            continue
        if code or not said or said.startswith(("NOLINT", "clang-format")):
            flush()
            continue
        tag = re.match(r"\\(file|brief|pre|post|throws?|returns?|param(?:\[\w+\])?|tparam|note)\s+(.*)", said)
        if tag or trailing or re.match(r"[-*] ", said):
            flush()
            if tag:
                said = re.sub(r"^\w+\s+", "", tag[2]) if tag[1].startswith(("param", "tparam", "throw")) else tag[2]
        if not held:
            first = number
        held.append(said.lstrip("-* "))
        if trailing:
            flush()
    flush()
    return texts


def literals(path: Path) -> list[Text]:
    """String literals of C++, adjacent ones as one: messages and help. Not measured."""
    texts = []
    source = path.read_text()
    for found in re.finditer(r'"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*', source):
        text = re.sub(r'"\s*"', "", found[0])[1:-1]
        if " " in text:
            texts.append(Text(source.count("\n", 0, found.start()) + 1, text, measured=False))
    return texts


def lines(path: Path) -> list[Text]:
    """Lines of a page's source: what it shows, and comments. Not measured."""
    return [Text(number, line, measured=False) for number, line in enumerate(path.read_text().splitlines(), 1)]


def docstrings(path: Path) -> list[Text]:
    texts = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            said = ast.get_docstring(node)
            if said:
                line = node.body[0].lineno
                for block in re.split(r"\n\s*\n", said):
                    if not re.search(r"^\s*(>>>|[A-Z]\w+:$|-{3,}|\.\. )", block, re.M):
                        texts.append(Text(line, plain(" ".join(block.split()))))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            texts.append(Text(node.lineno, node.value, measured=False))
    return texts


READERS = [
    (re.compile(r"^(docs/.*|[A-Z]+|.*/README)\.md$"), markdown),
    (re.compile(r"^(enfilade|compat|apps)/.*\.h$"), header),
    (re.compile(r"^python/(?!tests/).*\.py$"), docstrings),
    (re.compile(r"^(enfilade|apps|compat|python)/(?!.*_test\.).*\.(cpp|h)$"), literals),
    (re.compile(r"^web/(src|pages)/(?!.*\.test\.).*\.(ts|html|css)$"), lines),
]


def check(path: Path) -> list[Fault]:
    name = path.relative_to(ROOT).as_posix()
    if name in GENERATED or name.startswith(SKIPPED):
        return []
    faults = []
    for pattern, reader in READERS:
        if not pattern.match(name):
            continue
        for text in reader(path):
            said = re.sub(r"CODE|ADDRESS", "", text.text)
            faults += [
                Fault(path, text.line, f"'{found[0]}': write {say}") for p, say in PATTERNS for found in p.finditer(said)
            ]
            for one in sentences(text.text) if text.measured else []:
                faults += [Fault(path, text.line, f"'{one[:30]}...': {say}") for p, say in FIRSTS if p.match(one)]
                if words(one) > MOST_WORDS:
                    faults.append(Fault(path, text.line, f"'{one[:50]}...' has {words(one)} words, of {MOST_WORDS}"))
    if name.endswith(".md"):
        fenced = False
        for number, line in enumerate(path.read_text().splitlines(), 1):
            fenced ^= bool(re.match(r"\s*(```|~~~)", line))
            # Cells of a table, code and addresses cannot be broken.
            if not fenced and len(line) > MOST_COLUMNS and not re.match(r"\s*(\||!\[|```|\[[^\]]+\]: |\S+$)", line):
                faults.append(Fault(path, number, f"{len(line)} characters, of {MOST_COLUMNS}"))
    return faults


def main(arguments: list[str]) -> int:
    if arguments and arguments[0] in ("-h", "--help"):
        print(__doc__)
        return 0
    faults = [fault for path in ([Path(one).resolve() for one in arguments] or tracked_files()) for fault in check(path)]
    for fault in faults:
        print(fault)
    print(f"prose: {len(faults)} faults", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
