"""Clearance grid: the distance from each node of a regular grid to a surface, inf at the outermost nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geom.mesh.surface_distance import NearestOnSurface
from schemas.arrays import BoolArray, FloatArray, IntArray

GRID_CELLS = 64


@dataclass(frozen=True)
class ClearanceGrid:
    """Nodes (n, 3) and the distance (n,) of each to the surface, inf at the outermost; in the unit of the points."""

    nodes: FloatArray
    distance: FloatArray
    shape: tuple[int, ...]
    cell: float

    @property
    def border(self) -> BoolArray:
        """(n,) True for the outermost nodes, at least a cell beyond the box of all points."""
        border = np.ones(self.shape, dtype=bool)
        border[1:-1, 1:-1, 1:-1] = False
        return border.reshape(-1)


def clearance_grid(points: FloatArray, triangles: IntArray, nearest: NearestOnSurface | None = None) -> ClearanceGrid:
    """A grid with 64 cells along the longest edge of the box of triangles (m, 3) over points (n, 3)."""
    nearest = nearest or NearestOnSurface(points, triangles)
    used = points[triangles].reshape(-1, 3)
    low, high = used.min(axis=0), used.max(axis=0)
    cell = float((high - low).max()) / GRID_CELLS
    shape = np.ceil((high - low) / cell).astype(int) + 3
    start = 0.5 * (low + high) - 0.5 * (shape - 1) * cell
    nodes = (start + cell * np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)).reshape(-1, 3)
    grid = ClearanceGrid(nodes, np.full(len(nodes), np.inf), tuple(shape.tolist()), cell)
    # From beyond the box of all points a ball can only get further away from them.
    inner = ~grid.border
    grid.distance[inner] = np.linalg.norm(nearest(nodes[inner])[0] - nodes[inner], axis=1)
    return grid
