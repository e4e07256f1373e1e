"""The evaluation script of an EvalAI challenge on Room-to-Room, scored by Enfilade.

package.py makes the archive that a host uploads: this file, the program with its libraries, the
graphs, the phases. EvalAI's workers unpack it and call evaluate(). Where these are, unless
environment variables name others:

    ENFILADE              the program `enfilade` (default: bin/enfilade beside this file, else the PATH)
    ENFILADE_CONNECTIVITY the folder of navigation graphs (default: connectivity/ beside this file)
    ENFILADE_PHASES       the phases, as JSON, plain or packed with gzip
                          (default: phases.json or phases.json.gz beside this file, if one is there):
                          {"test": {"splits": ["test_split"], "step": 0.01}}
                          keys are the `codename`s of challenge_phases in challenge_config.yaml, `splits` those of
                          the dataset_splits that challenge_phase_splits connects with the phase (default: the
                          phase's own), `step` is what shares are rounded to, 0.001 to 0.5 (default: 0.01);
                          metres are rounded to ten times as much. "result_file": true puts the means into
                          the file that EvalAI shows each participant at once, whatever the leaderboard's
                          visibility; without it that file has no score. A phase that is not there has the
                          defaults

Goals stay secret only as far as the challenge's settings see to it: this script is asked anew for each file, so it
cannot count. docs/service_evaluation.md says which settings are needed. Only the standard library is needed, of
Python 3.7 or newer: workers have what their challenge asks for.
"""

import difflib
import gzip
import json
import os
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent

# Names on EvalAI's leaderboard, and ours (docs/tasks.md). Shares are from 0 to 1.
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

LOADER = "ld.so"  # of the program's libraries, as package.py names it
DEFAULT_STEP = 0.01
FORM = '{"test": {"splits": ["test_split"], "step": 0.01}}'


def _is_splits(value):
    named = isinstance(value, list) and all(isinstance(one, str) and one for one in value)
    return named and value != []


def _is_step(value):
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return number and 0.001 <= value <= 0.5


# Of a phase: what is allowed, in words, and the test of it.
FIELDS = {
    "splits": ("a list of names", _is_splits),
    "step": ("from 0.001 to 0.5", _is_step),
    "result_file": ("true or false", lambda value: isinstance(value, bool)),
}
METRES_OF_STEP = 10  # 0.01 of shares are 0.1 m, as on an Enfilade server
MOST_METRES = 30
# Those that do not depend on where goals are: whoever made the trajectories knows them.
GOAL_FREE = {"length"}


class BadSubmission(Exception):
    """The file can't be scored; the message lists its faults (up to 1000), for the participant."""


def _program():
    """The words that begin a command of the program."""
    packaged = HERE / "bin" / "enfilade"
    loader = HERE / "lib" / LOADER
    given = os.environ.get("ENFILADE")
    if given:
        return [given]
    if packaged.exists() and loader.exists():  # with all its libraries, whatever the worker has
        loader.chmod(0o700)  # archives are unpacked without the permission to run anything
        return [str(loader), "--library-path", str(loader.parent), str(packaged)]
    found = str(packaged) if packaged.exists() else shutil.which("enfilade")
    if not found:
        raise RuntimeError("enfilade: no such program; set ENFILADE to its path")
    return [found]


def _connectivity():
    return os.environ.get("ENFILADE_CONNECTIVITY", str(HERE / "connectivity"))


def _without_repeats(pairs, file):
    """Fields of an object; json.loads() takes the last of several without a word."""
    names = [name for name, _ in pairs]
    for name in names:
        if names.count(name) > 1:
            raise RuntimeError(f"{file}: {name}: given twice in one object")
    return dict(pairs)


def _text(file):
    """Of a JSON file, as the program finds and reads one; "{}" if there is none."""
    packed = str(file)[:-3] if file.suffix == ".gz" else str(file) + ".gz"
    for name in (file, Path(packed)):
        if name.exists():
            content = name.read_bytes()
            plain = gzip.decompress(content) if content.startswith(b"\x1f\x8b") else content
            return plain.decode("utf-8-sig")
    return "{}"


