"""The batched simulator, with names; the core takes indices."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from enfilade._arguments import MOST, whole
from enfilade._core import BatchSimulator, Graphs, ViewArrays
from enfilade._errors import ArgumentError

if TYPE_CHECKING:
    from typing_extensions import TypeGuard

Names = Union[Sequence[str], ArrayLike]


@dataclass(frozen=True)
class State:
    """The state of n agents: arrays over the simulator's memory. Later calls overwrite them; copy what
    you want to keep. Row k of `navigable_*` has navigable_count[k] entries, the rest is undefined. Entry
    0 is the current viewpoint; the others follow by rising angle from the centre of the image.
    """

    scan: NDArray[np.uint32]  #: (n,) index into Graphs.scans
    viewpoint: NDArray[np.uint32]  #: (n,) index into Graph.viewpoints
    heading: NDArray[np.float64]  #: (n,) radians, [0, 2 pi]
    elevation: NDArray[np.float64]  #: (n,) radians
    view_index: NDArray[np.uint32]  #: (n,) 0..35 when discretized, else 0
    step: NDArray[np.uint32]  #: (n,) actions since the start
    navigable_count: NDArray[np.uint32]  #: (n,)
    navigable_viewpoint: NDArray[np.uint32]  #: (n, m)
    navigable_rel_heading: NDArray[np.float64]  #: (n, m) radians, right positive
    navigable_rel_elevation: NDArray[np.float64]  #: (n, m) radians, up positive
    navigable_distance: NDArray[np.float64]  #: (n, m) metres


@dataclass(frozen=True)
class Candidate:
    """A neighbour of a viewpoint, and that of the 36 views whose centre is nearest to it: the result of
    `make_candidate` in EnvDrop and its descendants."""

    viewpoint: str
    ix: int  #: its index in Graph.viewpoints
    view_index: int  #: 0..35 (their pointId)
    index: int  #: into that view's navigable list (their idx)
    normalized_heading: float  #: heading towards it, world frame, radians, not wrapped
    normalized_elevation: float  #: radians above the horizon
    rel_heading: float  #: from the view's centre, radians
    rel_elevation: float  #: from the view's centre, radians
    angle: float  #: from the view's centre, radians (their distance)
    distance: float  #: straight line, metres
    position: tuple[float, float, float]  #: metres, world frame


@dataclass(frozen=True)
class CandidateTable:
    """Candidates of many viewpoints, one per row, ordered by scan and viewpoint.

    >>> rows = table.rows(scan, viewpoint)       # a slice, of one viewpoint
    >>> table.view_index[rows], table.normalized_heading[rows]
    """

    scan: NDArray[np.uint32]  #: (n,) index into Graphs.scans
    viewpoint: NDArray[np.uint32]  #: (n,) index of the viewpoint
    neighbour: NDArray[np.uint32]  #: (n,) index of its neighbour
    view_index: NDArray[np.uint32]  #: (n,) 0..35
    index: NDArray[np.uint32]  #: (n,) into that view's navigable list
    normalized_heading: NDArray[np.float64]  #: (n,) radians
    normalized_elevation: NDArray[np.float64]  #: (n,) radians
    rel_heading: NDArray[np.float64]  #: (n,) radians
    rel_elevation: NDArray[np.float64]  #: (n,) radians
    angle: NDArray[np.float64]  #: (n,) radians
    distance: NDArray[np.float64]  #: (n,) metres
    #: (k + 1,) per scan of the table: the index in `offsets` of its first viewpoint.
    scan_offsets: NDArray[np.int64]
    #: (v + 1,) per viewpoint of these scans, excluded ones too: the row of its first candidate. The
    #: next entry ends its rows.
    offsets: NDArray[np.int64]
    #: The scans of the table, in order, and the graphs with their names.
    scans: tuple[int, ...]
    graphs: Graphs

    def rows(self, scan: Union[str, int], viewpoint: Union[str, int]) -> slice:
        """The rows of one viewpoint, by names or indices. Raises UnknownNameError, and ArgumentError
        for a scan that is not in the table or an index out of range."""
        s = self.graphs.index(scan) if isinstance(scan, str) else whole("scan", scan)
        if s not in self._places:
            raise ArgumentError(f"scan {scan!r}: not one of the {len(self.scans)} of this table")
        place = self._places[s]
        first, last = int(self.scan_offsets[place]), int(self.scan_offsets[place + 1])
        if isinstance(viewpoint, str):
            v = self.graphs[self.graphs.scans[s]].index(viewpoint)
        else:
            v = whole("viewpoint", viewpoint, last - first - 1)
        return slice(int(self.offsets[first + v]), int(self.offsets[first + v + 1]))

    @cached_property
    def _places(self) -> dict[int, int]:
        return {scan: place for place, scan in enumerate(self.scans)}


class Simulator:
    """Moves a batch of agents through the buildings of a `Graphs`. Opens no images.

    An action moves first, then turns. A call that fails moves no agent. Use one simulator per thread;
    they may share a Graphs. All calls release the GIL.

    Args:
        graphs: the buildings.
        batch_size: agents, n.
        width, height: of the camera, pixels. With `vfov` they determine what is navigable.
        vfov: vertical field of view, radians.
        discretized: 36 views of 30 degrees, as in Room-to-Room (only the sign of a change counts);
            otherwise any heading, and elevations within `elevation_limits`.
        restricted: only neighbours in the horizontal field of view are navigable.
        field_of_view: "linear" is the old simulator's, on which published results depend (80 degrees
            with the default camera); "perspective" is the image's (75.2).
        elevation_limits: radians, -pi/2 < min < 0 < max < pi/2.
        random_starts: "uniform", or "mattersim" for the old simulator's random numbers.
        seed: for new_random_episodes().
        max_navigable: columns of `State.navigable_*`, m; Matterport3D needs 14.
        threads: for step(); 0: all cores. Never changes a result.

    Attributes:
        state: a State, arrays over the simulator's memory; every call that moves agents returns it.
        graphs, batch_size, width, height, vfov: as given. For other settings make a new simulator,
            which takes microseconds.

    A pickled or copied simulator has the same settings, without episodes. Raises ArgumentError for an
    invalid value, TypeError for a wrong type.
    """

    def __init__(
        self,
        graphs: Graphs,
        batch_size: int = 1,
        *,
        width: int = 640,
        height: int = 480,
        vfov: float = math.radians(60),
        discretized: bool = True,
        restricted: bool = True,
        field_of_view: str = "linear",
        elevation_limits: tuple[float, float] = (-0.94, 0.94),
        random_starts: str = "uniform",
        seed: int = 1,
        max_navigable: int = 32,
        threads: int = 1,
    ) -> None:
        if not isinstance(graphs, Graphs):
            raise TypeError(f"graphs: a {type(graphs).__name__}; enfilade.Graphs(folder) is wanted")
        _check_word("field_of_view", field_of_view, ("linear", "perspective"))
        _check_word("random_starts", random_starts, ("uniform", "mattersim"))
        if len(elevation_limits) != 2:
            raise ArgumentError(f"elevation_limits {elevation_limits}: (min, max) is wanted")
        self.graphs = graphs
        self.batch_size = whole("batch_size", batch_size)
        self.width, self.height, self.vfov = whole("width", width), whole("height", height), vfov
        self._core = BatchSimulator(
            graphs,
            batch_size=self.batch_size,
            width=self.width,
            height=self.height,
            vfov=vfov,
            discretized=discretized,
            restricted=restricted,
            linear_view=field_of_view == "linear",
            elevation_limits=elevation_limits,
            mattersim_starts=random_starts == "mattersim",
            seed=whole("seed", seed, 2**64 - 1),
            max_navigable=whole("max_navigable", max_navigable),
            threads=threads,
        )
        self.state = State(**self._core.state_arrays())
        s = self.state
        self._views = ViewArrays(s.scan, s.viewpoint, s.heading, s.elevation)  # for a Renderer
        self._nothing = np.zeros(self.batch_size)
        self._begun = False  # whether _check_begun() has seen an episode of every agent
        self._known: dict[str, tuple[list[str], list[tuple[float, float, float]]]] = {}
        self._options = {
            "width": self.width,
            "height": self.height,
            "vfov": vfov,
            "discretized": discretized,
            "restricted": restricted,
            "field_of_view": field_of_view,
            "elevation_limits": elevation_limits,
            "random_starts": random_starts,
            "seed": seed,
            "max_navigable": max_navigable,
            "threads": threads,
        }

    def __reduce__(self) -> tuple[Any, ...]:
        return _make_again, (type(self), self.graphs, self.batch_size, self._options)

    def new_episodes(
        self,
        scans: Names,
        viewpoints: Names,
        headings: ArrayLike = 0.0,
        elevations: ArrayLike = 0.0,
    ) -> State:
        """Starts an episode for every agent.

        Args:
            scans, viewpoints: (n,) names, or indices into Graphs.scans and Graph.viewpoints.
            headings: (n,) radians clockwise from +y, or one number for all.
            elevations: (n,) radians above the horizon, or one number for all.

        Raises UnknownNameError for an unknown name, ArgumentError for other invalid values; then
        no agent has moved.
        """
        scan = scan_indices(self.graphs, scans)
        viewpoint = viewpoint_indices(self.graphs, scan, viewpoints)
        self._core.new_episodes(
            scan, viewpoint, self._reals("headings", headings), self._reals("elevations", elevations)
        )
        return self.state

    def new_episode(
        self, agent: int, scan: str, viewpoint: str, heading: float = 0.0, elevation: float = 0.0
    ) -> State:
        """Starts an episode for one agent, 0 to n - 1; the others do not change. Angles in radians.
        Raises UnknownNameError for an unknown name, ArgumentError for other invalid values."""
        place = self.graphs.locate(scan, viewpoint)
        self._core.new_episode(whole("agent", agent), place[0], place[1], heading, elevation)
        return self.state

    def new_random_episodes(self, scans: Names) -> State:
        """Starts an episode for every agent: random viewpoint and heading in its scan, elevation 0.

        Args:
            scans: (n,) names or indices.

        Raises UnknownNameError, ArgumentError.
        """
        self._core.new_random_episodes(scan_indices(self.graphs, scans))
        return self.state

    def step(
        self,
        indices: ArrayLike,
        heading_changes: Optional[ArrayLike] = None,
        elevation_changes: Optional[ArrayLike] = None,
    ) -> State:
        """One action per agent: moves to entry `indices` of its navigable list (0: stays), then turns.

        Args:
            indices: (n,) integers.
            heading_changes: (n,) radians, right positive; None: no turn.
            elevation_changes: (n,) radians, up positive; None: no turn.

        Raises ArgumentError naming agent, value and range, TypeError for other types than integers; then
        no agent has moved.
        """
        self._core.step(
            _indices("indices", indices),
            self._turns("heading_changes", heading_changes),
            self._turns("elevation_changes", elevation_changes),
        )
        return self.state

    def viewpoint_ids(self) -> list[str]:
        """The agents' viewpoints, by name. Raises ArgumentError for an agent without an episode."""
        self._check_begun()
        scans = self.graphs.scans
        places = list(zip(self.state.scan.tolist(), self.state.viewpoint.tolist()))
        names = {s: self.graphs[scans[s]].viewpoints for s, _ in places}
        return [names[s][v] for s, v in places]

    def candidates(self, scan: str, viewpoint: str) -> list[Candidate]:
        """The neighbours of a viewpoint, each in the best of 36 views, in the order of a turn through
        views 0 to 35. Does not change the agents.

        Raises UnknownNameError, for excluded viewpoints too.
        """
        place = self.graphs.locate(scan, viewpoint)
        names, positions = self._places_of(scan)
        found = []
        for ix, view, index, heading, elevation, right, up, angle, metres in self._core.candidates(
            *place
        ):
            found.append(
                Candidate(
                    names[ix], ix, view, index, heading, elevation, right, up, angle, metres,
                    positions[ix],
                )  # fmt: skip
            )
        return found

    def _places_of(self, scan: str) -> tuple[list[str], list[tuple[float, float, float]]]:
        """Ids and positions by index, cached: making the lists takes longer than finding candidates."""
        if scan not in self._known:
            graph = self.graphs[scan]
            self._known[scan] = (graph.viewpoints, [(x, y, z) for x, y, z in graph.positions.tolist()])
        return self._known[scan]

    def all_candidates(self, scans: Optional[Names] = None) -> CandidateTable:
        """candidates() of every included viewpoint of these scans, given by name or index; None: all
        scans. Raises UnknownNameError, ArgumentError."""
        wanted = np.arange(len(self.graphs), dtype=np.uint32)
        if scans is not None:
            wanted = scan_indices(self.graphs, scans)
        if len(np.unique(wanted)) != len(wanted):
            raise ArgumentError("scans: one is named twice")
        integers, reals = self._core.candidate_arrays(wanted)
        names = self.graphs.scans
        sizes = [len(self.graphs[names[scan]]) for scan in wanted]
        scan_offsets = np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)]).astype(np.int64)
        place = np.zeros(len(names), np.int64)
        place[wanted] = np.arange(len(wanted))
        counts = np.bincount(
            scan_offsets[place[integers[:, 0]]] + integers[:, 1], minlength=int(scan_offsets[-1])
        )
        offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        columns: list[Any] = [np.ascontiguousarray(c) for c in (*integers.T, *reals.T)]
        columns += [scan_offsets, offsets, tuple(wanted.tolist()), self.graphs]
        return CandidateTable(*columns)

    def _check_begun(self) -> None:
        """Raises ArgumentError naming an agent without an episode."""
        if self._begun:
            return
        if not self.state.navigable_count.all():
            agent = int(np.argmin(self.state.navigable_count))
            raise ArgumentError(f"agent {agent}: no episode was started")
        self._begun = True

    def _turns(self, name: str, values: Optional[ArrayLike]) -> NDArray[np.float64]:
        return self._nothing if values is None else self._reals(name, values)

    def _reals(self, name: str, values: ArrayLike) -> NDArray[np.float64]:
        if type(values) is np.ndarray and values.dtype == np.float64 and values.ndim == 1:
            return values
        try:
            array = np.asarray(values, np.float64)
        except (TypeError, ValueError) as error:
            raise ArgumentError(f"{name}: numbers are wanted: {error}") from error
        if array.ndim == 0:
            return np.full(self.batch_size, array)
        return np.ascontiguousarray(_row(name, array))


