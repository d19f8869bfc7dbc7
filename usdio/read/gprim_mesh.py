"""Triangles of one gprim as arrays: reverse winding, transform, and split into `schemas.model.Mesh` by material."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from geom.mesh.finite import require_finite
from schemas.diagnostics import Location
from schemas.model import Mesh


@dataclass(frozen=True)
class GprimMesh:
    """A triangulated gprim.

    points (n, 3) float64; triangles (m, 3) int64; normals (m, 3, 3) float64 or None, of any length; uvs (m, 3, 2) by
    primvar name; colors (m, 3, 4) linear RGBA or None, with `constant_color` instead when one opaque colour covers
    all; subsets: (owner prim, rows of `triangles`), disjoint.
    """

    points: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    uvs: dict[str, np.ndarray] = field(default_factory=dict)
    colors: np.ndarray | None = None
    constant_color: tuple[float, float, float] | None = None
    subsets: tuple[tuple[Any, np.ndarray], ...] = ()
    double_sided: bool = False


def with_reversed_winding(surface: GprimMesh) -> GprimMesh:
    """`surface` with every triangle wound the other way round; corner attributes follow their corners."""
    return replace(
        surface,
        triangles=surface.triangles[:, ::-1],
        normals=None if surface.normals is None else surface.normals[:, ::-1],
        uvs={name: uv[:, ::-1] for name, uv in surface.uvs.items()},
        colors=None if surface.colors is None else surface.colors[:, ::-1],
    )


def transformed(surface: GprimMesh, X_WS: np.ndarray, where: Location) -> tuple[GprimMesh, int]:
    """`surface` moved by the 4x4 affine `X_WS`, and how many corner normals had to be replaced.

    A mirroring transform turns the triangles, so that they stay counter-clockwise from outside. Normals become unit
    length; zero or non-finite ones take the normal of their triangle.
    Raises InvalidInput `asset/nonfinite-vertices` when the transform or the result is not finite.
    """
    A = X_WS[:3, :3]
    with np.errstate(all="ignore"):
        points = surface.points @ A.T + X_WS[:3, 3]
        mirrored = np.linalg.det(A) < 0
    require_finite(points, where, row="point")
    moved = with_reversed_winding(surface) if mirrored else surface
    if moved.normals is None:
        return replace(moved, points=points), 0
    # Cofactors are det(A) A^-T, defined for flattening transforms too; the sign keeps normals on their side.
    cofactors = np.stack([np.cross(A[1], A[2]), np.cross(A[2], A[0]), np.cross(A[0], A[1])])
    normals, replaced = _unit_normals(
        moved.normals @ cofactors.T * (-1.0 if mirrored else 1.0), points, moved.triangles
    )
    return replace(moved, points=points, normals=normals), replaced


def submesh(surface: GprimMesh, rows: np.ndarray, uv_names: tuple[str, ...], *, colors: bool) -> Mesh:
    """The triangles `rows` as a nameless Mesh with only the points they use.

    UV sets come in the order of `uv_names`, which `TextureUse.uv_set` indexes, then the others. A missing name gets the
    first set; a surface without any has none.
    """
    triangles = surface.triangles[rows]
    used, renumbered = np.unique(triangles, return_inverse=True)
    spare = next(iter(surface.uvs), None)
    read_names = [name if name in surface.uvs else spare for name in uv_names]
    rest = [name for name in surface.uvs if name not in read_names]
    uvs = [surface.uvs[name][rows].astype(np.float32) for name in (*read_names, *rest) if name is not None]
    return Mesh(
        name="",
        points=surface.points[used],
        triangles=renumbered.reshape(-1, 3).astype(np.int32),
        normals=None if surface.normals is None else surface.normals[rows].astype(np.float32),
        uvs=tuple(uvs),
        colors=surface.colors[rows].astype(np.float32) if colors and surface.colors is not None else None,
    )


def _unit_normals(normals: np.ndarray, points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, int]:
    with np.errstate(all="ignore"):
        lengths = np.linalg.norm(normals, axis=2, keepdims=True)
        unit = normals / lengths
    bad = ~np.isfinite(unit).all(axis=2) | (lengths[..., 0] <= 0)
    if bad.any():
        a, b, c = (points[triangles[:, i]] for i in range(3))
        faces = np.cross(b - a, c - a)
        areas = np.linalg.norm(faces, axis=1, keepdims=True)
        faces = np.where(areas > 0, faces / np.where(areas > 0, areas, 1.0), [0.0, 0.0, 1.0])
        unit = np.where(bad[..., None], faces[:, None], unit)
    return unit, int(bad.sum())
