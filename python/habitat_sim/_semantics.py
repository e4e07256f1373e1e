"""What a scene means: its levels, regions and objects, with their boxes. All are read-only."""

from __future__ import annotations

from typing import Any, Iterable, Iterator, Optional

import magnum as mn
import numpy as np
from numpy.typing import NDArray

from habitat_sim._fields import vector3
from habitat_sim._house import Box, Category, Floats, House, Object, Region
from habitat_sim.geo import OBB

# The names of Matterport3D's letters, in the order of Habitat's indices.
_REGIONS = {
    "B": "bar", "C": "classroom", "D": "dining booth", "S": "spa/sauna", "Z": "junk", "a": "bathroom",
    "b": "bedroom", "c": "closet", "d": "dining room", "e": "entryway/foyer/lobby", "f": "familyroom/lounge",
    "g": "garage", "h": "hallway", "i": "library", "j": "laundryroom/mudroom", "k": "kitchen",
    "l": "living room", "m": "meetingroom/conferenceroom", "n": "lounge", "o": "office",
    "p": "porch/terrace/deck", "r": "rec/game", "s": "stairs", "t": "toilet", "u": "utilityroom/toolroom",
    "v": "tv", "w": "workout/gym/exercise", "x": "outdoor", "y": "balcony", "z": "other room",
}  # fmt: skip


class SemanticCategory:
    """A kind of regions or objects."""

    def __init__(self, names: dict[str, tuple[int, str]]) -> None:
        self._names = names

    def _of(self, mapping: str) -> tuple[int, str]:
        if mapping not in self._names:
            allowed = " or ".join(f"'{name}'" for name in self._names)
            raise ValueError(f"mapping '{mapping}': {allowed} is wanted")
        return self._names[mapping]

    def index(self, mapping: str = "") -> int:
        """The number in a list of categories."""
        return self._of(mapping)[0]

    def name(self, mapping: str = "") -> str:
        """The name in a list of categories."""
        return self._of(mapping)[1]


class Mp3dObjectCategory(SemanticCategory):
    """A kind of objects; mappings are "mpcat40", the same as "", and "raw"."""

    def __init__(self, read: Category) -> None:
        forty = (read.index, read.name)
        super().__init__({"": forty, "mpcat40": forty, "raw": (read.raw_index, read.raw_name)})


class Mp3dRegionCategory(SemanticCategory):
    """A kind of regions. Letters without a name have the index -1."""

    def __init__(self, letter: str) -> None:
        index = list(_REGIONS).index(letter) if letter in _REGIONS else -1
        super().__init__({"": (index, _REGIONS.get(letter, "no label"))})


class SemanticLevel:
    """A storey. As in Habitat, only its regions have objects."""

    def __init__(self, index: int, aabb: mn.Range3D) -> None:
        self.id, self.aabb = str(index), aabb
        self.regions: list[SemanticRegion] = []
        self.objects: list[SemanticObject] = []


class SemanticRegion:
    """A room."""

    def __init__(self, index: int, read: Region, level: Optional[SemanticLevel]) -> None:
        self.id = f"{level.id if level else ''}_{index}"
        self.level, self.aabb = level, _range(read.box)
        self.category = Mp3dRegionCategory(read.label)
        self.objects: list[SemanticObject] = []


class SemanticObject:
    """A thing with a name. `region` and `category` are None for one without."""

    def __init__(
        self, index: int, boxes: tuple[OBB, mn.Range3D], region: Optional[SemanticRegion], category: Any
    ) -> None:
        self.id, self.semantic_id = f"{region.id if region else ''}_{index}", index
        self.obb, self.aabb = boxes
        self.region, self.category = region, category


