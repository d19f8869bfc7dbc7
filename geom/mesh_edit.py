"""Edit the faces of a `Mesh` so that every corner attribute follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.model import FloatArray, IntArray, Mesh


def keep_faces(mesh: Mesh, kept: FloatArray) -> Mesh:
    """The faces where `kept` (m,) is True, or listed by index in that order; points stay as they are."""
    return replace(
        mesh,
        triangles=mesh.triangles[kept],
        normals=None if mesh.normals is None else mesh.normals[kept],
        uvs=tuple(uv[kept] for uv in mesh.uvs),
        colors=None if mesh.colors is None else mesh.colors[kept],
    )


def only_used_points(mesh: Mesh) -> Mesh:
    """The mesh without points that no face uses: they would still count in its bounds."""
    used, triangles = np.unique(mesh.triangles, return_inverse=True)
    if len(used) == len(mesh.points):
        return mesh
    return replace(mesh, points=mesh.points[used], triangles=triangles.reshape(-1, 3).astype(np.int32))


def flip_faces(mesh: Mesh, flipped: FloatArray) -> Mesh:
    """Turn the faces where `flipped` (m,) is True: corners 1 and 2 swap, their normals change sign."""

    def swap(corners: FloatArray) -> FloatArray:
        return np.where(
            flipped[:, None, None] if corners.ndim == 3 else flipped[:, None], corners[:, [0, 2, 1]], corners
        )

    normals = None
    if mesh.normals is not None:
        normals = swap(mesh.normals) * np.where(flipped, -1.0, 1.0).astype(np.float32)[:, None, None]
    return replace(
        mesh,
        triangles=swap(mesh.triangles),
        normals=normals,
        uvs=tuple(swap(uv) for uv in mesh.uvs),
        colors=None if mesh.colors is None else swap(mesh.colors),
    )


def append_faces(mesh: Mesh, points: FloatArray, triangles: IntArray, like: IntArray) -> Mesh:
    """`mesh` over `points` (which begin with its own) with `triangles` (k, 3) added.

    `like` (k, 3) names for each new corner the corner (3 * face + 0..2) whose UV and colour it takes; normals of new
    faces are flat.
    """
    if len(triangles) == 0:
        return mesh
    corners = points[triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), np.finfo(float).tiny)

    def grown(values: FloatArray) -> FloatArray:
        return np.concatenate([values, values.reshape(-1, values.shape[-1])[like]])

    return replace(
        mesh,
        points=points,
        triangles=np.concatenate([mesh.triangles, triangles]).astype(np.int32),
        normals=None
        if mesh.normals is None
        else np.concatenate([mesh.normals, np.repeat(flat[:, None], 3, axis=1)]).astype(np.float32),
        uvs=tuple(grown(uv) for uv in mesh.uvs),
        colors=None if mesh.colors is None else grown(mesh.colors),
    )


def merge_surfaces(meshes: Sequence[Mesh]) -> tuple[FloatArray, IntArray, IntArray]:
    """Points (n, 3), triangles (m, 3) and the mesh (m,) each triangle comes from; nothing is welded."""
    if not meshes:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32), np.zeros(0, dtype=np.int64)
    starts = np.cumsum([0, *(len(m.points) for m in meshes)])
    points = np.concatenate([np.asarray(m.points, dtype=np.float64).reshape(-1, 3) for m in meshes])
    triangles = np.concatenate([m.triangles.reshape(-1, 3) + s for m, s in zip(meshes, starts[:-1], strict=True)])
    return points, triangles.astype(np.int32), np.repeat(np.arange(len(meshes)), [len(m.triangles) for m in meshes])
