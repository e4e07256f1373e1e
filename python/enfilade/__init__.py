"""Vision-and-language navigation in C++, for Python.

There are three interfaces to the same simulator: this package, `enfilade.gym` (Gymnasium
environments) and `MatterSim` (a drop-in for Matterport3DSimulator's module).

>>> import enfilade
>>> d = enfilade.Dataset("data")
>>> sim = d.simulator(batch_size=2)
>>> scan = d.graphs.scans[0]
>>> sim.new_random_episodes([scan, scan])
>>> sim.step([0, 0], heading_changes=[0.5, -0.5])
>>> sim.state.heading                                      # (2,) radians

Frames: metres, +z up; headings in radians clockwise from +y; elevations in radians above the
horizon; row 0 of an image on top. Importing this takes milliseconds: NumPy is imported with the
first class that needs it, Gymnasium with `enfilade.gym`, torch with `enfilade.torch_data`.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from enfilade._core import (
    Graph,
    Graphs,
    Panoramas,
    Vocabulary,
    backends,
    metrics,
    tokenize,
)
from enfilade._errors import ArgumentError, Error, FileError, InvalidInput, UnknownNameError

if TYPE_CHECKING:
    from enfilade._arena import Arena, ArenaStep, arena
    from enfilade._continuous import (
        ContinuousAction,
        ContinuousEpisode,
        ContinuousEpisodes,
        ContinuousGoal,
        ContinuousSimulator,
        ContinuousState,
        EpisodeStatus,
        ExpertWalk,
        continuous_episodes,
        from_habitat,
        to_habitat,
    )
    from enfilade._dataset import Dataset, Part, SeenObject
    from enfilade._episodes import Episode, Episodes, Score, SubInstruction, TimedWord, Turn
    from enfilade._renderer import Renderer, open_panoramas
    from enfilade._scores import Scorer, score_paths, scorers
    from enfilade._simulator import Candidate, CandidateTable, Simulator, State
    from enfilade.synth import write_small_dataset

__version__ = "0.1.0"

# Name -> module, for names that need NumPy or the ray tracer.
_LATER = {
    "Arena": "_arena",
    "ArenaStep": "_arena",
    "arena": "_arena",
    "Dataset": "_dataset",
    "Part": "_dataset",
    "SeenObject": "_dataset",
    "ContinuousAction": "_continuous",
    "ContinuousEpisode": "_continuous",
    "ContinuousEpisodes": "_continuous",
    "ContinuousGoal": "_continuous",
    "ContinuousSimulator": "_continuous",
    "ContinuousState": "_continuous",
    "EpisodeStatus": "_continuous",
    "ExpertWalk": "_continuous",
    "continuous_episodes": "_continuous",
    "from_habitat": "_continuous",
    "to_habitat": "_continuous",
    "Candidate": "_simulator",
    "CandidateTable": "_simulator",
    "Simulator": "_simulator",
    "State": "_simulator",
    "Renderer": "_renderer",
    "open_panoramas": "_renderer",
    "Episode": "_episodes",
    "Episodes": "_episodes",
    "Score": "_episodes",
    "SubInstruction": "_episodes",
    "TimedWord": "_episodes",
    "Turn": "_episodes",
    "Scorer": "_scores",
    "score_paths": "_scores",
    "scorers": "_scores",
    "write_small_dataset": "synth",
}

_MODULES = ("agents", "camera", "eyes", "features", "goals", "torch_data")

__all__ = [
    "Arena",
    "ArenaStep",
    "ArgumentError",
    "Candidate",
    "CandidateTable",
    "ContinuousAction",
    "ContinuousEpisode",
    "ContinuousEpisodes",
    "ContinuousGoal",
    "ContinuousSimulator",
    "ContinuousState",
    "Dataset",
    "Episode",
    "EpisodeStatus",
    "Episodes",
    "Error",
    "ExpertWalk",
    "FileError",
    "Graph",
    "Graphs",
    "InvalidInput",
    "Panoramas",
    "Part",
    "Renderer",
    "Score",
    "Scorer",
    "SeenObject",
    "Simulator",
    "State",
    "SubInstruction",
    "TimedWord",
    "Turn",
    "UnknownNameError",
    "Vocabulary",
    "arena",
    "backends",
    "continuous_episodes",
    "from_habitat",
    "metrics",
    "open_panoramas",
    "score_paths",
    "scorers",
    "to_habitat",
    "tokenize",
    "write_small_dataset",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"enfilade.{name}")
    if name not in _LATER:
        raise AttributeError(f"module 'enfilade' has no attribute '{name}'")
    value = getattr(importlib.import_module(f"enfilade.{_LATER[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
