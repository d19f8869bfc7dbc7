"""Leaks of a vessel: whether a ball inside can leave by another opening than the mouth, on a clearance grid (m)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import ndimage, sparse

from geom.features.clearance_grid import ClearanceGrid, clearance_grid
from schemas.arrays import BoolArray, FloatArray, IntArray

# The grid resolves a gap only where nodes lie in it: a ball smaller by this factor is used.
SMALLER = 0.9
# Half a cell is the least distance from a wall that no step between two nodes crosses.
WALL_CLEAR_CELLS = 0.5


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
    ball's centre moves over a grid. A ball too small for the grid counts as the smallest that the grid resolves. False
    where the ball does not fit at `inside_m`.
    """
    return _gets_out(_below(clearance_grid(points, triangles), mouth_m, outward), inside_m, radius_m)


def widest_leak(
    around: ClearanceGrid,
    last_m: FloatArray,
    mouth_m: FloatArray,
    outward: FloatArray,
    probe_m: float,
    least_m: float,
) -> tuple[float, FloatArray]:
    """Radius in metres, to 1 part in 30, of the widest ball that leaks, and its centres (k, 3) on the path out.

    0 and no point where even a ball of `least_m` does not leak. `last_m` (3,) is the last centre of the probe ball on
    its path in: no ball wider than `probe_m` is tested, and a smaller one starts at the bottom of the probe ball.
    `around` is the grid of the surface; mouth as for `leaks`.
    """
    clearance = _below(around, mouth_m, outward)

    def start(radius_m: float) -> FloatArray:
        return last_m - max(probe_m - radius_m, 0.0) * outward

    if not _gets_out(clearance, start(least_m), least_m):
        return 0.0, np.empty((0, 3))
    low, high = least_m, max(probe_m, least_m)
    while high - low > low / 30.0:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _gets_out(clearance, start(middle), middle) else (low, middle)
    return low, _way_out(clearance, start(low), low)


def _below(around: ClearanceGrid, mouth_m: FloatArray, outward: FloatArray) -> ClearanceGrid:
    """The grid with clearance 0 above the mouth."""
    return replace(around, distance=np.where((around.nodes - mouth_m) @ outward < 0.0, around.distance, 0.0))


def _free(clearance: ClearanceGrid, radius_m: float) -> BoolArray:
    """(n,) True at the nodes where a ball of that radius fits."""
    return clearance.distance >= max(SMALLER * radius_m, WALL_CLEAR_CELLS * clearance.cell)


def _gets_out(clearance: ClearanceGrid, inside_m: FloatArray, radius_m: float) -> bool:
    """Whether the free nodes of such a ball lead from `inside_m` to the grid's border."""
    free = _free(clearance, radius_m)
    labels = np.asarray(ndimage.label(free.reshape(clearance.shape))[0]).reshape(-1)
    away = np.where(free & ~clearance.border, np.linalg.norm(clearance.nodes - inside_m, axis=1), np.inf)
    start = int(away.argmin())
    return bool(away[start] <= 2.0 * clearance.cell and (labels[clearance.border] == labels[start]).any())


def _way_out(clearance: ClearanceGrid, inside_m: FloatArray, radius_m: float) -> FloatArray:
    """Nodes (k, 3) on the shortest path from `inside_m` to the grid's border, which must exist."""
    free = _free(clearance, radius_m)
    index = np.where(free, np.arange(len(free)), -1).reshape(clearance.shape)
    pairs = [(np.delete(index, -1, axis), np.delete(index, 0, axis)) for axis in range(3)]
    edges = np.concatenate([np.stack([a, b])[:, (a >= 0) & (b >= 0)] for a, b in pairs], axis=1)
    graph = sparse.coo_array((np.ones(edges.shape[1]), (edges[0], edges[1])), shape=(len(free), len(free))).tocsr()
    away = np.where(free & ~clearance.border, np.linalg.norm(clearance.nodes - inside_m, axis=1), np.inf)
    start = int(away.argmin())
    order, before = sparse.csgraph.breadth_first_order(graph, start, directed=False)
    way = [int(order[clearance.border[order]][0])]
    while way[-1] != start:
        way.append(int(before[way[-1]]))
    return clearance.nodes[way[::-1]]
