# Made by python/tools/make_stubs.py.
from collections.abc import Iterable, Iterator, Mapping, Sequence
import os
import pathlib
from typing import Annotated, Any

import numpy
import numpy.typing
from numpy.typing import NDArray



class TensorFile:
    """The arrays of a file of weights or features."""

    def __init__(self, file: str | os.PathLike[str]) -> None: ...

    def names(self) -> list[str]: ...

    def metadata(self) -> dict[str, str]: ...

    def array(self, name: str) -> Annotated[Any, dict(writable=False)]:
        """A read-only view of an array of float32 or float16, (*shape)."""

def write_safetensors(file: str | os.PathLike[str], arrays: Mapping[str, Annotated[Any, dict(order='C', device='cpu', writable=False)]], metadata: Mapping[str, str]) -> None:
    """Writes arrays of float32 or float16 by their names."""

class Graph:
    """
    The viewpoints of one scan and the edges between them. Immutable. Iterates over ids.
    """

    @property
    def scan(self) -> str:
        """Name of the scan."""

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[str]:
        """Ids, as `viewpoints`."""

    def __contains__(self, arg: str, /) -> bool: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    @property
    def viewpoints(self) -> list[str]:
        """Ids by index, excluded viewpoints too."""

    @property
    def positions(self) -> numpy.typing.NDArray[numpy.float32]:
        """(n, 3) float32, metres, world frame; a read-only view."""

    def included(self, viewpoint: str) -> bool:
        """Whether agents can be at a viewpoint."""

    def index(self, viewpoint: str) -> int:
        """Index in `viewpoints`: MatterSim's `ix`. Raises UnknownNameError."""

    def neighbours(self, viewpoint: str) -> list[str]:
        """Ids of the viewpoints that an edge leads to."""

    def distance(self, a: str, b: str) -> float:
        """
        Length of the shortest path, metres; inf if there is none. Raises UnknownNameError.
        """

    def path(self, a: str, b: str) -> list[str] | None:
        """Ids of the shortest path, both ends included; None if there is none."""

    def nearest(self, point: tuple[float, float, float]) -> str | None:
        """
        The included viewpoint nearest to a point, metres, world frame; None if there is none, or a coordinate is not finite.
        """

    def edges(self) -> list[tuple[str, str, float]]:
        """
        (from, to, metres), each edge once, for networkx's add_weighted_edges_from().
        """

    def edge_arrays(self) -> tuple[numpy.typing.NDArray[numpy.uint32], numpy.typing.NDArray[numpy.float64]]:
        """
        (m, 2) indices from and to, and (m,) metres; an edge in both directions is listed twice.
        """

    def distances(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n, n) lengths of shortest paths, metres, by index; inf where there is none. The result of networkx's all_pairs_dijkstra_path_length(), in milliseconds.
        """

class Graphs:
    """
    The scans of a folder of <scan>_connectivity.json and scans.txt. A graph is read at first use, once per process.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        """Raises FileError or InvalidInput for a folder without a scans.txt."""

    def __reduce__(self) -> tuple[Any, ...]: ...

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[str]:
        """Names, as `scans`."""

    @property
    def scans(self) -> list[str]:
        """Names by index."""

    def __contains__(self, arg: str, /) -> bool: ...

    def __getitem__(self, scan: str) -> Graph:
        """Raises UnknownNameError."""

    def index(self, scan: str) -> int:
        """Index in `scans`. Raises UnknownNameError."""

    def locate(self, scan: str, viewpoint: str) -> tuple[int, int]:
        """
        Indices of an included viewpoint: its scan, then itself. Raises UnknownNameError.
        """

    def load_all(self, threads: int = 0) -> None:
        """
        Reads all graphs that are not read yet; threads 0: all cores. Raises FileError, InvalidInput.
        """

