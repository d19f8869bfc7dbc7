"""Unit normals of faces (m, 3) and of triangle corners (m, 3, 3), from points (n, 3) and triangles (m, 3)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from schemas.arrays import Float32Array, FloatArray, IntArray

CREASE_RAD = float(np.radians(40.0))  # A 12-sided cylinder (30 degrees) looks round, a cube stays sharp.


def corner_normals(points: FloatArray, triangles: IntArray, crease_rad: float = CREASE_RAD) -> Float32Array:
    """(m, 3, 3) float32 unit normals per triangle corner, smooth across edges flatter than `crease_rad`.

    Corners at one position belong together when a chain of faces around it is joined by edges shared by exactly two
    faces with a smaller angle between them; each group gets the area-weighted mean of its faces (weightings: Jin, Lewis
    and West 2005, "A comparison of algorithms for vertex normal computation"). Points at equal positions count as one,
    so UV seams do not show. Faces without area take the normal of their group, or +z when it has none.
    """
    count = len(triangles)
    if count == 0:
        return np.zeros((0, 3, 3), dtype=np.float32)
    _, position = np.unique(points, axis=0, return_inverse=True)
    corners = position.reshape(-1)[triangles]
    vectors = face_vectors(points, triangles)
    labels = _smooth_groups(corners, _unit(vectors, fallback=None), crease_rad)
    sums = np.stack([np.bincount(labels, weights=np.repeat(vectors[:, k], 3)) for k in range(3)], axis=1)
    normals = _unit(sums.astype(np.float64, copy=False), fallback=np.array([0.0, 0.0, 1.0]))
    return normals[labels].reshape(count, 3, 3).astype(np.float32)


def face_vectors(points: FloatArray, triangles: IntArray) -> FloatArray:
    """(m, 3) vectors along the face normals whose length is twice the area."""
    a, b, c = points[triangles[:, 0]], points[triangles[:, 1]], points[triangles[:, 2]]
    return np.cross(b - a, c - a)


def face_normals(points: FloatArray, triangles: IntArray) -> Float32Array:
    """(m, 3) float32 unit face normals; +z for faces without area."""
    return _unit(face_vectors(points, triangles), fallback=np.array([0.0, 0.0, 1.0])).astype(np.float32)


def _smooth_groups(corners: IntArray, normals: FloatArray, crease_rad: float) -> IntArray:
    """(3 m,) group of every corner; `corners` (m, 3) are welded point numbers, `normals` (m, 3) unit or zero."""
    count = len(corners)
    start, end = corners.reshape(-1), np.roll(corners, -1, axis=1).reshape(-1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.lexsort((high, low))
    low, high = low[order], high[order]
    first = np.flatnonzero(np.concatenate([[True], (low[1:] != low[:-1]) | (high[1:] != high[:-1])]))
    length = np.diff(np.concatenate([first, [len(order)]]))
    pairs = first[length == 2]
    left, right = order[pairs], order[pairs + 1]  # half-edge k: triangle k // 3, from corner k to its next corner
    cosine = np.einsum("ij,ij->i", normals[left // 3], normals[right // 3])
    # Opposite directions only: two faces wound against each other have no common side to smooth.
    smooth = (cosine >= np.cos(crease_rad)) & (start[left] == end[right])
    left, right = left[smooth], right[smooth]
    rows = np.concatenate([left, _next_corner(left)])
    columns = np.concatenate([_next_corner(right), right])
    graph = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(3 * count, 3 * count))
    return connected_components(graph, directed=False)[1]


def _next_corner(corner: IntArray) -> IntArray:
    return corner - corner % 3 + (corner % 3 + 1) % 3


def _unit(vectors: FloatArray, fallback: FloatArray | None) -> FloatArray:
    """`vectors` at unit length; zero and non-finite ones become `fallback`, or zero without one."""
    longest = np.abs(vectors).max(axis=1, keepdims=True)
    usable = np.isfinite(longest) & (longest > 0.0)
    # Divide by the largest component first: squares of areas of 1 mm faces would underflow.
    scaled = np.where(usable, vectors / np.where(usable, longest, 1.0), 0.0)
    length = np.linalg.norm(scaled, axis=1, keepdims=True)
    return np.where(usable, scaled / np.where(usable, length, 1.0), 0.0 if fallback is None else fallback)
