"""Data jobs on many machines: shares that are killed at random leave what one machine makes.
Homes are SYNTHETIC; sbatch is a stand-in that runs a job array here, kills its tasks and begins them again."""

import contextlib
import importlib
import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

SHARES = 4
HOMES = ["homes", "--preset", "graphs", "--homes", "5", "--paths", "6", "--tasks", "r2r"]

STAND_IN = '''#!{python}
"""sbatch: runs the tasks of an array at once; each is killed once at a random moment, and requeued."""
import os, random, re, signal, subprocess, sys, time
words = [word for word in sys.argv[1:] if not word.startswith("--")]
log = open(os.environ["SUBMITTED"], "a")
log.write(" ".join(sys.argv[1:]) + "\\n")
text = open(words[0]).read()
array = re.search(r"^#SBATCH --array=1-([0-9]+)$", text, re.M)
output = re.search(r'^#SBATCH --output="(.*)"$', text, re.M)[1]
assert text.startswith("#!/bin/bash\\n")
tasks = {{str(k): None for k in range(1, int(array[1]) + 1)}} if array else {{"": None}}
randoms = random.Random(int(os.environ["SEED"]))

def start(task):
    environment = dict(os.environ, **({{"SLURM_ARRAY_TASK_ID": task}} if task else {{}}))
    with open(output.replace("%a", task), "ab") as to:
        return subprocess.Popen(["bash", words[0]], env=environment, stdout=to, stderr=to, start_new_session=True)

for task in tasks:
    tasks[task] = start(task)
for task, process in tasks.items():
    if array:
        time.sleep(randoms.uniform(0, 0.3))
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            log.write("killed " + task + "\\n")
            tasks[task] = start(task)
log.flush()
assert all(process.wait() == 0 for process in tasks.values()), "a task failed"
print("1234;here")
'''


@pytest.fixture(scope="module")
def whole(program, tmp_path_factory):
    """What one machine makes."""
    folder = tmp_path_factory.mktemp("whole") / "homes"
    subprocess.run([program, *HOMES, "-o", str(folder)], check=True, capture_output=True)
    return folder


def files(folder):
    return {str(one.relative_to(folder)): one.read_bytes() for one in Path(folder).rglob("*") if one.is_file()}


def call(command, where, **environment):
    return subprocess.run(
        list(map(str, command)), cwd=where, env={**os.environ, **environment}, capture_output=True, text=True, timeout=900
    )  # fmt: skip


@pytest.fixture
def sbatch(tmp_path):
    """The environment in which `sbatch` is the stand-in."""
    tools = tmp_path / "tools"
    tools.mkdir()
    script = tools / "sbatch"
    script.write_text(STAND_IN.format(python=sys.executable))
    script.chmod(0o755)
    return {"PATH": f"{tools}{os.pathsep}{os.environ['PATH']}", "SUBMITTED": str(tmp_path / "submitted"), "SEED": "7"}


def test_a_job_array_leaves_what_one_machine_makes(program, whole, sbatch, tmp_path):
    where = tmp_path / "a folder"
    where.mkdir()
    command = [program, "slurm", "--shards", SHARES, "--cpus", 2, "--sbatch=--partition=cpu", "--submit",
               "-o", "job", *HOMES, "-o", "homes"]  # fmt: skip
    done = call(command, where, **sbatch)
    assert done.returncode == 0, done.stderr
    assert "submitted as job 1234, after it" in done.stdout
    assert files(where / "homes") == files(whole)
    submitted = Path(sbatch["SUBMITTED"]).read_text()
    assert "killed" in submitted and "--dependency=afterok:1234" in submitted
    script = (where / "job/shares.sbatch").read_text()
    for line in ("--partition=cpu", "--cpus-per-task=2", f"--array=1-{SHARES}", "--requeue"):
        assert f"#SBATCH {line}\n" in script
    # Once more: everything is done, so that no share says anything.
    logs = {one.name: one.stat().st_size for one in (where / "job/logs").iterdir() if one.name[0].isdigit()}
    assert call(command, where, **sbatch).returncode == 0
    assert files(where / "homes") == files(whole)
    assert {one.name: one.stat().st_size for one in (where / "job/logs").iterdir() if one.name[0].isdigit()} == logs


