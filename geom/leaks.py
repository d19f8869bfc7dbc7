"""Whether a ball in a vessel gets out otherwise than through the mouth: between shapes that leave a gap, say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage, sparse

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
    return _gets_out(_clearance(points, triangles, mouth_m, outward, radius_m), inside_m, radius_m)


def widest_second_way(
    points: FloatArray,
    triangles: IntArray,
    last_m: FloatArray,
    mouth_m: FloatArray,
    outward: FloatArray,
    probe_m: float,
    least_m: float,
) -> tuple[float, FloatArray]:
    """Radius in metres, to 1 part in 30, of the widest ball that leaks, and places (k, 3) of its centre on its way.

    0 and no place where even a ball of `least_m` does not. `last_m` (3,) is the last place of the probe ball on its
    way in: no ball wider than that of `probe_m` is asked for, and a smaller one starts at its bottom, to which it
    rolls. Surface and mouth as for `leaks`.
    """
    clearance = _clearance(points, triangles, mouth_m, outward, least_m)

    def start(radius_m: float) -> FloatArray:
        return last_m - max(probe_m - radius_m, 0.0) * outward

    if not _gets_out(clearance, start(least_m), least_m):
        return 0.0, np.empty((0, 3))
    low, high = least_m, max(probe_m, least_m)
    while high - low > low / 30.0:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _gets_out(clearance, start(middle), middle) else (low, middle)
    return low, _way_out(clearance, start(low), low)


@dataclass(frozen=True)
class _Clearance:
    """Distance in metres to the surface at nodes (n, 3) of a grid, 0 for those above the mouth."""

    nodes: FloatArray
    distance: FloatArray
    shape: tuple[int, ...]
    cell_m: float


def _clearance(
    points: FloatArray, triangles: IntArray, mouth_m: FloatArray, outward: FloatArray, margin_m: float
) -> _Clearance:
    used = points[triangles].reshape(-1, 3)
    low, high = used.min(axis=0) - margin_m, used.max(axis=0) + margin_m
    cell = float((high - low).max()) / GRID_CELLS
    shape = np.ceil((high - low) / cell).astype(int) + 1
    nodes = (low + cell * np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)).reshape(-1, 3)
    below = (nodes - mouth_m) @ outward < 0.0
    distance = np.zeros(len(nodes))
    distance[below] = np.linalg.norm(NearestOnSurface(points, triangles)(nodes[below])[0] - nodes[below], axis=1)
    return _Clearance(nodes, distance, tuple(shape.tolist()), cell)


def _free(clearance: _Clearance, radius_m: float) -> FloatArray:
    """(n,) True where a ball of that radius may be."""
    return clearance.distance >= max(SMALLER * radius_m, LEAST_CELLS * clearance.cell_m)


def _border(clearance: _Clearance) -> FloatArray:
    """(n,) True for the outermost nodes."""
    border = np.ones(clearance.shape, dtype=bool)
    border[1:-1, 1:-1, 1:-1] = False
    return border.reshape(-1)


def _gets_out(clearance: _Clearance, inside_m: FloatArray, radius_m: float) -> bool:
    """Whether the free nodes of such a ball lead from `inside_m` to the grid's border."""
    free = _free(clearance, radius_m)
    labels = np.asarray(ndimage.label(free.reshape(clearance.shape))[0]).reshape(-1)  # pyright: ignore[reportIndexIssue]
    away = np.where(free, np.linalg.norm(clearance.nodes - inside_m, axis=1), np.inf)
    start = int(away.argmin())
    return bool(away[start] <= 2.0 * clearance.cell_m and (labels[_border(clearance)] == labels[start]).any())


def _way_out(clearance: _Clearance, inside_m: FloatArray, radius_m: float) -> FloatArray:
    """Nodes (k, 3) on the shortest way from `inside_m` to the grid's border; there is one."""
    free = _free(clearance, radius_m)
    index = np.where(free, np.arange(len(free)), -1).reshape(clearance.shape)
    pairs = [(np.delete(index, -1, axis), np.delete(index, 0, axis)) for axis in range(3)]
    edges = np.concatenate([np.stack([a, b])[:, (a >= 0) & (b >= 0)] for a, b in pairs], axis=1)
    graph = sparse.coo_array((np.ones(edges.shape[1]), (edges[0], edges[1])), shape=(len(free), len(free))).tocsr()
    start = int(np.where(free, np.linalg.norm(clearance.nodes - inside_m, axis=1), np.inf).argmin())
    order, before = sparse.csgraph.breadth_first_order(graph, start, directed=False)
    way = [int(order[_border(clearance)[order]][0])]
    while way[-1] != start:
        way.append(int(before[way[-1]]))
    return clearance.nodes[way[::-1]]
