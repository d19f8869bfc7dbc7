"""Minkowski erosion and difference in the plane: where the origin of a convex outline (n, 2) may lie.

Regions are shapely geometries, in the unit of the outline.
"""

from __future__ import annotations

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from schemas.arrays import FloatArray


def eroded(region: BaseGeometry, outline: FloatArray) -> BaseGeometry:
    """The origins for which all of a convex `outline` (n, 2) lies in `region`, which may have holes and several parts.

    An outline lies inside when its centre does and no edge of the region meets it; it meets an edge exactly where its
    origin lies in the convex hull of the edge and the mirrored outline.
    """
    if region.is_empty:
        return region
    inside = affinity.translate(region, *(-outline.mean(axis=0)))
    ends = _edges(region)
    sums = (ends[:, :, None, :] - outline).reshape(len(ends), -1, 2)
    blocked = shapely.union_all(shapely.convex_hull(shapely.linestrings(sums)))
    return inside.difference(blocked)


def minkowski_difference(obstacle: BaseGeometry, outline: FloatArray) -> BaseGeometry:
    """The origins for which a convex `outline` (n, 2) meets a convex obstacle: the obstacle minus the outline."""
    # A line through the points has the same hull and is built far faster than a set of points.
    corners = shapely.get_coordinates(obstacle)
    return LineString((corners[:, None] - outline).reshape(-1, 2)).convex_hull


def _edges(region: BaseGeometry) -> FloatArray:
    """(e, 2, 2) ends of the edges of all rings."""
    rings = [ring for part in shapely.get_parts(region) for ring in (part.exterior, *part.interiors)]
    return np.concatenate([np.stack([p[:-1], p[1:]], axis=1) for p in (np.asarray(ring.coords) for ring in rings)])
