"""The part of Habitat's interface that VLN-CE's evaluators call, without Habitat.

>>> from enfilade import habitat
>>> env = habitat.Env(habitat.Config("data", task="r2r-ce", split="val_unseen"))
>>> seen = env.reset()
>>> while not env.episode_over:
...     seen = env.step(agent(seen))
>>> env.get_metrics()["spl"]

Everything here is in Habitat's frame, metres: x as in our world frame, y up, z as our -y. An agent faces
-z; rotations about +y are positive to the left. Differences from Habitat 0.1.7, call by call:
docs/python_continuous.md.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from enfilade._arguments import whole
from enfilade._continuous import (
    ContinuousAction,
    ContinuousEpisodes,
    ContinuousSimulator,
    EpisodeStatus,
    continuous_episodes,
)
from enfilade._continuous import ContinuousEpisode as _Episode
from enfilade._errors import ArgumentError

__all__ = [
    "ACTIONS",
    "AgentState",
    "Config",
    "Env",
    "Episode",
    "Goal",
    "Instruction",
    "Quaternion",
    "Simulator",
    "from_habitat",
    "to_habitat",
]

ACTIONS = {
    "STOP": 0,
    "MOVE_FORWARD": 1,
    "TURN_LEFT": 2,
    "TURN_RIGHT": 3,
    "LOOK_UP": 4,
    "LOOK_DOWN": 5,
}
"""Habitat's names of the actions."""


def to_habitat(points: ArrayLike) -> NDArray[Any]:
    """Points (..., 3) of our world frame in Habitat's: (x, y, z) becomes (x, z, -y)."""
    p = np.asarray(points)
    return np.stack([p[..., 0], p[..., 2], -p[..., 1]], axis=-1)


def from_habitat(points: ArrayLike) -> NDArray[Any]:
    """The inverse of to_habitat(): (x, y, z) becomes (x, -z, y)."""
    p = np.asarray(points)
    return np.stack([p[..., 0], -p[..., 2], p[..., 1]], axis=-1)


@dataclass(frozen=True)
class Quaternion:
    """A rotation with the interface of the package numpy-quaternion: w, x, y, z, real, imag, inverse(), and
    products of two."""

    w: float
    x: float
    y: float
    z: float

    @classmethod
    def of_heading(cls, heading: float) -> Quaternion:
        """The rotation of our heading: radians, clockwise seen from above; 0 faces -z."""
        return cls(math.cos(heading / 2), 0.0, -math.sin(heading / 2), 0.0)

    @property
    def heading(self) -> float:
        """Our heading, radians, [0, 2 pi): the direction that the agent faces, seen from above."""
        east = -2 * (self.x * self.z + self.w * self.y)
        ahead = 1 - 2 * (self.x * self.x + self.y * self.y)
        return math.atan2(east, ahead) % (2 * math.pi)

    @property
    def real(self) -> float:
        """w."""
        return self.w

    @property
    def imag(self) -> NDArray[np.float64]:
        """(3,): x, y, z."""
        return np.array([self.x, self.y, self.z])

    @property
    def components(self) -> NDArray[np.float64]:
        """(4,): w, x, y, z."""
        return np.array([self.w, self.x, self.y, self.z])

    def inverse(self) -> Quaternion:
        """The inverse rotation, for a quaternion of length 1."""
        return Quaternion(self.w, -self.x, -self.y, -self.z)

    def __mul__(self, other: Any) -> Quaternion:
        a, b = self, other
        return Quaternion(
            a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        )


def _quaternion(rotation: Any) -> Quaternion:
    """A Quaternion from an object with w, x, y, z, or from four numbers x, y, z, w."""
    if all(hasattr(rotation, name) for name in "wxyz"):
        numbers = [float(getattr(rotation, name)) for name in "wxyz"]
    else:
        values = np.asarray(rotation, np.float64)
        if values.shape != (4,):
            raise ArgumentError(f"rotation: shape {values.shape}, not four numbers x, y, z, w")
        numbers = [float(values[3]), *map(float, values[:3])]
    length = math.sqrt(sum(number * number for number in numbers))
    if not math.isfinite(length) or length < 1e-6:
        raise ArgumentError(f"rotation {rotation!r}: a quaternion of length 1 is wanted")
    return Quaternion(*(number / length for number in numbers))


@dataclass(frozen=True)
class AgentState:
    """The agent's pose: position (3,) float32 of its feet, and its rotation about +y."""

    position: NDArray[np.float32]
    rotation: Quaternion


