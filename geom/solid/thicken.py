"""Thickening of an open sheet to a closed wall (metres), by half the thickness to each side."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold, OpType

from geom.mesh.surface_distance import triangle_areas
from geom.mesh.weld import weld_points
from schemas.arrays import FloatArray, IntArray

MITRE_LIMIT = 3.0
LEAST_ACROSS = 0.5  # Of half a wall: a mitre that gives a face less thickness at its corner does not count for it.


def thicken(points: FloatArray, triangles: IntArray, thickness_m: float) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) and outward triangles (m, 3) of the wall of `thickness_m` around a sheet; closed and manifold.

    Each triangle becomes the hull of its corners moved to both sides, the union of all is the wall. Corners move along
    the mitre of the faces around them, at most three half walls, so that the faces keep their thickness at folds.
    Raises ValueError when no triangle has area.
    """
    points, triangles = weld_points(points, triangles)
    triangles = triangles[triangle_areas(points[triangles]) > 0.0]
    if len(triangles) == 0:
        raise ValueError("the sheet has no area")
    corners, offset = points[triangles], 0.5 * thickness_m * _offsets(points, triangles)
    plates = [
        Manifold.hull_points(np.ascontiguousarray(np.concatenate([corner + away, corner - away])))
        for corner, away in zip(corners, offset, strict=True)
    ]
    mesh = Manifold.batch_boolean(plates, OpType.Add).to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3].astype(np.float64), np.asarray(mesh.tri_verts).astype(np.int32)


def _offsets(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Per face and corner (m, 3, 3) the mitre there; the normal of the face where the mitre is not across the face.

    Where a sheet is folded back onto itself the normals around a point cancel, and the mitre has no direction.
    """
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    mitres = _mitres(points, triangles)[triangles]
    across = np.abs(np.einsum("mki,mi->mk", mitres, normals)) >= LEAST_ACROSS
    return np.where(across[..., None], mitres, normals[:, None, :])


def _mitres(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Per point (n, 3) the vector whose product with the normals of the faces around it is 1 on average.

    Normals are weighted by the face's angle at the point (Thürmer and Wüthrich 1998).
    """
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    total, weight = np.zeros(points.shape), np.zeros(len(points))
    for k in range(3):
        u, v = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
        np.add.at(total, triangles[:, k], angle[:, None] * normals)
        np.add.at(weight, triangles[:, k], angle)
    mean = total / np.maximum(weight, np.finfo(float).tiny)[:, None]
    square = np.einsum("ij,ij->i", mean, mean)
    # mean / |mean|² has product 1 with the mean; its length is 1 / |mean|, limited where faces nearly cancel.
    length = np.sqrt(square)
    return mean / np.maximum(square, length / MITRE_LIMIT)[:, None].clip(np.finfo(float).tiny)