def _make_again(kind: Any, first: Any, second: Any, options: dict[str, Any]) -> Any:
    """For unpickling classes with keyword options."""
    return kind(first, second, **options)


def scan_indices(graphs: Graphs, scans: Names) -> NDArray[np.uint32]:
    """(n,) indices of scans given by name or index."""
    if _are_indices(scans):
        return scans
    array = np.atleast_1d(scans)
    if _are_texts(array):
        return np.array([graphs.index(name) for name in _row("scans", array).tolist()], np.uint32)
    return _indices("scans", array, "integers or names")


def viewpoint_indices(
    graphs: Graphs, scans: NDArray[np.uint32], viewpoints: Names
) -> NDArray[np.uint32]:
    """(n,) indices of viewpoints given by name or index, each in its scan."""
    if _are_indices(viewpoints):
        return viewpoints
    array = np.atleast_1d(viewpoints)
    if not _are_texts(array):
        return _indices("viewpoints", array, "integers or names")
    if _row("viewpoints", array).shape != scans.shape:
        raise ArgumentError(f"viewpoints: {len(array)} for {len(scans)} scans")
    if len(scans) and scans.max() >= len(graphs):
        raise ArgumentError(f"scans: index {scans.max()}: 0 to {len(graphs) - 1} are allowed")
    names = graphs.scans
    return np.array(
        [graphs.locate(names[s], v)[1] for s, v in zip(scans.tolist(), array.tolist())], np.uint32
    )


