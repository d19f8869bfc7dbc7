"""Refinement and fairing of the triangles over a hole, so that they continue the surrounding surface smoothly.

Source: Liepa 2003, "Filling holes in meshes".
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

from geom.mesh.edges import edges_of
from schemas.arrays import FloatArray, IntArray

# A triangle is split while its middle is further from its corners than this many times their spacing (Liepa: sqrt 2).
DENSITY = float(np.sqrt(2.0))
REFINE_ROUNDS = 12
MOST_NEW_POINTS = 1500


def fair_patch(points: FloatArray, around: IntArray, cap: IntArray) -> tuple[FloatArray, IntArray]:
    """New points (k, 3) and triangles (m, 3) in place of `cap`; the triangles count the new points from `len(points)`.

    `around` (f, 3) are the faces that touch the rim. Refinement: triangles are split at their centroid and edges are
    swapped towards Delaunay until the spacing matches that of the rim. Fairing: the new points minimise the squared
    scale-dependent umbrella vectors of themselves and of the rim, whose other neighbours lie on the surface, so that
    the patch meets it with a common tangent. Source: Liepa 2003, "Filling holes in meshes", sections 4 and 5.
    """
    used, local = np.unique(np.concatenate([around, cap]), return_inverse=True)
    local = local.reshape(-1, 3)
    fixed, outside, inside = points[used], local[: len(around)], local[len(around) :]
    grown, refined = _refined(fixed, outside, inside)
    count = len(fixed)
    if len(grown) == count:
        return np.zeros((0, 3)), cap
    faired = _faired(grown, np.concatenate([outside, refined]), np.unique(refined), count)
    index = np.concatenate([used, len(points) + np.arange(len(grown) - count)])
    return faired, index[refined]


def _refined(points: FloatArray, outside: IntArray, inside: IntArray) -> tuple[FloatArray, IntArray]:
    """Points with the new ones appended, and the refined triangles."""
    spacing = _spacing(points, outside)
    for _ in range(REFINE_ROUNDS):
        corners = points[inside]
        middle = corners.mean(axis=1)
        corner_distance = np.linalg.norm(corners - middle[:, None], axis=2)
        split = (DENSITY * corner_distance > np.maximum(spacing[inside], spacing[inside].mean(axis=1)[:, None])).all(
            axis=1
        )
        if not split.any() or len(points) + split.sum() > len(spacing) + MOST_NEW_POINTS:
            break
        new = len(points) + np.arange(int(split.sum()))
        a, b, c = inside[split].T
        spacing = np.concatenate([spacing, spacing[inside[split]].mean(axis=1)])
        points = np.concatenate([points, middle[split]])
        parts = [np.stack(part, axis=1) for part in ((a, b, new), (b, c, new), (c, a, new))]
        inside = _relaxed(points, np.concatenate([inside[~split], *parts]))
    return points, inside


def _spacing(points: FloatArray, triangles: IntArray) -> FloatArray:
    """(n,) mean length of the edges at each point; the overall mean where there is none."""
    edges = edges_of(triangles).points
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    total = np.bincount(edges.reshape(-1), np.repeat(length, 2), len(points))
    uses = np.bincount(edges.reshape(-1), minlength=len(points))
    return np.where(uses > 0, total / np.maximum(uses, 1), length.mean())


def _relaxed(points: FloatArray, triangles: IntArray) -> IntArray:
    """Inner edges swapped where the two angles opposite to them add up to more than a half turn, one by one."""
    faces = [tuple(int(v) for v in face) for face in triangles]
    at = {(face[k], face[(k + 1) % 3]): i for i, face in enumerate(faces) for k in range(3)}
    pending = [edge for edge in at if edge[0] < edge[1]]
    swaps = 0
    while pending and swaps < 10 * len(faces):
        a, b = pending.pop()
        face_a, face_b = at.get((a, b)), at.get((b, a))
        if face_a is None or face_b is None:
            continue
        c, d = _opposite(faces[face_a], a, b), _opposite(faces[face_b], a, b)
        joined = (c, d) in at or (d, c) in at
        if joined or _angle(points, c, a, b) + _angle(points, d, a, b) <= np.pi + 1e-9:
            continue
        faces[face_a], faces[face_b] = (c, a, d), (d, b, c)
        for i in (face_a, face_b):
            for k in range(3):
                at[faces[i][k], faces[i][(k + 1) % 3]] = i
        del at[a, b], at[b, a]
        pending += [(c, a), (a, d), (d, b), (b, c)]
        swaps += 1
    return np.array(faces)


def _opposite(face: tuple[int, ...], a: int, b: int) -> int:
    return next(v for v in face if v not in (a, b))


def _angle(points: FloatArray, at: int, a: int, b: int) -> float:
    u, v = points[a] - points[at], points[b] - points[at]
    return float(np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v))


def _faired(points: FloatArray, triangles: IntArray, patch: IntArray, known: int) -> FloatArray:
    """(k, 3) the points from `known` on, at which the umbrella vectors at the points of `patch` are least."""
    edges = edges_of(triangles).points
    weight = 1.0 / np.maximum(np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1), np.finfo(float).tiny)
    rows, columns = np.concatenate([edges, edges[:, ::-1]]).T
    weights = np.tile(weight, 2)
    total = np.bincount(rows, weights, len(points))
    here = np.arange(len(points))
    umbrella = coo_array(
        (
            np.concatenate([weights / total[rows], -np.ones(len(points))]),
            (np.concatenate([rows, here]), np.concatenate([columns, here])),
        ),
        shape=(len(points),) * 2,
    ).tocsr()[patch]
    free = umbrella[:, known:]
    right = umbrella[:, :known] @ points[:known]
    return np.asarray(spsolve((free.T @ free).tocsc(), -(free.T @ right))).reshape(-1, 3)
