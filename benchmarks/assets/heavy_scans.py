"""Heavy textured surfaces from dev assets: triangles cut in four, points moved along their normals like a scan's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from assetkit.readers.by_format import FORMAT_OF, READERS
from assetkit.sources.source_file import SourceFile
from geom.mesh.corner_normals import corner_normals
from geom.mesh.weld import diagonal, weld_points
from schemas.arrays import AnyFloatArray, FloatArray
from schemas.model import Mesh, Model

# Ripples of a hundredth of the diagonal: relief that 5,000 triangles cannot hold, so that the normal map has to.
RIPPLE_SHARE, RIPPLE_LENGTH_SHARE = 3e-4, 0.012
_MIDPOINTS = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]])
_QUARTERS = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])


def read_model(file: Path) -> Model:
    """The model of a source file with ids for its meshes."""
    outcome = READERS[FORMAT_OF[file.suffix.lower()]](SourceFile(file, file.parent))
    if outcome.value is None:
        raise ValueError(f"{file.name}: {outcome.diagnostics}")
    return outcome.value.with_mesh_ids()


def heavy(model: Model, least_triangles: int, *, rippled: bool = True) -> Model:
    """The model with at least so many triangles; with ripples unless told otherwise."""
    meshes = list(model.meshes)
    while sum(len(mesh.triangles) for mesh in meshes) < least_triangles:
        meshes = [quartered(mesh) for mesh in meshes]
    size = diagonal(np.concatenate([mesh.points for mesh in meshes]))
    return replace(model, meshes=tuple(rippled_mesh(mesh, size) if rippled else mesh for mesh in meshes))


def quartered(mesh: Mesh) -> Mesh:
    """The mesh with each triangle cut in four at the middles of its edges; all corner attributes are interpolated."""

    def cut(corners: AnyFloatArray) -> FloatArray:
        return np.einsum("pc,mcx->mpx", _MIDPOINTS, corners)[:, _QUARTERS].reshape(-1, 3, corners.shape[2])

    points, triangles = weld_points(*_separate(cut(mesh.points[mesh.triangles])))
    return replace(
        mesh,
        points=points,
        triangles=triangles.astype(np.int32),
        normals=None if mesh.normals is None else cut(mesh.normals).astype(np.float32),
        uvs=tuple(cut(uvs).astype(np.float32) for uvs in mesh.uvs),
        colors=None if mesh.colors is None else cut(mesh.colors).astype(np.float32),
    )


def rippled_mesh(mesh: Mesh, size: float) -> Mesh:
    """The mesh with waves along its normals, in proportion to `size`, and with normals of the new surface."""
    points, triangles = weld_points(mesh.points, mesh.triangles)
    corner = corner_normals(points, triangles, np.pi).astype(np.float64)
    normals = np.zeros_like(points)
    normals[triangles.reshape(-1)] = corner.reshape(-1, 3)
    phase = 2.0 * np.pi * points / (RIPPLE_LENGTH_SHARE * size)
    waves = np.sin(phase[:, 0]) + np.sin(phase[:, 1]) + np.sin(phase[:, 2])
    moved = points + (RIPPLE_SHARE * size * waves)[:, None] * normals
    return replace(mesh, points=moved, triangles=triangles.astype(np.int32), normals=corner_normals(moved, triangles))


def _separate(corners: FloatArray) -> tuple[FloatArray, np.ndarray]:
    return corners.reshape(-1, 3), np.arange(corners.shape[0] * 3, dtype=np.int64).reshape(-1, 3)
