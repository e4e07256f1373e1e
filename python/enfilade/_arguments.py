"""Checks of arguments; the messages name them. Warnings of old names. Does not need NumPy."""

from __future__ import annotations

import operator
import sys
import warnings
from typing import Any

from enfilade._errors import ArgumentError

MOST = 2**32 - 1  # largest index and size


def whole(name: str, value: Any, most: int = MOST) -> int:
    """An integer of any type, 0 to `most`. Raises TypeError or ArgumentError, naming the argument."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} {value!r}: an integer is wanted") from None
    if not 0 <= number <= most:
        raise ArgumentError(f"{name} {number}: 0 to {most} are allowed")
    return number


def deprecated(old: str, new: str) -> None:
    """Warns of an old name, at the nearest line outside of this package and Gymnasium."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and _package(frame.f_globals) in ("enfilade", "gymnasium"):
        frame, level = frame.f_back, level + 1
    message = f"{old} is deprecated and will be removed in the next release: write {new}"
    warnings.warn(message, DeprecationWarning, stacklevel=level)


def _package(names: dict[str, Any]) -> str:
    return str(names.get("__name__", "")).partition(".")[0]
