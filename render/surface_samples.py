"""Points spread over drawn surfaces by area, for the shadow on the floor."""

from __future__ import annotations

import numpy as np

from render.surfaces import ShadedSurface
from schemas.arrays import FloatArray

_SHADOW_SAMPLES = 20_000


def surface_samples(parts: tuple[ShadedSurface, ...]) -> FloatArray:
    """(n, 3) points spread over the surface by area, the same ones every time."""
    if not parts:
        return np.zeros((0, 3))
    triangles = np.concatenate([part.points for part in parts])
    edges = triangles[:, 1:] - triangles[:, :1]
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).astype(np.float64)
    total = np.cumsum(area)
    if not len(total) or total[-1] <= 0.0:
        return triangles.reshape(-1, 3).astype(np.float64)
    index = np.arange(_SHADOW_SAMPLES)
    chosen = np.searchsorted(total, (index + 0.5) / _SHADOW_SAMPLES * total[-1]).clip(max=len(total) - 1)
    # The R2 low-discrepancy sequence (Roberts 2018), folded onto the triangle.
    u, v = (index * 0.7548776662466927) % 1.0, (index * 0.5698402909980532) % 1.0
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    return triangles[chosen, 0] + u[:, None] * edges[chosen, 0] + v[:, None] * edges[chosen, 1]
