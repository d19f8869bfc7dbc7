"""Triangulation of a closed loop of points (n, 3) in space that bends least against the surface around it."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray, IntArray

# Cubic in the number of points: this many cost a quarter of a second.
MOST_POINTS = 150
# Area only decides between triangulations that bend alike.
AREA_WEIGHT = 1e-6


def triangulate_loop(rim: FloatArray, normals: FloatArray, forbidden: FloatArray) -> IntArray | None:
    """(n - 2, 3) indices into the loop `rim` (n, 3), wound like it; None when every way needs a forbidden chord.

    `normals` (n, 3) are those of the faces beyond each side, from point i to i + 1; `forbidden` (n, n) is True for
    pairs that may not be joined, because the surface has that edge. Minimises the sum over all sides and chords of
    length times bending angle, so that planes and cylinders are continued exactly. Dynamic programming over sub-loops:
    Liepa 2003, "Filling holes in meshes", section 3, with the additive measure of Alboul and van Damme 1996.
    """
    count = len(rim)
    scale = float(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1).sum())
    cost = np.zeros((count, count))
    apex = np.zeros((count, count), dtype=np.int64)
    beyond = np.zeros((count, count, 3))
    index = np.arange(count)
    beyond[index, (index + 1) % count] = normals
    for span in range(2, count):
        first = np.arange(count - span)
        last = first + span
        middle = first[:, None] + np.arange(1, span)
        i, j = (np.broadcast_to(ends[:, None], middle.shape) for ends in (first, last))
        vector = np.cross(rim[middle] - rim[i], rim[j] - rim[i])
        double_area = np.linalg.norm(vector, axis=2)
        normal = vector / np.maximum(double_area, np.finfo(float).tiny)[..., None]
        total = cost[i, middle] + cost[middle, j] + AREA_WEIGHT * double_area / scale
        total += _bending(rim, normal, beyond, i, middle) + _bending(rim, normal, beyond, middle, j)
        if span == count - 1:  # The last triangle also meets the face beyond the closing side.
            closing = np.broadcast_to(normals[-1], normal.shape)
            total += np.linalg.norm(rim[-1] - rim[0]) * _angle(normal, closing)
        else:
            total[forbidden[first, last]] = np.inf
        best = total.argmin(axis=1)
        cost[first, last] = total[first, best]
        apex[first, last] = middle[first, best]
        beyond[first, last] = normal[first, best]
    if not np.isfinite(cost[0, count - 1]):
        return None
    return np.array(_triangles(apex, count))


def continued_faces(
    points: FloatArray, normals: FloatArray, loop: IntArray, triangles: IntArray
) -> tuple[IntArray, FloatArray]:
    """For each of `triangles` (m, 3) over a loop: the face (m,) beyond the loop that it continues, and the bend (m,).

    `normals` (n, 3) are those of the faces beyond the loop's sides. A triangle continues the face from which it
    bends least, directly or through other triangles; the bend is the largest angle on that path, in radians.
    """
    rim = loop.tolist()
    both = np.concatenate([normals, unit_normals(points[triangles])])
    at: dict[frozenset[int], list[int]] = {
        frozenset(s): [i] for i, s in enumerate(zip(rim, rim[1:] + rim[:1], strict=True))
    }
    for i, (a, b, c) in enumerate(triangles.tolist()):
        for side in ((a, b), (b, c), (c, a)):
            at.setdefault(frozenset(side), []).append(len(rim) + i)
    links = [pair for pair in at.values() if len(pair) == 2]
    bends = sorted((float(_angle(both[i], both[j])), i, j) for i, j in links)
    source = np.append(np.arange(len(rim)), np.full(len(triangles), -1))
    across = np.append(np.zeros(len(rim)), np.full(len(triangles), np.pi))
    while link := next(((bend, i, j) for bend, i, j in bends if (source[i] < 0) != (source[j] < 0)), None):
        bend, i, j = link
        known, new = (j, i) if source[i] < 0 else (i, j)
        source[new], across[new] = source[known], max(bend, across[known])
    return np.maximum(source[len(rim) :], 0), across[len(rim) :]


def unit_normals(corners: FloatArray) -> FloatArray:
    """(m, 3) normals of triangles (m, 3, 3); zero where a triangle has no area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)


def _bending(rim: FloatArray, normal: FloatArray, beyond: FloatArray, a: IntArray, b: IntArray) -> FloatArray:
    return np.linalg.norm(rim[b] - rim[a], axis=2) * _angle(normal, beyond[a, b])


def _angle(a: FloatArray, b: FloatArray) -> FloatArray:
    """Angle between unit vectors, good to rounding also where it is small (Kahan)."""
    return 2.0 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))


def _triangles(apex: IntArray, count: int) -> list[tuple[int, int, int]]:
    triangles: list[tuple[int, int, int]] = []
    pending = [(0, count - 1)]
    while pending:
        i, j = pending.pop()
        if j - i >= 2:
            k = int(apex[i, j])
            triangles.append((i, k, j))
            pending += [(k, j), (i, k)]
    return triangles
