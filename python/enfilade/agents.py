"""Trained agents: models of `enfilade train` and `enfilade import-weights`, run in C++.

>>> agent = enfilade.agents.load("run/models/duet")
>>> agent.enter(d.episodes("val_unseen"), features="features.safetensors")
>>> results = agent.walk()                                 # the whole split, as in a results file
>>> d.episodes("val_unseen").score(results).means["spl"]

PyTorch is neither needed nor imported, but libtorch is needed: the extension module of these agents is
built only where libtorch is found. Without it, importing this module raises ImportError, which says how
to get it.
"""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Optional, Union

from enfilade._arguments import whole
from enfilade._episodes import Episodes
from enfilade._errors import ArgumentError

try:
    from enfilade import _learn
except ImportError as missing:
    raise ImportError(
        "enfilade.agents: trained agents need libtorch, without which this enfilade was built or which "
        f"is not to be found here ({missing}). With Debian's libtorch-dev installed: "
        "pip install . -C cmake.define.EN_WITH_TORCH=ON in a clone; or build with -DEN_BUILD_PYTHON=ON "
        "-DEN_WITH_TORCH=ON and put build/NAME/python on PYTHONPATH (docs/python.md, Trained agents)"
    ) from missing

if TYPE_CHECKING:
    from numpy import int64
    from numpy.typing import NDArray

    _Path = Union[str, os.PathLike[str]]


class Agent:
    """A trained agent; load() makes one. It takes the most likely action. One thread at a time.

    kind: "seq2seq", "panoramic" or "duet"; iteration: of its weights; folder: the model directory.
    """

    def __init__(self, core: _learn.LearntAgent, folder: str) -> None:
        self._core = core
        self.folder = folder
        self._episodes: Optional[Episodes] = None
        self._began: Any = None  # (n,) the episode index of each slot

    def __repr__(self) -> str:
        return f"<enfilade.agents.Agent {self.kind}, iteration {self.iteration}, of {self.folder}>"

    @property
    def kind(self) -> str:
        """The network: "seq2seq", "panoramic" or "duet"."""
        return self._core.kind

    @property
    def iteration(self) -> int:
        """Number of updates of its weights."""
        return self._core.iteration

    @property
    def sees(self) -> bool:
        """Whether enter() needs image features."""
        return self._core.sees

    def enter(self, where: Any, features: Optional[_Path] = None) -> None:
        """Sets the episodes. Call it before walk() and act(); later calls replace them.

        Args:
            where: Episodes, or an environment of enfilade.gym.
            features: file of `enfilade features` or a published one; needed if `sees`.

        Raises ArgumentError if the agent needs features and there are none, or if their size is not the
        network's; InvalidInput for viewpoints without features.
        """
        episodes = where if isinstance(where, Episodes) else _environment(where).episodes
        file = None if features is None else os.fspath(features)
        self._core.enter(episodes._core.shared(), file)
        self._episodes, self._began = episodes, None

    def walk(
        self,
        batch_size: int = 100,
        *,
        results: Optional[_Path] = None,
        attention: Optional[_Path] = None,
    ) -> list[dict[str, Any]]:
        """Runs all episodes of enter(), batch by batch. Returns the entries of a results file, for
        Episodes.score().

        Args:
            batch_size: episodes per batch.
            results: a results file to write as well.
            attention: a file for attention weights and action probabilities, for `enfilade report`.
        """
        text = self._core.walk(
            whole("batch_size", batch_size),
            None if results is None else os.fspath(results),
            None if attention is None else os.fspath(attention),
        )
        self._began = None
        walked: list[dict[str, Any]] = json.loads(text)
        return walked

    def act(self, env: Any) -> NDArray[int64]:
        """The actions of all agents of an environment, (n,) int64, for its step().

        env: RoomToRoomEnv or RoomToRoomVectorEnv, on the episodes of enter(), with any actions. If all its
        agents are at the start of an episode, these episodes begin together. From then on every action
        has to be executed. Slots whose episode has ended, or has changed, get stop.

        Best actions: "panoramic" for a panoramic agent, "map" for DUET ("viewpoint" suits both), "six" for
        seq2seq. DUET ends where stopping was most likely. With "map" it cannot return there, and stops at
        the current viewpoint.

        Raises ArgumentError if an agent is not where its last action led, or if the environment has other
        episodes.
        """
        import numpy as np

        batch = _environment(env)
        if self._episodes is None or batch.episodes._core is not self._episodes._core:
            if self._episodes is None or not _same(batch.episodes, self._episodes):
                raise ArgumentError("act(): enter() this environment, or its episodes, first")
        arrays, actions = batch.arrays, batch.config.actions
        if not arrays["step"].any():
            self._begin(arrays["episode"], actions)
        if self._began is None:
            raise ArgumentError("act(): the environment's episodes have to begin together: reset() it")
        running = (arrays["terminated"] | arrays["truncated"]) == 0
        asked = (running & (arrays["episode"] == self._began)).astype(np.uint8)
        moves = self._core.next(np.ascontiguousarray(arrays["viewpoint"]), asked)
        stop = 5 if actions == "six" else 0
        chosen = np.full(batch.n, stop, np.int64)
        rows = arrays["node_viewpoint" if actions == "map" else "candidate_viewpoint"]
        there = arrays["node_mask" if actions == "map" else "candidate_mask"] != 0
        for slot, (stops, viewpoint, six, object_id) in enumerate(moves):
            if object_id and batch.config.task == "reverie":
                batch.answer(slot, int(object_id) if object_id.isdigit() else object_id)
            if stops:
                continue
            if actions == "six":
                chosen[slot] = six
                continue
            found = np.flatnonzero((rows[slot] == viewpoint) & there[slot])
            found = found[found > 0]
            if len(found) == 0:
                raise ArgumentError(f"act(): agent {slot} cannot go to viewpoint {viewpoint}")
            chosen[slot] = found[0]
        return chosen

    def _begin(self, episodes: Any, actions: str) -> None:
        import numpy as np

        self._core.begin(np.ascontiguousarray(episodes, np.uint32), actions)
        self._began = episodes.copy()


def load(folder: _Path, *, device: str = "cpu", threads: int = 0) -> Agent:
    """Loads a model directory.

    Args:
        folder: with config.json and weights.safetensors.
        device: "cpu", "cuda", "cuda:1"; some kinds of agents cannot use a GPU.
        threads: of libtorch in this process; 0: all cores.

    Raises FileError for a missing file, InvalidInput for a damaged one, ArgumentError for a device that
    this agent cannot use.
    """
    _learn.set_threads(whole("threads", threads))
    name = os.fspath(folder)
    return Agent(_learn.load(name, device), name)


def _environment(env: Any) -> Any:
    """The Batch of a single or vector environment. Raises TypeError for another object."""
    from enfilade.gym._batch import Batch

    batch = getattr(getattr(env, "unwrapped", env), "_batch", None)
    if not isinstance(batch, Batch):
        raise TypeError(f"{env!r}: Episodes or an environment of enfilade.gym is wanted")
    return batch


def _same(one: Episodes, other: Episodes) -> bool:
    """Whether both have the same task and the same instructions in the same order."""
    return one._core.task == other._core.task and one._core.texts == other._core.texts
