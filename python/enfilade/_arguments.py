"""Checks of arguments; the messages name them. Does not need NumPy."""

from __future__ import annotations

import operator
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
