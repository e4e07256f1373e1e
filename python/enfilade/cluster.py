"""Data jobs on a Ray cluster; `enfilade ray` runs this (needs `pip install ray`).

    python -m enfilade.cluster JOB --address auto

JOB is a folder made by `enfilade ray` or `enfilade slurm`. Each shard of the job is a task. If its worker
is killed, the task starts again, on any machine. Completed shards are marked in JOB/done and not repeated.
All machines need the same file system.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Optional, Sequence

from enfilade._errors import FileError

__all__ = ["main", "run_job"]

_LOOK = 3.0  # seconds between updates of the progress
_PR_SET_PDEATHSIG = 1


class ShareFailed(Exception):
    """A shard ended with an error of its own; another attempt would not help."""


def _die_with_parent() -> None:
    """If the worker is killed, its subprocess must not continue beside the next attempt."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _run_share(plan: dict[str, Any], job: str, number: int) -> None:
    """Runs shard `number`, counted from 1, unless it is done. Raises ShareFailed, RuntimeError."""
    done, log = Path(job, "done", str(number)), Path(job, "logs", f"{number}.log")
    if done.exists():
        return
    command = [plan["program"], *plan["shares"][number - 1]]
    with open(log, "ab") as output:
        ended = subprocess.run(
            command, cwd=plan["cwd"], stdout=output, stderr=subprocess.STDOUT, preexec_fn=_die_with_parent
        )
    if ended.returncode < 0:
        raise RuntimeError(f"killed by signal {-ended.returncode}")
    if ended.returncode > 0:
        raise ShareFailed(f"ended with {ended.returncode}: {log}")
    done.touch()


def run_job(
    job: str, *, cpus: int = 1, attempts: int = 5, address: Optional[str] = None, progress: bool = True
) -> list[str]:
    """Runs the shards of a job, then its collecting command.

    Args:
        job: its folder, on a file system that all machines of the cluster share.
        cpus: processors per shard.
        attempts: most starts of a shard whose worker was killed.
        address: of a running cluster; None: the one that Ray finds, or one on this machine alone.
        progress: show a counter, on a terminal.

    Returns a sentence per failed shard; empty: the job is done. Raises FileError for a folder without
    plan.json.
    """
    import ray  # type: ignore[import-not-found, unused-ignore]

    folder = Path(job).absolute()
    if not (folder / "plan.json").exists():
        raise FileError(f"{folder}: no plan.json; `enfilade ray` makes one")
    plan = json.loads((folder / "plan.json").read_text())
    if not ray.is_initialized():
        ray.init(address=address, log_to_driver=False, include_dashboard=False, configure_logging=False)
    if __name__ != "__main__":  # pickled by value: workers need not have this package
        ray.cloudpickle.register_pickle_by_value(sys.modules[__name__])
    # Ray restarts lost workers and tasks ended by a signal, but not other errors of a shard.
    task = ray.remote(num_cpus=cpus, max_retries=attempts - 1, retry_exceptions=[RuntimeError])(_run_share)
    open_tasks = {
        task.remote(plan, str(folder), number): number
        for number in range(1, len(plan["shares"]) + 1)
        if not (folder / "done" / str(number)).exists()
    }
    total, failed = len(plan["shares"]), []
    while open_tasks:
        ready, _ = ray.wait(list(open_tasks), num_returns=1, timeout=_LOOK)
        for one in ready:
            number = open_tasks.pop(one)
            try:
                ray.get(one)
            except ray.exceptions.RayError as error:
                failed.append(f"share {number}: {_reason_of(error)}")
        if progress and sys.stderr.isatty():
            ahead = total - len(open_tasks) - len(failed)
            print(f"\r{ahead} of {total} shares are done", end="" if open_tasks else "\n", file=sys.stderr)
    if failed or not plan["collect"]:
        return failed
    collected = subprocess.run([plan["program"], *plan["collect"]], cwd=plan["cwd"])
    return [] if collected.returncode == 0 else [f"collecting the shares ended with {collected.returncode}"]


def _reason_of(error: BaseException) -> str:
    cause = getattr(error, "cause", None)
    return str(cause if cause is not None else error).strip().splitlines()[-1]


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """python -m enfilade.cluster. Returns 0: all done; 1: some shards failed; 2: it cannot start."""
    parser = argparse.ArgumentParser(
        prog="python -m enfilade.cluster", description="Run a data job on a Ray cluster."
    )
    parser.add_argument("job", help="the folder that `enfilade ray` has made")
    parser.add_argument("--cpus", type=int, default=1, help="processors a share (default: 1)")
    parser.add_argument("--attempts", type=int, default=5, help="times that a share is begun (default: 5)")
    parser.add_argument("--address", help="of a running cluster (default: one on this machine alone)")
    given = parser.parse_args(arguments)
    try:
        import ray  # noqa: F401  # type: ignore[import-not-found, unused-ignore]
    except ImportError:
        print(f"ray: the package is not installed for {sys.executable}: pip install ray", file=sys.stderr)
        return 2
    begin = time.monotonic()
    try:
        failed = run_job(given.job, cpus=given.cpus, attempts=given.attempts, address=given.address)
    except FileError as error:
        print(error, file=sys.stderr)
        return 2
    for one in failed:
        print(one, file=sys.stderr)
    if failed:
        print(f"{len(failed)} shares are not done; the same command does them again", file=sys.stderr)
        return 1
    print(f"all shares are done, {time.monotonic() - begin:.1f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
