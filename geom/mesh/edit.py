"""Edits of a `Mesh` that keep all corner attributes (normals, UVs, colours) in step with its triangles (m, 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from schemas.arrays import AnyFloatArray, BoolArray, Float32Array, FloatArray, IntArray
from schemas.model import Mesh

_Number = TypeVar("_Number", bound=np.generic)


def keep_faces(mesh: Mesh, selected: BoolArray | IntArray) -> Mesh:
    """The faces where `selected` (m,) is True, or listed by index in that order; points are unchanged."""
    if selected.dtype == np.bool_:
        selected = np.flatnonzero(selected)
    if np.array_equal(selected, np.arange(len(mesh.triangles))):
        return mesh
    return replace(
        mesh,
        triangles=mesh.triangles[selected],
        normals=None if mesh.normals is None else mesh.normals[selected],
        uvs=tuple(uv[selected] for uv in mesh.uvs),
        colors=None if mesh.colors is None else mesh.colors[selected],
    )


def only_used_points(mesh: Mesh) -> Mesh:
    """The mesh without points that no face uses: they would still count in its bounds."""
    used, triangles = np.unique(mesh.triangles, return_inverse=True)
    if len(used) == len(mesh.points):
        return mesh
    return replace(mesh, points=mesh.points[used], triangles=triangles.reshape(-1, 3).astype(np.int32))


def flip_faces(mesh: Mesh, flipped: BoolArray) -> Mesh:
    """`mesh` with the faces where `flipped` (m,) is True reversed: corners 1 and 2 swap.

    Normals change sign where they would point away from the reversed face; a file may have correct normals on faces of
    the wrong winding.
    """

    if not flipped.any():
        return mesh

    def swap(corners: NDArray[_Number]) -> NDArray[_Number]:
        return np.where(
            flipped[:, None, None] if corners.ndim == 3 else flipped[:, None], corners[:, [0, 2, 1]], corners
        )

    triangles = swap(mesh.triangles)
    normals = None if mesh.normals is None else swap(mesh.normals)
    if normals is not None:
        away = flipped & (normal_cosines(mesh.points, triangles, normals) < 0.0).all(axis=1)
        normals = np.where(away[:, None, None], -normals, normals)
    return replace(
        mesh,
        triangles=triangles,
        normals=normals,
        uvs=tuple(swap(uv) for uv in mesh.uvs),
        colors=None if mesh.colors is None else swap(mesh.colors),
    )


def turn_normals(mesh: Mesh, turned: BoolArray) -> Mesh:
    """`mesh` with the normals of the faces where `turned` (m,) is True negated; a mesh without normals is unchanged."""
    if mesh.normals is None:
        return mesh
    return replace(mesh, normals=np.where(turned[:, None, None], -mesh.normals, mesh.normals))


def normal_cosines(points: FloatArray, triangles: IntArray, normals: AnyFloatArray) -> FloatArray:
    """(m, 3) cosine between each corner normal (m, 3, 3) and the normal of its face; zero for faces without area."""
    corners = points[triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), np.finfo(float).tiny)
    return np.einsum("mx,mkx->mk", flat, normals.astype(np.float64))


def append_faces(mesh: Mesh, points: FloatArray, triangles: IntArray, mix: csr_array) -> Mesh:
    """`mesh` over `points` (which begin with its own) with `triangles` (k, 3) added.

    `mix` (3 k, 3 m) gives the UV and colour of each new corner as weights over the old ones; normals of new faces are
    flat.
    """
    if len(triangles) == 0:
        return mesh
    corners = points[triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), np.finfo(float).tiny)

    def grown(values: Float32Array) -> Float32Array:
        new = mix @ values.reshape(-1, values.shape[-1])
        return np.concatenate([values, new.reshape(len(triangles), 3, -1).astype(values.dtype)])

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


def remix_faces(mesh: Mesh, triangles: IntArray, source: IntArray, weights: FloatArray) -> Mesh:
    """`mesh` with other `triangles` (k, 3) over its points, cut out of its faces `source` (k,).

    `weights` (k, 3, 3): the attributes of new corner i are the sum over j of weights[:, i, j] times those of corner j.
    """

    def mixed(values: Float32Array) -> FloatArray:
        return np.einsum("kij,kjx->kix", weights, values[source].astype(np.float64))

    normals = None if mesh.normals is None else mixed(mesh.normals)
    if normals is not None:
        normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), np.finfo(np.float32).tiny)
    return replace(
        mesh,
        triangles=triangles.astype(np.int32),
        normals=None if normals is None else normals.astype(np.float32),
        uvs=tuple(mixed(uv).astype(uv.dtype) for uv in mesh.uvs),
        colors=None if mesh.colors is None else mixed(mesh.colors).astype(mesh.colors.dtype),
    )


def merge_surfaces(meshes: Sequence[Mesh]) -> tuple[FloatArray, IntArray, IntArray]:
    """Points (n, 3), triangles (m, 3) and the mesh (m,) each triangle comes from; nothing is welded."""
    if not meshes:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32), np.zeros(0, dtype=np.int64)
    starts = np.cumsum([0, *(len(m.points) for m in meshes)])
    points = np.concatenate([np.asarray(m.points, dtype=np.float64).reshape(-1, 3) for m in meshes])
    triangles = np.concatenate([m.triangles.reshape(-1, 3) + s for m, s in zip(meshes, starts[:-1], strict=True)])
    return points, triangles.astype(np.int32), np.repeat(np.arange(len(meshes)), [len(m.triangles) for m in meshes])
