"""Decimation of triangle surfaces by quadric edge collapse, with attributes and the measured distance to the source."""

from __future__ import annotations

from dataclasses import replace

import fast_simplification
import numpy as np

from geom.mesh.surface_distance import closest_on_surface, two_way_distance
from geom.mesh.topology import degenerate_faces
from geom.mesh.weld import weld_points
from schemas.arrays import Float32Array, FloatArray, IntArray
from schemas.model import Mesh

Figures = dict[str, float]
FIGURE_SAMPLES = 4000


def decimate(points: FloatArray, triangles: IntArray, target_faces: int) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) and triangles (m, 3) with about `target_faces` faces; the input when it has no more.

    Quadric edge collapse (Garland and Heckbert 1997) by fast-simplification, in single precision, hence centred and
    scaled to unit size first. Equal points are welded beforehand, so that seams do not tear.
    """
    if len(triangles) <= target_faces:
        return points, triangles
    welded, faces = weld_points(points, triangles)
    faces = faces[~degenerate_faces(welded, faces)]
    centre = 0.5 * (welded.min(axis=0) + welded.max(axis=0))
    scale = float(np.ptp(welded, axis=0).max()) or 1.0
    unit = ((welded - centre) / scale).astype(np.float32)
    simplified = fast_simplification.simplify(unit, faces.astype(np.int32), target_count=max(4, target_faces))
    return np.asarray(simplified[0], dtype=np.float64) * scale + centre, np.asarray(simplified[1], dtype=np.int32)


def decimate_mesh(mesh: Mesh, target_faces: int) -> tuple[Mesh, Figures]:
    """`mesh` with about `target_faces` faces; each new corner takes the attributes of the nearest source point.

    Each corner is moved slightly into its own face first, so that it finds the right side of a UV seam or hard edge.
    Figures: `triangles_before`, `triangles_after`, `surface_distance_p95_m`, `surface_distance_max_m`.
    """
    points, triangles = decimate(mesh.points, mesh.triangles, target_faces)
    if triangles is mesh.triangles:
        return mesh, _figures(len(triangles), len(triangles), 0.0, 0.0)
    corners = points[triangles]
    inward = corners + 0.05 * (corners.mean(axis=1, keepdims=True) - corners)
    nearest, source = closest_on_surface(inward.reshape(-1, 3), mesh.points, mesh.triangles)
    weights = _barycentric(nearest, mesh.points[mesh.triangles[source]])

    def interpolated(values: Float32Array) -> Float32Array:
        mixed = np.einsum("kc,kcx->kx", weights, values[source].astype(np.float64))
        return mixed.reshape(len(triangles), 3, -1).astype(values.dtype)

    normals = None
    if mesh.normals is not None:
        normals = interpolated(mesh.normals)
        normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), np.finfo(np.float32).tiny)
    decimated = replace(
        mesh,
        points=points,
        triangles=triangles,
        normals=normals,
        uvs=tuple(interpolated(uv) for uv in mesh.uvs),
        colors=None if mesh.colors is None else interpolated(mesh.colors),
    )
    d = two_way_distance(mesh.points, mesh.triangles, points, triangles, FIGURE_SAMPLES, 0)
    return decimated, _figures(len(mesh.triangles), len(triangles), max(d.a_to_b_p95, d.b_to_a_p95), d.hausdorff)


def _figures(before: int, after: int, p95_m: float, max_m: float) -> Figures:
    return {
        "triangles_before": before,
        "triangles_after": after,
        "surface_distance_p95_m": p95_m,
        "surface_distance_max_m": max_m,
    }


def _barycentric(queries: FloatArray, corners: FloatArray) -> FloatArray:
    """Weights (k, 3) of each query (k, 3) in its triangle (k, 3, 3), clipped to it.

    Source: Ericson 2004, "Real-Time Collision Detection", section 3.4.
    """
    ab, ac, ap = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], queries - corners[:, 0]
    d00, d01, d11 = (np.einsum("ij,ij->i", x, y) for x, y in ((ab, ab), (ab, ac), (ac, ac)))
    d20, d21 = np.einsum("ij,ij->i", ap, ab), np.einsum("ij,ij->i", ap, ac)
    scale = np.maximum(d00 * d11 - d01 * d01, np.finfo(float).tiny)
    v, w = (d11 * d20 - d01 * d21) / scale, (d00 * d21 - d01 * d20) / scale
    weights = np.clip(np.stack([1.0 - v - w, v, w], axis=1), 0.0, 1.0)
    return weights / np.maximum(weights.sum(axis=1, keepdims=True), np.finfo(float).tiny)
