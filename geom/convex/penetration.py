"""Penetration depth and shared volume of the convex hulls of points (n, 3) and (m, 3), in the unit of the points."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold
from scipy.spatial import ConvexHull, QhullError

from schemas.arrays import FloatArray

MOST_PAIRS = 4096  # of points; beyond, only extreme points are used, which can only lessen the depth
_CORNER_DIRECTIONS = 64


def penetration_depth(points_a: FloatArray, points_b: FloatArray) -> float:
    """The shortest translation that separates the convex hulls of (n, 3) and (m, 3) points; 0 when they do not overlap.

    See `penetration`.
    """
    return penetration(points_a, points_b)[0]


def penetration(points_a: FloatArray, points_b: FloatArray) -> tuple[float, FloatArray]:
    """Depth as of `penetration_depth`, and the unit vector along which the hull of b moves by it to leave that of a.

    Exact: the hulls overlap iff the origin lies inside the hull of all differences `a - b`, and the depth is its
    distance from the nearest face there (van den Bergen 2003, "Collision Detection in Interactive 3D Environments").
    Beyond `MOST_PAIRS` differences only the extreme points along even directions are used, for a lower bound. The
    vector is zero where they do not overlap.
    """
    if box_overlap(points_a, points_b) <= 0.0:
        return 0.0, np.zeros(3)
    if len(points_a) * len(points_b) > MOST_PAIRS:
        points_a, points_b = _outermost(points_a), _outermost(points_b)
    differences = (points_a[:, None] - points_b[None]).reshape(-1, 3)
    try:
        planes = ConvexHull(differences).equations
    except (QhullError, ValueError):
        return 0.0, np.zeros(3)
    nearest = planes[int(planes[:, 3].argmax())]
    depth = float(-nearest[3])
    return (depth, nearest[:3]) if depth > 0.0 else (0.0, np.zeros(3))


def box_overlap(points_a: FloatArray, points_b: FloatArray) -> float:
    """The shortest translation along x, y or z that separates the bounding boxes: never less than the depth of the
    hulls; negative for a gap.
    """
    one_way, other_way = points_a.max(axis=0) - points_b.min(axis=0), points_b.max(axis=0) - points_a.min(axis=0)
    return float(np.minimum(one_way, other_way).min())


def shared_volume(points_a: FloatArray, points_b: FloatArray) -> float:
    """Volume of the intersection of two convex hulls."""
    first, second = (Manifold.hull_points(np.ascontiguousarray(p, dtype=np.float64)) for p in (points_a, points_b))
    return float((first ^ second).volume())


def even_directions(count: int) -> FloatArray:
    """(count, 3) unit vectors spread evenly over the sphere (Fibonacci lattice)."""
    k = np.arange(count) + 0.5
    height, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + 5.0**0.5) * k
    radius = np.sqrt(1.0 - height**2)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def _outermost(points: FloatArray) -> FloatArray:
    return points[np.unique((points @ even_directions(_CORNER_DIRECTIONS).T).argmax(axis=0))]
