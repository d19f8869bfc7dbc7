"""Measures rectangles around footprints in many layouts at once: extents, distances, directions along an axis. Frame P
of the owner, metres and radians; rectangles (..., 4) are x_low, x_high, y_low, y_high.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from scenec.solve.planar import AXIS
from schemas.arrays import FloatArray


class AxisOrder(NamedTuple):
    """Member `first` ends `gap_m` before member `second` begins, along axis 0 (x) or 1 (y)."""

    first: int
    second: int
    along: int
    gap_m: float


def axis_of(direction: tuple[float, float]) -> int | None:
    """0 for a direction along x, 1 for one along y, None for any other."""
    return next((axis for axis in (0, 1) if abs(direction[axis]) > AXIS), None)


def wrapped_all(angle_rad: FloatArray) -> FloatArray:
    """Angles brought into [-pi, pi)."""
    return (angle_rad + np.pi) % (2.0 * np.pi) - np.pi


def extent(rect_m: FloatArray, direction: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Where rectangles (..., 4) begin and end along a direction."""
    dx, dy = direction
    x_first, y_first = (0, 1) if dx >= 0 else (1, 0), (2, 3) if dy >= 0 else (3, 2)
    low = dx * rect_m[..., x_first[0]] + dy * rect_m[..., y_first[0]]
    return low, dx * rect_m[..., x_first[1]] + dy * rect_m[..., y_first[1]]


def distance(one_m: FloatArray, two_m: FloatArray) -> FloatArray:
    """Distance of rectangles (..., 4)."""
    dx = np.maximum(np.maximum(two_m[..., 0] - one_m[..., 1], one_m[..., 0] - two_m[..., 1]), 0.0)
    dy = np.maximum(np.maximum(two_m[..., 2] - one_m[..., 3], one_m[..., 2] - two_m[..., 3]), 0.0)
    return np.hypot(dx, dy)
