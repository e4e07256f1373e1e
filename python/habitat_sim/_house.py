"""A reader of Matterport3D's `.house` files: what of a home has a name, in the file's frame, z up."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any, Iterator

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]


@dataclass
class Box:
    """A box along the axes."""

    low: Floats
    high: Floats


@dataclass
class Region:
    """A room: its level, or -1, and the letter of its kind."""

    level: int
    label: str
    box: Box


@dataclass
class Category:
    """A kind of objects: its number and name in Matterport3D's list and among the 40 of mpcat40."""

    raw_index: int
    raw_name: str
    index: int
    name: str


@dataclass
class Object:
    """A thing: its region and category, or -1, and an oriented box with two of its axes."""

    region: int
    category: int
    center: Floats
    axes: tuple[Floats, Floats]
    radii: Floats


@dataclass
class House:
    """What a file has."""

    box: Box
    levels: list[Box] = field(default_factory=list)
    regions: list[Region] = field(default_factory=list)
    categories: list[Category] = field(default_factory=list)
    objects: list[Object] = field(default_factory=list)
    segments: dict[int, int] = field(default_factory=dict)  # the object of a segment's id


# The words of a line of each kind that is used, in the order in which others refer to them.
_WORDS = {"L": 18, "R": 20, "C": 11, "O": 24, "E": 19}
_NOT_USED = "PSVI"
# Where the H line counts lines of a kind.
_COUNTS = {"I": (3,), "P": (4, 11), "V": (5,), "S": (6,), "E": (7,), "O": (8,), "C": (9,), "R": (10,),
           "L": (12,)}  # fmt: skip
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_WHOLE = re.compile(r"[+-]?\d{1,10}", re.ASCII)
_MOST = float(np.finfo(np.float32).max)


class _Line:
    """The words of one line."""

    def __init__(self, place: str, words: list[str]) -> None:
        self.words = words
        self._place = place

    def error(self, what: str) -> ValueError:
        return ValueError(f"{self._place}: {what}")

    def _wrong(self, name: str, at: int, wanted: str) -> ValueError:
        return self.error(f"{name} '{self.words[at]}': {wanted} is wanted")

    def whole(self, name: str, at: int, least: int = -(2**31), most: int = 2**31 - 1) -> int:
        word = self.words[at]
        if not _WHOLE.fullmatch(word) or not least <= int(word) <= most:
            raise self._wrong(name, at, f"an integer from {least} to {most}")
        return int(word)

    def place(self, name: str, at: int, count: int) -> int:
        """An entry of a list, or -1."""
        return self.whole(name, at, -1, count - 1)

    def own_place(self, expected: int) -> None:
        if self.whole("index", 1) != expected:
            raise self._wrong("index", 1, f"its place among the {self.words[0]} lines, {expected},")

    def text(self, at: int) -> str:
        return self.words[at].replace("#", " ")

    def letter(self, name: str, at: int) -> str:
        if len(self.words[at]) != 1:
            raise self._wrong(name, at, "one character")
        return self.words[at]

    def numbers(self, name: str, at: int, least: float = -_MOST, most: float = _MOST) -> Floats:
        """Three numbers."""
        for k in range(at, at + 3):
            word = self.words[k]
            if not _NUMBER.fullmatch(word) or not least <= float(word) <= most:
                raise self._wrong(name, k, f"a number from {least:g} to {most:g}")
        return np.array([_nearest(word) for word in self.words[at : at + 3]], np.float32)

    def box(self, at: int) -> Box:
        return Box(self.numbers("box", at), self.numbers("box", at + 3))


def _nearest(word: str) -> Any:
    """The nearest float32: a double between would be rounded twice."""
    near, most = np.float32(word), np.float32(_MOST)
    nearby = (near, np.nextafter(near, -most), np.nextafter(near, most))
    return min(nearby, key=lambda one: abs(Decimal(float(one)) - Decimal(word)))


def read_house(file: str) -> tuple[House, list[str], str]:
    """Reads a file. Returns what it has, what is odd, and the bad line where the reading ended, or "".

    As in Habitat, a bad line ends it, and counts, and lines of unknown kinds, change nothing.

    Raises ValueError for a file without a head. Messages have file, line, field and what is allowed.
    """
    with open(file, encoding="utf-8", errors="replace") as stream:
        rows = [row.split() for row in stream]
    lines = [_Line(f"{file}, line {k}", row) for k, row in enumerate(rows, 1) if row]
    if not lines or lines[0].words != ["ASCII", "1.1"]:
        raise ValueError(f"{file}, line 1: 'ASCII 1.1' is wanted")
    if len(lines) < 2 or lines[1].words[0] != "H" or len(lines[1].words) != 29:
        raise ValueError(f"{file}, line 2: an H line of 29 words is wanted")
    head = lines[1]
    odd: list[str] = []
    house = House(head.box(18))
    kinds: dict[str, list[_Line]] = {letter: [] for letter in [*_WORDS, *_NOT_USED]}
    others: list[_Line] = []
    for line in lines[2:]:
        kinds.get(line.words[0], others).append(line)
    if others:
        what = f"kind '{others[0].words[0][:20]}': one of {', '.join(kinds)} is known"
        odd.append(str(others[0].error(f"{what}; lines of other kinds: {len(others)}")))
    try:
        for letter, places in _COUNTS.items():
            count = sum(head.whole(f"count of {letter}", at, 0) for at in places)
            if count != len(kinds[letter]):
                what = f"count of {letter} {count}: the number of its lines is {len(kinds[letter])}"
                odd.append(str(head.error(what)))
    except ValueError as error:
        odd.append(str(error))
    try:
        _fill(house, kinds)
    except ValueError as error:
        return house, odd, str(error)
    return house, odd, ""


def _fill(house: House, kinds: dict[str, list[_Line]]) -> None:
    def lines_of(letter: str) -> Iterator[_Line]:
        for k, line in enumerate(kinds[letter]):
            if len(line.words) != _WORDS[letter]:
                wanted = f"a line {letter} of {_WORDS[letter]} is wanted"
                raise line.error(f"{len(line.words)} words: {wanted}")
            line.own_place(k)
            yield line

    for line in lines_of("L"):
        house.levels.append(line.box(7))
    for line in lines_of("R"):
        level = line.place("level", 2, len(house.levels))
        house.regions.append(Region(level, line.letter("label", 5), line.box(9)))
    for line in lines_of("C"):
        raw, index = line.whole("mapping index", 2), line.whole("mpcat40 index", 4)
        house.categories.append(Category(raw, line.text(3), index, line.text(5)))
    for line in lines_of("O"):
        region = line.place("region", 2, len(house.regions))
        category = line.place("category", 3, len(house.categories))
        center, radii = line.numbers("position", 4), line.numbers("radii", 13)
        first = line.numbers("first axis", 7, -1.001, 1.001)
        second = line.numbers("second axis", 10, -1.001, 1.001)
        house.objects.append(Object(region, category, center, (first, second), radii))
    for line in lines_of("E"):
        owner = line.place("object", 2, len(house.objects))
        if owner >= 0:
            house.segments[line.whole("id", 3)] = owner
