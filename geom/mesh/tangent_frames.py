"""Tangent frames of triangles from their texture coordinates, and unit vectors in and out of them.

The frame at a place with unit normal N is (T, B, N): T is the direction of growing u, dP/du, made perpendicular to N,
and B = +-(N x T) on the side of growing v. dP/du is constant on a triangle. Source: Mikkelsen 2020, "Surface gradient
based bump mapping framework", section 3; renderers that derive the frame from derivatives on the screen, as OpenUSD's
Storm does for UsdPreviewSurface, compute this one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from schemas.arrays import AnyFloatArray, FloatArray, IntArray

_LEAST_TANGENT = 1e-30


class TangentFrames(NamedTuple):
    """Per triangle dP/du (m, 3) of any length, and the side (m,) of B: 1, or -1 where coordinates are mirrored."""

    tangents: FloatArray
    sides: FloatArray


def tangent_frames(points: FloatArray, triangles: IntArray, uvs: AnyFloatArray) -> TangentFrames:
    """The frames of triangles (m, 3) of points (n, 3) with corner coordinates (m, 3, 2), v pointing up.

    Where the coordinates of a triangle span no area, T is along its first edge.
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    (u1, v1), (u2, v2) = (np.moveaxis(uvs[:, k].astype(np.float64) - uvs[:, 0], 1, 0) for k in (1, 2))
    det = u1 * v2 - u2 * v1
    tangents = np.where(det < 0.0, -1.0, 1.0)[:, None] * ((b - a) * v2[:, None] - (c - a) * v1[:, None])
    flat = (np.abs(det) < _LEAST_TANGENT) | ~(np.linalg.norm(tangents, axis=1) > 0.0)
    return TangentFrames(np.where(flat[:, None], b - a, tangents), np.where(det < 0.0, -1.0, 1.0))


def into_frame(vectors: FloatArray, normals: FloatArray, tangents: FloatArray, sides: FloatArray) -> FloatArray:
    """(k, 3) components along T, B and N of `vectors` (k, 3) where `normals` (k, 3) are unit."""
    T, B = _axes(normals, tangents, sides)
    return np.stack([np.einsum("ki,ki->k", vectors, axis) for axis in (T, B, normals)], axis=1)


def out_of_frame(components: FloatArray, normals: FloatArray, tangents: FloatArray, sides: FloatArray) -> FloatArray:
    """(k, 3) vectors whose `components` (k, 3) are along T, B and N."""
    T, B = _axes(normals, tangents, sides)
    return components[:, :1] * T + components[:, 1:2] * B + components[:, 2:] * normals


def _axes(normals: FloatArray, tangents: FloatArray, sides: FloatArray) -> tuple[FloatArray, FloatArray]:
    level = tangents - np.einsum("ki,ki->k", tangents, normals)[:, None] * normals
    T = level / np.maximum(np.linalg.norm(level, axis=1, keepdims=True), _LEAST_TANGENT)
    return T, sides[:, None] * np.asarray(np.cross(normals, T), dtype=np.float64)
