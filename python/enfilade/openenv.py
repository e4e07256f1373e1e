"""The arena as an OpenEnv server: https://github.com/meta-pytorch/OpenEnv.

Needs `pip install openenv` (0.10), or `openenv-core` (0.3), its former name.

    python -m enfilade.openenv r2r/val_unseen --data homes --port 8000

serves episodes over HTTP and WebSockets, as OpenEnv's own server does. In a client:

>>> with GenericEnvClient(base_url="http://127.0.0.1:8000").sync() as env:
...     seen = env.reset().observation                      # {"prompt": ..., "observation": {...}, "images": []}
...     result = env.step({"tool": "go_to", "argument": "B"})
...     result.reward, result.done                          # the reward is 0 before the end
"""

from __future__ import annotations

import argparse
import base64
import threading
from typing import Any, Callable, Optional
from urllib.parse import urlsplit

from openenv.core.env_server import (  # type: ignore[import-not-found, unused-ignore]
    Action,
    Environment,
    Observation,
    State,
    create_fastapi_app,
)
from openenv.core.env_server.types import EnvironmentMetadata  # type: ignore[import-not-found, unused-ignore]
from pydantic import Field

import enfilade
from enfilade._arena import Arena, ArenaStep

__all__ = ["Walk", "WalkAction", "WalkObservation", "app", "main"]

_SUCCESS = ("success", "success_rate", "sr")  # benchmarks' names of success
_arenas = threading.Lock()  # opening one reads the whole split


class WalkAction(Action):  # type: ignore[misc, unused-ignore]
    """A tool call, or a model's text (docs/arena.md)."""

    tool: str = Field("", description="go_to, back_to, look, move, turn_back, answer or stop")
    argument: str = Field("", description="The tool's value: B; of move several, with commas between")
    answer: str = Field("", description="Instead of a tool: a model's words, read as the prompt asks for")


class WalkObservation(Observation):  # type: ignore[misc, unused-ignore]
    """The observation of a step. An episode's last one has its ending, and its metrics unless the goal is
    hidden."""

    episode: str = Field("", description="The episode's id")
    ending: str = Field("", description="stopped, out-of-steps or mistakes; empty: the episode goes on")
    metrics: dict[str, float] = Field(default_factory=dict, description="At the end: the benchmark's metrics")
    prompt: str = Field("", description="The prompt's text for this step")
    observation: dict[str, Any] = Field(default_factory=dict, description="docs/arena.md, A step")
    told: str = Field("", description="What came of the last call, a sentence")
    images: list[str] = Field(default_factory=list, description="The prompt's pictures: JPEG in base64")


class Walk(Environment[WalkAction, WalkObservation, State]):  # type: ignore[misc, unused-ignore]
    """An OpenEnv environment. The reward is 0 until the end, and then the benchmark's success, 0 or 1.
    It stays 0 if the goal is hidden, or if the benchmark has no such metric. `metrics` has all of them.

    Args:
        make: returns the arena.
    """

    SUPPORTS_CONCURRENT_SESSIONS = True

    def __init__(self, make: Callable[[], Arena]) -> None:
        super().__init__()
        with _arenas:
            self._arena = make()
        self._step: Optional[ArenaStep] = None
        self._calls = 0
        self._next = 0

    def reset(
        self, seed: Optional[int] = None, episode_id: Optional[str] = None, **_: Any
    ) -> WalkObservation:  # fmt: skip
        """Begins the episode `episode_id`; without it, episode number `seed`; without both, the next."""
        ids = self._arena.ids
        if episode_id is None:
            episode_id = ids[(self._next if seed is None else seed) % len(ids)]
        self._step = self._arena.begin(episode_id)
        self._next = ids.index(episode_id) + 1
        self._calls = 0
        return self._seen(self._step)

    def step(self, action: WalkAction, timeout_s: Optional[float] = None, **_: Any) -> WalkObservation:
        """Executes a call. An invalid one has no effect: `told` lists the valid ones. Raises RuntimeError
        before reset()."""
        step = self._step
        if step is None:
            raise RuntimeError("no episode is being walked: call reset()")
        if action.tool:
            step.call(action.tool, action.argument)
        else:
            step.act(action.answer)
        self._calls += 1
        if step.ending is None:
            self._step = next(self._arena)
            return self._seen(self._step, step.told)
        self._step = None
        metrics = self._metrics(step.episode)
        return WalkObservation(
            done=True,
            reward=next((metrics[name] for name in _SUCCESS if name in metrics), 0.0),
            told=step.told,
            episode=step.episode,
            ending=step.ending,
            metrics=metrics,
            metadata={"ending": step.ending, "episode": step.episode, "metrics": metrics},
        )

    @property
    def state(self) -> State:
        """The episode's id and the number of its calls."""
        return State(episode_id=self._step.episode if self._step else None, step_count=self._calls)

    def get_metadata(self) -> EnvironmentMetadata:
        """Name and description, for clients that ask what this is."""
        return EnvironmentMetadata(
            name="enfilade",
            description="Vision-and-language navigation: an agent follows an instruction through a building.",
            version=enfilade.__version__,
        )

    def _metrics(self, episode: str) -> dict[str, float]:
        try:
            return self._arena.score(episode).episodes[episode]
        except enfilade.ArgumentError:  # the goal is hidden
            return {}

    @staticmethod
    def _seen(step: ArenaStep, told: str = "") -> WalkObservation:
        images = [base64.b64encode(one).decode("ascii") for one in step.images]
        return WalkObservation(
            done=False, reward=0.0, prompt=step.prompt, observation=step.observation, told=told, images=images,
            episode=step.episode, metadata={"episode": step.episode},
        )  # fmt: skip


