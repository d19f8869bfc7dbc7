"""Heightfield of a surface along a direction, on a grid, and the filling of its depressions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geom.mesh.rays import Rays
from geom.mesh.surface_distance import sample_surface
from schemas.arrays import FloatArray, IntArray

GRID_CELLS = 64
WALL_SAMPLES = 40_000


class Heightfield(NamedTuple):
    """Heights of a surface seen from above on a grid, one empty cell around; units of the points.

    ground  (rows x, columns y) heights, -inf where empty.         floor   height of the lowest point.
    step    edge of a cell.                                         corner  (2,) x and y of the first cell's centre.
    """

    ground: FloatArray
    floor: float
    step: float
    corner: FloatArray


def heightfield(rays: Rays, points: FloatArray, walls: FloatArray, frame: FloatArray) -> Heightfield:
    """The heightfield of the surface in `rays`, in axes that are the rows of `frame` (3, 3), the last one up.

    Rays give the height at cell centres; `walls` (k, 3), points on faces and edges, add walls and rims thinner than a
    cell, which rays may miss. `points` (n, 3) span the grid.
    """
    local = points @ frame.T
    low, high = local.min(axis=0), local.max(axis=0)
    step = float((high - low)[:2].max()) / GRID_CELLS or 1.0
    cells = np.maximum(np.ceil((high - low)[:2] / step).astype(int), 1) + 2
    corner = 0.5 * (low + high)[:2] - 0.5 * (cells - 1) * step
    x, y = (float(corner[i]) + step * np.arange(int(cells[i]), dtype=np.float64) for i in range(2))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    above = float(high[2]) + max(float((high - low).max()), step)
    starts = np.column_stack([grid, np.full(len(grid), above)]) @ frame
    ground = (above - rays.hit_distances(starts, -frame[2])).reshape(cells[0], cells[1])
    seen = walls @ frame.T
    cell = np.clip(np.rint((seen[:, :2] - corner) / step).astype(int), 0, cells - 1)
    np.maximum.at(ground, (cell[:, 0], cell[:, 1]), seen[:, 2])
    return Heightfield(ground, float(low[2]), step, corner)


def wall_points(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Points (k, 3) on the faces, and on the edges no further apart than half a cell of the finest grid."""
    extent = np.sort(np.ptp(points, axis=0))
    step = 0.5 * float(extent[1]) / GRID_CELLS or 1.0
    return np.concatenate(
        [sample_surface(points, triangles, WALL_SAMPLES, 0)[0], _along_edges(points, triangles, step)]
    )


def _along_edges(points: FloatArray, triangles: IntArray, step: float) -> FloatArray:
    """All corners, and points at most `step` apart on the edges that are longer."""
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    pieces = np.ceil(np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1) / step).astype(int)
    edges, pieces = edges[pieces > 1], pieces[pieces > 1]
    which = np.repeat(np.arange(len(edges)), pieces - 1)
    first = np.cumsum(pieces - 1) - (pieces - 1)
    share = (np.arange(len(which)) - first[which] + 1) / pieces[which]
    start, along = points[edges[which, 0]], points[edges[which, 1]] - points[edges[which, 0]]
    return np.concatenate([points[np.unique(triangles)], start + share[:, None] * along])


def fill_depressions(ground: FloatArray) -> FloatArray:
    """Level to which each cell fills before it drains over the grid's border or into a cell at -inf.

    The least level `max(ground, lowest neighbour's level)` over four neighbours (Planchon and Darboux 2002, "A fast,
    simple and versatile algorithm to fill the depressions of digital elevation models"), by sweeps over the whole grid
    until nothing changes: a wall one cell thick holds diagonally too.
    """
    border = np.ones(ground.shape, dtype=bool)
    border[1:-1, 1:-1] = False
    level = np.where(border | np.isneginf(ground), ground, np.inf)
    while True:
        neighbours = np.full(level.shape, np.inf)
        neighbours[1:] = level[:-1]
        np.minimum(neighbours[:-1], level[1:], out=neighbours[:-1])
        np.minimum(neighbours[:, 1:], level[:, :-1], out=neighbours[:, 1:])
        np.minimum(neighbours[:, :-1], level[:, 1:], out=neighbours[:, :-1])
        lower = np.minimum(level, np.maximum(ground, neighbours))
        if np.array_equal(lower, level):
            return level
        level = lower