class BatchSimulator:
    """The core of enfilade.Simulator: indices and arrays only."""

    def __init__(self, graphs: Graphs, *, batch_size: int, width: int, height: int, vfov: float, discretized: bool, restricted: bool, linear_view: bool, elevation_limits: tuple[float, float], mattersim_starts: bool, seed: int, max_navigable: int, threads: int) -> None: ...

    def new_episodes(self, scans: Annotated[NDArray[numpy.uint32], dict(shape=(None,), order='C', device='cpu', writable=False)], viewpoints: Annotated[NDArray[numpy.uint32], dict(shape=(None,), order='C', device='cpu', writable=False)], headings: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], elevations: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def new_episode(self, agent: int, scan: int, viewpoint: int, heading: float, elevation: float) -> None: ...

    def new_random_episodes(self, scans: Annotated[NDArray[numpy.uint32], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def step(self, indices: Annotated[NDArray[numpy.uint32], dict(shape=(None,), order='C', device='cpu', writable=False)], heading_changes: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], elevation_changes: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def state_arrays(self) -> dict[str, numpy.typing.NDArray[Any]]: ...

    def candidates(self, scan: int, viewpoint: int) -> list[tuple[int, int, int, float, float, float, float, float, float]]: ...

    def candidate_arrays(self, scans: numpy.typing.NDArray[numpy.uint32]) -> tuple[numpy.typing.NDArray[numpy.uint32], numpy.typing.NDArray[numpy.float64]]: ...

class Panoramas:
    """
    The panoramas of a Graphs' scans: stores, or Matterport3D's files in any layout. A scan is opened at first use.
    """

    def __init__(self, images: Sequence[str | os.PathLike[str]], connectivity: str | os.PathLike[str], graphs: Graphs) -> None:
        """
        images: folders to search, in this order. connectivity: folder of the graphs' files.
        """

    @staticmethod
    def of_scans(images: Sequence[str | os.PathLike[str]], connectivity: str | os.PathLike[str], scans: Sequence[str]) -> Panoramas:
        """The same, with names of scans."""

    def __contains__(self, scan: str) -> bool:
        """
        Whether a scan has images. Raises FileError, InvalidInput for broken ones.
        """

    def __reduce__(self) -> tuple[Any, ...]: ...

    @property
    def scans(self) -> list[str]:
        """Names by index, as Graphs.scans."""

class ViewArrays:
    """The poses of n views: arrays that each rendering reads."""

    def __init__(self, scans: Annotated[NDArray[numpy.uint32], dict(shape=(None,), order='C', device='cpu', writable=False)], viewpoints: Annotated[NDArray[numpy.uint32], dict(shape=(None,), order='C', device='cpu', writable=False)], headings: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], elevations: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def __len__(self) -> int: ...

class ViewRenderer:
    """The core of enfilade.Renderer."""

    def __init__(self, panoramas: Panoramas, backend: str, threads: int, cache_bytes: int, shared_bytes: int, clamped_edges: bool, eight_bit_depth: bool, device: str, card_bytes: int) -> None: ...

    @property
    def description(self) -> str: ...

    def memory(self, shape: tuple[int, ...], type: str) -> numpy.typing.NDArray[Any]:
        """A new array to draw into; its content is undefined."""

    def render(self, views: ViewArrays, width: int, height: int, vfov: float, colour: Annotated[Any, dict(order='C')] | None, colour_format: str, depth: Annotated[Any, dict(order='C')] | None, ray_depth: bool, classes: Annotated[Any, dict(order='C')] | None, instances: Annotated[Any, dict(order='C')] | None, stream: int | None) -> None: ...

def backends() -> list[str]:
    """The Renderer's back ends in this build, such as "cpu" and "gl"."""

class DatasetFolder:
    """The core of enfilade.Dataset."""

    def __init__(self, folder: str | os.PathLike[str] | None) -> None: ...

    @property
    def folder(self) -> pathlib.Path: ...

    @property
    def synthetic(self) -> bool: ...

    @property
    def splits(self) -> list[str]: ...

    @property
    def graphs(self) -> Graphs: ...

    @property
    def panoramas(self) -> Panoramas: ...

    @property
    def panorama_places(self) -> tuple[list[pathlib.Path], pathlib.Path]: ...

    def region(self, scan: str, viewpoint: str) -> int | None: ...

    @property
    def tasks(self) -> dict[str, list[str]]: ...

    def objects_at(self, scan: str, viewpoint: str) -> list[tuple[int, str, tuple[int, ...], tuple[tuple[int, int, int, int], ...]]]: ...

    def examine(self) -> list[tuple[str, bool, str, str]]: ...

def tokenize(text: str) -> list[str]:
    """Splits a text into words, as R2R's released code does."""

class Vocabulary:
    """Words and their ids: 0 <PAD>, 1 <UNK>, 2 <EOS>."""

    @staticmethod
    def load(file: str | os.PathLike[str]) -> Vocabulary:
        """
        Reads one word per line, as in R2R's train_vocab.txt. Raises FileError, InvalidInput.
        """

    @staticmethod
    def build(texts: Sequence[str], least_count: int = 5) -> Vocabulary:
        """
        The words with at least least_count occurrences, most frequent first; ties by alphabet.
        """

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes a file for load(). Raises FileError."""

    def __len__(self) -> int: ...

    @property
    def words(self) -> list[str]:
        """Words by id."""

    def encode(self, text: str, length: int = 80) -> list[int]:
        """Token ids: words reversed, <EOS>, then <PAD> up to `length`."""

    def decode(self, ids: Sequence[int]) -> str:
        """
        Words in reading order, without <PAD> and <EOS>; unknown ids become <UNK>.
        """

    def __getstate__(self) -> list[str]: ...

    def __setstate__(self, arg: Sequence[str], /) -> None: ...

class EpisodeSet:
    """The core of enfilade.Episodes."""

    def __init__(self, dataset: DatasetFolder, task: str, split: str, all_instructions: bool, file: str | os.PathLike[str] | None) -> None: ...

    def __len__(self) -> int: ...

    def episode(self, index: int) -> tuple[Any, ...]: ...

    def about(self, index: int) -> tuple[str, int, int, str, str]: ...

    def find(self, instruction_id: str) -> int | None: ...

    def shared(self) -> Any:
        """The C++ object, for another extension module of this package."""

    @property
    def texts(self) -> list[str]: ...

    @property
    def task(self) -> str: ...

    @property
    def graphs(self) -> Graphs: ...

    def score(self, file: str | os.PathLike[str] | None, text: str, scorer: str, success_distance: float, bootstrap_samples: int, part: bool) -> tuple[str, tuple[str, ...], dict[str, tuple[float, float, float]], numpy.typing.NDArray[numpy.float64], list[int], list[str]]: ...

def metrics(graphs: Graphs, scan: str, trajectory: Iterable[str | int], reference: Iterable[str | int], success_distance: float = 3.0) -> dict[str, float]:
    """
    All metrics of one trajectory against one reference path, both viewpoint ids or indices: nav_error, success, spl, ndtw, cls, ... (docs/tasks.md has the equations). Raises UnknownNameError, and ArgumentError for a path without viewpoints.
    """

def score_paths(graphs: Graphs, task: str, scorer: str, scans: list[str], trajectories: list[Any], references: list[Any], goals: list[Any], answers: list[Any]) -> numpy.typing.NDArray[numpy.float64]: ...

def scorers(task: str) -> list[tuple[str, str, tuple[str, ...], tuple[str, ...]]]: ...

class BatchEnvironment:
    """The core of enfilade.gym's environments."""

    def __init__(self, episodes: object, *, batch_size: int, actions: str, reward: str, max_steps: int, success_distance: float, reset_at_next_step: bool, seed: int, width: int, height: int, vfov: float, max_navigable: int) -> None: ...

    def reset(self, mask: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order='C', device='cpu', writable=False)] | None, chosen: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu', writable=False)] | None) -> None: ...

    def step(self, actions: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def seed(self, agent: int, seed: int) -> None: ...

    @property
    def action_count(self) -> int: ...

    def arrays(self) -> dict[str, numpy.typing.NDArray[Any]]: ...

    def expert(self, agent: int, rule: str) -> int | None: ...

    def walked(self, agent: int) -> list[int]: ...

    def metrics(self, agent: int) -> dict[str, float]: ...

class ArenaPlay:
    """The core of enfilade.arena()."""

    def __init__(self, dataset: DatasetFolder, episodes: object, subset: str, prompt: str, answers: str, steps: int, mistakes: int, picture_size: int, folder: str | os.PathLike[str] | None, words: bool) -> None: ...

    @staticmethod
    def free(data: str | os.PathLike[str], task: str, split: str, subset: str, prompt: str, answers: str, steps: int, mistakes: int, folder: str | os.PathLike[str] | None) -> ArenaPlay: ...

    def standpoint(self) -> tuple[str, str | None, tuple[float, float, float] | None, float, float]: ...

    def free_score(self, episode: str | None) -> tuple[dict[str, tuple[float, float, float]], dict[str, dict[str, float]]]: ...

    def begin(self) -> bool: ...

    def begin_at(self, episode: str) -> None: ...

    @property
    def ids(self) -> list[str]: ...

    def start_text(self) -> str: ...

    def step_text(self) -> str: ...

    def observation(self) -> str: ...

    def functions(self) -> str: ...

    def schema(self) -> str: ...

    def episode(self) -> str: ...

    def draw(self) -> list[bytes]: ...

    def answer(self, text: str) -> tuple[bool, str | None, str]: ...

    def call(self, tool: str, arguments: str) -> tuple[bool, str | None, str]: ...

    def use(self, tool: str, argument: str) -> tuple[bool, str | None, str]: ...

    def results(self, episode: str | None) -> str: ...

    @property
    def done(self) -> int: ...

    def __len__(self) -> int: ...

class FloorSet:
    """The navigation meshes of a folder, by name."""

    def __init__(self, folder: str | os.PathLike[str]) -> None: ...

    def __len__(self) -> int: ...

    @property
    def scans(self) -> list[str]: ...

    @property
    def floor(self) -> str: ...

    def index(self, scan: str) -> int: ...

    def nearest(self, building: int, point: numpy.typing.NDArray[numpy.float64], aside: float, above_below: float) -> tuple[tuple[float, float, float], int] | None: ...

    def distance(self, building: int, start: numpy.typing.NDArray[numpy.float64], goals: numpy.typing.NDArray[numpy.float64], reach: float) -> float: ...

    def path(self, building: int, start: numpy.typing.NDArray[numpy.float64], goal: numpy.typing.NDArray[numpy.float64], reach: float) -> numpy.typing.NDArray[numpy.float32] | None: ...

    def random_point(self, building: int, seed: int) -> tuple[float, float, float]: ...

    def areas(self, building: int) -> list[float]: ...

def continuous_benchmarks() -> list[tuple[str, str, float, float, float, float]]: ...

class BatchContinuous:
    """The core of enfilade.ContinuousSimulator: indices and arrays."""

    def __init__(self, buildings: FloorSet, task: str, batch_size: int, options: dict[str, object]) -> None: ...

    def new_episodes(self, buildings: Annotated[NDArray[numpy.uint32], dict(shape=(None,), order='C', device='cpu', writable=False)], positions: Annotated[NDArray[numpy.float64], dict(shape=(None, 3), order='C', device='cpu', writable=False)], headings: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], elevations: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def new_episode(self, agent: int, building: int, position: Annotated[NDArray[numpy.float64], dict(shape=(None, 3), order='C', device='cpu', writable=False)], heading: float, elevation: float) -> None: ...

    def step(self, actions: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def follow(self, agent: int, points: Annotated[NDArray[numpy.float64], dict(shape=(None, 3), order='C', device='cpu', writable=False)], reached: float, last_reached: float) -> None: ...

    def expert_action(self, agent: int) -> int: ...

    def config(self) -> dict[str, Any]: ...

    def state_arrays(self) -> dict[str, numpy.typing.NDArray[Any]]: ...

class ContinuousSet:
    """The core of enfilade.ContinuousEpisodes."""

    def __init__(self, data: str | os.PathLike[str], task: str, split: str, file: str | os.PathLike[str] | None) -> None: ...

    def __len__(self) -> int: ...

    @property
    def file(self) -> str: ...

    @property
    def texts(self) -> list[str]: ...

    def find(self, episode_id: str) -> int | None: ...

    def episode(self, index: int) -> tuple[Any, ...]: ...

    def expert(self, index: int) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.uint8]] | None: ...

    def score_walk(self, buildings: FloorSet, index: int, positions: numpy.typing.NDArray[numpy.float32], actions: numpy.typing.NDArray[numpy.uint8], collided: numpy.typing.NDArray[numpy.uint8]) -> tuple[dict[str, float], numpy.typing.NDArray[numpy.float64]]: ...

class FreeEnvironment:
    """The core of enfilade.gym's continuous environments."""

    def __init__(self, episodes: ContinuousSet, buildings: FloorSet, batch_size: int, options: dict[str, object]) -> None: ...

    def begin(self, chosen: Annotated[NDArray[numpy.int64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def step(self, actions: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def expert(self, agent: int, shortest: bool) -> int | None: ...

    def score(self, agent: int) -> dict[str, float]: ...

    def walk(self, agent: int) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.uint8], numpy.typing.NDArray[numpy.uint8]]: ...

    def arrays(self) -> dict[str, numpy.typing.NDArray[Any]]: ...
