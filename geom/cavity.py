"""Openings that a thing can go into: the inside of a mug, bowl, basket or bin, and large through-holes.

Found by pouring water: seen along an opening direction, the surface is a landscape; what fills up before it runs off
over the edge is a cavity (the depression filling of hydrology: Barnes, Lehman and Mulla 2014, "Priority-flood").
Inner ground that a ray does not hit is closed by the support the object stands on, so pipes and rings hold water too;
they are told apart as `through`.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from geom.hull import contains, convex_hull, outside_by, volume
from geom.support import surface
from geom.surface_distance import closest_on_surface, sample_surface
from schemas.model import FloatArray, IntArray
from schemas.physics import CollisionShape, Solid

GRID_CELLS = 64
WALL_SAMPLES = 40_000
DIRECTIONS = np.array([[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]], dtype=np.float64)

# A cavity matters when its water is at least this share of the hull: upward, and in any other direction, where things
# are seldom put in and most furniture has a recess.
UPWARD_SHARE, OTHER_SHARE = 0.04, 0.12
# ... and when it is at least this deep against its opening, so that a dented plate is not a container.
LEAST_DEPTH_SHARE = 0.12
# Through: the support closes more than this share of the ground. A hole in a wall or a ring holds little water and
# matters by its width, as a share of the diagonal.
THROUGH_SHARE = 0.5
THROUGH_DIAMETER_SHARE = 0.1
# The probe ball, as a share of the opening diameter; it must go down this share of the way it goes in the solid.
PROBE_SHARE, PROBE_DEPTH_SHARE = 0.6, 0.8
PROBE_STEPS = 24


@dataclass(frozen=True)
class Cavity:
    """One significant opening; lengths in metres, frame of the points.

    direction   (3,) unit vector out of the opening.
    opening_m   (3,) centre of the largest circle that fits into the opening, at the rim.
    diameter_m  diameter of that circle, short by up to three grid cells.
    depth_m     from the rim to the ground below that centre.
    probe_m     radius of the probe ball, 60 % of the opening.
    reach_m     how far below the rim the lowest point of that ball gets inside the solid.
    volume_m3   water it holds.
    through     the ground is mostly open: a pipe or ring rather than a container.
    """

    direction: FloatArray
    opening_m: FloatArray
    diameter_m: float
    depth_m: float
    probe_m: float
    reach_m: float
    volume_m3: float
    through: bool


def find_cavities(solid: Solid) -> tuple[Cavity, ...]:
    """Significant cavities along the six axis directions, upward first; none for a solid of kind `hull`.

    A through-hole is listed once, not from both ends.
    """
    if solid.kind == "hull":
        return ()
    try:
        hull_volume = volume(*convex_hull(solid.points))
    except ValueError:
        return ()
    found: list[Cavity] = []
    for direction in DIRECTIONS:
        share = UPWARD_SHARE if direction[2] > 0 else OTHER_SHARE
        for cavity in _pour(solid, direction, share * hull_volume):
            mirrored = any(c.through and cavity.through and c.direction @ direction < -0.5 for c in found)
            if not mirrored:
                found.append(cavity)
    return tuple(found)


def keeps_cavity(shapes: Sequence[CollisionShape], cavity: Cavity) -> bool:
    """True iff the probe ball goes into the opening between the collision shapes, 80 % as far as in the solid."""
    bottom = np.linspace(0.0, PROBE_DEPTH_SHARE * cavity.reach_m, PROBE_STEPS)
    centres = _ball_centres(cavity.opening_m, cavity.direction, cavity.probe_m, bottom)
    for shape in shapes:
        points, triangles = surface(shape)
        hull = convex_hull(points)
        # Beyond a face plane by the radius is far enough; only the rest needs exact distances.
        centres_near = centres[outside_by(*hull, centres) < cavity.probe_m]
        if len(centres_near) == 0:
            continue
        if contains(*hull, centres_near).any():
            return False
        nearest, _ = closest_on_surface(centres_near, points, triangles)
        if (np.linalg.norm(nearest - centres_near, axis=1) < cavity.probe_m).any():
            return False
    return True


def _pour(solid: Solid, direction: FloatArray, least_volume_m3: float) -> list[Cavity]:
    """Cavities that open along `direction` and hold at least `least_volume_m3`, and wide through-holes."""
    frame = _frame(direction)
    local = solid.points @ frame.T
    ground, floor, step, corner = _landscape(local, solid.triangles)
    open_floor = np.isneginf(ground)
    outside, _ = _label(open_floor)
    drain = open_floor & np.isin(outside, np.concatenate([outside[0], outside[-1], outside[:, 0], outside[:, -1]]))
    ground = np.where(open_floor & ~drain, floor, ground)
    depth = np.zeros(ground.shape)
    depth[~drain] = _water_level(ground)[~drain] - ground[~drain]
    pools, count = _label(depth > 0.02 * max(float(np.ptp(local[:, 2])), step))
    size = float(np.linalg.norm(np.ptp(local, axis=0)))
    cavities = []
    for k in range(1, count + 1):
        pool = pools == k
        water = float(depth[pool].sum()) * step * step
        through = bool((open_floor & ~drain)[pool].mean() > THROUGH_SHARE)
        if not through and water < least_volume_m3:
            continue
        # Half a cell more: the distance runs to the centre of the first dry cell.
        clearance = np.asarray(ndimage.distance_transform_edt(pool))
        row, column = np.unravel_index(int(np.argmax(clearance)), pool.shape)
        radius = (float(clearance[row, column]) - 0.5) * step
        deepest = float(depth[row, column])
        deep = water >= least_volume_m3 and deepest >= LEAST_DEPTH_SHARE * 2.0 * radius
        wide = through and 2.0 * radius >= THROUGH_DIAMETER_SHARE * size
        if radius <= 0.0 or not (deep or wide):
            continue
        rim = float(ground[row, column]) + deepest
        opening = frame.T @ np.array([corner[0] + row * step, corner[1] + column * step, rim])
        probe = PROBE_SHARE * radius
        reach = _reach(solid, opening, direction, probe, deepest)
        cavities.append(Cavity(direction, opening, 2.0 * radius, deepest, probe, reach, water, through))
    return cavities


def _landscape(local: FloatArray, triangles: IntArray) -> tuple[FloatArray, float, float, FloatArray]:
    """Height of the surface seen from above on a grid (rows x, columns y), -inf where nothing is.

    Also the lowest height, the cell size, and x, y of the first cell's centre. Rays give the height at cell centres;
    points on faces and edges add walls and rims thinner than a cell, which no ray needs to hit. One empty cell
    surrounds everything.
    """
    import open3d as o3d  # Slow to load; only needed here.

    low, high = local.min(axis=0), local.max(axis=0)
    step = float((high - low)[:2].max()) / GRID_CELLS or 1.0
    cells = np.maximum(np.ceil((high - low)[:2] / step).astype(int), 1) + 2
    corner = 0.5 * (low + high)[:2] - 0.5 * (cells - 1) * step
    x, y = corner[0] + step * np.arange(cells[0]), corner[1] + step * np.arange(cells[1])
    # Unit size, centred: Open3D computes in single precision.
    centre, scale = 0.5 * (low + high), float(np.ptp(local, axis=0).max())
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(((local - centre) / scale).astype(np.float32)),
        o3d.core.Tensor.from_numpy(triangles.astype(np.uint32)),
    )
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    start = np.column_stack([(grid - centre[:2]) / scale, np.full(len(grid), 2.0)])
    rays = np.concatenate([start, np.tile([0.0, 0.0, -1.0], (len(grid), 1))], axis=1).astype(np.float32)
    hit = scene.cast_rays(o3d.core.Tensor.from_numpy(rays))["t_hit"].numpy().astype(np.float64)
    ground = (centre[2] + scale * (2.0 - hit)).reshape(cells[0], cells[1])
    samples, _ = sample_surface(local, triangles, WALL_SAMPLES, 0)
    samples = np.concatenate([samples, _along_edges(local, triangles, 0.5 * step)])
    cell = np.clip(np.rint((samples[:, :2] - corner) / step).astype(int), 0, cells - 1)
    np.maximum.at(ground, (cell[:, 0], cell[:, 1]), samples[:, 2])
    return ground, float(low[2]), step, corner


def _along_edges(points: FloatArray, triangles: IntArray, step: float) -> FloatArray:
    """Points (k, 3) at most `step` apart on every edge, corners included."""
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    start, along = points[edges[:, 0]], points[edges[:, 1]] - points[edges[:, 0]]
    pieces = np.maximum(np.ceil(np.linalg.norm(along, axis=1) / step).astype(int), 1)
    which = np.repeat(np.arange(len(edges)), pieces + 1)
    first = np.cumsum(pieces + 1) - (pieces + 1)
    share = (np.arange(len(which)) - first[which]) / pieces[which]
    return start[which] + share[:, None] * along[which]


def _water_level(ground: FloatArray) -> FloatArray:
    """Level to which each cell fills before it drains over the grid's border or into a cell at -inf.

    Priority-flood (Barnes et al. 2014, algorithm 1) over four neighbours: a wall one cell thick holds diagonally too.
    """
    rows, columns = ground.shape
    level = np.full(ground.shape, np.inf)
    queue: list[tuple[float, int, int]] = []
    for r in range(rows):
        for c in range(columns):
            if r in (0, rows - 1) or c in (0, columns - 1) or np.isneginf(ground[r, c]):
                level[r, c] = ground[r, c]
                queue.append((float(ground[r, c]), r, c))
    heapq.heapify(queue)
    while queue:
        height, r, c = heapq.heappop(queue)
        for dr, dc in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            i, j = r + dr, c + dc
            if 0 <= i < rows and 0 <= j < columns and np.isinf(level[i, j]) and level[i, j] > 0:
                level[i, j] = max(height, float(ground[i, j]))
                heapq.heappush(queue, (level[i, j], i, j))
    return level


def _reach(solid: Solid, opening: FloatArray, direction: FloatArray, radius: float, depth: float) -> float:
    """How far below the rim the bottom of a ball gets before it touches the solid."""
    bottoms = np.linspace(0.0, depth, 4 * PROBE_STEPS)
    centres = _ball_centres(opening, direction, radius, bottoms)
    nearest, _ = closest_on_surface(centres, solid.points, solid.triangles)
    touching = np.linalg.norm(nearest - centres, axis=1) < radius
    return float(bottoms[max(int(touching.argmax()) - 1, 0)] if touching.any() else depth)


def _ball_centres(opening: FloatArray, direction: FloatArray, radius: float, bottoms: FloatArray) -> FloatArray:
    """Centres (k, 3) of balls whose lowest points lie `bottoms` (k,) below the rim."""
    return opening + (radius - bottoms)[:, None] * direction


def _label(mask: FloatArray) -> tuple[IntArray, int]:
    """Number (rows, columns) of each cell's patch of True cells, from 1, and how many there are."""
    labels = np.zeros(mask.shape, dtype=np.int32)
    return labels, int(ndimage.label(mask, output=labels))  # pyright: ignore[reportArgumentType]  # an int with `output`


def _frame(direction: FloatArray) -> FloatArray:
    """Rotation (3, 3) that takes `direction`, a coordinate axis or its opposite, to z."""
    axis = int(np.abs(direction).argmax())
    rows = np.stack([np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3], np.abs(direction)])
    if direction[axis] < 0:
        rows[1:] = -rows[1:]
    return rows
