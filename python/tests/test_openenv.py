"""The arena through OpenEnv's own server and client. Graphs are SYNTHETIC."""

import json
import os
import shutil
import socket
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path
from urllib.parse import urlsplit

import enfilade
import pytest

pytest.importorskip("openenv.core", reason="neither openenv nor openenv-core is installed (Python 3.10 or newer)")
import uvicorn
import websockets.exceptions
import websockets.sync.client
from enfilade import openenv as served
from openenv.core.generic_client import GenericEnvClient

PACKAGE = Path(__file__).parents[2] / "examples" / "openenv"


@pytest.fixture(scope="module")
def address(small):
    config = uvicorn.Config(
        served.app("r2r/val_unseen", data=small, subset=3), host="127.0.0.1", port=0, log_level="warning"
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    while not server.started:
        time.sleep(0.02)
    yield f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    server.should_exit = True
    thread.join()


def test_episodes_are_walked_one_after_another(address):
    with GenericEnvClient(base_url=address).sync() as env:
        begun = env.reset()
        first = env.state()["episode_id"]
        assert not begun.done and "Instruction: " in begun.observation["prompt"]
        place = begun.observation["observation"]["places"][0]["name"]
        walked = env.step({"tool": "go_to", "argument": place})
        assert f"You went to {place}" in walked.observation["told"]
        refused = env.step({"tool": "go_to", "argument": "QQ"})
        assert not refused.done and "is not one of" in refused.observation["told"]
        assert refused.observation["observation"] == {
            **walked.observation["observation"], "told": refused.observation["told"],
        }  # fmt: skip
        ended = env.step({"tool": "stop"})
        assert ended.done and ended.reward in (0, 1)
        assert ended.observation["episode"] == first and ended.observation["ending"] == "stopped"
        assert ended.observation["metrics"]["success"] == ended.reward
        env.reset()
        assert env.state()["episode_id"] != first
        env.reset(episode_id=first)
        assert env.state() == {"episode_id": first, "step_count": 0}
        assert env.reset(seed=0).observation["prompt"] == begun.observation["prompt"]


def test_walkers_do_not_see_each_other(address):
    with GenericEnvClient(base_url=address).sync() as one, GenericEnvClient(base_url=address).sync() as other:
        one.reset(seed=0)
        other.reset(seed=1)
        one.step({"tool": "look", "argument": "left"})
        assert (one.state()["step_count"], other.state()["step_count"]) == (1, 0)


def test_the_environment_has_a_name(address):
    with urllib.request.urlopen(f"{address}/metadata") as answer:
        said = json.loads(answer.read())
    assert said["name"] == "enfilade" and said["version"] == enfilade.__version__


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},  # a name that resolves to this machine
        {"Host": "localhost.evil.example:80"},
        {"Host": "["},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
    ],
)
def test_pages_of_other_servers_are_refused(address, headers):
    request = urllib.request.Request(f"{address}/metadata", headers=headers)
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(request)


@pytest.mark.parametrize("host, origin", [("evil.example", None), (None, "http://evil.example"), (None, "null")])
def test_websockets_of_other_servers_pages_are_refused(address, host, origin):
    own = urlsplit(address)
    refused = pytest.raises(websockets.exceptions.InvalidStatus, match="403")
    with socket.create_connection((own.hostname, own.port)) as connected, refused:
        websockets.sync.client.connect(f"ws://{host or own.netloc}/ws", sock=connected, origin=origin)


def test_its_own_pages_are_served(address):
    request = urllib.request.Request(f"{address}/metadata", headers={"Origin": address})
    with urllib.request.urlopen(request) as answer:
        assert answer.status == 200


@pytest.fixture(scope="module")
def command():
    """OpenEnv's own program."""
    found = shutil.which("openenv", path=str(Path(sys.executable).parent)) or shutil.which("openenv")
    if found is None:
        pytest.skip("there is no command openenv")
    return found


def test_openenv_finds_no_fault_with_the_server(address, command):
    done = subprocess.run([command, "validate", "--url", address], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr


def test_openenv_finds_no_fault_with_the_package(command):
    def validate(*options):
        given = [command, "validate", str(PACKAGE), *options]
        return subprocess.run(given, capture_output=True, text=True, timeout=120)

    done = validate("--level", "static")  # others build an image
    if "No such option" in done.stdout + done.stderr:
        done = validate()
        if "uv.lock" in done.stdout + done.stderr:
            pytest.skip("this version of openenv wants a uv.lock, which the package does not have")
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_serves_a_data_set_that_it_makes(tmp_path):
    code = "import server.app, enfilade.openenv as e; print(type(server.app.app).__name__)"
    kept = {name: value for name, value in os.environ.items() if not name.startswith("ENFILADE")}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, cwd=PACKAGE,
        env={**kept, "TMPDIR": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "FastAPI"


def test_what_is_wrong_is_told(address):
    with GenericEnvClient(base_url=address).sync() as env:
        with pytest.raises(RuntimeError, match="no such id"):
            env.reset(episode_id="nowhere")
        with pytest.raises(RuntimeError, match="call reset"):
            env.step({"tool": "stop"})
        env.reset()
        with pytest.raises(RuntimeError, match="VALIDATION|[Vv]alid|[Ee]xtra"):
            env.step({"shout": "stop"})
