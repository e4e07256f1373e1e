"""Rotations as numpy-quaternion has them, and as x, y, z, w."""

from __future__ import annotations

from typing import Any, Tuple

import numpy as np

from habitat_sim._fields import finite, numbers, wrong

try:
    import quaternion  # type: ignore[import-untyped, import-not-found, unused-ignore]
except ImportError as error:
    raise ImportError(
        "habitat_sim needs the package numpy-quaternion: pip install numpy-quaternion"
    ) from error

Xyzw = Tuple[float, float, float, float]
Quaternion: Any = quaternion.quaternion
IDENTITY: Xyzw = (0.0, 0.0, 0.0, 1.0)


def to_quaternion(xyzw: Any) -> Any:
    """numpy-quaternion's object of four numbers x, y, z, w."""
    x, y, z, w = (float(number) for number in xyzw)
    return Quaternion(w, x, y, z)


def to_xyzw(name: str, rotation: Any) -> Xyzw:
    """The numbers, as float32 keeps them, of a numpy-quaternion, or of a list or array of x, y, z, w.

    Raises TypeError for other types, ValueError for a length other than 1.
    """
    if isinstance(rotation, Quaternion):
        given = np.array([rotation.x, rotation.y, rotation.z, rotation.w])
    else:
        if not isinstance(rotation, (list, np.ndarray)):
            raise wrong(name, rotation, "a numpy-quaternion, or a list or array of x, y, z, w,")
        given = numbers(name, rotation, 4)
    finite(name, given)
    length = float(np.linalg.norm(given))
    if abs(length - 1) > 1e-5:
        raise ValueError(f"{name} {rotation!r}: the length is {length:g}, it has to be 1")
    x, y, z, w = given.astype(np.float32).tolist()
    return x, y, z, w
