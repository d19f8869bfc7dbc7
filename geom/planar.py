"""Rotations about z and convex outlines in the plane z = 0, for level objects: points (n, 2), angles in radians."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray

# Of its breadth: what the simplification of an outline may move it by.
DETAIL_SHARE = 2e-3


def turned(points: FloatArray, yaw_rad: float) -> FloatArray:
    """Points (n, 2) rotated about the origin by `yaw_rad`, counter-clockwise."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return points @ np.array([[c, s], [-s, c]])


def front_of(quat_wxyz: tuple[float, float, float, float]) -> FloatArray:
    """The front (+x of the asset frame) of an orientation, projected on z = 0, (2,); of length 1 or less."""
    w, x, y, z = quat_wxyz
    return np.array([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)])


def inner_radius(outline: FloatArray) -> float:
    """Distance of the origin from the nearest edge line of a convex outline (n, 2), counter-clockwise; negative when
    the origin lies outside."""
    edges = np.roll(outline, -1, axis=0) - outline
    cross = edges[:, 1] * outline[:, 0] - edges[:, 0] * outline[:, 1]
    return float((cross / np.maximum(np.hypot(edges[:, 0], edges[:, 1]), 1e-12)).min())
