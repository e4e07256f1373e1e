"""The old simulator's interface: v0.2 (lists) and v0.1 (scalars)."""

from collections.abc import Sequence
from typing import Any, Union

from numpy.typing import NDArray

Angle = Any  # int, float, NumPy scalar, array of one

class Mat:
    """A picture: np.array(mat, copy=False) sees the simulator's own memory, shape (height, width,
    channels), row 0 on top."""

    def __buffer__(self, flags: int, /) -> memoryview: ...
    def __array__(self, dtype: Any = None, copy: Any = None) -> NDArray[Any]: ...

class ViewPoint:
    """A viewpoint as an agent sees it."""

    @property
    def viewpointId(self) -> str:
        """Its id in the scan's files."""
    @property
    def ix(self) -> int:
        """Place in the scan's connectivity file, excluded viewpoints counted."""
    @property
    def x(self) -> float:
        """Metres, world frame."""
    @property
    def y(self) -> float:
        """Metres, world frame."""
    @property
    def z(self) -> float:
        """Metres, world frame, up."""
    @property
    def point(self) -> list[float]:
        """[x, y, z], as v0.1 has it."""
    @property
    def rel_heading(self) -> float:
        """Radians from the picture's middle, right positive."""
    @property
    def rel_elevation(self) -> float:
        """Radians from the picture's middle, up positive."""
    @property
    def rel_distance(self) -> float:
        """Metres."""

class SimState:
    """Where an agent is, and what it sees and can reach. World frame: metres, z up; headings in
    radians clockwise from +y, elevations above the horizon. In v0.2 the simulator changes the
    object, and the pixels of its pictures, at each action and episode, until close() or another
    initialize(); in v0.1 it is a copy. It may be read as long as it is kept, also after the
    simulator is gone."""

    @property
    def scanId(self) -> str:
        """Name of the scan."""
    @property
    def step(self) -> int:
        """Actions since the episode began."""
    @property
    def rgb(self) -> Mat:
        """(height, width, 3) uint8, B G R. In v0.1 a NumPy array."""
    @property
    def depth(self) -> Mat:
        """(height, width, 1) uint16, quarter millimetres along the optical axis; 0: no reading."""
    @property
    def location(self) -> ViewPoint:
        """Where the agent is; None before the first episode."""
    @property
    def heading(self) -> float:
        """Radians clockwise from world +y, [0, 2 pi]."""
    @property
    def elevation(self) -> float:
        """Radians above the horizon."""
    @property
    def viewIndex(self) -> int:
        """0..35 when discretized (12 headings; down, level, up), else 0."""
    @property
    def navigableLocations(self) -> list[ViewPoint]:
        """Where a move may lead; [0] is the present place."""

class Simulator:
    """The old simulator. docs/python_mattersim.md has what differs."""

    def __init__(self) -> None: ...
    def setDatasetPath(self, path: Union[str, bytes], /) -> None:
        """Folder of the scans' pictures. Default ./data/v1/scans/ (v0.1: ./data)."""
    def setNavGraphPath(self, path: Union[str, bytes], /) -> None:
        """Folder of scans.txt and <scan>_connectivity.json. Default ./connectivity."""
    def setRenderingEnabled(self, enabled: bool, /) -> None:
        """False: no picture is opened. Default True."""
    def setCameraResolution(self, width: int, height: int, /) -> None:
        """Width and height, pixels. Default 320, 240. Takes effect at the next action."""
    def setCameraVFOV(self, vfov: float, /) -> None:
        """Vertical field of view, radians. Default 0.8. Takes effect at the next action."""
    def setElevationLimits(self, min: float, max: float, /) -> bool:
        """Radians, -pi/2 < min < 0 < max < pi/2, else False is returned and nothing changes."""
    def setDiscretizedViewingAngles(self, enabled: bool, /) -> None:
        """36 views: 12 headings x 3 elevations of 30 degrees. Default False."""
    def setRestrictedNavigation(self, enabled: bool, /) -> None:
        """Only what the picture's width shows is navigable. Default True."""
    def setPreloadingEnabled(self, enabled: bool, /) -> None:
        """Decode all pictures at initialize(), and keep them. Default False."""
    def setDepthEnabled(self, enabled: bool, /) -> None:
        """Draw depth too. Default False."""
    def setBatchSize(self, size: int, /) -> None:
        """Agents. Default 1."""
    def setCacheSize(self, panoramas: int, /) -> None:
        """Decoded panoramas to keep. Default 200."""
    def setSeed(self, seed: int, /) -> None:
        """Of random starts. Default 1 (v0.1: the clock)."""
    def initialize(self) -> None:
        """Takes the settings over; v0.2."""
    def init(self) -> None:
        """Takes the settings over; v0.1."""
    def close(self) -> None:
        """Lets go of pictures; initialize() begins anew."""
    def newEpisode(
        self,
        scanIds: Union[str, bytes, Sequence[str]],
        viewpointIds: Union[str, bytes, Sequence[str]],
        headings: Angle,
        elevations: Angle,
        /,
    ) -> None:
        """Lists, an element an agent (v0.2), or scalars (v0.1, where viewpoint "" is random)."""
    def newRandomEpisode(self, scanIds: Sequence[str], /) -> None:
        """Random viewpoints, the old simulator's headings."""
    def makeAction(self, indices: Any, headings: Angle, elevations: Angle, /) -> None:
        """Move to navigableLocations[index], then turn by so many radians."""
    def getState(self) -> Any:
        """list[SimState] (v0.2), or a copy of one SimState (v0.1)."""
    def resetTimers(self) -> None:
        """Begins timingInfo() anew."""
    def timingInfo(self) -> str:
        """How long what took, as text."""

def cbf(
    depth: NDArray[Any],
    intensity: NDArray[Any],
    mask: NDArray[Any],
    result: NDArray[Any],
    /,
) -> None:
    """Fills holes of depth; (H, W) uint8 in Fortran order, `result` is written. mask: not 0 where
    depth is missing."""
