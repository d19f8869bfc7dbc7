"""Whether a ball in a vessel gets out otherwise than through the mouth: between shapes that leave a gap, say."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from geom.surface_distance import NearestOnSurface
from schemas.model import FloatArray, IntArray

GRID_CELLS = 64
# The grid sees a gap only where nodes lie in it: a ball this much smaller stands for the ball.
SMALLER = 0.9
# Half a cell is the least distance from a wall that no step between two nodes crosses.
LEAST_CELLS = 0.5


def leaks(
    points: FloatArray,
    triangles: IntArray,
    inside_m: FloatArray,
    mouth_m: FloatArray,
    outward: FloatArray,
    radius_m: float,
) -> bool:
    """True iff a ball of `radius_m` can roll from `inside_m` (3,) to the outside without rising above the mouth.

    Surface: points (n, 3), triangles (m, 3), closed or not; above is along `outward` (3,) from `mouth_m` (3,). The
    ball's centre moves over a grid. A ball too small for the grid counts as the smallest that the grid can tell. False
    where the ball has no place at `inside_m`: what does not go in cannot come out.
    """
    used = points[triangles].reshape(-1, 3)
    low, high = used.min(axis=0) - radius_m, used.max(axis=0) + radius_m
    cell = float((high - low).max()) / GRID_CELLS
    shape = np.ceil((high - low) / cell).astype(int) + 1
    nodes = (low + cell * np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)).reshape(-1, 3)
    below = (nodes - mouth_m) @ outward < 0.0
    distance = np.zeros(len(nodes))
    distance[below] = np.linalg.norm(NearestOnSurface(points, triangles)(nodes[below])[0] - nodes[below], axis=1)
    free = below & (distance >= max(SMALLER * radius_m, LEAST_CELLS * cell))
    labels = np.asarray(ndimage.label(free.reshape(shape))[0])  # pyright: ignore[reportIndexIssue]
    away = np.linalg.norm(nodes - inside_m, axis=1)
    start = int(np.where(free, away, np.inf).argmin())
    if not free[start] or away[start] > 2.0 * cell:
        return False
    border = np.ones(labels.shape, dtype=bool)
    border[1:-1, 1:-1, 1:-1] = False
    return bool((labels[border] == labels.reshape(-1)[start]).any())
