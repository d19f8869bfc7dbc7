"""Contact points and outline of a pushed body in the plane of the support, m, from its shapes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, Delaunay, QhullError

from schemas.arrays import FloatArray
from schemas.measurement import Subject

_LOW = 0.02  # share of the height within which vertices count as of the lowest face
_FOOTPRINT_CELLS = 24


def vertices_of(subject: Subject, root: Path) -> FloatArray:
    """(n, 3) corners of the subject in its own frame. Raises ValueError when it has no shape."""
    if subject.box is not None:
        signs = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
        return signs * np.array(subject.box.size_m)
    if subject.mesh is not None:
        return np.asarray(trimesh.load_mesh(root / subject.mesh, process=False).vertices, dtype=float)
    raise ValueError("the subject has neither box nor mesh: a push needs its outline")


def outlines(vertices: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(k, 2) convex outline that a pusher meets and (j, 2) that the body stands on, counter-clockwise, z up.

    Raises ValueError for a body that does not stand on a face.
    """
    height = vertices[:, 2]
    low = height <= height.min() + _LOW * float(np.ptp(height))
    return _hull(vertices[:, :2]), _hull(vertices[low, :2])


def _hull(points: FloatArray) -> FloatArray:
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        raise ValueError("the body does not stand on a face: a pressure under it cannot be assumed") from None


def even_points(outline: FloatArray) -> FloatArray:
    """(p, 2) points spread evenly over a convex outline, each for the same share of the load."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    middles = (np.arange(_FOOTPRINT_CELLS) + 0.5) / _FOOTPRINT_CELLS
    grid = np.stack(np.meshgrid(middles, middles), axis=-1).reshape(-1, 2) * (high - low) + low
    return grid[Delaunay(outline).find_simplex(grid) >= 0]


def nearest(outline: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Signed distance (n,) of points (n, 2) from a convex outline (outside positive), the nearest place (n, 2) on it,
    and the outward normal there (n, 2).
    """
    a, b = outline, np.roll(outline, -1, axis=0)
    edge = b - a
    length = np.linalg.norm(edge, axis=1)
    share = np.clip(((points[:, None] - a) * edge).sum(axis=2) / length**2, 0.0, 1.0)
    place = a + share[..., None] * edge
    apart = points[:, None] - place
    outward = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / length[:, None]
    inside = ((points[:, None] - a) * outward).sum(axis=2).max(axis=1) <= 0.0
    distance = np.linalg.norm(apart, axis=2)
    k = distance.argmin(axis=1)
    rows = np.arange(len(points))
    d, q, n = distance[rows, k], place[rows, k], outward[k]
    corner = ~inside & ((share[rows, k] <= 0.0) | (share[rows, k] >= 1.0)) & (d > 1e-9)
    n = np.where(corner[:, None], apart[rows, k] / np.maximum(d, 1e-9)[:, None], n)
    return np.where(inside, -d, d), q, n
