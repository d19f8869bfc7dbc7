"""Which texel of an atlas shows which place of its meshes, and how the colours of charts go on beyond their edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt

from geom.mesh.rays import Rays
from schemas.arrays import BoolArray, Float32Array, FloatArray, IntArray
from schemas.model import Mesh

_RIM_PX = 2  # one is read by bilinear filtering; the tips of charts that hold no middle of a texel need another


@dataclass(frozen=True)
class AtlasTexels:
    """k texels of one mesh: rows (k,) from the bottom and columns (k,), the triangle (k,) that each shows, and the
    (k, 3) barycentric weights of its centre, or of the nearest place of the chart where the centre lies beyond it.
    """

    rows: IntArray
    columns: IntArray
    faces: IntArray
    weights: FloatArray


def atlas_texels(meshes: Sequence[Mesh], size_px: int, *, rim: bool = True) -> tuple[AtlasTexels, ...]:
    """The texels of each mesh in the atlas of `size_px` by `size_px` that their first coordinates share.

    A ray falls through the centre of each texel onto the triangles laid out flat. With `rim` the texels around a
    chart show the nearest place of it: bilinear filtering reads them inside of the chart.
    """
    counts = [len(mesh.triangles) for mesh in meshes]
    corners = np.concatenate([mesh.uvs[0] for mesh in meshes]).astype(np.float64).reshape(-1, 2) * size_px
    flat = np.concatenate([corners, np.zeros((len(corners), 1))], axis=1)
    chart = Rays(flat, np.arange(len(flat), dtype=np.int64).reshape(-1, 3))
    rows, columns = (index.ravel() for index in np.indices((size_px, size_px)))
    above = np.stack([columns + 0.5, rows + 0.5, np.full(rows.size, float(size_px))], axis=1)
    hits = chart.hits(above, np.array([0.0, 0.0, -1.0]))
    faces, weights = hits.triangles.copy(), hits.weights
    if rim:
        inside = (faces >= 0).reshape(size_px, size_px)
        around = binary_dilation(inside, np.ones((3, 3), dtype=bool), iterations=_RIM_PX)
        touching = np.flatnonzero((around & ~inside).ravel())
        centres = above[touching] * np.array([1.0, 1.0, 0.0])
        faces[touching], weights[touching], _ = chart.nearest(centres)
    shown = np.flatnonzero(faces >= 0)
    mesh_of = np.searchsorted(np.cumsum(counts), faces[shown], side="right")
    texels: list[AtlasTexels] = []
    for k, first in enumerate(np.cumsum([0, *counts[:-1]])):
        mine = shown[mesh_of == k]
        texels.append(AtlasTexels(rows[mine], columns[mine], faces[mine] - first, weights[mine]))
    return tuple(texels)


def dilated(picture: Float32Array, shown: BoolArray, reach_px: int) -> Float32Array:
    """(h, w, c) picture whose texels beyond `shown` (h, w) take the value of the nearest shown one up to `reach_px`
    away, and the mean of all shown ones farther away.
    """
    if shown.all() or not shown.any():
        return picture
    away, nearest = distance_transform_edt(~shown, return_indices=True)
    result = picture.copy()
    result[~shown] = picture[shown].mean(axis=0)
    near = ~shown & (away <= reach_px)
    result[near] = picture[nearest[0][near], nearest[1][near]]
    return result
