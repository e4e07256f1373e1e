"""Trained agents: models of `enfilade train` and `enfilade import-weights`, run in C++.

>>> agent = enfilade.agents.load("run/models/duet")
>>> score = agent.evaluate(d.episodes("val_unseen"), "features.safetensors")
>>> score.means["spl"]
>>> policy = agent.policy(env, "features.safetensors")     # an environment of enfilade.gym
>>> env.step(policy())

PyTorch is neither needed nor imported, but libtorch is needed: the extension module of these agents is
built only where libtorch is found. Without it, importing this module raises ImportError, which says how
to get it.
"""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Optional, Union

from enfilade._arguments import deprecated, whole
from enfilade._episodes import Episodes, Score
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

    run() and evaluate() end the episodes of its policies, and so does another policy: reset() the
    environment then.

    kind: "seq2seq", "panoramic" or "duet"; iteration: of its weights; folder: the model directory.
    """

    def __init__(self, core: _learn.LearntAgent, folder: str) -> None:
        self._core = core
        self.folder = folder
        self._user: Any = None  # the policy whose episodes the core has
        self._entered: Optional[tuple[Episodes, Optional[_Path]]] = None
        self._entered_policy: Optional[Policy] = None

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
        """Whether it needs image features."""
        return self._core.sees

    def run(
        self,
        episodes: Episodes,
        features: Optional[_Path] = None,
        *,
        batch_size: int = 100,
        results: Optional[_Path] = None,
        attention: Optional[_Path] = None,
    ) -> list[dict[str, Any]]:
        """Runs all episodes, batch by batch. Returns the entries of a results file, for Episodes.score().

        Args:
            features: file of `enfilade features` or a published one; needed if `sees`.
            batch_size: episodes per batch.
            results: a results file to write as well.
            attention: a file for attention weights and action probabilities, for `enfilade report`.

        Raises ArgumentError if the agent needs features and there are none, or if their size is not the
        network's; InvalidInput for viewpoints without features.
        """
        self._bind(None, episodes, features)
        text = self._core.walk(
            whole("batch_size", batch_size),
            None if results is None else os.fspath(results),
            None if attention is None else os.fspath(attention),
        )
        entries: list[dict[str, Any]] = json.loads(text)
        return entries

    def evaluate(
        self, episodes: Episodes, features: Optional[_Path] = None, **options: Any
    ) -> Score:
        """Runs all episodes and scores them, by the task's default scorer. Options and errors are those
        of run(), and the errors of Episodes.score()."""
        return episodes.score(self.run(episodes, features, **options))

    def policy(self, env: Any, features: Optional[_Path] = None) -> Policy:
        """The policy of this agent in an environment: a function that returns its actions.

        Args:
            env: VlnEnv or VlnVectorEnv of a task on graphs, with any actions.
            features: as in run().

        Best actions: "panoramic" for a panoramic agent, "map" for DUET ("viewpoint" suits both), "six" for
        seq2seq. DUET ends where stopping was most likely. With "map" it cannot return there, and stops at
        the current viewpoint.

        Raises the errors of run(), and TypeError for another object.
        """
        batch = _environment(env)
        made = Policy(self, env, batch.episodes, features)
        self._bind(made, batch.episodes, features)
        return made

    def enter(self, where: Any, features: Optional[_Path] = None) -> None:
        """Deprecated: the episodes of walk() and act(). Write run(), evaluate() or policy()."""
        deprecated("Agent.enter()", "run(), evaluate() or policy()")
        episodes = where if isinstance(where, Episodes) else _environment(where).episodes
        self._bind(None, episodes, features)
        self._entered, self._entered_policy = (episodes, features), None

    def walk(
        self,
        batch_size: int = 100,
        *,
        results: Optional[_Path] = None,
        attention: Optional[_Path] = None,
    ) -> list[dict[str, Any]]:
        """Deprecated: run() of the episodes of enter()."""
        deprecated("Agent.walk()", "run(episodes, features)")
        if self._entered is None:
            raise RuntimeError("walk(): enter() has to come first; or write run(episodes, features)")
        return self.run(*self._entered, batch_size=batch_size, results=results, attention=attention)

    def act(self, env: Any) -> NDArray[int64]:
        """Deprecated: the actions of policy() in an environment of the episodes of enter(), (n,)."""
        deprecated("Agent.act(env)", "policy(env)()")
        batch = _environment(env)
        if self._entered is None or not _same(batch.episodes, self._entered[0]):
            raise ArgumentError("act(): enter() this environment, or its episodes, first")
        policy = self._entered_policy
        if policy is None or policy._batch is not batch:
            policy = self._entered_policy = Policy(self, env, *self._entered)
        return policy._actions()

    def _bind(self, user: Any, episodes: Episodes, features: Optional[_Path]) -> None:
        self._user = None
        self._core.enter(episodes._core.shared(), None if features is None else os.fspath(features))
        self._user = user


class Policy:
    """The actions of an agent in an environment; Agent.policy() makes one.

    >>> policy = agent.policy(envs)
    >>> seen, info = envs.reset(options={"episode": numpy.arange(64)})
    >>> seen, *_ = envs.step(policy())
    """

    def __init__(
        self, agent: Agent, env: Any, episodes: Episodes, features: Optional[_Path]
    ) -> None:
        self._agent, self._episodes, self._features = agent, episodes, features
        self._batch = _environment(env)
        self._single = not hasattr(getattr(env, "unwrapped", env), "num_envs")
        self._began: Any = None  # (n,) the episode index of each slot

    def __call__(self, observation: Any = None) -> Any:
        """The next actions, for step(): (n,) int64, or one integer for a single environment.

        Args:
            observation: not needed: the environment's state is read.

        If all agents are at the start of an episode, these episodes begin together. From then on every
        action has to be executed. Slots whose episode has ended, or has changed, get stop. In REVERIE the
        agent's answers go to the environment.

        Raises ArgumentError if an agent is not where its last action led, or if its episodes did not
        begin here.
        """
        actions = self._actions()
        return actions[0] if self._single else actions

    def _actions(self) -> NDArray[int64]:
        import numpy as np

        batch, core = self._batch, self._agent._core
        batch._check_begun("policy")
        arrays, actions = batch.arrays, batch.config.actions
        begins = not arrays["step"].any()
        if self._agent._user is not self:
            self._began = None
            if begins:
                self._agent._bind(self, self._episodes, self._features)
        if begins:
            core.begin(np.ascontiguousarray(arrays["episode"], np.uint32), actions)
            self._began = arrays["episode"].copy()
        if self._began is None:
            raise ArgumentError("policy: the environment's episodes have to begin together: reset() it")
        running = (arrays["terminated"] | arrays["truncated"]) == 0
        asked = (running & (arrays["episode"] == self._began)).astype(np.uint8)
        moves = core.next(np.ascontiguousarray(arrays["viewpoint"]), asked)
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
                raise ArgumentError(f"policy: agent {slot} cannot go to viewpoint {viewpoint}")
            chosen[slot] = found[0]
        return chosen


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
    """The batch of a single or vector environment. Raises TypeError for another object."""
    from enfilade.gym._graph import GraphBatch

    batch = getattr(getattr(env, "unwrapped", env), "_batch", None)
    if not isinstance(batch, GraphBatch):
        raise TypeError(f"{env!r}: an environment of enfilade.gym on graphs is wanted")
    return batch


def _same(one: Episodes, other: Episodes) -> bool:
    """Whether both have the same task and the same instructions in the same order."""
    return one is other or one._core.task == other._core.task and one._core.texts == other._core.texts