@dataclass(frozen=True)
class Config:
    """The configuration of an Env: plain data.

    Args:
        data: folder of the data set, with navigation meshes and episodes (`enfilade continuous`).
        task: "r2r-ce" or "rxr-ce".
        split: of the task's episodes.
        episodes_file: this file instead of the split's.
        max_episode_steps: actions after which an episode ends.
        simulator: options of ContinuousSimulator that differ from the task's.
        sensors: images in the observations: "rgb" (h, w, 3) uint8; "depth" (h, w, 1) float32, 0 to 1 for 0
            to max_depth.
        sizes: (width, height) of these images by name.
        hfov: their horizontal field of view, degrees.
        max_depth: metres.
        eyes: options of enfilade.eyes.Eyes: {"meshes": "mp3d", "up": "z"}; without "meshes" the data are
            synthetic homes.
    """

    data: Union[str, os.PathLike[str]]
    task: str = "r2r-ce"
    split: str = "val_unseen"
    episodes_file: Optional[str] = None
    max_episode_steps: int = 500
    simulator: dict[str, Any] = field(default_factory=dict)
    sensors: tuple[str, ...] = ()
    sizes: dict[str, tuple[int, int]] = field(default_factory=dict)
    hfov: float = 90
    max_depth: float = 10
    eyes: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Instruction:
    """An episode's instruction, under VLN-CE's names."""

    instruction_text: str
    instruction_tokens: Optional[list[int]]
    instruction_id: Optional[str]
    language: Optional[str]


@dataclass(frozen=True)
class Goal:
    """A goal of an episode: position and radius in metres, Habitat's frame."""

    position: list[float]
    radius: Optional[float]


@dataclass(frozen=True)
class Episode:
    """An episode, under Habitat's and VLN-CE's names. Fields that test splits hide are None."""

    episode_id: str
    trajectory_id: str
    scene_id: str
    start_position: list[float]
    start_rotation: list[float]  #: x, y, z, w
    instruction: Instruction
    goals: Optional[list[Goal]]
    reference_path: Optional[list[list[float]]]
    info: dict[str, Any]
    index: int  #: its index in Env.all_episodes


class Simulator:
    """Env.sim: one agent in the building of the current episode."""

    def __init__(self, native: ContinuousSimulator) -> None:
        self._native = native
        self._scan: Optional[str] = None

    @property
    def native(self) -> ContinuousSimulator:
        """The underlying simulator with one agent, in our world frame."""
        return self._native

    @property
    def previous_step_collided(self) -> bool:
        """Whether a wall shortened the last step."""
        return bool(self._native.state.collided[0])

    def get_agent_state(self, agent_id: int = 0) -> AgentState:
        """The agent's pose. Raises ArgumentError before Env.reset(), or for another agent than 0."""
        self._building(agent_id)
        state = self._native.state
        position = to_habitat(state.position[0]).astype(np.float32)
        return AgentState(position, Quaternion.of_heading(float(state.heading[0])))

    def set_agent_state(
        self, position: ArrayLike, rotation: Any, agent_id: int = 0, reset_sensors: bool = True
    ) -> bool:
        """Moves the agent within the building. Returns False, without effect, if there is no floor within
        0.5 m. The episode continues, and no action is counted.

        Args:
            position: (3,) metres.
            rotation: a Quaternion, numpy-quaternion's, or x, y, z, w. Only its part about +y counts.
            reset_sensors: no effect: sensors have no state.

        Raises ArgumentError for numbers that are not finite, an invalid rotation, or before Env.reset().
        """
        scan = self._building(agent_id)
        point = from_habitat(np.asarray(position, np.float64))
        heading = _quaternion(rotation).heading
        if not np.isfinite(point).all():
            raise ArgumentError(f"position {position!r}: finite numbers are wanted")
        aside, above_below = self._native.config["start_reach"]
        if self._native.nearest(scan, point, aside=aside, above_below=above_below) is None:
            return False
        self._native.new_episode(0, scan, point, heading, float(self._native.state.elevation[0]))
        return True

    def geodesic_distance(
        self, position_a: ArrayLike, position_b: ArrayLike, episode: Optional[Episode] = None
    ) -> float:
        """The length of the shortest path on the floor, metres; inf if there is none.

        Args:
            position_a: (3,) metres.
            position_b: (3,) metres, or (m, 3): then the nearest of them.
            episode: no effect: nothing is cached between calls.
        """
        ends = from_habitat(np.asarray(position_b, np.float64))
        start = from_habitat(np.asarray(position_a, np.float64))
        return self._native.geodesic_distance(self._building(), start, ends)

    def get_straight_shortest_path_points(
        self, position_a: ArrayLike, position_b: ArrayLike
    ) -> list[NDArray[np.float32]]:
        """The points of the shortest path, (3,) metres each, both ends included; [] if there is none."""
        start = from_habitat(np.asarray(position_a, np.float64))
        end = from_habitat(np.asarray(position_b, np.float64))
        path = self._native.geodesic_path(self._building(), start, end)
        return [] if path is None else list(to_habitat(path).astype(np.float32))

    def is_navigable(self, point: ArrayLike) -> bool:
        """Whether an agent can stand there: the floor is within 2 cm sideways and 0.5 m vertically."""
        place = from_habitat(np.asarray(point, np.float64))
        return self._native.nearest(self._building(), place, aside=0.02) is not None

    def snap_point(self, point: ArrayLike) -> NDArray[np.float32]:
        """The nearest point of the floor within 2 m, (3,); (nan, nan, nan) if there is none."""
        place = from_habitat(np.asarray(point, np.float64))
        found = self._native.nearest(self._building(), place, aside=2.0, above_below=2.0)
        return np.asarray(to_habitat(found) if found is not None else [np.nan] * 3, np.float32)

    def _building(self, agent_id: int = 0) -> str:
        if agent_id != 0:
            raise ArgumentError(f"agent_id {agent_id}: there is one agent, 0")
        if self._scan is None:
            raise ArgumentError("sim: Env.reset() has to come first")
        return self._scan


