"""One-sided Hausdorff distance from triangles to a surface: a distance attained by a point and a proven upper bound.

Source: Tang, Lee and Kim 2009, "Interactive Hausdorff distance computation for general polygonal models".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geom.mesh.surface_distance import NearestOnSurface, triangle_areas
from schemas.arrays import FloatArray, IntArray

# Parts examined before the search stops and leaves a wider gap; the first examination of each triangle is free.
SEARCH_BUDGET = 400_000
_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class DistanceBounds:
    """Bounds of the largest distance from one surface to another, in the unit of the points.

    attained  distance of the point `at` (3,) of the first surface: a lower bound.
    bound     upper bound over all points of the first surface; `bound - attained` is the gap that the search left.
    """

    attained: float
    bound: float
    at: FloatArray


ZERO_DISTANCE = DistanceBounds(0.0, 0.0, np.full(3, np.nan))


def one_sided_hausdorff(
    corners: FloatArray,
    points: FloatArray,
    triangles: IntArray,
    tolerance: float,
    *,
    solid: bool = False,
    budget: int = SEARCH_BUDGET,
) -> DistanceBounds:
    """The largest distance from the triangles `corners` (k, 3, 3) to the surface `points`, `triangles`.

    With `solid` the surface is closed and wound outward, and points inside it have distance 0.

    Branch and bound. The distance to one triangle is convex, so over a part it is largest at a corner; the distance to
    the surface is at most that to the triangle nearest to the part's centroid, and at most the centroid's distance plus
    the part's radius. Parts that may exceed the largest distance found by more than `tolerance` are quartered, until
    none is left or the `budget` is spent. Deterministic. Raises ValueError when the surface has no area.
    """
    parts = corners[triangle_areas(corners) > 0.0]
    if len(parts) == 0:
        return ZERO_DISTANCE
    target, surface = NearestOnSurface(points, triangles), points[triangles]
    vertices = np.unique(parts.reshape(-1, 3), axis=0)
    away = _distances(vertices, surface[target(vertices)[1]])
    if solid:
        away[target.inside(vertices)] = 0.0
    attained, at = float(away.max()), vertices[away.argmax()]
    bound, looked_at = attained, -len(parts)
    while len(parts):
        centroids = parts.mean(axis=1)
        nearest = surface[target(centroids)[1]]
        away = _distances(centroids, nearest)
        radii = np.linalg.norm(parts - centroids[:, None], axis=2).max(axis=1)
        at_corners = np.max([_distances(parts[:, k], nearest) for k in range(3)], axis=0)
        bounds = np.minimum(away + radii, at_corners)
        if solid:
            within = target.inside(centroids)
            bounds[within & (away >= radii)] = 0.0
            away[within] = 0.0
        if away.max() > attained:
            attained, at = float(away.max()), centroids[away.argmax()]
        looked_at += len(parts)
        undecided = bounds > attained + tolerance
        if looked_at + 4 * int(undecided.sum()) > budget:
            undecided[:] = False
        bound = max(bound, attained, float(bounds[~undecided].max(initial=0.0)))
        parts = _quartered(parts[undecided])
    return DistanceBounds(attained, bound, at)


def _distances(queries: FloatArray, corners: FloatArray) -> FloatArray:
    """(k,) distances of queries (k, 3) to one triangle (k, 3, 3) each, of any size.

    Where a query projects into the triangle, the distance to its plane; else the least of those to its sides.
    """
    sides = np.roll(corners, -1, axis=1) - corners
    to_query = queries[:, None] - corners
    normals = np.cross(sides[:, 0], sides[:, 1])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), _TINY)
    within = (np.einsum("kix,kx->ki", np.cross(sides, to_query), normals) >= 0.0).all(axis=1)
    along = np.einsum("kix,kix->ki", to_query, sides) / np.maximum(np.einsum("kix,kix->ki", sides, sides), _TINY)
    off_sides = to_query - np.clip(along, 0.0, 1.0)[..., None] * sides
    to_plane: FloatArray = np.abs(np.einsum("kx,kx->k", to_query[:, 0], normals))
    to_sides: FloatArray = np.linalg.norm(off_sides, axis=2).min(axis=1)
    return np.where(within, to_plane, to_sides)


def _quartered(parts: FloatArray) -> FloatArray:
    """(4 k, 3, 3) the triangles (k, 3, 3) cut at the middles of their sides."""
    a, b, c = parts[:, 0], parts[:, 1], parts[:, 2]
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(quarter, axis=1) for quarter in quarters])
