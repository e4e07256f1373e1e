"""python3 main_test.py PROGRAM VECTORS: the script on the graph of tests/vectors."""

import gzip
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import main

PROGRAM, VECTORS = sys.argv[1:3]


class Evaluate(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        os.environ["ENFILADE"] = PROGRAM
        os.environ["ENFILADE_CONNECTIVITY"] = str(Path(VECTORS) / "data" / "connectivity")

        os.environ.pop("ENFILADE_PHASES", None)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, content):
        file = Path(self.folder.name) / name
        file.write_text(json.dumps(content))
        return file

    def set_phases(self, phases):
        os.environ["ENFILADE_PHASES"] = str(self.write("phases.json", phases))

    def evaluate_many(self, successes):
        """Of 200 paths from v0 to v1, so many succeed; the others stay at their start."""
        annotations = self.write("secret.json", [{
            "path_id": k, "scan": "triangle", "heading": 0.0, "path": ["v0", "v1"],
            "distance": 3.0, "instructions": ["Walk on."]} for k in range(200)])  # fmt: skip
        way = [["v0", 0, 0], ["v1", 0, 0]]
        results = self.write("results.json", [
            {"instr_id": f"{k}_0", "trajectory": way if k < successes else way[:1]}
            for k in range(200)])  # fmt: skip
        return main.evaluate(annotations, results, "test")["result"][0]["test"]

    def evaluate(self, trajectory):
        # From v0 to v1, which are 3 m apart (docs of the vectors).
        annotations = self.write("secret.json", [{
            "path_id": 1, "scan": "triangle", "heading": 0.0, "path": ["v0", "v1"],
            "distance": 3.0, "instructions": ["Walk on."]}])  # fmt: skip
        results = self.write("results.json", [{"instr_id": "1_0", "trajectory": trajectory}])
        return main.evaluate(annotations, results, "test", submission_metadata={})

    def test_who_arrives_succeeds(self):
        scored = self.evaluate([["v0", 0, 0], ["v1", 0, 0]])
        row = scored["result"][0]["test"]
        self.assertEqual(row["success"], 1)
        self.assertEqual(row["spl"], 1)
        self.assertAlmostEqual(row["length"], 3)
        self.assertEqual(set(row), set(main.COLUMNS))

    def test_who_stays_does_not(self):
        row = self.evaluate([["v0", 0, 0]])["result"][0]["test"]
        self.assertEqual(row["success"], 0)
        self.assertEqual(row["nav_error"], 3)

    def test_results_are_of_the_splits_of_the_phase(self):
        self.set_phases({"test": {"splits": ["a", "b"]}, "other": {"splits": ["c"]}})
        scored = self.evaluate([["v0", 0, 0], ["v1", 0, 0]])
        self.assertEqual([list(one) for one in scored["result"]], [["a"], ["b"]])

    def test_participants_files_have_no_score_unless_the_host_says_so(self):
        scored = self.evaluate([["v0", 0, 0], ["v1", 0, 0]])
        self.assertEqual(set(scored["submission_result"]), {"length"})
        self.set_phases({"test": {"result_file": True}})
        scored = self.evaluate([["v0", 0, 0], ["v1", 0, 0]])
        self.assertEqual(scored["submission_result"], scored["result"][0]["test"])

    def test_exact_means_are_not_told(self):
        # They are 0.52 and 0.525; 1.44 m and 1.425 m. Only what comes to the edge of a step is told:
        # that is a bound on what an answer tells, and no secrecy.
        base = self.evaluate_many(104)
        more = self.evaluate_many(105)
        for column in ("success", "spl", "nav_error"):
            self.assertEqual(base[column], more[column])
        self.assertEqual(base["success"], 0.52)
        self.assertEqual(base["nav_error"], 1.4)
        self.assertAlmostEqual(more["length"] - base["length"], 3 / 200)

    def test_walks_that_surely_succeed_make_the_grid_no_finer(self):
        # Added one by one, so that some come to the edges of rounding: each answer is still one of
        # 101, and tells no more than log2 101 bits.
        for successes in (101, 102, 103):
            told = self.evaluate_many(successes)["success"]
            self.assertIn(told, [round(level / 100, 2) for level in range(101)])
            self.assertLessEqual(abs(told - successes / 200), 0.0051)

    def test_the_host_says_how_coarse(self):
        self.set_phases({"test": {"step": 0.1}})
        row = self.evaluate_many(105)
        self.assertEqual(row["success"], 0.5)
        self.assertEqual(row["nav_error"], 1)
        self.set_phases({"test": {"step": 0.7}})
        with self.assertRaises(RuntimeError):
            self.evaluate_many(0)

    def test_phases_may_have_a_byte_order_mark_and_be_packed(self):
        file = self.write("phases.json", {"test": {"splits": ["a"]}})
        os.environ["ENFILADE_PHASES"] = str(file)
        content = file.read_bytes()

        def splits():
            scored = self.evaluate([["v0", 0, 0], ["v1", 0, 0]])
            return [list(one) for one in scored["result"]]

        file.write_bytes(b"\xef\xbb\xbf" + content)
        self.assertEqual(splits(), [["a"]])
        packed = Path(str(file) + ".gz")
        packed.write_bytes(gzip.compress(content[:9]) + gzip.compress(content[9:]) + bytes(64))
        file.unlink()
        self.assertEqual(splits(), [["a"]])
        packed.rename(file)
        self.assertEqual(splits(), [["a"]])

    def test_fields_of_phases_are_those_that_there_are(self):
        for phases, said in {
            '{"test": {"stpe": 0.1}}': "phases.json: test: unknown field 'stpe'; the nearest is step",
            '{"test": {"split": ["a"]}}': "unknown field 'split'; the nearest is splits",
            '{"other": {"comment": 1}}': "other: unknown field 'comment'; allowed are splits, step, result_file",
            '{"test": {"splits": "a"}}': "test.splits: 'a', not a list of names",
            '{"test": {"splits": []}}': r"test.splits: '\[\]', not a list of names",
            '{"test": {"step": "0.1"}}': "test.step: '0.1', not from 0.001 to 0.5",
            '{"test": {"result_file": "no"}}': "test.result_file: 'no', not true or false",
            '{"test": 3}': "test: '3', not an object",
            '[{"test": {}}]': '"splits": .* is expected',
            '{"test": {}': "phases.json: cannot be read",
            '{"phases": [{"name": "test", "split": "test", "annotations": "a.json"}]}':
                'phases of `enfilade serve`; those of EvalAI have another form: {"test": ',
        }.items():  # fmt: skip
            file = self.write("phases.json", {})
            file.write_text(phases)
            os.environ["ENFILADE_PHASES"] = str(file)
            with self.assertRaisesRegex(RuntimeError, said):
                self.evaluate_many(0)
            # The host learns of it before the archive is made.
            command = [sys.executable, "-B", Path(main.__file__).with_name("package.py")]
            command += ["--program", PROGRAM, "--connectivity", self.folder.name, "--phases", file]
            packed = subprocess.run(
                [*command, "-o", file.with_suffix(".zip")], capture_output=True, text=True, check=False
            )
            self.assertEqual(packed.returncode, 3)
            self.assertRegex(packed.stderr, said)
            self.assertFalse(file.with_suffix(".zip").exists())

    def test_a_phase_that_is_given_twice_is_refused(self):
        self.set_phases({})
        file = Path(os.environ["ENFILADE_PHASES"])
        for phases in ('"test": {"step": 0.1}, "test": {}', '"test": {"step": 0.1, "step": 0.2}'):
            file.write_text("{" + phases + "}")
            with self.assertRaisesRegex(RuntimeError, "phases.json: (test|step): given twice"):
                self.evaluate_many(0)

    def test_faults_are_told_without_the_secret_files_name(self):
        with self.assertRaises(main.BadSubmission) as refused:
            self.evaluate([["v1", 0, 0]])
        self.assertIn("$[0].trajectory[0]", str(refused.exception))
        self.assertNotIn("secret.json", str(refused.exception))
        self.assertNotIn(self.folder.name, str(refused.exception))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
