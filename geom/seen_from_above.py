"""Turns about z and fronts as they are seen from above: everything in a scene stands level."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def turned(points: FloatArray, yaw_rad: float) -> FloatArray:
    """Points (n, 2) turned about the origin."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return points @ np.array([[c, s], [-s, c]])


def front_of(quat_wxyz: tuple[float, float, float, float]) -> FloatArray:
    """The front (+x of the asset frame) of an orientation, (2,); shorter than 1 where it points up or down."""
    w, x, y, z = quat_wxyz
    return np.array([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)])
