"""Cameras: pixels to rays and points, and back.

The camera's frame is x right, y down, z along the optical axis, metres. The world's is +z up; a
heading is radians clockwise from +y, an elevation radians above the horizon. Pixel (0, 0) is the left
top one, and its centre is at (0.5, 0.5). Depth is along the optical axis, the renderers' default; 0 is
no reading.

>>> from enfilade import camera
>>> k = camera.intrinsics(640, 480, math.radians(60))
>>> points = camera.unproject(depth, math.radians(60), position, heading, elevation)   # (h, w, 3)
"""

from __future__ import annotations

import math
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from enfilade._arguments import whole
from enfilade._errors import ArgumentError

__all__ = ["intrinsics", "project", "rotation", "unproject"]


def intrinsics(width: int, height: int, vfov: float) -> NDArray[np.float64]:
    """The (3, 3) matrix of a pinhole camera; `vfov` is its vertical field of view, radians. The focal
    length is height / 2 / tan(vfov / 2) pixels in both directions, the principal point the centre.
    Raises ArgumentError for a size of 0, or an angle outside (0, pi)."""
    if whole("width", width) == 0 or whole("height", height) == 0:
        raise ArgumentError(f"a picture of {width} x {height}: at least 1 x 1 is wanted")
    if not 0 < vfov < math.pi:
        raise ArgumentError(f"vfov {vfov}: more than 0 and less than pi radians are wanted")
    focal = height / 2 / math.tan(vfov / 2)
    return np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])


def rotation(heading: float = 0.0, elevation: float = 0.0) -> NDArray[np.float64]:
    """world_from_camera: the (3, 3) matrix from directions in the camera's frame to the world's."""
    sin_h, cos_h = math.sin(heading), math.cos(heading)
    sin_e, cos_e = math.sin(elevation), math.cos(elevation)
    right = (cos_h, -sin_h, 0.0)
    forward = (sin_h * cos_e, cos_h * cos_e, sin_e)
    down = (sin_h * sin_e, cos_h * sin_e, -cos_e)
    return np.array([right, down, forward]).T


def unproject(
    depth: ArrayLike,
    vfov: float,
    position: Optional[ArrayLike] = None,
    heading: float = 0.0,
    elevation: float = 0.0,
) -> NDArray[np.float32]:
    """The points of a depth image.

    Args:
        depth: (h, w) metres; or uint16, quarter millimetres, as in MatterSim.
        vfov: vertical field of view, radians.
        position: (3,) metres, world frame: Graph.positions[ix]. None: points in the camera's frame;
            heading and elevation are ignored.
        heading, elevation: of the camera, radians.

    Returns (h, w, 3) float32; NaN where there is no reading. Raises ArgumentError for other shapes.
    """
    metres = np.asarray(depth)
    if metres.ndim != 2:
        raise ArgumentError(f"depth: shape {metres.shape}: (height, width) is wanted")
    height, width = metres.shape
    k = intrinsics(width, height, vfov)
    z = metres / 4000.0 if metres.dtype == np.uint16 else metres.astype(np.float64)
    z = np.where(z > 0, z, np.nan)
    x = (np.arange(width) + 0.5 - k[0, 2]) / k[0, 0]
    y = (np.arange(height) + 0.5 - k[1, 2]) / k[1, 1]
    points = np.stack([z * x, z * y[:, None], z], axis=-1)
    if position is None:
        return points.astype(np.float32)
    moved: NDArray[np.float64] = points @ rotation(heading, elevation).T + _point(position)
    return moved.astype(np.float32)


def project(
    points: ArrayLike,
    width: int,
    height: int,
    vfov: float,
    position: ArrayLike,
    heading: float = 0.0,
    elevation: float = 0.0,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Projects points (..., 3), metres, world frame, into an image. Returns (..., 2) pixels x, y, and
    (...) depth in metres. Points behind the camera have NaN as pixel, and a depth of 0 or less. Raises
    ArgumentError for other shapes."""
    world = np.asarray(points, np.float64)
    if world.ndim == 0 or world.shape[-1] != 3:
        raise ArgumentError(f"points: shape {world.shape}: (..., 3) is wanted")
    seen = (world - _point(position)) @ rotation(heading, elevation)
    k = intrinsics(width, height, vfov)
    depth = seen[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = seen[..., :2] / np.where(depth > 0, depth, np.nan)[..., None]
    return pixels * np.array([k[0, 0], k[1, 1]]) + k[:2, 2], depth


def _point(position: ArrayLike) -> NDArray[Any]:
    point = np.asarray(position, np.float64)
    if point.shape != (3,):
        raise ArgumentError(f"position: shape {point.shape}: (3,) is wanted")
    return point
