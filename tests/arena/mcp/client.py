#!/usr/bin/env python3
"""Two episodes by the protocol's client for Python, `pip install mcp`. It lists the tools once, as assistants do.

client.py COMMAND...       a server on standard input and output
client.py http://...       one over HTTP
"""

import asyncio
import re
import sys

import mcp
from mcp.client.stdio import StdioServerParameters, stdio_client


def texts(result):
    return "\n".join(block.text for block in result.content if block.type == "text")


async def play(session):
    names = [tool.name for tool in (await session.list_tools()).tools]
    assert names == ["begin", "go_to", "back_to", "look", "stop"], names

    async def call(name, **arguments):
        assert name in names
        return texts(await session.call_tool(name, arguments))

    said = await call("begin")
    assert "Instruction: " in said
    place = re.search(r"^go_to place: (\w+)", said, re.M)[1]
    assert f"You went to {place}" in await call("go_to", place=place)
    assert "You went to A" in await call("back_to", place="A")
    assert "is not one of" in await call("go_to", place="QQ")
    assert "The episode is over" in await call("stop")
    assert "begin starts the next one" in await call("stop")
    assert "Instruction: " in await call("begin")
    assert "The episode is over" in await call("stop")


async def main(words):
    if words[0].startswith("http"):
        import mcp.client.streamable_http as http

        connect = getattr(http, "streamable_http_client", None) or http.streamablehttp_client
        streams = connect(words[0])
    else:
        streams = stdio_client(StdioServerParameters(command=words[0], args=words[1:]))
    async with streams as opened, mcp.ClientSession(opened[0], opened[1]) as session:
        await session.initialize()
        await play(session)


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1:]))