class Env:
    """One agent in the episodes of a split, one after the other, with habitat.Env's interface.

    reset() begins the next episode in the order of `episodes`; the first follows the last.
    """

    def __init__(self, config: Config) -> None:
        self._config = config
        if whole("max_episode_steps", config.max_episode_steps) < 1:
            raise ArgumentError("max_episode_steps 0: at least 1 is wanted")
        self._set: ContinuousEpisodes = continuous_episodes(
            config.data, config.task, config.split, file=config.episodes_file
        )
        # Env counts the steps itself: set_agent_state() resets the simulator's count.
        options = {**config.simulator, "most_steps": 2**32 - 1}
        self._native = ContinuousSimulator(config.data, config.task, **options)
        self._sim = Simulator(self._native)
        self._actions = 4 if config.task == "r2r-ce" else 6
        self._all = [_episode(i, self._set[i]) for i in range(len(self._set))]
        self._episodes = list(self._all)
        self._next = 0
        self._current: Optional[Episode] = None
        self._forced = False
        self._over = True
        self._eyes = _eyes_of(config)
        self._walk: list[NDArray[np.float32]] = []
        self._did: list[int] = []
        self._collided: list[bool] = []

    @property
    def sim(self) -> Simulator:
        """The simulator: the agent's pose, and distances."""
        return self._sim

    @property
    def all_episodes(self) -> list[Episode]:
        """All episodes of the file, whatever the value of `episodes`."""
        return list(self._all)

    @property
    def episodes(self) -> list[Episode]:
        """The episodes of reset(). If you set it, reset() begins with the first. Raises ArgumentError for
        an empty list."""
        return self._episodes

    @episodes.setter
    def episodes(self, episodes: list[Episode]) -> None:
        if not episodes:
            raise ArgumentError("episodes: none, at least one is wanted")
        self._episodes, self._next = list(episodes), 0

    @property
    def number_of_episodes(self) -> int:
        """The length of `episodes`."""
        return len(self._episodes)

    @property
    def current_episode(self) -> Episode:
        """The episode that runs, or has just ended. If you set it, the next reset() begins it. Raises
        ArgumentError before reset()."""
        if self._current is None:
            raise ArgumentError("current_episode: reset() has to come first")
        return self._current

    @current_episode.setter
    def current_episode(self, episode: Episode) -> None:
        self._current, self._forced = episode, True

    @property
    def episode_over(self) -> bool:
        """Whether the episode has ended, by STOP or max_episode_steps; True before reset()."""
        return self._over

    def reset(self) -> dict[str, Any]:
        """Begins the next episode and returns its observations. Raises ArgumentError if its start has no
        floor."""
        if self._forced and self._current is not None:
            episode, self._forced = self._current, False
        else:
            episode = self._episodes[self._next % len(self._episodes)]
            self._next += 1
        own = self._set[episode.index]
        self._native.new_episode(0, own.scan, own.start, own.heading)
        self._sim._scan, self._current, self._over = own.scan, episode, False
        self._walk, self._did, self._collided = [self._native.state.position[0].copy()], [], []
        return self._observations()

    def step(self, action: Any) -> dict[str, Any]:
        """Executes an action: its number, its name (ACTIONS), or {"action": either}. Raises ArgumentError
        for an unknown action, or if the episode has ended."""
        if self._over:
            raise ArgumentError("step(): the episode is over; reset() has to come first")
        number = self._number(action)
        state = self._native.step([number])
        self._did.append(number)
        self._collided.append(bool(state.collided[0]))
        self._walk.append(state.position[0].copy())
        stopped = state.episode[0] == EpisodeStatus.STOPPED
        self._over = bool(stopped) or len(self._did) >= self._config.max_episode_steps
        return self._observations()

    def get_metrics(self) -> dict[str, Any]:
        """VLN-CE's measures of the trajectory so far; empty if the goal is hidden. `collisions` is
        {"count", "is_collision"}, as in Habitat. `position` is {"position", "distance"}, as in VLN-CE, with
        one entry for the start and one per action."""
        episode = self.current_episode
        if episode.goals is None:
            return {}
        score, distances = self._set._score(
            self._native, episode.index, np.array(self._walk), self._did, self._collided
        )
        metrics: dict[str, Any] = dict(score)
        metrics["collisions"] = {
            "count": sum(self._collided),
            "is_collision": bool(self._collided and self._collided[-1]),
        }
        metrics["position"] = {
            "position": to_habitat(np.array(self._walk)).tolist(),
            "distance": distances.tolist(),
        }
        return metrics

    def seed(self, seed: int) -> None:
        """No effect: nothing here is random."""
        whole("seed", seed, 2**64 - 1)

    def close(self) -> None:
        """No effect: memory is freed with the object."""

    def __enter__(self) -> Env:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def _number(self, action: Any) -> int:
        wanted = action["action"] if isinstance(action, dict) else action
        if isinstance(wanted, str):
            if wanted not in ACTIONS:
                raise ArgumentError(f"action '{wanted}': one of {', '.join(ACTIONS)} is wanted")
            wanted = ACTIONS[wanted]
        number = whole("action", wanted)
        if number >= self._actions:
            names = ", ".join(list(ACTIONS)[: self._actions])
            raise ArgumentError(f"action {number}: {self._config.task} has {names}")
        return int(ContinuousAction(number))

    def _observations(self) -> dict[str, Any]:
        episode = self.current_episode
        state = self._sim.get_agent_state()
        turn = -float(self._native.state.heading[0])  # Habitat's, about +y
        return {
            "instruction": {
                "text": episode.instruction.instruction_text,
                "tokens": episode.instruction.instruction_tokens,
                "trajectory_id": episode.trajectory_id,
            },
            "position": state.position,
            "heading": np.array([math.remainder(turn, 2 * math.pi)], np.float32),
            **self._pictures(),
        }

    def _pictures(self) -> dict[str, NDArray[Any]]:
        seen: dict[str, NDArray[Any]] = {}
        for sensor in self._config.sensors:
            width, height = self._config.sizes.get(sensor, (224, 224) if sensor == "rgb" else (256, 256))
            vfov = 2 * math.atan(math.tan(math.radians(self._config.hfov) / 2) * height / width)
            drawn: NDArray[Any] = self._eyes.render_agents(
                self._native, layers=(sensor,), size=(width, height), vfov=vfov
            )[sensor][0]
            if sensor == "depth":
                drawn = np.clip(drawn[..., None] / np.float32(self._config.max_depth), 0, 1)
            seen[sensor] = drawn
        return seen


def _eyes_of(config: Config) -> Any:
    for sensor in config.sensors:
        if sensor not in ("rgb", "depth"):
            raise ArgumentError(f"sensors '{sensor}': any of rgb, depth are wanted")
    if not config.sensors:
        return None
    from enfilade.eyes import Eyes  # loads a ray tracer

    return Eyes(None if "meshes" in config.eyes else config.data, **config.eyes)


def _episode(index: int, own: _Episode) -> Episode:
    words = Instruction(
        own.instruction,
        None if own.tokens is None else list(own.tokens),
        own.instruction_id,
        own.language,
    )
    goals = own.goals and [Goal(to_habitat(g.position).tolist(), g.radius) for g in own.goals]
    path = None if own.reference_path is None else to_habitat(own.reference_path).tolist()
    info = {} if own.geodesic_distance is None else {"geodesic_distance": own.geodesic_distance}
    return Episode(
        own.id, own.trajectory_id, own.scene, to_habitat(own.start).tolist(), list(own.rotation), words,
        goals or None, path, info, index,
    )  # fmt: skip
