"""Continuous navigation on navigation meshes: VLN-CE's episodes, and the batched simulator."""

from __future__ import annotations

import enum
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from enfilade._arguments import whole
from enfilade._core import BatchContinuous, ContinuousSet, FloorSet, continuous_benchmarks
from enfilade._errors import ArgumentError, FileError

PathLike = Union[str, "os.PathLike[str]"]
Point = Tuple[float, float, float]
MOST_AGENTS = 2**20  # more would be a mistake, and fill the memory


def to_habitat(points: ArrayLike) -> NDArray[Any]:
    """Points (..., 3) of our world frame in Habitat's, y up: (x, y, z) becomes (x, z, -y)."""
    p = np.asarray(points)
    return np.stack([p[..., 0], p[..., 2], -p[..., 1]], axis=-1)


def from_habitat(points: ArrayLike) -> NDArray[Any]:
    """The inverse of to_habitat(): (x, y, z) becomes (x, -z, y)."""
    p = np.asarray(points)
    return np.stack([p[..., 0], -p[..., 2], p[..., 1]], axis=-1)


class ContinuousAction(enum.IntEnum):
    """Actions, with VLN-CE's numbers. R2R-CE has the first four, RxR-CE all."""

    STOP = 0
    FORWARD = 1
    LEFT = 2
    RIGHT = 3
    LOOK_UP = 4
    LOOK_DOWN = 5


class EpisodeStatus(enum.IntEnum):
    """The status of an agent's episode: values of ContinuousState.episode."""

    WALKING = 0
    STOPPED = 1  #: by the action STOP
    CUT_SHORT = 2  #: after most_steps actions


@dataclass(frozen=True)
class ContinuousState:
    """The state of n agents: read-only arrays over the simulator's memory. Later calls overwrite them;
    copy what you want to keep."""

    building: NDArray[np.uint32]  #: (n,) index into ContinuousSimulator.scans
    position: NDArray[np.float32]  #: (n, 3) the feet, metres, world frame (z up)
    heading: NDArray[np.float64]  #: (n,) radians clockwise from +y, [0, 2 pi)
    elevation: NDArray[np.float64]  #: (n,) the camera's, radians, up positive
    steps: NDArray[np.uint32]  #: (n,) actions since the start
    collisions: NDArray[np.uint32]  #: (n,) forward steps that a wall shortened
    collided: NDArray[np.bool_]  #: (n,) whether the last action was a collision
    episode: NDArray[np.uint8]  #: (n,) EpisodeStatus
    off_floor: NDArray[np.float32]  #: (n,) metres from the start's position to the floor under it


@dataclass(frozen=True)
class ContinuousGoal:
    """A goal of an episode."""

    position: Point  #: metres, world frame
    radius: Optional[float]  #: metres; 3 in all released files


@dataclass(frozen=True)
class ExpertWalk:
    """An expert's trajectory in an episode (VLN-CE's `_gt` files)."""

    locations: NDArray[np.float64]  #: (k, 3) metres, world frame: the start, then one per forward step
    actions: NDArray[np.uint8]  #: (m,) ContinuousAction; the last one is STOP


@dataclass(frozen=True)
class ContinuousEpisode:
    """An episode in continuous space. Fields that test splits hide are None. Points are in the world
    frame, metres, z up; files have them in Habitat's."""

    id: str  #: VLN-CE's episode_id
    trajectory_id: str  #: R2R's or RxR's path_id
    scene: str  #: as in the file: "mp3d/zsNo4HB9uLZ/zsNo4HB9uLZ.glb"
    scan: str
    instruction: str
    start: Point  #: the floor under the body
    heading: float  #: at the start, radians clockwise from +y, [0, 2 pi)
    rotation: tuple[float, float, float, float]  #: the same as in the file: Habitat's x, y, z, w
    goals: Optional[tuple[ContinuousGoal, ...]]
    reference_path: Optional[NDArray[np.float64]]  #: (k, 3) start to goal
    geodesic_distance: Optional[float]  #: from the start to the goal, metres, from the file
    language: Optional[str]  #: RxR-CE only: "en-IN"
    instruction_id: Optional[str]  #: RxR-CE only
    tokens: Optional[tuple[int, ...]]  #: R2R-CE only: ids of the file's vocabulary, padded


