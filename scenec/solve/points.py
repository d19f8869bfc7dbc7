"""Points of a region: uniform random samples, or the extreme point along a direction."""

from __future__ import annotations

from math import inf

import numpy as np
import shapely
from numpy.random import Generator
from shapely.geometry.base import BaseGeometry


def sample_point(region: BaseGeometry, rng: Generator) -> tuple[float, float] | None:
    """A point sampled uniformly from a region's area, from its lines where it has no area; None where it is empty."""
    if region.is_empty:
        return None
    if region.area > 1e-16:
        triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(region))
        areas = shapely.area(triangles).cumsum()
        chosen = triangles[min(int(np.searchsorted(areas, rng.random() * areas[-1])), len(areas) - 1)]
        a, b, c = shapely.get_coordinates(chosen)[:3]
        u, v = rng.random(2)
        if u + v > 1.0:
            u, v = 1.0 - u, 1.0 - v
        x, y = a + u * (b - a) + v * (c - a)
        return float(x), float(y)
    # A polygon without measurable area is sampled along its boundary.
    lines = [getattr(part, "exterior", part) for part in shapely.get_parts(region) if part.length > 0.0]
    if lines:
        point = max(lines, key=lambda part: part.length).interpolate(rng.random(), normalized=True)
        return point.x, point.y
    return extreme_point(region, 1.0, 0.0)


def extreme_point(region: BaseGeometry, dx: float, dy: float) -> tuple[float, float] | None:
    """The vertex of a region farthest along (dx, dy); None where it is empty."""
    points = shapely.get_coordinates(region)
    if not len(points):
        return None
    x, y = points[int(np.argmax(points @ (dx, dy)))]
    return (float(x), float(y)) if max(abs(x), abs(y)) < inf else None
