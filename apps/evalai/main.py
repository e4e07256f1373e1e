"""The evaluation script of an EvalAI challenge on Room-to-Room, scored by Enfilade.

EvalAI's workers import this module and call evaluate(). What the host puts beside it, or names by
environment variables:

    ENFILADE              the program `enfilade` (default: bin/enfilade beside this file, else the PATH)
    ENFILADE_CONNECTIVITY the folder of navigation graphs (default: connectivity/ beside this file)

Only the standard library is needed. docs/service.md says how to set a challenge up.
"""

import json
import os
import shutil
import subprocess
from pathlib import Path

HERE = Path(__file__).resolve().parent

# Names on EvalAI's leaderboard, and ours (docs/r2r.md). Shares are from 0 to 1.
COLUMNS = {
    "length": "trajectory_length",
    "nav_error": "nav_error",
    "oracle_success": "oracle_success",
    "success": "success",
    "spl": "spl",
    "ndtw": "ndtw_collapsed",
    "sdtw": "sdtw_collapsed",
    "cls": "cls",
}


class BadSubmission(Exception):
    """The file can't be scored; the message lists every fault, for the participant."""


def _program():
    given = os.environ.get("ENFILADE")
    beside = HERE / "bin" / "enfilade"
    found = given or (str(beside) if beside.exists() else shutil.which("enfilade"))
    if not found:
        raise RuntimeError("enfilade: no such program; set ENFILADE to its path")
    return found


def _connectivity():
    return os.environ.get("ENFILADE_CONNECTIVITY", str(HERE / "connectivity"))


def evaluate(test_annotation_file, user_submission_file, phase_codename, **kwargs):
    """Scores a results file.

    test_annotation_file: R2R annotations with goals. user_submission_file: a results file in any
    form that `enfilade score` reads. phase_codename: names the split in the answer. Whatever else
    EvalAI passes (submission_metadata) is not looked at.

    Returns EvalAI's {"result": [{split: {column: mean}}], "submission_result": {...}}. Means only:
    metrics of single episodes would tell where hidden goals are.
    Raises BadSubmission for a file with faults, RuntimeError if the program fails otherwise.
    """
    command = [
        _program(), "score", str(user_submission_file),
        "--annotations", str(test_annotation_file),
        "--connectivity", _connectivity(),
        "--json", "-",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode == 1:  # faults in what was checked
        # Never the annotations' path: participants read this.
        raise BadSubmission(done.stderr.replace(str(user_submission_file), "submission"))
    if done.returncode != 0:
        raise RuntimeError(f"enfilade score ended with status {done.returncode}")
    means = json.loads(done.stdout)["means"]
    row = {column: means[metric]["mean"] for column, metric in COLUMNS.items()}
    return {"result": [{phase_codename: row}], "submission_result": row}
