"""The old simulator's interface: v0.2 (lists) and v0.1 (scalars)."""

from collections.abc import Sequence
from typing import Any, Union

from numpy.typing import NDArray

Angle = Any  # int, float, NumPy scalar, array of one

class Mat:
    """An image: np.array(mat, copy=False) shares the simulator's memory, shape (height, width,
    channels), row 0 on top."""

    def __buffer__(self, flags: int, /) -> memoryview: ...
    def __array__(self, dtype: Any = None, copy: Any = None) -> NDArray[Any]: ...

class ViewPoint:
    """A viewpoint, relative to an agent's view."""

    @property
    def viewpointId(self) -> str:
        """Its id in the scan's files."""
    @property
    def ix(self) -> int:
        """Index in the scan's connectivity file, excluded viewpoints counted."""
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
        """[x, y, z], as in v0.1."""
    @property
    def rel_heading(self) -> float:
        """Radians from the image's centre, right positive."""
    @property
    def rel_elevation(self) -> float:
        """Radians from the image's centre, up positive."""
    @property
    def rel_distance(self) -> float:
        """Metres."""

class SimState:
    """The state of an agent: pose, images and navigable viewpoints. World frame: metres, z up;
    headings in radians clockwise from +y, elevations above the horizon. In v0.2 the simulator
    changes the object, and the pixels of its images, at each action and episode, until close() or
    another initialize(). In v0.1 it is a copy. It stays valid without the simulator."""

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
        """The agent's viewpoint; None before the first episode."""
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
        """The navigable viewpoints; [0] is the current one."""

class Simulator:
    """The old simulator. Differences: docs/python_mattersim.md."""

    def __init__(self) -> None: ...
    def setDatasetPath(self, path: Union[str, bytes], /) -> None:
        """Folder of the scans' images. Default ./data/v1/scans/ (v0.1: ./data)."""
    def setNavGraphPath(self, path: Union[str, bytes], /) -> None:
        """Folder of scans.txt and <scan>_connectivity.json. Default ./connectivity."""
    def setRenderingEnabled(self, enabled: bool, /) -> None:
        """False: no image is opened. Default True."""
    def setCameraResolution(self, width: int, height: int, /) -> None:
        """Width and height, pixels. Default 320, 240. Takes effect at the next action."""
    def setCameraVFOV(self, vfov: float, /) -> None:
        """Vertical field of view, radians. Default 0.8. Takes effect at the next action."""
    def setElevationLimits(self, min: float, max: float, /) -> bool:
        """Radians, -pi/2 < min < 0 < max < pi/2, else nothing changes and False is returned."""
    def setDiscretizedViewingAngles(self, enabled: bool, /) -> None:
        """36 views: 12 headings x 3 elevations of 30 degrees. Default False."""
    def setRestrictedNavigation(self, enabled: bool, /) -> None:
        """Only viewpoints within the image's width are navigable. Default True."""
    def setPreloadingEnabled(self, enabled: bool, /) -> None:
        """Decode all images of all scans at initialize(), and keep them. Default False."""
    def setDepthEnabled(self, enabled: bool, /) -> None:
        """Draw depth too. Default False."""
    def setBatchSize(self, size: int, /) -> None:
        """Agents. Default 1."""
    def setCacheSize(self, panoramas: int, /) -> None:
        """Decoded panoramas to keep. Default 200."""
    def setSeed(self, seed: int, /) -> None:
        """Seed of random starts. Default 1 (v0.1: the clock)."""
    def initialize(self) -> None:
        """Applies the settings; v0.2."""
    def init(self) -> None:
        """Applies the settings; v0.1."""
    def close(self) -> None:
        """Releases the images; initialize() starts again."""
    def newEpisode(
        self,
        scanIds: Union[str, bytes, Sequence[str]],
        viewpointIds: Union[str, bytes, Sequence[str]],
        headings: Angle,
        elevations: Angle,
        /,
    ) -> None:
        """Lists with one element per agent (v0.2), or scalars (v0.1, where viewpoint "" is random)."""
    def newRandomEpisode(self, scanIds: Sequence[str], /) -> None:
        """Random viewpoints, the old simulator's headings."""
    def makeAction(self, indices: Any, headings: Angle, elevations: Angle, /) -> None:
        """Move to navigableLocations[index], then turn by heading and elevation, radians."""
    def getState(self) -> Any:
        """list[SimState] (v0.2), or a copy of one SimState (v0.1)."""
    def resetTimers(self) -> None:
        """Resets timingInfo()."""
    def timingInfo(self) -> str:
        """Times of the simulator's parts, as text."""

def cbf(
    depth: NDArray[Any],
    intensity: NDArray[Any],
    mask: NDArray[Any],
    result: NDArray[Any],
    /,
) -> None:
    """Fills holes of depth; (H, W) uint8 in Fortran order, `result` is written. mask: not 0 where
    depth is missing."""
