"""Regions of the plane as shapely areas: half-planes, strips, wedges, and where one outline meets another (no-fit
polygons). Points are (x, y) in the frame P of an owner, metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, pi, sin

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from scenec.solve.frames import Pose2
from scenec.solve.planar import SLACK_M, hulls
from schemas.arrays import FloatArray

NOWHERE = Polygon()
FEW_CORNERS = 100  # product of the corner counts of two outlines below which the hull of all differences is as fast
Box = tuple[float, float, float, float]  # x_low, y_low, x_high, y_high


def no_fit_polygons(outline: FloatArray, reflected: Sequence[FloatArray]) -> list[BaseGeometry]:
    """No-fit polygons of one convex obstacle (n, 2): its Minkowski sums with the reflected footprint's pieces."""
    return hulls([minkowski_sum_points(outline, piece) for piece in reflected])


def minkowski_sum_points(a: FloatArray, b: FloatArray) -> FloatArray:
    """Points (k, 2) whose hull is the Minkowski sum of a convex outline and a reflected one: all differences of corners
    where these are few, else the corners found by merging the edges of both by direction."""
    if len(a) * len(b) <= FEW_CORNERS:
        return (a[:, None, :] - b[None, :, :]).reshape(-1, 2)
    one, two = _from_lowest(a), _from_lowest(-b)
    edges = np.concatenate([_from(one, 1) - one, _from(two, 1) - two])
    order = np.argsort(np.arctan2(edges[:, 1], edges[:, 0]) % (2.0 * pi), kind="stable")
    passed = np.cumsum(order < len(one))
    at = np.concatenate([[0], passed[:-1]])
    return one[at % len(one)] + two[(np.arange(len(order)) - at) % len(two)]


def _from_lowest(outline: FloatArray) -> FloatArray:
    # Counter-clockwise, beginning at the lowest corner (the leftmost of these): edges turn from 0 to a whole turn.
    (x, y), (x_next, y_next) = outline.T, _from(outline, 1).T
    if float(x @ y_next - y @ x_next) < 0.0:
        outline = outline[::-1]
    return _from(outline, int(np.lexsort((outline[:, 0], outline[:, 1]))[0]))


def _from(outline: FloatArray, k: int) -> FloatArray:
    # From corner k on; np.roll takes ten times as long for so few corners.
    return np.concatenate([outline[k:], outline[:k]])


def half_plane(dx: float, dy: float, end: float, around: Box) -> Polygon:
    """The part of a large square around the box `around` with p . (dx, dy) <= end, for a unit direction."""
    cx, cy = (around[0] + around[2]) / 2, (around[1] + around[3]) / 2
    size = 2.0 * (around[2] - around[0] + around[3] - around[1]) + 1.0
    past = min(end - cx * dx - cy * dy, 0.7 * size)  # a border far beyond the box must not leave the box behind
    px, py = cx + past * dx, cy + past * dy
    return Polygon(
        [
            (px + size * -dy, py + size * dx),
            (px + size * (-dy - 2 * dx), py + size * (dx - 2 * dy)),
            (px + size * (dy - 2 * dx), py + size * (-dx - 2 * dy)),
            (px + size * dy, py - size * dx),
        ]
    )


def in_P(outline_B: FloatArray, owner: Pose2) -> FloatArray:
    """An outline (n, 2) of the background's frame B in the frame of an owner."""
    c, s = cos(owner.yaw_rad), sin(owner.yaw_rad)
    return (outline_B - (owner.x_m, owner.y_m)) @ np.array([[c, -s], [s, c]])


def widened(box: Box) -> Box:
    """A box with a metre more on each side."""
    return box[0] - 1.0, box[1] - 1.0, box[2] + 1.0, box[3] + 1.0


def strip(nx: float, ny: float, low: float, high: float, around: Box) -> BaseGeometry:
    """Points with low <= p . n <= high near a box; a line where both are equal."""
    cx, cy = (around[0] + around[2]) / 2, (around[1] + around[3]) / 2
    size = around[2] - around[0] + around[3] - around[1] + 1.0
    at = cx * nx + cy * ny
    ends = [(cx + (v - at) * nx, cy + (v - at) * ny) for v in (low, high)]
    if high - low <= SLACK_M:
        x, y = ends[0]
        return shapely.LineString([(x - size * ny, y + size * nx), (x + size * ny, y - size * nx)])
    (xa, ya), (xb, yb) = ends
    return Polygon(
        [
            (xa - size * ny, ya + size * nx),
            (xa + size * ny, ya - size * nx),
            (xb + size * ny, yb - size * nx),
            (xb - size * ny, yb + size * nx),
        ]
    )


def wedge(apex: tuple[float, float], heading: float, half: float, size: float) -> BaseGeometry:
    """Points within an angle `half` (rad) of a heading as seen from the apex, as far as `size` at least."""
    x, y = apex
    size /= cos(half)
    sides = [(x + size * cos(heading + h), y + size * sin(heading + h)) for h in (-half, half)]
    if half <= SLACK_M:
        return shapely.LineString([apex, sides[0]])
    return Polygon([apex, *sides])


def beside(a: tuple[float, float], b: tuple[float, float], tolerance: float) -> BaseGeometry:
    """Points between two others, no farther than a tolerance beside their line."""
    length = hypot(b[0] - a[0], b[1] - a[1])
    if length < SLACK_M:
        return NOWHERE
    line = shapely.LineString([a, b])
    return line.buffer(tolerance, cap_style="flat") if tolerance > SLACK_M else line
