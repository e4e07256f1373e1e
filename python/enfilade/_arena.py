"""Evaluation of language models, step by step, with prompts and images."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Iterator, NamedTuple, Optional, Union

from enfilade._arguments import whole
from enfilade._core import ArenaPlay, DatasetFolder
from enfilade._episodes import Episodes, Score
from enfilade._errors import ArgumentError

if TYPE_CHECKING:  # Python 3.8 has no os.PathLike[str]; and importing this does not need NumPy
    from enfilade._continuous import ContinuousEpisodes

    _Path = Union[str, os.PathLike[str]]


class Standpoint(NamedTuple):
    """Pose of a session: heading and elevation in radians. On a graph `viewpoint` is set; in continuous
    space `eye` is, (x, y, z) in metres, world frame."""

    scan: str
    viewpoint: Optional[str]
    eye: Optional[tuple[float, float, float]]
    heading: float
    elevation: float


class ArenaStep:
    """One step of an episode: its observation and its tools. act() ends it."""

    def __init__(self, core: ArenaPlay, first: bool) -> None:
        self._core = core
        self.first = first  #: whether it is the first step of its episode
        self.episode: str = core.episode()  #: its instruction id
        self.observation: dict[str, Any] = json.loads(core.observation())  #: docs/arena.md, A step
        #: Not part of the prompt: for your own images and features.
        self.standpoint = Standpoint(*core.standpoint())
        text = core.step_text()
        self.prompt: str = f"{core.start_text()}\n\n{text}" if first else text
        #: The tools in the form of OpenAI's `tools`: name, description, parameters (JSON Schema).
        self.functions: list[dict[str, Any]] = json.loads(core.functions())
        self._images: Optional[list[bytes]] = None
        self.carried_out: Optional[bool] = None  #: whether the call was valid; None before act()
        self.told = ""  #: the result of act(), a sentence
        self.ending: Optional[str] = None  #: "stopped", "out-of-steps", "mistakes"; None: not ended

    def __repr__(self) -> str:
        return f"<enfilade.ArenaStep {self.observation['step']} of {self.episode}>"

    @property
    def instruction(self) -> str:
        """The episode's instruction."""
        return str(self.observation["instruction"])

    @property
    def images(self) -> list[bytes]:
        """The prompt's images, JPEG, drawn at first use. Empty in continuous space; there
        enfilade.eyes.Eyes draws the view from `standpoint`. Raises RuntimeError after act(), FileError
        if the viewpoint has no images."""
        if self._images is None:
            self._expect_open()
            self._images = self._core.draw()
        return self._images

    @property
    def schema(self) -> dict[str, Any]:
        """A JSON Schema of answers without tools, for servers with `response_format`. Raises
        RuntimeError after act()."""
        self._expect_open()
        schema: dict[str, Any] = json.loads(self._core.schema())
        return schema

    def act(self, answer: Union[str, Mapping[str, Any]]) -> bool:
        """Executes a model's answer.

        Args:
            answer: a tool call, {"name": "go_to", "arguments": {"place": "B"}} (arguments may be
                JSON text); or the model's text, read by the arena's `answers`.

        Returns whether the call was valid. An invalid or unreadable answer has no effect: the next
        step reports it, and it counts as a mistake. Raises RuntimeError if called twice,
        ArgumentError for an answer of another type.
        """
        self._expect_open()
        if isinstance(answer, str):
            return self._done(self._core.answer(answer))
        if isinstance(answer, Mapping):
            name, given = answer.get("name"), answer.get("arguments")
            if not isinstance(name, str):
                raise ArgumentError('act: a dict {"name": ..., "arguments": {...}} has a name, a str')
            text = given if isinstance(given, str) else json.dumps({} if given is None else given)
            return self._done(self._core.call(name, text))
        raise ArgumentError(f"act: a str or a dict, not {type(answer).__name__}")

    def call(self, tool: str, argument: str = "") -> bool:
        """The same with a tool and its value: "go_to", "B"; for `move` several, separated by commas."""
        self._expect_open()
        return self._done(self._core.use(tool, argument))

    def _done(self, outcome: tuple[bool, Optional[str], str]) -> bool:
        self.carried_out, self.ending, self.told = outcome
        return self.carried_out

    def _expect_open(self) -> None:
        if self.carried_out is not None:
            raise RuntimeError("this step is over: act() was called")


