"""The server of the Model Context Protocol, driven by the protocol's own client library."""

import asyncio
import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest

mcp = pytest.importorskip("mcp", reason="the package mcp is not installed (Python 3.10 or newer)")
from mcp.client.stdio import StdioServerParameters, stdio_client  # noqa: E402


@pytest.fixture(scope="module")
def homes(program, tmp_path_factory):
    """Three small homes without pictures (SYNTHETIC)."""
    folder = tmp_path_factory.mktemp("arena") / "homes"
    subprocess.run(
        [program, "homes", "-o", str(folder), "--preset", "graphs", "--homes", "3"],
        check=True,
        capture_output=True,
    )
    return folder


def texts(result):
    return "\n".join(block.text for block in result.content if block.type == "text")


def place_of(tools):
    """The schema of the argument of `go_to`."""
    tool = next(tool for tool in tools if tool.name == "go_to")
    return (getattr(tool, "input_schema", None) or tool.inputSchema)["properties"]["place"]


async def play(session, folder, lists_again=True):
    """Lists the tools, and steps through two episodes by them."""
    kept = (await session.list_tools()).tools
    assert [tool.name for tool in kept] == ["begin", "go_to", "back_to", "look", "stop"]
    assert place_of(kept)["type"] == "string" and "enum" not in place_of(kept)
    for _ in range(2):
        begun = await session.call_tool("begin", {})
        assert "Instruction: " in texts(begun)
        places = re.search("^go_to place: (.*)$", texts(begun), re.M)[1].split(", ")
        if lists_again:
            assert place_of((await session.list_tools()).tools)["enum"] == places
        refused = await session.call_tool("go_to", {"place": "QQ"})
        assert "is not one of" in texts(refused)
        walked = await session.call_tool("go_to", {"place": places[0]})
        assert f"You went to {places[0]}" in texts(walked)
        assert "The episode is over" in texts(await session.call_tool("stop", {}))
    results = json.loads((folder / "results.json").read_text())
    assert len(results) == 2
    assert all(len(entry["trajectory"]) == 2 for entry in results)


def parameters(program, homes, folder):
    arguments = [
        "mcp",
        "--data",
        str(homes),
        "--split",
        "val_unseen",
        "--subset",
        "5",
        "-o",
        str(folder),
    ]
    return StdioServerParameters(command=program, args=arguments)


def test_the_protocols_client_walks_by_the_handshake(program, homes, tmp_path):
    async def run():
        async with stdio_client(parameters(program, homes, tmp_path)) as (read, write):
            async with mcp.ClientSession(read, write) as session:
                await session.initialize()
                await play(session, tmp_path, lists_again=False)

    asyncio.run(run())


@contextlib.contextmanager
def over_http(program, homes, folder):
    """The address of `enfilade mcp --port`."""
    given = parameters(program, homes, folder)
    command = [given.command, *given.args, "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        said = server.stdout.readline()
        if "http://" not in said and "no HTTP" in server.stderr.read():
            pytest.skip("this build speaks no HTTP: no `enfilade mcp --port`")
        try:
            yield said.split()[-1]
        finally:
            server.terminate()
            assert server.wait(20) == 0


def test_the_protocols_client_walks_over_http(program, homes, tmp_path):
    http = pytest.importorskip("mcp.client.streamable_http", reason="this version of mcp has no such client")
    connect = getattr(http, "streamable_http_client", None) or http.streamablehttp_client

    async def run(address):
        async with connect(address) as streams:
            async with mcp.ClientSession(streams[0], streams[1]) as session:
                await session.initialize()
                await play(session, tmp_path)

    with over_http(program, homes, tmp_path) as address:
        asyncio.run(run(address))


@pytest.mark.skipif(not hasattr(mcp, "Client"), reason="this version of mcp knows the handshake only")
def test_the_protocols_client_walks_over_http_without_a_handshake(program, homes, tmp_path):
    async def run(address):
        async with mcp.Client(address) as client:
            assert client.protocol_version == "2026-07-28"
            await play(client, tmp_path, lists_again=False)

    with over_http(program, homes, tmp_path) as address:
        asyncio.run(run(address))


CLIENTS = Path(__file__).parents[2] / "tests" / "arena" / "mcp"


@pytest.mark.parametrize("client", ["client.py", "client.mjs"])
@pytest.mark.parametrize("way", ["stdio", "http"])
def test_clients_that_list_the_tools_once_finish_episodes(program, tmp_path, client, way):
    if client.endswith(".mjs"):
        if not shutil.which("node") or "ENFILADE_NODE_MODULES" not in os.environ:
            pytest.skip("ENFILADE_NODE_MODULES names no folder with @modelcontextprotocol/sdk, or there is no node")
        run = ["node", str(CLIENTS / client)]
    else:
        run = [sys.executable, str(CLIENTS / client)]
    with contextlib.ExitStack() as stack:
        if way == "http":
            to = [stack.enter_context(over_http(program, CLIENTS / "grid", tmp_path))]
        else:
            given = parameters(program, CLIENTS / "grid", tmp_path)
            to = [given.command, *given.args]
        done = subprocess.run([*run, *to], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert len(json.loads((tmp_path / "results.json").read_text())) == 2


def test_pages_of_other_sites_do_not_play(program, homes, tmp_path):
    body = json.dumps({"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": {"name": "begin"}}).encode()

    def status(address, **headers):
        request = urllib.request.Request(address, body, {"Content-Type": "application/json", **headers})
        try:
            with urllib.request.urlopen(request) as answer:
                return answer.status
        except urllib.error.HTTPError as error:
            return error.code

    with over_http(program, homes, tmp_path) as address:
        assert status(address, Origin="https://example.org") == 403
        assert status(address, Host="example.org:80") == 403
        assert status(address, **{"Mcp-Session-Id": "another"}) == 404
        assert status(address, Origin=address.rsplit("/", 1)[0]) == 200


@pytest.mark.skipif(not hasattr(mcp, "Client"), reason="this version of mcp knows the handshake only")
def test_the_protocols_client_walks_without_a_handshake(program, homes, tmp_path):
    async def run():
        async with mcp.Client(parameters(program, homes, tmp_path)) as client:
            assert client.protocol_version == "2026-07-28"
            await play(client, tmp_path, lists_again=False)

    asyncio.run(run())