def app(name: str, *, sessions: int = 16, **options: Any) -> Any:
    """OpenEnv's FastAPI application. Arguments are those of enfilade.arena(); sessions: most at once."""

    def enfilade_env() -> Walk:  # its name is the environment's in addresses
        return Walk(lambda: enfilade.arena(name, **options))

    made = create_fastapi_app(
        enfilade_env,
        WalkAction,
        WalkObservation,
        max_concurrent_envs=sessions,
    )
    made.add_middleware(_OwnPagesOnly)
    return made


class _OwnPagesOnly:
    """Refuses requests of web pages that another server sent, also of one whose name now resolves to this
    machine. Browsers send `Origin` with them, and the name as `Host`."""

    _LOOPBACK = ("127.0.0.1", "localhost", "::1")

    def __init__(self, app: Any) -> None:
        self._app = app

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] not in ("http", "websocket") or self._is_own(scope):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008})  # the handshake gets 403
        else:
            await send({"type": "http.response.start", "status": 403, "headers": [(b"content-type", b"text/plain")]})
            await send({"type": "http.response.body", "body": b"Host or Origin names another server\n"})

    @classmethod
    def _is_own(cls, scope: Any) -> bool:
        headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
        host, origin = headers.get(b"host", ""), headers.get(b"origin")
        try:
            name, page = urlsplit(f"//{host}").hostname, urlsplit(origin or "").netloc
        except ValueError:  # no address at all
            return False
        local = (scope.get("server") or ("",))[0] in cls._LOOPBACK  # None: a socket without an address
        return (not local or name in cls._LOOPBACK) and (origin is None or page == host)


def main(arguments: Optional[list[str]] = None) -> None:
    """python -m enfilade.openenv"""
    parser = argparse.ArgumentParser(
        prog="python -m enfilade.openenv", description="Serve the arena to OpenEnv's clients."
    )
    parser.add_argument("name", help="task and split: r2r/val_unseen")
    parser.add_argument("--data", help="folder of the data set (default: what ENFILADE_DATA names)")
    parser.add_argument("--subset", default="all", help="how many episodes, or a file of ids (default: all)")
    parser.add_argument("--prompt", default="text", help="text, marks, navgpt, mapgpt, or a file (default: text)")
    parser.add_argument("--host", default="127.0.0.1", help="interface to listen on (default: 127.0.0.1)")
    parser.add_argument("--port", type=int, default=8000, help="(default: 8000)")
    parser.add_argument("--sessions", type=int, default=16, help="sessions at once (default: 16)")
    given = parser.parse_args(arguments)
    import uvicorn

    served = app(given.name, data=given.data, subset=given.subset, prompt=given.prompt, sessions=given.sessions)
    uvicorn.run(served, host=given.host, port=given.port, log_level="warning")


if __name__ == "__main__":
    main()
