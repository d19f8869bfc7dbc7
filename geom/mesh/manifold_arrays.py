"""Conversion between manifold3d bodies and points (n, 3), triangles (m, 3)."""

from __future__ import annotations

import numpy as np
from manifold3d import Error, Manifold, Mesh64

from schemas.arrays import FloatArray, IntArray

# Of the volume: an import that changes it by more has lost corners. Of the longest side: far above the precision of the
# import (1e-12), far below any length that counts.
IMPORT_TOLERANCE, JITTER_SHARE = 1e-6, 1e-9


def manifold_arrays(body: Manifold) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) float64 and triangles (m, 3) int64 of a body, in its unit."""
    mesh = body.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64)


def manifold_of(points: FloatArray, triangles: IntArray) -> Manifold:
    """The body inside a closed outward surface; its `status()` is an error when that is no oriented manifold.

    On import manifold3d 3.5 drops points between collinear edges, and at a pinched edge takes corners for such: a board
    came out 4 % smaller. Where the volume has changed, the points are moved at random by `JITTER_SHARE` before.
    """
    body = _imported(points, triangles)
    volume = signed_volume(points, triangles)
    if body.status() != Error.NoError or abs(body.volume() - volume) <= IMPORT_TOLERANCE * abs(volume):
        return body
    step = JITTER_SHARE * float(np.ptp(points, axis=0).max())
    return _imported(points + step * np.random.default_rng(0).uniform(-1.0, 1.0, points.shape), triangles)


def signed_volume(points: FloatArray, triangles: IntArray) -> float:
    """Volume enclosed by a closed surface, about its own centre, so that its position does not matter."""
    if len(triangles) == 0:
        return 0.0
    corners = points[triangles]
    corners = corners - corners.reshape(-1, 3).mean(axis=0)
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0)


def _imported(points: FloatArray, triangles: IntArray) -> Manifold:
    return Manifold(Mesh64(np.ascontiguousarray(points), np.ascontiguousarray(triangles, dtype=np.uint64)))
