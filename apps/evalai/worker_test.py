"""python3 worker_test.py PROGRAM VECTORS: the archive of package.py, in a stand-in for EvalAI's worker."""

import functools
import gzip
import http.server
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest
import zipfile
from pathlib import Path

PROGRAM, VECTORS = sys.argv[1:3]
HERE = Path(__file__).resolve().parent


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


class Worker(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """A host's archive, and a server that has it: the part of EvalAI that workers ask for files."""
        cls.media = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.media.cleanup)
        root = Path(cls.media.name)
        (root / "phases.json").write_text(json.dumps(
            {"test": {"splits": ["test_split", "again"], "step": 0.1}}))  # fmt: skip
        graph = "connectivity/triangle_connectivity.json"
        shutil.copytree(Path(VECTORS) / "data" / "connectivity", root / "connectivity")
        (root / f"{graph}.gz").write_bytes(gzip.compress((root / graph).read_bytes()))
        (root / graph).unlink()  # as people keep them, too
        cls.archive = root / "evaluation.zip"
        cls.make_archive(cls.archive)
        (root / "R2R_secret_goals.json").write_text(json.dumps([{
            "path_id": 1, "scan": "triangle", "heading": 0.0, "path": ["v0", "v1"],
            "distance": 3.0, "instructions": ["Walk on."]}]))  # fmt: skip
        for name, way in {"arrives": ["v0", "v1"], "stays": ["v0"], "elsewhere": ["v1"]}.items():
            (root / f"{name}.json").write_text(json.dumps(
                [{"instr_id": "1_0", "trajectory": [[v, 0, 0] for v in way]}]))  # fmt: skip
        handler = functools.partial(Quiet, directory=str(root))
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        cls.addClassCleanup(server.server_close)
        cls.addClassCleanup(server.shutdown)
        cls.url = f"http://127.0.0.1:{server.server_port}"

    @classmethod
    def make_archive(cls, file):
        root = Path(cls.media.name)
        subprocess.run(
            [sys.executable, "-B", HERE / "package.py", "--program", PROGRAM, "--connectivity",
             root / "connectivity", "--phases", root / "phases.json", "-o", file],
            check=True, stderr=subprocess.DEVNULL)  # fmt: skip

    def run_worker(self, *files):
        """A worker that has Python and nothing else: no PATH, no variables of ours."""
        temporary = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, temporary)
        phases = [{"id": 5, "codename": "test", "test_annotation": f"{self.url}/R2R_secret_goals.json",
                   "splits": ["test_split", "again"]},
                  {"id": 6, "codename": "dev", "test_annotation": f"{self.url}/R2R_secret_goals.json",
                   "splits": ["other"]}]  # fmt: skip
        submissions = [{"id": k, "phase": phase, "input_file": f"{self.url}/{file}.json"}
                       for k, (phase, file) in enumerate(files)]  # fmt: skip
        asked = {"challenge": {"id": 7, "evaluation_script": f"{self.url}/evaluation.zip"},
                 "phases": phases, "submissions": submissions}  # fmt: skip
        done = subprocess.run([sys.executable, "-B", HERE / "stand_in_worker.py"], text=True,
                              input=json.dumps(asked), stdout=subprocess.PIPE, check=True,
                              env={"PATH": "/nonexistent", "TMPDIR": temporary})  # fmt: skip
        said = json.loads(done.stdout)
        return said["stored"], Path(said["folder"])

    def test_a_good_file_is_on_the_leaderboards_of_its_phase(self):
        (arrives, stays), _ = self.run_worker((5, "arrives"), (5, "stays"))
        for stored, success in ((arrives, 1), (stays, 0)):
            self.assertEqual(stored["status"], "finished")
            self.assertEqual([row["split"] for row in stored["leaderboard"]], ["test_split", "again"])
            for row in stored["leaderboard"]:
                self.assertEqual(row["result"]["success"], success)
                self.assertEqual(set(row["result"]), {
                    "length", "nav_error", "oracle_success", "success", "spl", "ndtw", "sdtw", "cls"
                })  # fmt: skip
            self.assertEqual(set(json.loads(stored["result_file"])), {"length"})
            self.assertEqual(stored["stdout"], "")

    def test_a_file_with_faults_fails_and_its_author_reads_why_and_no_secret(self):
        (stored,), _ = self.run_worker((5, "elsewhere"))
        self.assertEqual(stored["status"], "failed")
        self.assertEqual(stored["leaderboard"], [])
        self.assertIn("$[0].trajectory[0]", stored["stderr"])
        self.assertNotIn("R2R_secret_goals", stored["stderr"])

    def test_a_phase_that_the_file_of_phases_lacks_fails_if_its_split_has_another_name(self):
        (stored,), _ = self.run_worker((6, "arrives"))
        self.assertEqual(stored["status"], "failed")
        self.assertIn("dev is none of the phase's splits", stored["stderr"])

    def test_nothing_is_unpacked_that_may_be_run_and_the_host_packs_the_same_bytes(self):
        with zipfile.ZipFile(self.archive) as opened:
            names = opened.namelist()
            self.assertEqual([one.external_attr >> 16 & 0o111 for one in opened.infolist()],
                             [0] * len(names))  # fmt: skip
        self.assertNotIn("requirements.txt", names)
        again = self.archive.with_name("again.zip")
        self.make_archive(again)
        self.assertEqual(again.read_bytes(), self.archive.read_bytes())

    def test_the_program_needs_nothing_of_the_worker_but_a_kernel(self):
        """In a root folder that has the archive alone: no library, no shell, no /proc."""
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        with zipfile.ZipFile(self.archive) as opened:
            opened.extractall(folder)
        Path(folder, "lib", "ld.so").chmod(0o700)
        for file in ("R2R_secret_goals", "arrives"):
            shutil.copy(Path(self.media.name, f"{file}.json"), folder)
        unshare = ["unshare", "--user", "--map-root-user"]
        able = shutil.which("unshare") and not subprocess.run(
            [*unshare, "--root=/", "true"], check=False, stderr=subprocess.DEVNULL).returncode  # fmt: skip
        if not able:
            self.skipTest("this machine lets us have no other root folder (unshare --user --root)")
        done = subprocess.run(
            [*unshare, f"--root={folder}", "/lib/ld.so", "--library-path", "/lib", "/bin/enfilade", "score", "arrives.json", "--annotations", "R2R_secret_goals.json",
             "--connectivity", "connectivity", "--json", "-"],
            check=False, text=True, capture_output=True, env={})  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["means"]["success"]["mean"], 1)


if __name__ == "__main__":
    os.environ.pop("ENFILADE", None)
    unittest.main(argv=sys.argv[:1])