class SemanticScene:
    """What a scene means: what the `.house` file beside it has, or nothing without."""

    def __init__(self, house: Optional[House] = None) -> None:
        self.aabb = mn.Range3D()
        self.categories: list[SemanticCategory] = []
        self.levels: list[SemanticLevel] = []
        self.regions: list[SemanticRegion] = []
        self.objects: list[SemanticObject] = []
        self.semantic_index_map: dict[int, int] = {}
        if house is not None:
            # An empty box may be inside out, with the largest numbers there are.
            with np.errstate(over="ignore", invalid="ignore"):
                self._fill(house)

    def _fill(self, house: House) -> None:
        self.aabb = _range(house.box)
        self.categories = [Mp3dObjectCategory(one) for one in house.categories]
        self.levels = [SemanticLevel(k, _range(box)) for k, box in enumerate(house.levels)]
        for k, room in enumerate(house.regions):
            level = self.levels[room.level] if room.level >= 0 else None
            self.regions.append(SemanticRegion(k, room, level))
            if level is not None:
                level.regions.append(self.regions[-1])
        for k, (thing, boxes) in enumerate(zip(house.objects, _boxes(house.objects))):
            region = self.regions[thing.region] if thing.region >= 0 else None
            category = self.categories[thing.category] if thing.category >= 0 else None
            self.objects.append(SemanticObject(k, boxes, region, category))
            if region is not None:
                region.objects.append(self.objects[-1])
        self.semantic_index_map = dict(house.segments)

    def semantic_index_to_object_index(self, mask: int) -> int:
        """The object of a segment of the mesh, by the segment's id; -1 for none."""
        return self.semantic_index_map.get(mask, -1)

    def get_regions_for_point(self, point: Any) -> list[int]:
        """The places in `regions` of those whose box has a point."""
        place = vector3("point", point)
        return [k for k, region in enumerate(self.regions) if region.aabb.contains(place)]

    def get_regions_for_points(self, points: Iterable[Any]) -> list[tuple[int, float]]:
        """The regions whose box has any of some points, and the share of points in it, most first."""
        found = [self.get_regions_for_point(point) for point in points]
        shares = [
            (k, sum(k in places for places in found) / len(found))
            for k in range(len(self.regions))
            if any(k in places for places in found)
        ]
        return sorted(shares, key=lambda share: -share[1])


# All is float32, in the order in which Habitat's numbers come out to the bit.
_HALF = np.float32(0.5)
_ROOT = np.sqrt(_HALF)
_TO_Y_UP = np.array([-_ROOT, 0, 0, _ROOT], np.float32)
_CORNERS = np.array([[(-1, 1)[k >> axis & 1] for axis in range(3)] for k in range(8)], np.float32)


def _turned(turn: Floats, points: NDArray[Any]) -> Floats:
    """Points turned by quaternions x, y, z, w."""
    side = np.cross(turn[..., :3], points)
    side += side
    turned: Floats = points + turn[..., 3:] * side + np.cross(turn[..., :3], side)
    return turned


def _boxes(objects: list[Object]) -> Iterator[tuple[OBB, mn.Range3D]]:
    """The boxes of objects. Habitat's box along the axes also has the origin."""
    if not objects:
        return
    centers = _turned(_TO_Y_UP, np.array([one.center for one in objects]))
    radii = np.array([one.radii for one in objects])
    first, second = (_turned(_TO_Y_UP, np.array([one.axes[k] for one in objects])) for k in (0, 1))
    matrices = np.stack([first, second, np.cross(first, second)], axis=-1)
    turns = np.array([_quaternion(matrix) for matrix in matrices])
    corners = centers[:, None] + _turned(turns[:, None], _CORNERS * radii[:, None])
    low, high = np.minimum(corners.min(axis=1), 0), np.maximum(corners.max(axis=1), 0)
    for k, center in enumerate(centers):
        box = OBB(mn.Vector3(center), mn.Vector3(2 * radii[k]), mn.Vector4(turns[k]))
        yield box, mn.Range3D(low[k], high[k])


def _quaternion(m: NDArray[Any]) -> Floats:
    """The quaternion x, y, z, w of a rotation matrix."""
    one, turn = np.float32(1), np.zeros(4, np.float32)
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    if trace > 0:
        root = np.sqrt(trace + one)
        part = _HALF / root
        turn[:] = [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 0]
        turn *= part
        turn[3] = _HALF * root
        return turn
    i = int(np.argmax(np.diagonal(m)))
    j, k = (i + 1) % 3, (i + 2) % 3
    root = np.sqrt(m[i, i] - m[j, j] - m[k, k] + one)
    part = _HALF / root
    turn[i], turn[3] = _HALF * root, (m[k, j] - m[j, k]) * part
    turn[j], turn[k] = (m[j, i] + m[i, j]) * part, (m[k, i] + m[i, k]) * part
    return turn


def _range(box: Box) -> mn.Range3D:
    """A box of the file, y up: its middle and its half size are turned."""
    middle = _turned(_TO_Y_UP, (box.low + box.high) * _HALF)
    half = np.abs(_turned(_TO_Y_UP, box.high - box.low)) * _HALF
    return mn.Range3D(middle - half, middle + half)