class ContinuousEpisodes(Sequence[ContinuousEpisode]):
    """The episodes of a split; continuous_episodes() makes one. A sequence, in the order of the file.

    task: "r2r-ce" or "rxr-ce"; split; file: their source.
    """

    def __init__(self, core: ContinuousSet, data: str, task: str, split: str, file: Optional[str]) -> None:
        self._core = core
        self._origin = (data, task, split, file)
        self.task, self.split = task, split

    @property
    def file(self) -> str:
        """The file of the episodes."""
        return self._core.file

    def __len__(self) -> int:
        return len(self._core)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        place = index + len(self) if index < 0 else index
        if not 0 <= place < len(self):
            raise IndexError(f"episode {index}: there are {len(self)}")
        row = self._core.episode(place)
        episode_id, trajectory_id, scene, scan, text, start, heading, rotation = row[:8]
        goals, path, metres, language, instruction_id, tokens = row[8:]
        found = None if goals is None else tuple(ContinuousGoal(*goal) for goal in goals)
        words = None if tokens is None else tuple(tokens)
        return ContinuousEpisode(
            episode_id, trajectory_id, scene, scan, text, start, heading, rotation, found, path, metres,
            language, instruction_id, words,
        )  # fmt: skip

    def __iter__(self) -> Iterator[ContinuousEpisode]:
        return (self[i] for i in range(len(self)))

    def find(self, episode_id: Union[str, int]) -> Optional[int]:
        """The index of an episode by its id; None if unknown."""
        return self._core.find(str(episode_id))

    def expert(self, index: int) -> Optional[ExpertWalk]:
        """The expert's trajectory in an episode; None if no file has it."""
        walk = self._core.expert(whole("episode", index, len(self) - 1))
        return None if walk is None else ExpertWalk(*walk)

    def score(
        self, simulator: ContinuousSimulator, index: int, positions: ArrayLike, actions: ArrayLike,
        collided: Optional[ArrayLike] = None,
    ) -> dict[str, float]:  # fmt: skip
        """VLN-CE's measures of a trajectory: path_length, distance_to_goal (metres), success,
        oracle_success, spl, ndtw, sdtw (0 to 1), steps_taken, collisions (a share of the actions), ...

        Args:
            simulator: has the navigation meshes on which distances are computed.
            index: the episode's index.
            positions: (m + 1, 3) metres, world frame: the start, then after each action.
            actions: (m,) ContinuousAction.
            collided: (m,) whether each action ended at a wall; None: unknown, then collisions is NaN.

        Raises ArgumentError for arrays of different lengths, or a hidden goal.
        """
        return self._score(simulator, index, positions, actions, collided)[0]

    def _score(
        self, simulator: ContinuousSimulator, index: int, positions: ArrayLike, actions: ArrayLike,
        collided: Optional[ArrayLike],
    ) -> tuple[dict[str, float], NDArray[np.float64]]:  # fmt: skip
        points = np.ascontiguousarray(positions, np.float32)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ArgumentError(f"positions: shape {points.shape}, not (m + 1, 3)")
        numbers = np.ascontiguousarray(actions, np.uint8)
        flags = np.zeros(0, np.uint8) if collided is None else np.ascontiguousarray(collided, np.uint8)
        place = whole("episode", index, len(self) - 1)
        return self._core.score_walk(simulator._floors, place, points, numbers, flags)

    def __reduce__(self) -> tuple[Any, ...]:
        return _load, self._origin


def _load(data: str, task: str, split: str, file: Optional[str]) -> ContinuousEpisodes:
    return ContinuousEpisodes(ContinuousSet(data, task, split, file), data, task, split, file)


def continuous_episodes(
    data: Optional[PathLike] = None,
    task: str = "r2r-ce",
    split: str = "val_unseen",
    *,
    file: Optional[PathLike] = None,
) -> ContinuousEpisodes:
    """Reads the episodes of a split of VLN-CE, and the experts' trajectories if there are any.

    Args:
        data: folder of the data set; None: the one that the environment variable ENFILADE_DATA names.
        task: "r2r-ce" or "rxr-ce".
        split: "train", "val_seen", "val_unseen", "test", ...
        file: this file instead, compressed or not; then there are no experts.

    Raises FileError naming every path that was tried, InvalidInput listing a file's faults,
    UnknownNameError for an unknown task.
    """
    folder = "" if file is not None and data is None else _data_folder(data)
    return _load(folder, task, split, None if file is None else os.fspath(file))


