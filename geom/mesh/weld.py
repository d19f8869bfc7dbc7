"""Welding: merges points (n, 3) at equal or nearly equal positions, so that neighbouring faces share them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh

# Single-precision files round at 6e-8 of their extent; anything closer than this was one point.
TOLERANCE_PER_DIAGONAL = 1e-7


def weld(mesh: Mesh, tolerance: float | None = None) -> Mesh:
    """`mesh` with equal points merged and unreferenced points dropped; corner attributes are untouched.

    `tolerance` is a length in the unit of the points; by default 1e-7 of the bounding-box diagonal.
    """
    points, triangles = weld_points(mesh.points, mesh.triangles, tolerance)
    return replace(mesh, points=points, triangles=triangles)


def weld_points(points: FloatArray, triangles: IntArray, tolerance: float | None = None) -> tuple[FloatArray, IntArray]:
    """Points (k, 3) float64 and triangles (m, 3) int32 after merging; every triangle is kept, in order.

    Bitwise equal points merge first, then chains of points closer than `tolerance`; the first of a group stays.
    """
    if len(triangles) == 0:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32)
    used, index = np.unique(triangles, return_inverse=True)
    merged = np.asarray(points, dtype=np.float64)[used] + 0.0  # -0.0 and 0.0 are one point
    merged, index = _merge(merged, index.reshape(-1), _equal_groups(merged))
    length = tolerance if tolerance is not None else TOLERANCE_PER_DIAGONAL * diagonal(merged)
    merged, index = _merge(merged, index, _near_groups(merged, length))
    return merged, index.reshape(-1, 3).astype(np.int32)


def diagonal(points: FloatArray) -> float:
    """Length of the bounding-box diagonal; zero for no points."""
    return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0


def _equal_groups(points: FloatArray) -> IntArray:
    return np.unique(points, axis=0, return_inverse=True)[1].reshape(-1)


def _near_groups(points: FloatArray, tolerance: float) -> IntArray:
    if tolerance <= 0.0:
        return np.arange(len(points))
    centred = points - points.mean(axis=0)  # Far from the origin the tree would compare rounded squares.
    pairs = KDTree(centred).query_pairs(tolerance, output_type="ndarray")
    if len(pairs) == 0:
        return np.arange(len(points))
    links = coo_array((np.ones(len(pairs), dtype=bool), (pairs[:, 0], pairs[:, 1])), shape=(len(points),) * 2)
    return connected_components(links, directed=False)[1]


def _merge(points: FloatArray, index: IntArray, groups: IntArray) -> tuple[FloatArray, IntArray]:
    """One point per group, the first of each, in order of first appearance."""
    _, first, inverse = np.unique(groups, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    order = np.argsort(first)
    rank[order] = np.arange(len(first))
    return points[first[order]], rank[inverse.reshape(-1)][index]