def _check_field(where, name, value):
    """Raises RuntimeError unless it is a field of a phase with a value that is allowed."""
    if name not in FIELDS:
        near = difflib.get_close_matches(name, FIELDS, 1)
        advice = f"the nearest is {near[0]}" if near else f"allowed are {', '.join(FIELDS)}"
        raise RuntimeError(f"{where}: unknown field {name[:40]!r}; {advice}")
    allowed, good = FIELDS[name]
    if not good(value):
        raise RuntimeError(f"{where}.{name}: {str(value)[:40]!r}, not {allowed}")


def load_phases(file):
    """The phases of a file, by codename; none if there is no file.

    Raises RuntimeError naming the first fault for a file of another form: evaluate() would score by
    settings that nobody wrote.
    """
    try:
        text = _text(file)
        phases = json.loads(
            text, object_pairs_hook=lambda pairs: _without_repeats(pairs, file.name)
        )
    except (ValueError, OSError, EOFError, RecursionError, zlib.error) as error:
        raise RuntimeError(f"{file.name}: cannot be read: {error}") from None
    if not isinstance(phases, dict):
        raise RuntimeError(f"{file.name}: {FORM} is expected")
    if isinstance(phases.get("phases"), list):
        raise RuntimeError(
            f"{file.name}: phases of `enfilade serve`; those of EvalAI have another form: {FORM}"
        )
    for codename, phase in phases.items():
        where = f"{file.name}: {codename[:40]}"
        if not isinstance(phase, dict):
            raise RuntimeError(f"{where}: {str(phase)[:40]!r}, not an object; {FORM} is expected")
        for name, value in phase.items():
            _check_field(where, name, value)
    return phases


def _phase(codename):
    """Splits and step of a phase, and whether its participants' result files have the means."""
    file = Path(os.environ.get("ENFILADE_PHASES", str(HERE / "phases.json")))
    phase = load_phases(file).get(codename, {})
    step = phase.get("step", DEFAULT_STEP)
    return phase.get("splits", [codename]), step, phase.get("result_file", False)


def _rounded(column, mean, step):
    """A mean as it may be told: on a grid, so that it cannot tell one episode's error."""
    if column in GOAL_FREE:
        return mean
    most = MOST_METRES if column == "nav_error" else 1
    grid = step * METRES_OF_STEP if column == "nav_error" else step
    last = round(most / grid)
    level = last if mean is None else min(round(mean / grid), last)  # None: a goal out of reach
    return round(level * grid, 6)


def evaluate(test_annotation_file, user_submission_file, phase_codename, **kwargs):
    """Scores a results file.

    test_annotation_file: R2R annotations with goals. user_submission_file: a results file in any
    form that `enfilade score` reads. phase_codename: one of the challenge's phases. Whatever else
    EvalAI passes (submission_metadata) is not looked at.

    Returns EvalAI's {"result": [{split: {column: mean}}, ...], "submission_result": {...}}, an
    entry for each split of the phase; who sees them is a setting of the challenge. Means only, and
    rounded: metrics of single episodes, or exact means of two files that differ in one, would tell
    where hidden goals are.
    Raises BadSubmission for a file with faults, RuntimeError if the program or the phases' file
    fails otherwise.
    """
    splits, step, in_file = _phase(phase_codename)
    command = [
        *_program(), "score", str(user_submission_file),
        "--annotations", str(test_annotation_file),
        "--connectivity", _connectivity(),
        "--json", "-",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode == 1:  # faults in what was checked
        # Never the annotations' path: participants read this.
        raise BadSubmission(done.stderr.replace(str(user_submission_file), "submission"))
    if done.returncode != 0:
        # For the host, in the worker's log: sys.stderr is the participant's here.
        print(done.stderr, file=sys.__stderr__)
        raise RuntimeError(f"enfilade score ended with status {done.returncode}")
    means = json.loads(done.stdout)["means"]
    row = {
        column: _rounded(column, means[metric]["mean"], step) for column, metric in COLUMNS.items()
    }
    told = {column: mean for column, mean in row.items() if in_file or column in GOAL_FREE}
    return {"result": [{split: row} for split in splits], "submission_result": told}
