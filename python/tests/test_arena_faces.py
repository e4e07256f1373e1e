"""The same calls through every face of the arena: `enfilade ask`, Python, MCP, HTTP. They walk the same.
Homes are SYNTHETIC."""

import contextlib
import json
import re
import subprocess
import urllib.request
from pathlib import Path

import enfilade
import pytest

TASKS = ("r2r", "r2r-back", "reverie", "r2r-ce")
EPISODES = "4"


def run(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def homes(web_program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("faces") / "homes"
    run(web_program, "homes", "-o", folder, "--preset", "graphs", "--homes", 3, "--paths", 6, "--tasks", "reverie,r2r-back")
    run(web_program, "continuous", folder)
    return folder


@pytest.fixture(scope="module", params=TASKS)
def asked(request, web_program, homes, tmp_path_factory):
    """A task, and the run of the stand-in's oracle over some episodes."""
    folder = tmp_path_factory.mktemp("asked") / request.param
    said = run(
        web_program, "ask", "--data", homes, "--task", request.param, "--stand-in", "oracle",
        "--subset", EPISODES, "-o", folder,
    )  # fmt: skip
    success = re.search(r"^(SR \(%\)|success_rate|sr)\s+([0-9.]+)", said, re.M)
    assert success and float(success[2]) == (1 if request.param == "reverie" else 100), said
    return request.param, folder


def read_calls(folder):
    """By episode, in the order of the results."""
    calls = {}
    for file in sorted((folder / "transcripts").iterdir()):
        lines = [json.loads(line) for line in file.read_text().splitlines()]
        calls[lines[0]["episode"]] = [line["call"] for line in lines if "call" in line]
        assert lines[-1]["ending"] == "stopped"
    assert len(calls) == int(EPISODES)
    return calls


def results_of(folder):
    return json.loads((folder / "results.json").read_text())


def test_python_walks_the_same(asked, homes):
    task, folder = asked
    walk = enfilade.arena(f"{task}/val_unseen", data=homes, subset=int(EPISODES))
    for episode, calls in read_calls(folder).items():
        step = walk.begin(episode)
        for k, call in enumerate(calls):
            step = step if k == 0 else next(walk)
            assert step.call(call["tool"], call["argument"])
        assert step.ending == "stopped"
    assert walk.results() == results_of(folder)
    score = walk.score()
    assert score.means[{"reverie": "success_rate", "r2r-back": "sr"}.get(task, "success")][0] in (1, 100)
    assert set(score.episodes) == set(read_calls(folder))


def test_mcp_walks_the_same(asked, web_program, homes, tmp_path):
    task, folder = asked
    ids = run(web_program, "ask", "--data", homes, "--task", task, "--subset", EPISODES, "--list").split()
    calls = read_calls(folder)
    command = [web_program, "mcp", "--data", str(homes), "--task", task, "--subset", EPISODES, "-o", str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:

        def use(name, arguments):
            message = {
                "jsonrpc": "2.0", "id": 1, "method": "tools/call",
                "params": {"name": name, "arguments": arguments},
            }  # fmt: skip
            print(json.dumps(message), file=server.stdin, flush=True)
            while True:
                answer = json.loads(server.stdout.readline())
                if "result" in answer:  # and not a notification
                    assert not answer["result"]["isError"], answer
                    return answer["result"]

        for episode in ids:
            use("begin", {})
            for call in calls[episode]:
                name = {"move": "actions", "answer": "object", "look": "direction"}.get(call["tool"], "place")
                use(call["tool"], {name: call["argument"]} if call["argument"] else {})
        server.stdin.close()
        assert server.wait(60) == 0
    assert results_of(tmp_path) == results_of(folder)


@contextlib.contextmanager
def serving(program, homes, folder):
    command = [program, "serve", str(homes), "--db", str(folder / "service.sqlite"), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            said = next(line for line in server.stdout if "http://" in line)
            yield re.search(r"http://[0-9.:]+", said)[0]
        finally:
            server.terminate()


def request(address, body=None, key=""):
    data = None if body is None else json.dumps(body).encode()
    headers = {"Content-Type": "application/json", **({"Enfilade-Session": key} if key else {})}
    with urllib.request.urlopen(urllib.request.Request(address, data, headers)) as answer:
        return json.loads(answer.read())


def test_http_walks_the_same(asked, web_program, homes, tmp_path):
    task, folder = asked
    entries = []
    with serving(web_program, homes, tmp_path) as server:
        for episode, calls in read_calls(folder).items():
            begun = request(
                f"{server}/api/v1/sessions", {"task": task, "split": "val_unseen", "episode": episode}
            )
            session, key = f"{server}/api/v1/sessions/{begun['session']}", begun["key"]
            for k, call in enumerate(calls):
                answer = request(f"{session}/calls", {**call, "after": k}, key)
                assert answer["carried_out"]
            assert answer["ending"] == "stopped"
            entries.append(request(f"{session}/result", None, key))
    if task == "r2r-ce":
        assert {k: v for entry in entries for k, v in entry.items()} == results_of(folder)
    else:
        by_id = {json.dumps(one, sort_keys=True) for entry in entries for one in entry}
        assert by_id == {json.dumps(one, sort_keys=True) for one in results_of(folder)}


def test_a_run_replays_on_another_machine(asked, web_program, homes, tmp_path):
    """Nobody is asked: the cache alone, copied elsewhere, gives the same bytes."""
    task, folder = asked
    cache = tmp_path / "cache"
    cache.mkdir()
    for file in (folder / "cache").rglob("*"):
        if file.is_file():
            copied = cache / file.relative_to(folder / "cache")
            copied.parent.mkdir(parents=True, exist_ok=True)
            copied.write_bytes(file.read_bytes())
    run(
        web_program, "ask", "--data", homes, "--task", task, "--replay", "--model", "stand-in-oracle",
        "--subset", EPISODES, "--cache", cache, "-o", tmp_path / "again",
    )  # fmt: skip

    def files(at: Path):
        return {
            str(one.relative_to(at)): one.read_bytes()
            for one in at.rglob("*")
            if one.is_file() and not str(one.relative_to(at)).startswith(("cache", "ask.lock"))
        }

    assert files(tmp_path / "again") == files(folder)
