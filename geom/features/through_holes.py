"""Through-holes: tunnels through a solid for a hook, a finger or a peg. Lengths in metres.

A straight tunnel is a hole in the silhouette along some direction; a surface of genus 0 has none, whatever its
silhouette.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geom.mesh.rays import Rays
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.physics import Solid

SILHOUETTE_CELLS = 144
# The 13 directions through the faces, edges and corners of a cube, one of each pair.
VIEW_DIRECTIONS = np.array(
    [
        *([1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1], [0, 1, 1], [0, 1, -1]),
        *([1, 1, 1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]),
    ],
    dtype=np.float64,
)
LEAST_RADIUS_CELLS = 1.0  # inscribed radius of a hole, in cells


@dataclass(frozen=True)
class ThroughHole:
    """One tunnel in the silhouette along a direction.

    centre_m    (3,) middle of the largest circle that passes through, at the depth of the material around it.
    direction   (3,) unit vector through it; diameter_m of that circle.
    outline_m   (k, 3) the loop around it.
    bar_m       thickness of the material on the side away from the middle of the object, in the plane of the loop; inf
                where there is none.
    bar_at_m    (3,) middle of that bar; bar_depth_m its thickness along the direction.
    offset      distance of the hole from the middle of the silhouette, as a share of the silhouette's radius.
    """

    centre_m: FloatArray
    direction: FloatArray
    diameter_m: float
    outline_m: FloatArray
    bar_m: float
    bar_at_m: FloatArray
    bar_depth_m: float
    offset: float


def find_through_holes(solid: Solid) -> tuple[ThroughHole, ...]:
    """Tunnels open along one of 13 directions, the widest first; none for a solid of kind `hull`.

    A tunnel open along several directions counts once, at its largest diameter.
    """
    if solid.kind == "hull" or (solid.kind == "closed" and genus(solid.triangles) == 0):
        return ()
    rays = Rays(solid.points, solid.triangles)
    directions = VIEW_DIRECTIONS / np.linalg.norm(VIEW_DIRECTIONS, axis=1, keepdims=True)
    candidates = [hole for direction in directions for hole in _holes_along(solid.points, rays, direction)]
    candidates.sort(key=lambda h: (-round(h.diameter_m, 9), *np.round(h.centre_m, 9).tolist()))
    distinct: list[ThroughHole] = []
    for hole in candidates:
        if all(np.linalg.norm(hole.centre_m - other.centre_m) > 0.75 * other.diameter_m for other in distinct):
            distinct.append(hole)
    return tuple(distinct)


def genus(triangles: IntArray) -> int:
    """Handles of a closed surface, summed over its connected pieces: 0 for a ball, 1 for a ring; Euler's formula."""
    corners = np.unique(triangles)
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    count = int(corners.max()) + 1
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    _, labels = connected_components(graph, directed=False)
    pieces = len(np.unique(labels[corners]))
    return pieces - (len(corners) - len(edges) + len(triangles)) // 2


def _holes_along(points: FloatArray, rays: Rays, direction: FloatArray) -> list[ThroughHole]:
    axis = int(np.abs(direction).argmin())
    u: FloatArray = np.eye(3)[axis] - direction[axis] * direction
    u /= np.linalg.norm(u)
    R_VA = np.stack([u, np.cross(direction, u), direction])
    local = points @ R_VA.T
    low, high = local.min(axis=0), local.max(axis=0)
    step = float((high - low)[:2].max()) / SILHOUETTE_CELLS or 1.0
    cells = np.ceil((high - low)[:2] / step).astype(int) + 2
    corner = 0.5 * (low + high)[:2] - 0.5 * (cells - 1) * step
    x, y = (float(corner[i]) + step * np.arange(int(cells[i]), dtype=np.float64) for i in range(2))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    starts = np.column_stack([grid, np.full(len(grid), low[2] - step)]) @ R_VA
    front = rays.hit_distances(starts, direction).reshape(cells[0], cells[1])
    empty = np.isinf(front)
    labels, count = _label(empty)
    outside = set(np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])).tolist())
    holes: list[ThroughHole] = []
    for k in range(1, count + 1):
        hole = labels == k
        if k in outside or hole.sum() < LEAST_RADIUS_CELLS**2 * np.pi:
            continue
        clearance = np.asarray(ndimage.distance_transform_edt(hole))
        row, column = np.unravel_index(int(clearance.argmax()), hole.shape)
        radius = float(clearance[row, column]) - 0.5
        if radius < LEAST_RADIUS_CELLS:
            continue
        holes.append(_hole(hole, empty, (int(row), int(column)), radius, (corner, step, low[2] - step), rays, R_VA))
    return holes


