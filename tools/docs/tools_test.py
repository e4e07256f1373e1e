#!/usr/bin/env python3
"""Tests of what checks the documentation: each fault is found, and named by file and line."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parent))

import architecture
import cpp_reference
import markdown_tree
import prose
import python_reference
import tutorials


class MarkdownTree(unittest.TestCase):
    def faults(self, text: str) -> list[str]:
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(markdown_tree, "ROOT", Path(folder).resolve()):
            root = markdown_tree.ROOT
            (root / "tools").mkdir()
            (root / "other.md").write_text("# Other\n\n## A `part`, here\n")
            (root / "page.md").write_text(text)
            return [str(fault) for fault in markdown_tree.check_page(root / "page.md")]

    def test_without_git_what_gitignore_names_is_left_out(self) -> None:
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(markdown_tree, "ROOT", Path(folder).resolve()):
            root = markdown_tree.ROOT
            (root / ".gitignore").write_text("# Made\n/build/\n/web/dist/\nnode_modules/\n*.orig\n")
            kept = ["README.md", "dist/a.md", "web/a.md"]
            for name in [*kept, "build/a.md", "web/dist/a.md", "web/node_modules/b/a.md", "node_modules/a.md"]:
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text("x")
            with mock.patch.dict(os.environ, {"GIT_CEILING_DIRECTORIES": str(root.parent)}):
                found = markdown_tree.tracked_files("*.md")
            self.assertEqual([str(one.relative_to(root)) for one in found], kept)

    def test_a_link_to_nothing_is_named_by_its_line(self) -> None:
        self.assertEqual(self.faults("# Page\n\n[x](none.md)\n"), ["page.md:3: the link 'none.md' leads to no file"])

    def test_a_link_to_no_heading_is_found(self) -> None:
        self.assertEqual(self.faults("[x](other.md#a-part-here)"), [])
        self.assertIn("no heading '#b'", self.faults("[x](other.md#b)")[0])

    def test_a_path_that_is_not_in_the_tree_is_found(self) -> None:
        self.assertEqual(self.faults("see `tools/` and `homes/connectivity`"), [])
        self.assertIn("'tools/none.py' is not in the tree", self.faults("see `tools/none.py`")[0])

    def test_code_is_no_link(self) -> None:
        self.assertEqual(self.faults("```\n[x](none.md)\n```\n`a[0](none)`\n<!-- [x](none.md) -->"), [])


class Prose(unittest.TestCase):
    def faults(self, name: str, text: str) -> list[str]:
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(prose, "ROOT", Path(folder).resolve()):
            file = prose.ROOT / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
            return [str(fault) for fault in prose.check(file)]

    def test_forbidden_words_and_long_sentences_are_named_by_their_line(self) -> None:
        self.assertEqual(self.faults("docs/a.md", "# Page\n\nAn agent acts.\n"), [])
        self.assertIn("docs/a.md:3: 'freely'", self.faults("docs/a.md", "# Page\n\nIt walks freely.\n")[0])
        self.assertIn("has 26 words", self.faults("docs/a.md", "A" + " word" * 25 + ".\n")[0])
        self.assertIn("121 characters", self.faults("docs/a.md", "ab " * 40 + "a\n")[-1])

    def test_code_and_the_glossary_are_left_out(self) -> None:
        self.assertEqual(self.faults("docs/a.md", "```\nfreely\n```\n<!-- prose: off -->\nfreely\n<!-- prose: on -->\n"), [])

    def test_comments_docstrings_and_messages_are_read(self) -> None:
        self.assertIn("enfilade/a.h:2: 'nobody'", self.faults("enfilade/a.h", "#pragma once\n/// Seen by nobody.\n")[0])
        self.assertIn("begin with the thing", self.faults("enfilade/a.h", "/// Of the agent: its pose.\n")[0])
        self.assertIn("'whoever'", self.faults("python/enfilade/a.py", '"""For whoever."""\n')[0])
        self.assertIn("'somebody'", self.faults("apps/a.cpp", 'fail("asked by somebody");\n')[0])


class CppReference(unittest.TestCase):
    def undocumented(self, text: str) -> list[str]:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder).resolve()
            (root / "enfilade/x").mkdir(parents=True)
            (root / "enfilade/x/y.h").write_text(text)
            with mock.patch.object(cpp_reference, "ROOT", root):
                faults = cpp_reference.run_doxygen(root / "out")
                headers = cpp_reference.Reader(root / "out/xml").headers()
                return [str(f) for f in [*faults, *cpp_reference.undocumented(headers)]]

    def test_what_has_no_comment_is_named_by_file_and_line(self) -> None:
        text = "/// \\file  A header.\n#pragma once\nnamespace enfilade::x {\n%sstruct S { int field; };\n}\n"
        self.assertEqual(self.undocumented(text % ""), ["enfilade/x/y.h:4: struct x::S has no comment (///)"])
        self.assertEqual(self.undocumented(text % "/// A thing.\n"), [])

    def test_members_that_do_work_want_a_comment(self) -> None:
        text = ("/// \\file  A header.\n#pragma once\nnamespace enfilade::x {\n/// A thing.\nclass C {\n public:\n  C();\n  ~C();\n"
                "  C(const C&) = delete;\n  int size() const;\n  void turn(int by);\n};\n}\n")  # fmt: skip
        self.assertEqual(self.undocumented(text), ["enfilade/x/y.h:11: function x::C::turn has no comment (///)"])

    def test_a_tag_that_is_none_is_found(self) -> None:
        text = "/// \\file  Files of <scan>.\n#pragma once\nnamespace enfilade::x {}\n"
        self.assertIn("enfilade/x/y.h:1: ", " ".join(self.undocumented(text)))

    def test_declarations_are_the_headers_own(self) -> None:
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(cpp_reference, "ROOT", Path(folder)):
            (Path(folder) / "a.h").write_text("struct S {\n  template <class T>\n  int f(T a,  // first\n        int b = 2) const { return 1; }\n};\n")
            found = cpp_reference.Declarations().at("a.h", 3)
        self.assertEqual(found, "template <class T>\nint f(T a,\n      int b = 2) const")


class PythonReference(unittest.TestCase):
    def test_what_has_no_docstring_is_named(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder).resolve()
            (root / "python/thing").mkdir(parents=True)
            (root / "python/thing/__init__.py").write_text('"""A thing."""\n\n__all__ = ["f"]\n\n\ndef f():\n    pass\n')
            with mock.patch.multiple(python_reference, ROOT=root, SOURCES=root / "python"):
                faults = [str(f) for f in python_reference.undocumented(python_reference.load())]
        self.assertEqual(faults, ["python/thing/__init__.py:6: thing.f has no docstring"])


class Tutorials(unittest.TestCase):
    def test_outputs_are_compared(self) -> None:
        self.assertTrue(tutorials.matches("a 1\nb\n", "a 1 \nb"))
        self.assertFalse(tutorials.matches("a 1", "a 2"))
        self.assertTrue(tutorials.matches("took ... s", "took 1.5 s"))
        self.assertTrue(tutorials.matches("a\n...\nd", "a\nb\nc\nd"))
        self.assertFalse(tutorials.matches("a\n...\nd", "a\nb\nc"))
        self.assertTrue(tutorials.matches("SR 1.0 [0.5, 2.0]", "SR  12.5", loose=True))

    def test_blocks_are_found_by_what_stands_behind_their_language(self) -> None:
        page = "```sh run\nls\n```\n```text output\na\n```\n```python file=a.py\nx = 1\n```\n```\nno\n```\n"
        self.assertEqual([(b.what, b.file, b.line) for b in tutorials.blocks_of(page)],
                         [("run", "", 1), ("output", "", 4), ("file", "a.py", 7)])  # fmt: skip


class Architecture(unittest.TestCase):
    def test_arrows_that_follow_from_others_are_left_out(self) -> None:
        direct = {"a": set(), "b": {"a"}, "c": {"a", "b"}}
        self.assertEqual(architecture.reduced(direct), {"a": set(), "b": {"a"}, "c": {"b"}})

    def test_every_process_draws_the_same_picture(self) -> None:
        # Python orders sets of strings by a seed that differs between processes.
        draw = "import architecture, hashlib; print(hashlib.sha256(architecture.draw().encode()).hexdigest())"
        drawn = {subprocess.run([sys.executable, "-B", "-c", draw], cwd=Path(__file__).parent, check=True, text=True,
                                capture_output=True, env=os.environ | {"PYTHONHASHSEED": str(seed)}).stdout
                 for seed in range(16)}  # fmt: skip
        self.assertEqual(len(drawn), 1)


if __name__ == "__main__":
    unittest.main()
