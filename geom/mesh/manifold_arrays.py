"""Conversion of a manifold3d body to points (n, 3) and triangles (m, 3)."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from schemas.arrays import FloatArray, IntArray


def manifold_arrays(body: Manifold) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) float64 and triangles (m, 3) int64 of a body, in its unit."""
    mesh = body.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64)
