"""Cavities behind a narrower mouth: the inside of a bottle, vase, flask or jug, in any direction of its neck.

Method: balls of growing radius on a clearance grid. A necked cavity is where a ball still fits that can no longer
leave. This needs no closed surface, no opening direction and no least wall thickness.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from geom.features.clearance_grid import ClearanceGrid
from geom.mesh.surface_distance import NearestOnSurface
from schemas.arrays import BoolArray, FloatArray, IntArray

# Balls from one cell on, which no wall of this grid lets through (half a cell's diagonal would do), by this factor.
RADIUS_STEP = 1.15
# A cavity is enclosed: at least this share of the rays from its widest place hits the surface.
ENCLOSED_SHARE, RAY_COUNT = 0.75, 400
# The mouth's axis is fitted to the walls within this distance, in radii; the mouth ends where the walls are further
# than
MOUTH_WALLS, FLARE = 1.3, 1.05
MOUTH_NODES, MOUTH_STEPS = 3, (0.15, 0.05, 0.02)
CENTRINGS = 8
RIM_STEP, RIM_SEARCH_STEPS = 0.1, 400


@dataclass(frozen=True)
class NeckedCavity:
    """One necked cavity with the widest path into it; lengths in the unit of the points.

    mouth     (3,) middle of the narrowest place of the path, where its walls end on the outer side.
    radius    of the ball that just passes the mouth.
    outward   (3,) unit vector along the mouth's axis.
    way       (k, 3) centres of a ball on its path in, from outside to the widest place, about a radius from all walls.
    depth     from the mouth to the furthest point of the cavity, along the axis.
    volume    swept by balls of the mouth's size inside the cavity.
    """

    mouth: FloatArray
    radius: float
    outward: FloatArray
    way: FloatArray
    depth: float
    volume: float


def find_necked_cavities(
    nearest: NearestOnSurface, grid: ClearanceGrid, walls: FloatArray, least_volume: float, least_radius: float
) -> tuple[NeckedCavity, ...]:
    """Cavities of at least `least_volume` behind a mouth of radius at least `least_radius`, widest mouth last.

    `walls` (k, 3) are points spread over the surface, to which `nearest` and `grid` belong. Deterministic.
    """
    nodes, cell, clearance = grid.nodes, grid.cell, grid.distance.reshape(grid.shape)
    cavities: list[NeckedCavity] = []
    for inside, outer in _closed_off(clearance, cell, least_volume):
        swept = np.asarray(ndimage.distance_transform_edt(~inside)) * cell <= outer * RADIUS_STEP
        volume = float(swept.sum()) * cell**3
        widest = int(np.where(inside, clearance, 0.0).argmax())
        if volume < least_volume or nearest.enclosed_share(nodes[widest], RAY_COUNT) < ENCLOSED_SHARE:
            continue
        way = nodes[_way_out(grid, outer, widest)][::-1]
        mouth, outward, radius = _mouth(nearest, way, walls)
        if radius >= least_radius:
            depth = float(((mouth - nodes[swept.reshape(-1)]) @ outward).max())
            cavities.append(NeckedCavity(mouth, radius, outward, _centred(nearest, way, radius), depth, volume))
    return tuple(cavities)


def _clearance(nearest: NearestOnSurface, queries: FloatArray) -> FloatArray:
    return np.linalg.norm(nearest(queries)[0] - queries, axis=1)


def _closed_off(clearance: FloatArray, cell: float, least_volume: float) -> Iterator[tuple[BoolArray, float]]:
    """Each set of grid nodes that a growing ball can no longer leave: its mask, and the last radius that could."""
    radius, before = cell, None
    limit = float(clearance[np.isfinite(clearance)].max())
    while radius <= limit:
        labels = np.zeros(clearance.shape, dtype=np.int32)
        count = ndimage.label(clearance >= radius, output=labels)
        outside = labels == labels[0, 0, 0]
        if before is not None and count > 1:
            for label, box in enumerate(ndimage.find_objects(labels), start=1):
                size = np.array([s.stop - s.start - 1 for s in box]) * cell + 2.0 * radius
                if size.prod() < least_volume or label == labels[0, 0, 0]:
                    continue
                inside = labels == label
                if before[inside].any():
                    yield inside, radius / RADIUS_STEP
        before, radius = outside, radius * RADIUS_STEP


def _way_out(grid: ClearanceGrid, radius: float, start: int) -> IntArray:
    """Flat node indices of a path from `start` to the grid's border for a ball of `radius`, well away from walls."""
    clearance = grid.distance
    number = np.arange(clearance.size).reshape(grid.shape)
    steps = [np.stack([np.delete(number, cut, axis).reshape(-1) for cut in (-1, 0)]) for axis in range(3)]
    a, b = np.concatenate(steps, axis=1)
    narrowest = np.minimum(clearance[a], clearance[b])
    free = (narrowest >= radius) & np.isfinite(narrowest)  # Not along the border, where the path ends.
    a, b, edge_cost = a[free], b[free], (radius / narrowest[free]) ** 2
    graph = coo_array((edge_cost, (a, b)), shape=(clearance.size, clearance.size)).tocsr()
    length, before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)[:2]
    border = np.flatnonzero(grid.border)
    node = int(border[np.argmin(length[border])])
    way: list[int] = []
    while node >= 0:
        way.append(node)
        node = int(before[node])
    return np.array(way[::-1])


def _centred(nearest: NearestOnSurface, way: FloatArray, radius: float) -> FloatArray:
    """A path (k, 3) over grid nodes moved away from the walls until a ball of `radius` fits, where possible."""
    for _ in range(CENTRINGS):
        away = way - nearest(way)[0]
        clearance = np.maximum(np.linalg.norm(away, axis=1, keepdims=True), np.finfo(float).tiny)
        way = way + 0.5 * np.maximum(radius - clearance, 0.0) * away / clearance
    return way


def _mouth(nearest: NearestOnSurface, way: FloatArray, walls: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Middle, axis (outward) and radius of the narrowest place on a path that leads in."""
    clearance = _clearance(nearest, way)
    # The first and last nodes are no places to be narrow: one is outside, the other the widest.
    inner = np.arange(1, len(way) - 1) if len(way) > 2 else np.array([0])
    narrow = inner[clearance[inner] <= RADIUS_STEP * clearance[inner].min()]
    at = int(narrow[len(narrow) // 2])
    ahead, behind = max(at - MOUTH_NODES, 0), min(at + MOUTH_NODES, len(way) - 1)
    axis = (way[ahead] - way[behind]) / np.linalg.norm(way[ahead] - way[behind])
    outward, middle, radius = axis, way[at], float(clearance[at])
    for step in MOUTH_STEPS:
        across = step * radius * np.linalg.svd(axis[None])[2][1:]
        candidates = middle + np.stack(np.meshgrid(*2 * [np.arange(-3.0, 4.0)]), axis=-1).reshape(-1, 2) @ across
        free = _clearance(nearest, candidates)
        middle, radius = candidates[free.argmax()], float(free.max())
        to_walls = walls - middle
        far = np.linalg.norm(to_walls, axis=1)
        near = (far > 0.0) & (far <= MOUTH_WALLS * radius)
        to_walls = to_walls[near] / far[near, None]
        axis = np.linalg.eigh(to_walls.T @ to_walls)[1][:, 0]
    outward = axis if axis @ outward > 0.0 else -axis
    along = middle + RIM_STEP * radius * np.arange(RIM_SEARCH_STEPS)[:, None] * outward
    within = np.logical_and.accumulate(_clearance(nearest, along) <= FLARE * radius)
    return along[within][-1], outward, radius
