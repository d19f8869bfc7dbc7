"""Convex hulls of points (n, 3) as closed outward surfaces without slivers, reduced to few points; hull measures."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold
from scipy.spatial import ConvexHull, QhullError

from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.physics import CollisionShape

MAX_POINTS = 64
MERGE_TOLERANCE = 1e-6
# Points that stick out of the reduced hull by less than this share of its size are left out.
REDUCTION_TOLERANCE = 1e-3
MAX_GROWTH = 1.1  # Beyond this growth the reduced hull stays too small: so few points do not describe it.


def convex_hull(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) float64 and outward triangles (m, 3) int32 of the convex hull.

    Closed and free of zero-area faces: Manifold's Quickhull (Barber et al. 1996), then its simplification, which merges
    points within 1e-6 of the size. (Qhull triangulates coplanar points into slivers, 1 mesh in 900 not closed.)
    Computed centred and at unit size, so that place and scale do not matter. Raises ValueError when the points span no
    volume.
    """
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    scale = float(np.ptp(points, axis=0).max())
    if not scale > 0.0:
        raise ValueError("the points span no volume")
    unit = (points - centre) / scale
    corners, triangles = _simplified_hull(unit)
    if not _convex(corners, triangles):
        # Among nearly coplanar points Manifold 3.x can take an inner one as a corner and fold the surface over it.
        corners, triangles = _simplified_hull(unit[ConvexHull(unit).vertices])
    return corners * scale + centre, triangles


def _simplified_hull(points: FloatArray) -> tuple[FloatArray, IntArray]:
    hull = Manifold.hull_points(np.ascontiguousarray(points)).simplify(MERGE_TOLERANCE)
    if hull.is_empty() or not hull.volume() > 0.0:
        raise ValueError("the points span no volume")
    mesh = hull.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int32)


def _convex(points: FloatArray, triangles: IntArray) -> bool:
    """Whether a closed surface encloses the volume that Qhull finds for the hull of its points."""
    try:
        full = ConvexHull(points).volume
        return abs(volume(points, triangles) - full) <= 1e-5 * full  # A fold adds volume or loses some.
    except QhullError:  # Too flat for Qhull.
        return True


def hull_shape(
    points: FloatArray, max_points: int = MAX_POINTS, most_growth: float = MAX_GROWTH
) -> CollisionShape | None:
    """The convex hull of `points` (n, 3) as a collision shape, reduced as `reduced_hull` does; None when flat."""
    try:
        hull_points, triangles = reduced_hull(points, max_points, most_growth)
    except ValueError:
        return None
    return CollisionShape("hull", (), np.eye(4), hull_points, triangles)


def reduced_hull(
    points: FloatArray, max_points: int = MAX_POINTS, most_growth: float = MAX_GROWTH
) -> tuple[FloatArray, IntArray]:
    """A hull of at most `max_points` points with the same volume as the full hull, or as near as `most_growth` allows.

    Points are added farthest first (the order of Quickhull), which bounds the error at every step. A hull through a
    subset of the points is too small everywhere, so it is scaled about its centre until the volume is right: the error
    is then shared between both sides of the surface; at `most_growth` 1 the hull lies inside the full one. Raises
    ValueError when the points span no volume.
    """
    full, triangles = convex_hull(points)
    if len(full) <= max_points:
        return full, triangles
    directions = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], dtype=np.float64)
    chosen = list(dict.fromkeys((full @ directions.T).argmax(axis=0).tolist()))[:max_points]
    tolerance = REDUCTION_TOLERANCE * float(np.ptp(full, axis=0).max())
    while len(chosen) < max_points:
        normals, offsets = face_planes(*convex_hull(full[chosen]))
        outside = full @ normals.T - offsets
        beyond = [int(outside[:, f].argmax()) for f in np.argsort(-outside.max(axis=0), kind="stable")]
        beyond_hull = outside.max(axis=1)
        new = [p for p in dict.fromkeys(beyond) if beyond_hull[p] > tolerance and p not in chosen]
        if not new:
            break
        # A quarter at a time: close to one by one in quality, at a fraction of the hull computations.
        chosen += new[: min(max_points - len(chosen), max(1, len(chosen) // 4))]
    points_in, triangles_in = convex_hull(full[sorted(chosen)])
    growth = (volume(full, triangles) / volume(points_in, triangles_in)) ** (1.0 / 3.0)
    centre = centroid(points_in, triangles_in)
    return centre + min(growth, most_growth) * (points_in - centre), triangles_in


def extreme_points(points: FloatArray, directions: int) -> IntArray:
    """Indices (k,), ascending, of the points (n, 3) furthest along even directions (Fibonacci lattice) and the axes."""
    height = 1.0 - (2.0 * np.arange(directions) + 1.0) / directions
    turn = np.arange(directions) * np.pi * (3.0 - np.sqrt(5.0))
    across = np.sqrt(1.0 - height**2)
    even = np.stack([across * np.cos(turn), across * np.sin(turn), height])
    indices = [points.argmax(axis=0), points.argmin(axis=0)]
    indices += [(points @ part).argmax(axis=0) for part in np.array_split(even, max(1, directions // 64), axis=1)]
    return np.unique(np.concatenate(indices))


def volume(points: FloatArray, triangles: IntArray) -> float:
    """Volume inside a closed, outward surface (divergence theorem, about its own middle)."""
    a, b, c = np.moveaxis(points[triangles] - points.mean(axis=0), 1, 0)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def centroid(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Centre (3,) of the volume inside a closed, outward surface."""
    middle = points.mean(axis=0)
    a, b, c = np.moveaxis(points[triangles] - middle, 1, 0)
    weights = np.einsum("ij,ij->i", a, np.cross(b, c))
    return middle + weights @ (a + b + c) / (4.0 * weights.sum())


def thickness(points: FloatArray, triangles: IntArray) -> float:
    """Smallest width of a convex hull across one of its faces; the true width is never larger."""
    normals, offsets = face_planes(points, triangles)
    return float((offsets - (points @ normals.T).min(axis=0)).min())


def contains(points: FloatArray, triangles: IntArray, queries: FloatArray, margin: float = 0.0) -> BoolArray:
    """(k,) True where a query (k, 3) lies inside the hull or less than `margin` outside one of its planes."""
    return beyond_planes(points, triangles, queries) <= margin


def beyond_planes(points: FloatArray, triangles: IntArray, queries: FloatArray) -> FloatArray:
    """(k,) largest signed distance of queries (k, 3) beyond a face plane: a lower bound outside, negative inside."""
    normals, offsets = face_planes(points, triangles)
    return (queries @ normals.T - offsets).max(axis=1)


def face_planes(points: FloatArray, triangles: IntArray) -> tuple[FloatArray, FloatArray]:
    """Outward unit normals (m, 3) and offsets (m,) of the faces; faces without area are left out."""
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    has_area = lengths > 1e-12 * lengths.max()
    normals = normals[has_area] / lengths[has_area, None]
    return normals, np.einsum("ij,ij->i", normals, corners[has_area, 0])