class Arena(Iterator[ArenaStep]):
    """Episodes to step through; arena() makes one. One thread at a time."""

    def __init__(self, core: ArenaPlay, episodes: Union[Episodes, ContinuousEpisodes]) -> None:
        self._core = core
        self._step: Optional[ArenaStep] = None
        self.episodes = episodes  #: all episodes of the split

    def __len__(self) -> int:
        """Number of episodes in the subset, completed ones included."""
        return len(self._core)

    @property
    def done(self) -> int:
        """Completed episodes, including those of earlier processes in the same folder."""
        return self._core.done

    @property
    def ids(self) -> list[str]:
        """Instruction ids of the subset, in order."""
        return self._core.ids

    def begin(self, episode: str) -> ArenaStep:
        """Begins an episode by its id; next() continues with it. For a completed episode, the last
        trajectory counts. Raises UnknownNameError, and ArgumentError for one outside the subset."""
        self._core.begin_at(episode)
        self._step = ArenaStep(self._core, True)
        return self._step

    def __iter__(self) -> Arena:
        return self

    def __next__(self) -> ArenaStep:
        """The next step; after an episode's end, the first step of the next. Raises RuntimeError if
        act() was not called at the previous step."""
        last = self._step
        if last is not None and last.carried_out is None:
            raise RuntimeError(f"act() was not called at step {last.observation['step']} of {last.episode}")
        first = last is None or last.ending is not None
        if first and not self._core.begin():
            self._step = None
            raise StopIteration
        self._step = ArenaStep(self._core, first)
        return self._step

    def results_text(self) -> str:
        """A results file of all completed episodes, in the benchmark's format."""
        return self._core.results(None)

    def results(self, episode: Optional[str] = None) -> Any:
        """The same as objects: a list of entries; for r2r-ce, a dict of poses by episode. With an id,
        only that episode, which this object must have completed."""
        text = self._core.results(episode)
        if self.episodes.task == "rxr-ce":
            return [json.loads(line) for line in text.splitlines()]
        return json.loads(text)

    def score(self, episode: Optional[str] = None) -> Score:
        """The score of the completed episodes, or of one that this object completed. Raises FileError,
        InvalidInput, and ArgumentError if the goals are hidden."""
        if isinstance(self.episodes, Episodes):
            return self.episodes.score(self.results(episode), part=True)
        means, by_id = self._core.free_score(episode)
        return Score(means, by_id, [], self.episodes.task, "vln-ce")


def arena(
    name: str,
    *,
    data: Optional[_Path] = None,
    subset: Union[None, int, str, os.PathLike[str]] = None,
    prompt: Union[str, os.PathLike[str]] = "text",
    answers: Optional[str] = None,
    steps: Optional[int] = None,
    mistakes: int = 10,
    picture_size: int = 512,
    words: str = "none",
    output: Optional[_Path] = None,
) -> Arena:
    """Opens episodes for a model or any function to step through.

    >>> walk = enfilade.arena("r2r/val_unseen", data="homes", subset=100, prompt="marks")
    >>> for step in walk:
    ...     step.act(my_model(step.prompt, step.images))
    >>> walk.score().means["success"]

    Args:
        name: task and split, "reverie/val_unseen": r2r, r4r, rxr, r2r-last, r2r-back, cvdn or
            reverie; r2r-ce and rxr-ce are continuous: one to four actions per call, no images.
        data: folder of the data set; None: the one that ENFILADE_DATA names.
        subset: number of episodes, spread over buildings and lengths; a file with one instruction id
            per line; "all"; None: 100, or all if there are fewer.
        prompt: "text", "marks", "navgpt", "mapgpt", or a template file (docs/arena.md).
        answers: how texts are read: "tools", "json" or "text"; None: the prompt's own way. act() also
            accepts tool calls as dicts.
        steps: calls after which an episode ends; None: 30, or 125 in continuous space (500 actions, up
            to four per call).
        mistakes: consecutive invalid calls after which an episode ends.
        picture_size: pixels, 64 to 2048.
        words: description of views in the text: "none", or "labels", from images of classes and
            instances, on graphs.
        output: folder for results.json and transcripts/; episodes with a transcript there are skipped.
            None: nothing is written.

    Raises ArgumentError, UnknownNameError, FileError or InvalidInput. SOON has no tool for its answers
    and is refused at the first step.
    """
    task, slash, split = name.partition("/")
    if not (task and slash and split):
        raise ArgumentError(f"arena: '{name}': task/split is expected, as in r2r/val_unseen")
    chosen = "" if subset is None else str(subset) if isinstance(subset, int) else os.fspath(subset)
    most = 0 if steps is None else whole("steps", steps, 10**6)
    if steps is not None and most == 0:
        raise ArgumentError("steps 0: 1 or more are allowed")
    if words not in ("none", "labels"):
        raise ArgumentError(f"words '{words}': none or labels")
    if task in ("r2r-ce", "rxr-ce"):
        if words != "none":
            raise ArgumentError("words 'labels': on graphs only; in continuous space `enfilade ask` has them")
        from enfilade._continuous import _data_folder, continuous_episodes

        free = continuous_episodes(data, task, split)
        walk = ArenaPlay.free(
            _data_folder(data), task, split, chosen, os.fspath(prompt), answers or "", most,
            whole("mistakes", mistakes, 10**6), output,
        )  # fmt: skip
        return Arena(walk, free)
    dataset = DatasetFolder(data)
    episodes = Episodes._of_dataset(dataset, split, task, False, None)
    core = ArenaPlay(
        dataset,
        episodes._core,
        chosen,
        os.fspath(prompt),
        answers or "",
        most,
        whole("mistakes", mistakes, 10**6),
        whole("picture_size", picture_size, 2048),
        output,
        words == "labels",
    )
    return Arena(core, episodes)
