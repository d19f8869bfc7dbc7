"""The planes that a body rests on, and hulls kept on its side of them.

A body stands on facets of its convex hull (Goldberg et al. 1999, "Part pose statistics"). A hull that reaches through
such a facet by a hair tips the body, so what sticks out there is cut off.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from manifold3d import Manifold

from geom.convex.hull import MAX_POINTS, convex_hull, hull_shape
from geom.decomposition.simplified_body import arrays
from geom.mesh.surface_distance import triangle_areas
from schemas.model import FloatArray
from schemas.physics import CollisionShape

# Faces of the convex hull within this cosine are one facet; it is one to rest on from this share of the hull's surface
# on, which keeps the foot of a vase and leaves out the faces of what is round and rolls.
SAME_FACET, LEAST_AREA = 0.9999, 0.03
BIN = 0.01  # of the components of a normal
# A hull that reaches through a plane by this share of its own size does not: rounding.
ROUNDING = 1e-9


class Planes(NamedTuple):
    """Half spaces `normals @ p <= offsets`: outward unit normals (k, 3), offsets (k,) in the unit of the points."""

    normals: FloatArray
    offsets: FloatArray


def resting_planes(points: FloatArray) -> Planes:
    """Planes of the broad facets of the convex hull of points (n, 3), largest first; all points lie within them.

    None of them for points that span no volume.
    """
    try:
        corners, triangles = convex_hull(points)
    except ValueError:
        return Planes(np.zeros((0, 3)), np.zeros(0))
    a, b, c = np.moveaxis(corners[triangles], 1, 0)
    areas = triangle_areas(corners[triangles])
    normals = np.cross(b - a, c - a) / np.maximum(2.0 * areas, np.finfo(float).tiny)[:, None]
    least, left, found = LEAST_AREA * float(areas.sum()), areas.copy(), list[FloatArray]()
    # What is round has very many faces: only those count whose bin of normals holds a corner's share of a facet.
    _, bins = np.unique(np.rint(normals / BIN).astype(np.int64), axis=0, return_inverse=True)
    left[np.bincount(bins.reshape(-1), areas)[bins.reshape(-1)] < least / 8.0] = 0.0
    while left.max() > 0.0:
        facet = (normals @ normals[left.argmax()] > SAME_FACET) & (left > 0.0)
        if left[facet].sum() >= least:
            mean = left[facet] @ normals[facet]
            found.append(mean / np.linalg.norm(mean))
        left[facet] = 0.0
    stacked = np.array(found).reshape(-1, 3)
    return Planes(stacked, (stacked @ corners.T).max(axis=1))


def standing_hull(points: FloatArray, ground: Planes, max_points: int = MAX_POINTS) -> CollisionShape | None:
    """The hull of points (n, 3) as a shape of at most `max_points` points that ends at `ground`; None when flat."""
    shape = hull_shape(points, max_points)
    if shape is None or shape.points is None:
        return shape
    corners = shape.points
    rounding = ROUNDING * float(np.ptp(corners, axis=0).max())
    beyond = (corners @ ground.normals.T - ground.offsets).max(axis=0, initial=-np.inf) > rounding
    if not beyond.any():
        return shape
    # About its own middle, so that the place does not matter.
    middle = corners.mean(axis=0)
    hull = Manifold.hull_points(np.ascontiguousarray(corners - middle))
    for normal, offset in zip(ground.normals[beyond], ground.offsets[beyond], strict=True):
        hull = hull.trim_by_plane((-normal[0], -normal[1], -normal[2]), float(normal @ middle - offset))
    if hull.is_empty():
        return None
    # Cutting adds corners; what few remain must not grow over the planes again.
    return hull_shape(arrays(hull)[0] + middle, max_points, most_growth=1.0)
