"""Language models walk: one step after another, by prompts and pictures."""

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
    """Where a session stands and looks: of a graph its viewpoint, in continuous space its eye (x, y, z)
    in metres of the world frame; heading and elevation in radians."""

    scan: str
    viewpoint: Optional[str]
    eye: Optional[tuple[float, float, float]]
    heading: float
    elevation: float


class ArenaStep:
    """What is known at a step of an episode, and what can be done. act() ends it."""

    def __init__(self, core: ArenaPlay, first: bool) -> None:
        self._core = core
        self.first = first  #: of its episode
        self.episode: str = core.episode()  #: its instruction id
        self.observation: dict[str, Any] = json.loads(core.observation())  #: docs/arena.md, A step
        #: Nothing that a model is told: for pictures and features of one's own.
        self.standpoint = Standpoint(*core.standpoint())
        text = core.step_text()
        self.prompt: str = f"{core.start_text()}\n\n{text}" if first else text
        #: The tools as OpenAI's `tools` have them: name, description, parameters (JSON Schema).
        self.functions: list[dict[str, Any]] = json.loads(core.functions())
        self._images: Optional[list[bytes]] = None
        self.carried_out: Optional[bool] = None  #: None before act()
        self.told = ""  #: what came of act(), a sentence
        self.ending: Optional[str] = None  #: "stopped", "out-of-steps", "mistakes"; None: it goes on

    def __repr__(self) -> str:
        return f"<enfilade.ArenaStep {self.observation['step']} of {self.episode}>"

    @property
    def instruction(self) -> str:
        """What to do."""
        return str(self.observation["instruction"])

    @property
    def images(self) -> list[bytes]:
        """The prompt's pictures, JPEG: drawn when they are first asked for. None in continuous space,
        where enfilade.eyes.Eyes draws what is seen from `standpoint`. Raises RuntimeError after act(),
        FileError without pictures of the place."""
        if self._images is None:
            self._expect_open()
            self._images = self._core.draw()
        return self._images

    @property
    def schema(self) -> dict[str, Any]:
        """A JSON Schema of answers without tools, for servers that take `response_format`. Raises
        RuntimeError after act()."""
        self._expect_open()
        schema: dict[str, Any] = json.loads(self._core.schema())
        return schema

    def act(self, answer: Union[str, Mapping[str, Any]]) -> bool:
        """Does what a model answered.

        Args:
            answer: a dict {"name": "go_to", "arguments": {"place": "B"}}, as a tool call has it
                (arguments may be a text of JSON); or the model's text, read by the arena's
                `answers`.

        Returns whether it was carried out. What is impossible or cannot be read changes nothing: it
        is told at the next step, and counted. Raises RuntimeError if it was called before.
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
        """The same of one tool and its value: "go_to", "B"; of `move` several, with commas between."""
        self._expect_open()
        return self._done(self._core.use(tool, argument))

    def _done(self, outcome: tuple[bool, Optional[str], str]) -> bool:
        self.carried_out, self.ending, self.told = outcome
        return self.carried_out

    def _expect_open(self) -> None:
        if self.carried_out is not None:
            raise RuntimeError("this step is over: act() was called")


class Arena(Iterator[ArenaStep]):
    """Episodes that are walked step by step; arena() makes one. One thread at a time."""

    def __init__(self, core: ArenaPlay, episodes: Union[Episodes, ContinuousEpisodes]) -> None:
        self._core = core
        self._step: Optional[ArenaStep] = None
        self.episodes = episodes  #: of the whole split

    def __len__(self) -> int:
        """How many episodes are to be walked, with those that are done."""
        return len(self._core)

    @property
    def done(self) -> int:
        """Episodes that are done, those of earlier processes in the same folder too."""
        return self._core.done

    @property
    def ids(self) -> list[str]:
        """Of the episodes that are to be walked, in their order."""
        return self._core.ids

    def begin(self, episode: str) -> ArenaStep:
        """Begins an episode by its id, also one that is done: its last walk counts. next() goes on with
        it. Raises UnknownNameError; ArgumentError for one that is not of the subset."""
        self._core.begin_at(episode)
        self._step = ArenaStep(self._core, True)
        return self._step

    def __iter__(self) -> Arena:
        return self

    def __next__(self) -> ArenaStep:
        """The next step, of the next episode where one has ended. Raises RuntimeError if act() was
        not called at the step before."""
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
        """A results file of all episodes that are done, as the benchmark has it."""
        return self._core.results(None)

    def results(self, episode: Optional[str] = None) -> Any:
        """The same as objects: a list of entries; of r2r-ce a dict of poses by episode. With an id of
        that episode alone, which was walked by this object."""
        text = self._core.results(episode)
        if self.episodes.task == "rxr-ce":
            return [json.loads(line) for line in text.splitlines()]
        return json.loads(text)

    def score(self, episode: Optional[str] = None) -> Score:
        """Of the episodes that are done, or of one that was walked by this object. Raises as
        Episodes.score(), also if the goals are hidden."""
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
    """Has a model, or any function, walk episodes.

    >>> walk = enfilade.arena("r2r/val_unseen", data="homes", subset=100, prompt="marks")
    >>> for step in walk:
    ...     step.act(my_model(step.prompt, step.images))
    >>> walk.score().means["success"]

    Args:
        name: task and split, "reverie/val_unseen": r2r, r4r, rxr, r2r-last, r2r-back, cvdn or
            reverie; r2r-ce and rxr-ce walk freely, one to four actions a call, and show no pictures.
        data: folder of the data set; None: what ENFILADE_DATA names.
        subset: how many, spread over buildings and lengths; a file with an instruction id a line;
            "all"; None: 100, or as many as there are.
        prompt: "text", "marks", "navgpt", "mapgpt", or a template file (docs/arena.md).
        answers: how texts say what to do: "tools", "json" or "text"; None: as the prompt has it.
            Calls of tools can always be given to act() as dicts.
        steps, mistakes: an episode ends after so many calls, and after so many one after another
            that could not be carried out. Steps None: 30, and in continuous space as many as the
            benchmark's actions take.
        picture_size: pixels, 64 to 2048.
        words: what texts say of views: "none", or "labels", by pictures of classes and instances, on
            graphs.
        output: folder for results.json and transcripts/; episodes that have a transcript there are
            left out. None: nothing is written.

    Raises ArgumentError, UnknownNameError, FileError, InvalidInput naming what is wrong. SOON, whose
    answers no tool can give, is refused at the first step.
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
