"""python3 main_test.py PROGRAM VECTORS: the script on the graph of tests/vectors."""

import json
import os
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

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, content):
        file = Path(self.folder.name) / name
        file.write_text(json.dumps(content))
        return file

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
        self.assertEqual(scored["submission_result"], row)

    def test_who_stays_does_not(self):
        row = self.evaluate([["v0", 0, 0]])["result"][0]["test"]
        self.assertEqual(row["success"], 0)
        self.assertAlmostEqual(row["nav_error"], 3)

    def test_faults_are_told_without_the_secret_files_name(self):
        with self.assertRaises(main.BadSubmission) as refused:
            self.evaluate([["v1", 0, 0]])
        self.assertIn("$[0].trajectory[0]", str(refused.exception))
        self.assertNotIn("secret.json", str(refused.exception))
        self.assertNotIn(self.folder.name, str(refused.exception))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
