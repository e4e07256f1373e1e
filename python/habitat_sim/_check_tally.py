"""Counts of values that are equal to recorded ones, and of those that are not. For habitat_sim.check."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

SHOWN = 5  # mismatches that are kept as text


class LeftOutError(Exception):
    """A section, or a part of it, cannot run here. The message says why."""


@dataclass
class Tally:
    """What one section found."""

    values: int = 0
    mismatches: int = 0
    shown: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    on_purpose: int = 0
    """Names that a table leaves out with a reason: no values."""

    def add(self, other: Tally) -> None:
        """Adds the counts of a later part."""
        self.values += other.values
        self.mismatches += other.mismatches
        self.on_purpose += other.on_purpose
        self.shown = (self.shown + other.shown)[:SHOWN]
        self.left_out += [reason for reason in other.left_out if reason not in self.left_out]

    @contextlib.contextmanager
    def leaving_out(self, what: str = "") -> Iterator[None]:
        """Within it, what cannot run here ends, and is noted with its reason."""
        try:
            yield
        except (LeftOutError, NotImplementedError) as e:  # the second: a module says what it lacks
            reason = f"{what}: {e}" if what else str(e)
            if reason not in self.left_out:
                self.left_out.append(reason)

    def wrong(self, place: str, wanted: Any, found: Any, count: int = 1) -> None:
        """Counts mismatches, and keeps the first as text. Their values are counted elsewhere."""
        self.mismatches += count
        if len(self.shown) < SHOWN:
            self.shown.append(f"{place}: wanted {_short(wanted)}, found {_short(found)}")

    def value(self, place: str, wanted: Any, found: Any) -> None:
        """One value: equal to the bit, and of the same kind."""
        self.values += 1
        if not _same(wanted, found):
            self.wrong(place, wanted, found)

    def array(self, place: str, wanted: Any, found: Any, parts: int = 0) -> None:
        """Values of an array, each with the last `parts` axes of it: 1 for points. Equal to the bit."""
        wanted = np.asarray(wanted)
        try:
            found = np.asarray(found, wanted.dtype)
        except (TypeError, ValueError):
            found = np.asarray(found, object)
        whole = wanted.ndim - parts
        count = int(np.prod(wanted.shape[:whole]))
        self.values += count
        if wanted.shape != found.shape:
            self.wrong(f"{place}: shape", wanted.shape, found.shape, max(count, 1))
            return
        equal = same_bits(wanted, found).reshape(wanted.shape[:whole] + (-1,)).all(axis=-1)
        wrong = np.argwhere(~equal)
        for index in wrong[:SHOWN]:
            at = tuple(int(i) for i in index)
            self.wrong(f"{place}[{', '.join(map(str, at))}]", wanted[at].tolist(), found[at].tolist())
        self.mismatches += max(0, len(wrong) - SHOWN)

    def tree(self, place: str, wanted: Any, found: Any) -> None:
        """Every leaf of something out of JSON. A list of numbers is one value: a point, a rotation."""
        if isinstance(wanted, dict) and isinstance(found, dict):
            for key, value in wanted.items():
                if key in found:
                    self.tree(f"{place}.{key}", value, found[key])
                else:
                    self.value(f"{place}.{key}", value, None)
        elif isinstance(wanted, list) and isinstance(found, list) and not _is_point(wanted):
            self.value(f"{place}: length", len(wanted), len(found))
            for i, (one, other) in enumerate(zip(wanted, found)):
                self.tree(f"{place}[{i}]", one, other)
            missing = sum(_leaves(one) for one in wanted[len(found) :])
            self.values += missing
            self.mismatches += missing
        else:
            self.value(place, wanted, found)

    def share(self, place: str, agrees: Any, least: float) -> None:
        """One value: a picture of whose pixels at least the share `least` agrees."""
        self.values += 1
        share = float(np.mean(agrees))
        if not share >= least:
            self.wrong(place, f"{least:.1%} of pixels", f"{share:.3%}")


def same_bits(a: Any, b: Any) -> Any:
    """Where two arrays of one type are equal: 0 is not -0, and NaN is NaN."""
    if a.dtype.kind != "f":
        return a == b
    return (a == b) & (np.signbit(a) == np.signbit(b)) | np.isnan(a) & np.isnan(b)


def point(p: Any) -> Any:
    """A point of any type as float32."""
    return np.array([p[0], p[1], p[2]], np.float32)


def numbers(p: Any) -> list[float]:
    """A point of any type as JSON has it."""
    return [float(x) for x in point(p)]


def rotation(q: Any) -> Any:
    """A quaternion as x, y, z, w in float32."""
    return np.array([q.x, q.y, q.z, q.w], np.float32)


def _leaves(value: Any) -> int:
    """How many values tree() has in something out of JSON."""
    if isinstance(value, dict):
        return sum(map(_leaves, value.values()))
    if isinstance(value, list) and not _is_point(value):
        return 1 + sum(map(_leaves, value))
    return 1


def _is_point(value: list[Any]) -> bool:
    return bool(value) and all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in value)


def _same(wanted: Any, found: Any) -> bool:
    if isinstance(wanted, list):
        return (
            isinstance(found, list)
            and len(wanted) == len(found)
            and all(_same(a, b) for a, b in zip(wanted, found))
        )
    if isinstance(wanted, float) and isinstance(found, (int, float)):
        return bool(same_bits(np.float64(wanted), np.float64(found)))
    return isinstance(wanted, bool) == isinstance(found, bool) and bool(wanted == found)


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 120 else text[:117] + "..."