def _are_indices(values: Union[Names, ArrayLike]) -> TypeGuard[NDArray[np.uint32]]:
    """Whether they have State's type and need no conversion, which would take microseconds."""
    return type(values) is np.ndarray and values.dtype == np.uint32 and values.ndim == 1


def _are_texts(array: NDArray[Any]) -> bool:
    """Whether the elements are strings: NumPy's, or Python's as objects, as in data frames."""
    objects = array.dtype.kind == "O" and array.size > 0
    return array.dtype.kind == "U" or (objects and all(isinstance(v, str) for v in array.flat))


def _row(name: str, array: NDArray[Any]) -> NDArray[Any]:
    if array.ndim != 1:
        raise ArgumentError(f"{name}: shape {array.shape}: a row is wanted, an element an agent")
    return array


def _indices(name: str, values: ArrayLike, wanted: str = "integers") -> NDArray[np.uint32]:
    if _are_indices(values):
        return values
    array = _row(name, np.atleast_1d(values))
    if array.size == 0:  # an empty list has no integer type
        return np.zeros(0, np.uint32)
    if array.dtype.kind not in "iub":
        raise TypeError(f"{name} of type {array.dtype}: {wanted} are wanted")
    found = np.ascontiguousarray(array, np.uint32)
    if array.dtype != np.uint32 and (found != array).any():
        agent = int(np.argmax(found != array))
        raise ArgumentError(f"{name}: {array[agent]} of agent {agent}: 0 to {MOST} are allowed")
    return found


def _check_word(name: str, word: str, allowed: tuple[str, ...]) -> None:
    if word not in allowed:
        raise ArgumentError(f"{name} '{word}': one of {', '.join(allowed)} is wanted")
