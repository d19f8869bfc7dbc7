"""Where a convex outline may stand so that it stays inside a region of the plane (Minkowski erosion)."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from schemas.model import FloatArray


def eroded(region: BaseGeometry, outline: FloatArray) -> BaseGeometry:
    """Where the origin of a convex `outline` (n, 2) may be so that all of it lies in `region`, holes and parts heeded.

    An outline whose centre lies inside, and which no edge of the region meets, lies inside; it meets an edge exactly
    where the origin lies in the hull of edge and mirrored outline.
    """
    if region.is_empty:
        return region
    inside = affinity.translate(region, *(-outline.mean(axis=0)))
    ends = _edges(region)
    sums = (ends[:, :, None, :] - outline).reshape(len(ends), -1, 2)
    blocked = shapely.union_all(shapely.convex_hull(shapely.linestrings(sums)))
    return inside.difference(blocked)


def meets(obstacle: BaseGeometry, outline: FloatArray) -> BaseGeometry:
    """Where the origin of a convex `outline` (n, 2) is when it meets a convex obstacle: their Minkowski difference."""
    # A line through points has their hull, and is made far faster than a set of points.
    corners = shapely.get_coordinates(obstacle)
    return LineString((corners[:, None] - outline).reshape(-1, 2)).convex_hull


def _edges(region: BaseGeometry) -> FloatArray:
    """(e, 2, 2) ends of the edges of all rings."""
    rings = [ring for part in shapely.get_parts(region) for ring in (part.exterior, *part.interiors)]
    return np.concatenate([np.stack([p[:-1], p[1:]], axis=1) for p in (np.asarray(ring.coords) for ring in rings)])