class ContinuousSimulator:
    """Moves a batch of agents through buildings, on their navigation meshes. Opens no images. The same
    starts and actions give the same bytes in any batch and with any number of threads.

    >>> sim = enfilade.ContinuousSimulator("data", "r2r-ce", batch_size=2)
    >>> sim.new_episodes([episode.scan] * 2, [episode.start] * 2, [episode.heading] * 2)
    >>> sim.step([1, 3])                                       # forward; right
    >>> sim.state.position                                     # (2, 3) metres

    Args:
        data: folder with `navmesh/TASK/SCAN.navmesh`, as `enfilade continuous` makes them; None: the one
            that the environment variable ENFILADE_DATA names.
        task: "r2r-ce" or "rxr-ce"; sets the defaults below: body, steps and turns.
        batch_size: agents, n; at most 2**20.
        navigation: a folder of navigation meshes instead of the data set's.
        navmesh: "enfilade" or "habitat", the floor that the folder must have, by `enfilade continuous
            --navmesh`; None: either.
        options: forward (metres, 0.25), turn (radians, 15 or 30 degrees), look (radians, 30 degrees),
            most_elevation (radians, 60 degrees), slide (along walls; otherwise agents stop there),
            eye_height (metres above the floor), most_steps (500), start_reach (metres that a start may
            be off the floor: sideways, and above or below), threads (1; 0: all cores).

    Attributes:
        state: a ContinuousState; every call that moves agents returns it.
        task, batch_size: as given. config: all options with their values.

    One thread at a time. A pickled or copied simulator has the same settings, without episodes. Raises
    FileError if there are no navigation meshes, ArgumentError for an invalid value.
    """

    def __init__(
        self,
        data: Optional[PathLike] = None,
        task: str = "r2r-ce",
        batch_size: int = 1,
        *,
        navigation: Optional[PathLike] = None,
        navmesh: Optional[str] = None,
        **options: Any,
    ) -> None:
        folder = navigation if navigation is not None else Path(_data_folder(data), "navmesh", task)
        if task not in TASKS:
            raise ArgumentError(f"task '{task}': one of {', '.join(TASKS)} is wanted")
        if navmesh not in (None, "enfilade", "habitat"):
            raise ArgumentError(f"navmesh {navmesh!r}: 'enfilade', 'habitat' or None is wanted")
        self._floors = FloorSet(os.fspath(folder))
        if navmesh is not None and navmesh != self.floor.split()[0]:
            raise ArgumentError(
                f"navmesh '{navmesh}': {os.fspath(folder)} has the floor {self.floor}; "
                f"`enfilade continuous DATA --navmesh {navmesh}` makes that one"
            )
        self._arguments = (data, task, batch_size, navigation, navmesh, options)
        self._core = BatchContinuous(
            self._floors, task, whole("batch_size", batch_size, MOST_AGENTS), options
        )
        self.task, self.batch_size = task, batch_size
        self.config: dict[str, Any] = self._core.config()
        self.state = ContinuousState(**self._core.state_arrays())
        self._asked: dict[int, tuple[int, int]] = {}  # by agent: step, teacher's action

    @property
    def scans(self) -> list[str]:
        """Names of the buildings with a navigation mesh."""
        return self._floors.scans

    @property
    def floor(self) -> str:
        """The floor's name, as in scores: "enfilade" or "habitat 0.3.3"."""
        return self._floors.floor

    def new_episodes(
        self,
        scans: Sequence[Union[str, int]],
        positions: ArrayLike,
        headings: ArrayLike,
        elevations: ArrayLike = 0.0,
    ) -> ContinuousState:
        """Starts an episode for every agent.

        Args:
            scans: (n,) names, or indices into `scans`.
            positions: (n, 3) the feet, metres, world frame. Until its first step an agent is exactly
                there, even slightly off the floor, as VLN-CE's starts are.
            headings: (n,) radians clockwise from +y, or one for all.
            elevations: (n,) radians, or one for all.

        Raises UnknownNameError for an unknown scan, ArgumentError naming the agent if no floor is in
        reach of its position. Then no episode has begun.
        """
        n = self.batch_size
        if isinstance(scans, str) or len(scans) != n:
            raise ArgumentError(f"scans: {n} names or indices are wanted")
        buildings = np.array([self._index(scan) for scan in scans], np.uint32)
        self._core.new_episodes(
            buildings, _points("positions", positions), _row(headings, n), _row(elevations, n)
        )
        self._asked.clear()
        return self.state

    def new_episode(
        self, agent: int, scan: Union[str, int], position: ArrayLike, heading: float, elevation: float = 0
    ) -> ContinuousState:
        """The same for one agent."""
        place = _point("position", position)
        self._core.new_episode(whole("agent", agent), self._index(scan), place, heading, elevation)
        self._asked.pop(agent, None)
        return self.state

    def step(self, actions: ArrayLike) -> ContinuousState:
        """One action per agent, (n,) of ContinuousAction. Agents whose episode has ended do not move.
        Raises ArgumentError for an invalid action or shape, TypeError for a type other than integers;
        then no agent has moved."""
        numbers = np.asarray(actions)
        if numbers.dtype.kind not in "iub":
            raise TypeError(f"actions of type {numbers.dtype}: integers are wanted")
        if numbers.shape != (self.batch_size,):
            raise ArgumentError(f"actions: shape {numbers.shape}, not ({self.batch_size},)")
        if numbers.size and (numbers.min() < 0 or numbers.max() > 255):
            raise ArgumentError("actions: 0 to 5 are allowed")
        self._core.step(np.ascontiguousarray(numbers, np.uint8))
        return self.state

    def geodesic_distance(
        self, scan: Union[str, int], start: ArrayLike, goals: ArrayLike, *, reach: float = 1.0
    ) -> float:
        """The length of the shortest path on the floor to the nearest of some goals, metres; inf if there
        is none.

        Args:
            start: (3,) metres, world frame.
            goals: (3,) or (m, 3) metres, world frame.
            reach: metres along each axis within which a point is moved to the nearest floor; a point
                without floor there is out of reach.
        """
        ends = _points("goals", np.atleast_2d(np.asarray(goals, np.float64)))
        return self._floors.distance(self._index(scan), _point("start", start), ends, reach)

    def geodesic_path(
        self, scan: Union[str, int], start: ArrayLike, goal: ArrayLike, *, reach: float = 1.0
    ) -> Optional[NDArray[np.float32]]:
        """The shortest path on the floor, (k, 3) metres, both ends included; None if there is none."""
        begin, end = _point("start", start), _point("goal", goal)
        return self._floors.path(self._index(scan), begin, end, reach)

    def nearest(
        self, scan: Union[str, int], point: ArrayLike, *, aside: float = 0.5, above_below: float = 1.0
    ) -> Optional[Point]:
        """The point of the floor nearest to `point`, metres, world frame; None if there is none within
        `aside` metres sideways and `above_below` metres vertically."""
        found = self._floors.nearest(self._index(scan), _point("point", point), aside, above_below)
        return None if found is None else found[0]

    def random_point(self, scan: Union[str, int], seed: int) -> Point:
        """A point of the floor, uniform by area seen from above; the same seed gives the same point."""
        return self._floors.random_point(self._index(scan), whole("seed", seed, 2**64 - 1))

    def areas(self, scan: Union[str, int]) -> list[float]:
        """Square metres of each connected part of the floor."""
        return self._floors.areas(self._index(scan))

    def follow(
        self, agent: int, points: ArrayLike, *, reached: float = 0.5, last_reached: float = 0.5
    ) -> None:
        """Sets the points that an agent's teacher follows, until the agent's next episode.

        Args:
            points: (m, 3) metres, world frame, in this order: an episode's reference_path.
            reached, last_reached: metres within which a point, and the last point, count as reached.

        Raises ArgumentError for an agent without an episode or points off the floor.
        """
        self._core.follow(whole("agent", agent), _points("points", points), reached, last_reached)
        self._asked.pop(agent, None)

    def expert_action(self, agent: int) -> ContinuousAction:
        """The teacher's next action, by the rule of VLN-CE's experts; STOP at the end. Call it before
        every step of the agent. Raises ArgumentError before follow()."""
        place = whole("agent", agent, self.batch_size - 1)
        step = int(self.state.steps[place])
        if self._asked.get(place, (-1, 0))[0] != step:
            self._asked[place] = (step, self._core.expert_action(place))
        return ContinuousAction(self._asked[place][1])

    def _index(self, scan: Union[str, int]) -> int:
        return self._floors.index(scan) if isinstance(scan, str) else whole("scan", scan)

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, self._arguments


