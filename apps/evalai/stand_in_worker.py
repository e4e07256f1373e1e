"""A stand-in for EvalAI's submission worker, for tests: what that does to a challenge's archive and files, without its
database and queue.

As its scripts/workers/submission_worker.py (Cloud-CV/EvalAI, read at 47e68b2): everything is fetched over HTTP; the
archive is unpacked by zipfile into the package challenge_data.challenge_ID; the annotations lie below
that package, a participant's file elsewhere; both streams of Python are replaced while evaluate() runs; a result counts
if each entry's first key is a split of the phase. Later workers also install a requirements.txt of
the archive; this one refuses it.

Reads {"challenge", "phases", "submissions"} from stdin and prints what EvalAI would store of each submission.
"""

import contextlib
import importlib
import json
import shutil
import sys
import tempfile
import traceback
import urllib.request
import zipfile
from pathlib import Path


def fetch(url, file):
    with urllib.request.urlopen(url) as response:
        file.write_bytes(response.read())


def make_package(folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "__init__.py").write_text("")


def name_in(url):
    return url.rsplit("/", 1)[1]


class Worker:
    def __init__(self, challenge, phases):
        self.base = Path(tempfile.mkdtemp()) / "compute"
        make_package(self.base)
        sys.path.append(str(self.base))
        make_package(self.base / "challenge_data")
        folder = self.base / "challenge_data" / f"challenge_{challenge['id']}"
        make_package(folder)
        archive = folder / f"challenge_{challenge['id']}.zip"
        fetch(challenge["evaluation_script"], archive)
        with zipfile.ZipFile(archive) as opened:
            opened.extractall(folder)
        archive.unlink()
        if (folder / "requirements.txt").exists():
            raise SystemExit("requirements.txt: nothing is to be installed")
        self.phases = {phase["id"]: dict(phase) for phase in phases}
        for phase in self.phases.values():
            url = phase["test_annotation"]
            phase["annotations"] = folder / "phase_data" / f"phase_{phase['id']}" / name_in(url)
            phase["annotations"].parent.mkdir(parents=True)
            fetch(url, phase["annotations"])
        importlib.invalidate_caches()
        self.script = importlib.import_module(f"challenge_data.challenge_{challenge['id']}")
        self.folder = folder

    def run(self, submission):
        """What is stored of it: status, rows of leaderboards, and the files a participant gets."""
        folder = self.base / "submission_files" / f"submission_{submission['id']}"
        make_package(folder)
        given = folder / name_in(submission["input_file"])
        fetch(submission["input_file"], given)
        phase = self.phases[submission["phase"]]
        run = folder / "run"
        run.mkdir()
        with open(run / "temp_stdout.txt", "a+") as out, open(run / "temp_stderr.txt", "a+") as err:
            stored = self.evaluate(phase, given, submission, out, err)
        stored["stdout"] = (run / "temp_stdout.txt").read_text()
        if stored["status"] == "failed":
            stored["stderr"] = (run / "temp_stderr.txt").read_text()
        shutil.rmtree(run)
        return stored

    def evaluate(self, phase, given, submission, out, err):
        output, rows, good = None, [], True
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                output = self.script.evaluate(str(phase["annotations"]), str(given), phase["codename"],
                                              submission_metadata=submission)  # fmt: skip
            for entry in output["result"]:
                split = list(entry.keys())[0]
                if split not in phase["splits"]:
                    raise LookupError(f"{split} is none of the phase's splits")
                rows.append({"split": split, "result": entry[split]})
        except Exception:
            err.write(traceback.format_exc())
            good, rows = False, []
        stored = {"status": "finished" if good else "failed", "leaderboard": rows}
        if output:
            stored["result_file"] = json.dumps(output.get("submission_result", ""))
            stored["metadata_file"] = "" + output.get("submission_metadata", "")  # a text
        return stored


if __name__ == "__main__":
    asked = json.load(sys.stdin)
    worker = Worker(asked["challenge"], asked["phases"])
    stored = [worker.run(submission) for submission in asked["submissions"]]
    print(json.dumps({"stored": stored, "folder": str(worker.folder)}))