def test_commands_of_a_file_are_shares(program, sbatch, tmp_path):
    (tmp_path / "commands.txt").write_text(
        '# one home each\n'
        'homes -o "one home" --preset graphs --homes 1 --paths 0\n\n'
        "enfilade homes -o two --preset graphs --homes 1 --paths 0 --seed 2\n"
    )  # fmt: skip
    done = call([program, "slurm", "--commands", "commands.txt", "--submit"], tmp_path, **sbatch)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "one home/homes.json").exists() and (tmp_path / "two/homes.json").exists()
    assert "after it" not in done.stdout


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["slurm"], 2, "a verb is needed"),
        (["slurm", "score", "x.json"], 2, "features and homes can be cut"),
        (["slurm", "homes", "-o", "h", "--shard", "1/2"], 2, "--shard: it is set for each share here"),
        (["slurm", "features", "--weights", "random"], 2, "-o FILE is needed"),
        (["slurm", "--commands", "nowhere.txt"], 3, "nowhere.txt"),
        (["slurm", "--commands", "open.txt"], 3, "line 2: a quote without an end"),
        (["slurm", "--commands", "empty.txt"], 3, "no command in it"),
        (["slurm", "--commands", "open.txt", "homes"], 2, "one of them"),
        (["ray", "--python", "no-such-python", "homes", "-o", "h"], 2, "no-such-python"),
    ],
)
def test_what_cannot_be_a_job_is_told(program, tmp_path, words, status, said):
    (tmp_path / "open.txt").write_text('homes -o h\nhomes -o "h\n')
    (tmp_path / "empty.txt").write_text("# nothing\n")
    done = call([program, *words], tmp_path)
    assert said in done.stderr
    assert done.returncode == status, done.stderr


def test_a_folder_of_another_job_is_refused(program, tmp_path):
    assert call([program, "slurm", *HOMES, "-o", "one"], tmp_path).returncode == 0
    done = call([program, "slurm", *HOMES, "-o", "another"], tmp_path)
    assert done.returncode == 2 and "holds another job" in done.stderr


def test_without_slurm_the_user_is_told(program, tmp_path):
    if shutil.which("sbatch"):
        pytest.skip("this machine has Slurm")
    done = call([program, "slurm", "--submit", *HOMES, "-o", "one"], tmp_path)
    assert done.returncode == 2 and "there is no sbatch on this machine" in done.stderr


def kill_workers(stop, killed, seed):
    """Kills processes of Ray that run a share, at random moments."""
    randoms = random.Random(seed)
    while not stop.is_set() and len(killed) < 6:
        time.sleep(randoms.uniform(0.1, 0.5))
        found = subprocess.run(["pgrep", "-f", "^ray::_run_share"], capture_output=True, text=True).stdout.split()
        if found:
            victim = int(randoms.choice(found))
            with contextlib.suppress(ProcessLookupError):
                os.kill(victim, signal.SIGKILL)
                killed.append(victim)


def test_a_ray_cluster_leaves_what_one_machine_makes(program, whole, tmp_path):
    ray = pytest.importorskip("ray", reason="the package ray is not installed")
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    try:
        for _ in range(2):  # three nodes, as processes of this machine
            cluster.add_node(num_cpus=1)
        made = call([program, "ray", "--python", "true", "--shards", SHARES, "-o", "job", *HOMES, "-o", "homes"], tmp_path)
        assert made.returncode == 0, made.stderr
        from enfilade import cluster as jobs

        stop, killed = threading.Event(), []
        killer = threading.Thread(target=kill_workers, args=(stop, killed, 3))
        killer.start()
        ray.init(address=cluster.address, log_to_driver=False, include_dashboard=False)
        failed = jobs.run_job(str(tmp_path / "job"), attempts=20, progress=False)
        stop.set()
        killer.join()
        assert failed == []
        assert killed, "no share was killed"
        assert files(tmp_path / "homes") == files(whole)
        assert len(list((tmp_path / "job/done").iterdir())) == SHARES
    finally:
        ray.shutdown()
        cluster.shutdown()


def test_a_share_with_an_error_of_its_own_is_told_once(program, tmp_path):
    ray = pytest.importorskip("ray", reason="the package ray is not installed")
    from enfilade import cluster as jobs

    (tmp_path / "commands.txt").write_text(
        "homes -o one --preset graphs --homes 1 --paths 0\nscore nowhere.json --data nowhere\n"
    )
    made = call([program, "ray", "--python", "true", "--commands", "commands.txt", "-o", "job"], tmp_path)
    assert made.returncode == 0, made.stderr
    try:
        failed = jobs.run_job(str(tmp_path / "job"), progress=False)
    finally:
        ray.shutdown()
    assert len(failed) == 1 and failed[0].startswith("share 2: ended with 2: ")
    assert "--split" in (tmp_path / "job/logs/2.log").read_text()
    assert (tmp_path / "one/homes.json").exists()


def test_rllib_learns_on_a_cluster_of_three_nodes(program, tmp_path):
    ray = pytest.importorskip("ray", reason="the package ray is not installed")
    for module in ("torch", "ray.rllib"):
        try:
            importlib.import_module(module)
        except ImportError:
            pytest.skip(f"the package {module} is not installed")
    from ray.cluster_utils import Cluster

    homes = call([program, "homes", "-o", "homes", "--preset", "graphs", "--homes", "3", "--paths", "20"], tmp_path)
    assert homes.returncode == 0, homes.stderr
    example = Path(__file__).parents[2] / "examples/python/rl_cluster.py"
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    try:
        for _ in range(2):
            cluster.add_node(num_cpus=1)
        done = call([sys.executable, str(example), str(tmp_path / "homes"), "4", cluster.address], tmp_path)
        assert done.returncode == 0, done.stderr
        assert "after 4 iterations, 2 runners on 3 machines" in done.stdout
    finally:
        ray.shutdown()
        cluster.shutdown()
