#!/usr/bin/env python3
"""How much two processes that train together lose to a slow network, and against one process.

Runs a training by turns as one process of two threads (the batch at once, and in 8 parts), and as
two processes of one thread each: on this machine's loopback, and in two network namespaces with a
link of --rate between them (needs root, `ip` and `tc`, and leaves nothing behind). Prints the
seconds of an iteration of each, the speed of two processes against one, and how much of the time
that sending takes at that rate is hidden behind computing.

  sudo bench/ranks_network.py --turns 3 -- enfilade train --data homes --features f.safetensors \\
      --agent duet --recipe small --iterations 40
"""

import argparse
import contextlib
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile

HOSTS = ["10.77.31.1", "10.77.31.2"]
SPACES = ["enfilade0", "enfilade1"]


def ip(*words):
    subprocess.run(["ip", *words], check=True)


@contextlib.contextmanager
def link(rate):
    """Two namespaces with a link of this rate, each way."""
    for space in SPACES:
        ip("netns", "add", space)
    try:
        ip("link", "add", "veth0", "netns", SPACES[0], "type", "veth",
           "peer", "name", "veth1", "netns", SPACES[1])
        for k, space in enumerate(SPACES):
            ip("-n", space, "link", "set", "lo", "up")
            ip("-n", space, "addr", "add", f"{HOSTS[k]}/24", "dev", f"veth{k}")
            ip("-n", space, "link", "set", f"veth{k}", "up")
            subprocess.run(["tc", "-n", space, "qdisc", "add", "dev", f"veth{k}", "root", "tbf",
                            "rate", rate, "burst", "256kb", "latency", "50ms"], check=True)
        yield
    finally:
        for space in SPACES:
            subprocess.run(["ip", "netns", "del", space], check=False)


def seconds_of(folder, skip):
    """The median seconds of an iteration, without the first `skip`, which make caches."""
    took, before = [], 0
    with open(os.path.join(folder, "log.jsonl"), encoding="utf-8") as log:
        for line in log:
            record = json.loads(line)
            if record["type"] != "train":
                continue
            if before >= skip:
                took.append(record["seconds"] / (record["iteration"] - before))
            before = record["iteration"]
    return statistics.median(took)


def train(command, folder, processes, threads, more, spaces=None):
    """Trains once. Returns the bytes of the weights."""
    shutil.rmtree(folder, ignore_errors=True)
    command = [*command, "--evaluate-every", "0", "--threads", str(threads), "-o", folder, *more]
    running = []
    for rank in range(processes):
        environment = dict(os.environ, OMP_WAIT_POLICY="passive")
        if processes > 1:
            environment.update(
                RANK=str(rank), WORLD_SIZE=str(processes), LOCAL_RANK=str(rank),
                LOCAL_WORLD_SIZE=str(processes), MASTER_PORT="29411",
                MASTER_ADDR=HOSTS[0] if spaces else "127.0.0.1")
        inside = ["ip", "netns", "exec", spaces[rank]] if spaces else []
        running.append(subprocess.Popen([*inside, *command], env=environment,
                                        stdout=subprocess.DEVNULL))
    if any([process.wait() for process in running]):
        sys.exit("a process ended with an error")
    return os.path.getsize(os.path.join(folder, "weights.safetensors"))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rate", type=float, default=1, help="of the link, Gbit/s")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--skip", type=int, default=10, help="first iterations that do not count")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    arguments = parser.parse_args()
    command = [word for word in arguments.command if word != "--"]
    if not command:
        parser.error("a training is needed, behind --")
    parts = ["--parts", "8"]
    took = {}
    with tempfile.TemporaryDirectory() as root:
        folder = os.path.join(root, "model")
        for _ in range(arguments.turns):
            for name, run in {
                "one process, 2 threads, the batch at once": lambda: train(command, folder, 1, 2, []),
                "one process, 2 threads, 8 parts": lambda: train(command, folder, 1, 2, parts),
                "two processes, loopback": lambda: train(command, folder, 2, 1, parts),
                "two processes, as their sums come": lambda: train(command, folder, 2, 1,
                                                                   ["--all-reduce"]),
            }.items():
                run()
                took.setdefault(name, []).append(seconds_of(folder, arguments.skip))
            with link(f"{int(1000 * arguments.rate)}mbit"):
                size = train(command, folder, 2, 1, parts, SPACES)
            name = f"two processes, {arguments.rate:g} Gbit/s"
            took.setdefault(name, []).append(seconds_of(folder, arguments.skip))
    for name, seconds in took.items():
        print(f"{name:42} {statistics.median(seconds):.4f} s an iteration  "
              f"({', '.join(f'{one:.4f}' for one in seconds)})")
    median = {name: statistics.median(seconds) for name, seconds in took.items()}
    at_once, in_parts, loopback, _, limited = median.values()
    sending = 8 * size / (1e9 * arguments.rate)  # each sends half of the gradient twice
    print(f"two processes against one: {at_once / loopback:.2f} of its speed at once, "
          f"{in_parts / loopback:.2f} of its speed in parts")
    print(f"sending {size / 1e6:.1f} MB takes {sending:.4f} s at that rate, "
          f"of which {1 - (limited - loopback) / sending:.2f} is hidden")


if __name__ == "__main__":
    main()