def _hole(
    hole: BoolArray,
    empty: BoolArray,
    middle: tuple[int, int],
    radius: float,
    place: tuple[FloatArray, float, float],
    rays: Rays,
    R_VA: FloatArray,
) -> ThroughHole:
    """One hole of a silhouette with its loop and the bar on its outer side."""
    corner, step, start = place
    matter = np.argwhere(~empty)
    centre = matter.mean(axis=0)
    spread = float(np.sqrt(((matter - centre) ** 2).sum(axis=1).mean())) * np.sqrt(2.0)
    away = np.array(middle) - centre
    offset = float(np.linalg.norm(away))
    away = away / offset if offset > 1e-9 else np.array([1.0, 0.0])
    inner, outer = _bar(hole, empty, np.array(middle), away)

    def depths(cells: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The depth (k,) at which material begins along the view, and its thickness (k,) there."""
        from_ = np.column_stack([corner + step * cells, np.full(len(cells), start)]) @ R_VA
        first = rays.hit_distances(from_, R_VA[2])
        within = from_ + (first + 1e-4 * step)[:, None] * R_VA[2]
        return start + first, rays.hit_distances(np.where(np.isfinite(within), within, 0.0), R_VA[2])

    around = np.asarray(ndimage.binary_dilation(hole, iterations=2), dtype=np.bool_)
    ring = np.argwhere(around & ~empty).astype(float)
    begin, thick = depths(ring)
    solid_there = np.isfinite(begin) & np.isfinite(thick)
    mids = (begin + 0.5 * thick)[solid_there]
    depth = float(np.median(mids)) if len(mids) else start
    bar, bar_depth, bar_at = np.inf, np.inf, np.array(middle, dtype=float)
    if np.isfinite(outer):
        bar, bar_at = (outer - inner) * step, np.array(middle) + 0.5 * (inner + outer) * away
        begin, thick = depths(bar_at[None])
        if np.isfinite(begin[0]) and np.isfinite(thick[0]):
            bar_depth, depth = float(thick[0]), float(begin[0] + 0.5 * thick[0])

    def place_of(cells: FloatArray) -> FloatArray:
        return np.column_stack([corner + step * cells, np.full(len(cells), depth)]) @ R_VA

    turn = np.argsort(np.arctan2(*(ring - np.array(middle)).T), kind="stable")
    loop = ring[turn][:: max(1, len(ring) // 24)]
    return ThroughHole(
        place_of(np.array([middle], dtype=float))[0],
        R_VA[2],
        2.0 * radius * step,
        place_of(loop),
        float(bar),
        place_of(bar_at[None])[0],
        bar_depth,
        offset / max(spread, 1e-9),
    )


def _bar(hole: BoolArray, empty: BoolArray, middle: FloatArray, away: FloatArray) -> tuple[float, float]:
    """Where the bar begins and ends, in cells from the middle of a hole on the line out of the silhouette."""
    distance = np.arange(0.0, float(np.hypot(*empty.shape)), 0.5)
    cells = np.rint(middle + distance[:, None] * away).astype(int)
    inside = ((cells >= 0) & (cells < np.array(empty.shape))).all(axis=1)
    cells, distance = cells[inside], distance[inside]
    matter = ~empty[cells[:, 0], cells[:, 1]]
    if not matter.any():
        return 0.0, np.inf
    first = int(matter.argmax())
    after = np.flatnonzero(~matter[first:])
    if not len(after) or matter[first + int(after[0]) :].any():  # The outer side must be free.
        return float(distance[first]), np.inf
    return float(distance[first]), float(distance[first + int(after[0])])


def _label(mask: BoolArray) -> tuple[IntArray, int]:
    labels = np.zeros(mask.shape, dtype=np.int32)
    return labels, ndimage.label(mask, output=labels)
