"""Resting planes of a body: the broad facets of its convex hull, and collision hulls trimmed to them.

A body rests on facets of its convex hull (Goldberg et al. 1999, "Part pose statistics"). A collision hull that extends
slightly through such a facet tips the body, so the excess is cut off. Lengths in the unit of the points.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from manifold3d import Manifold

from geom.convex.hull import MAX_POINTS, convex_hull, hull_shape
from geom.mesh.manifold_arrays import manifold_arrays
from geom.mesh.surface_distance import triangle_areas
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

# Faces of the convex hull within this cosine are one facet; it counts as a resting facet from this share of the
# hull's surface on, which keeps the foot of a vase and leaves out the faces of round bodies.
SAME_FACET, LEAST_AREA = 0.9999, 0.03
BIN = 0.01  # of the components of a normal
# An excess below this share of the hull's size is rounding.
EXCESS_ROUNDING = 1e-9


class HalfSpaces(NamedTuple):
    """Half spaces `normals @ p <= offsets`: outward unit normals (k, 3), offsets (k,) in the unit of the points."""

    normals: FloatArray
    offsets: FloatArray


def resting_planes(points: FloatArray) -> HalfSpaces:
    """Half-spaces of the broad facets of the convex hull of points (n, 3), largest first; all points lie within them.

    Empty for points that span no volume.
    """
    try:
        corners, triangles = convex_hull(points)
    except ValueError:
        return HalfSpaces(np.zeros((0, 3)), np.zeros(0))
    a, b, c = np.moveaxis(corners[triangles], 1, 0)
    areas = triangle_areas(corners[triangles])
    normals = np.cross(b - a, c - a) / np.maximum(2.0 * areas, np.finfo(float).tiny)[:, None]
    least, left, facet_normals = LEAST_AREA * float(areas.sum()), areas.copy(), list[FloatArray]()
    # Round bodies have very many faces: only those count whose bin of normals has an eighth of the area of a facet.
    _, bins = np.unique(np.rint(normals / BIN).astype(np.int64), axis=0, return_inverse=True)
    left[np.bincount(bins.reshape(-1), areas)[bins.reshape(-1)] < least / 8.0] = 0.0
    while left.max() > 0.0:
        facet = (normals @ normals[left.argmax()] > SAME_FACET) & (left > 0.0)
        if left[facet].sum() >= least:
            mean = left[facet] @ normals[facet]
            facet_normals.append(mean / np.linalg.norm(mean))
        left[facet] = 0.0
    stacked = np.array(facet_normals).reshape(-1, 3)
    return HalfSpaces(stacked, (stacked @ corners.T).max(axis=1))


def hull_within(points: FloatArray, half_spaces: HalfSpaces, max_points: int = MAX_POINTS) -> CollisionShape | None:
    """The hull of points (n, 3) within the half-spaces, as a shape of at most `max_points` points; None when flat."""
    shape = hull_shape(points, max_points)
    if shape is None or shape.points is None:
        return shape
    corners = shape.points
    rounding = EXCESS_ROUNDING * float(np.ptp(corners, axis=0).max())
    beyond = (corners @ half_spaces.normals.T - half_spaces.offsets).max(axis=0, initial=-np.inf) > rounding
    if not beyond.any():
        return shape
    # About its own middle, so that the position does not matter.
    middle = corners.mean(axis=0)
    hull = Manifold.hull_points(np.ascontiguousarray(corners - middle))
    for normal, offset in zip(half_spaces.normals[beyond], half_spaces.offsets[beyond], strict=True):
        hull = hull.trim_by_plane((-normal[0], -normal[1], -normal[2]), float(normal @ middle - offset))
    if hull.is_empty():
        return None
    # Cutting adds corners; the reduced hull must not grow over the planes again.
    return hull_shape(manifold_arrays(hull)[0] + middle, max_points, most_growth=1.0)