TASKS: tuple[str, ...] = tuple(row[0] for row in continuous_benchmarks())


def _again(
    data: Optional[PathLike], task: str, batch_size: int, navigation: Optional[PathLike],
    navmesh: Optional[str], options: dict[str, Any],
) -> ContinuousSimulator:  # fmt: skip
    return ContinuousSimulator(
        data, task, batch_size, navigation=navigation, navmesh=navmesh, **options
    )


def _data_folder(data: Optional[PathLike]) -> str:
    folder = os.environ.get("ENFILADE_DATA") if data is None else os.fspath(data)
    if not folder:
        raise FileError("no folder was named, and the environment variable ENFILADE_DATA is not set")
    return folder


def _points(name: str, values: ArrayLike) -> NDArray[np.float64]:
    points = np.ascontiguousarray(values, np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ArgumentError(f"{name}: shape {points.shape}, not (n, 3)")
    return points


def _point(name: str, values: ArrayLike) -> NDArray[np.float64]:
    point = np.ascontiguousarray(values, np.float64)
    if point.shape != (3,):
        raise ArgumentError(f"{name}: shape {point.shape}, not (3,)")
    return point.reshape(1, 3)


def _row(values: ArrayLike, n: int) -> NDArray[np.float64]:
    return np.ascontiguousarray(np.broadcast_to(np.asarray(values, np.float64), (n,)))
