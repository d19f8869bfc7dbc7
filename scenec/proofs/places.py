"""Bounds on where a thing may be on its place: walls and obstacles as convex pieces in A, each on the safe side of the
truth.

Walls are convex hulls of regions that must contain an outline; obstacles are convex pieces that an outline must not
enter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon

from geom.planar import turned
from scenec.ir.problem import Problem, Thing
from scenec.proofs.outlines import OUTLINE_SLACK_M, YawCell, half_planes, hull, kernel, support_bounds
from scenec.proofs.swept_spaces import certain_spaces
from schemas.arrays import FloatArray
from schemas.scene.geometry import BACKGROUND, ScenePlace, Stance

RING_SIDES = 24
LEAST_AREA_M2 = 1e-8


@dataclass(frozen=True)
class PlacementBounds:
    """For one thing in one orientation: walls and obstacles as (outline in S, container or obstacle (n, 2) in A), and
    the rectangle of its origin. `ring` is the robot's reach in A (centre, least, most) where the place does not move.
    """

    walls: tuple[tuple[FloatArray, FloatArray], ...]
    obstacles: tuple[tuple[FloatArray, FloatArray], ...]
    low_m: FloatArray
    high_m: FloatArray
    ring: tuple[FloatArray, float, float] | None = None


def background_yaw(problem: Problem) -> float:
    """Yaw of the background in the world."""
    return float(np.arctan2(problem.X_WB[1, 0], problem.X_WB[0, 0]))


def area(place: ScenePlace) -> shapely.Geometry:
    """The area in A that footprints in the place may cover (the union of the layers of a volume)."""
    return shapely.union_all([layer.polygon for layer in place.layers]) if place.is_volume else place.polygon


def area_hull(place: ScenePlace) -> FloatArray:
    """Convex hull of `area`, counter-clockwise (n, 2)."""
    return ring_of(shapely.convex_hull(area(place)))


def ring_of(convex: shapely.Geometry) -> FloatArray:
    """Corners (n, 2) of a polygon without holes, counter-clockwise."""
    return shapely.get_coordinates(shapely.orient_polygons(convex))[:-1]


def fits_height(thing: Thing, stance: Stance) -> bool:
    """Whether an orientation is low enough for the clearance or rim."""
    return stance.height_m <= thing.place.height_m + OUTLINE_SLACK_M


def max_base_height(thing: Thing, stance: Stance) -> float:
    """Largest height (m) of its lowest point over the floor: on contents of a volume, else 0."""
    return max(0.0, thing.place.height_m - stance.height_m) if thing.place.is_volume else 0.0


def placement_bounds(problem: Problem, thing: Thing, stance: Stance) -> PlacementBounds:
    """Bounds of a thing in one orientation. Of things with fixed poses only `ring` is used."""
    walls: list[tuple[FloatArray, FloatArray]] = []
    obstacles: list[tuple[FloatArray, FloatArray]] = []
    lift = max_base_height(thing, stance)
    pieces = sorted(stance.prisms, key=lambda prism: -Polygon(prism.outline_m).area)[:8]
    if not thing.place.is_volume:
        walls.append((hull(stance.prisms), area_hull(thing.place)))
        holes = _parts(thing.place.polygon.convex_hull.difference(thing.place.polygon))
        obstacles += [(prism.outline_m, part) for prism in pieces for part in holes]
        obstacles += [
            (prism.outline_m, part.outline_m)
            for prism in pieces
            for part in thing.place.above
            if min(prism.high_m, part.high_m) - max(prism.low_m, part.low_m) > OUTLINE_SLACK_M
        ]
    else:
        for prism in pieces:
            container = _layers(thing.place, prism.low_m + lift, prism.high_m)
            if shapely.is_empty(container):
                return PlacementBounds((), (), np.full(2, np.inf), np.full(2, -np.inf))
            around = shapely.convex_hull(container)
            walls.append((prism.outline_m, ring_of(around)))
            obstacles += [(prism.outline_m, part) for part in _parts(shapely.difference(around, container))]
    for rule in problem.keep_outs:
        if (rule.parent, rule.place.name) == (thing.parent, thing.place.name):
            entered = [prism for prism in pieces if prism.low_m + lift < rule.height_m - OUTLINE_SLACK_M]
            obstacles += [(prism.outline_m, part) for prism in entered for part in _parts(rule.polygon)]
    for space in certain_spaces(problem, thing):
        entered = [
            prism
            for prism in pieces
            if prism.low_m + lift < space.high_m - OUTLINE_SLACK_M and prism.high_m > space.low_m + OUTLINE_SLACK_M
        ]
        obstacles += [(prism.outline_m, part) for prism in entered for part in _parts(space.area)]
    (x0, x1), (y0, y1) = thing.domain.x_m, thing.domain.y_m
    return PlacementBounds(
        tuple(walls), tuple(obstacles), np.array([x0, y0]), np.array([x1, y1]), _ring(problem, thing)
    )


def _layers(place: ScenePlace, low_m: float, high_m: float) -> shapely.Geometry:
    """Container of a prism that spans at least these heights: the intersection of these layers, else the union of
    all."""
    spanned = [polygon for low, high, polygon in place.layers if min(high, high_m) - max(low, low_m) > OUTLINE_SLACK_M]
    return shapely.intersection_all(spanned) if spanned else area(place)


def _parts(shape: shapely.Geometry) -> list[FloatArray]:
    """Convex pieces of polygons: themselves, or the triangles of those that are not convex."""
    parts: list[FloatArray] = []
    for polygon in shapely.get_parts(shape):
        if polygon.geom_type != "Polygon" or polygon.area < LEAST_AREA_M2:
            continue
        convex = not polygon.interiors and polygon.convex_hull.area - polygon.area < 1e-12
        pieces = [polygon] if convex else shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
        parts += [ring_of(piece) for piece in pieces if piece.area >= LEAST_AREA_M2]
    return parts


def _ring(problem: Problem, thing: Thing) -> tuple[FloatArray, float, float] | None:
    reach = problem.reach
    if reach is None or thing.name not in reach.members or thing.parent != BACKGROUND:
        return None
    centre = turned((reach.base_m - problem.X_WB[:3, 3])[None, :2], -background_yaw(problem))[0]
    return centre - thing.place.origin_P_m[:2], reach.least_m, reach.most_m


def linear_bounds(placement_bounds: PlacementBounds, yaw: YawCell) -> tuple[FloatArray, FloatArray]:
    """(normals (k, 2), bounds (k,)): normals @ origin <= bounds for the origin in A at any yaw of the interval."""
    normals, bounds = [], []
    for outline, container in placement_bounds.walls:
        edges = np.roll(container, -1, axis=0) - container
        outward = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.hypot(edges[:, 0], edges[:, 1])[:, None]
        fronts = np.array([support_bounds(outline, normal, yaw)[0] for normal in outward])
        normals.append(outward)
        bounds.append(np.einsum("ij,ij->i", outward, container) - fronts)
    normals.append(np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]))
    bounds.append(np.concatenate([placement_bounds.high_m, -placement_bounds.low_m]))
    if placement_bounds.ring is not None:
        angles = np.arange(RING_SIDES) * (2.0 * np.pi / RING_SIDES)
        outward = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        normals.append(outward)
        bounds.append(outward @ placement_bounds.ring[0] + placement_bounds.ring[2])
    stacked, limits = np.concatenate(normals), np.concatenate(bounds) + OUTLINE_SLACK_M
    return stacked[np.isfinite(limits)], limits[np.isfinite(limits)]


def forbidden(placement_bounds: PlacementBounds, yaw: YawCell) -> list[FloatArray]:
    """Convex outlines in A whose interior cannot contain the origin at any yaw of the interval."""
    kernels = {id(outline): outline for outline, _ in placement_bounds.obstacles}
    kernels = {key: kernel(outline, yaw) for key, outline in kernels.items()}
    outlines = [
        minkowski(obstacle, -inner)
        for outline, obstacle in placement_bounds.obstacles
        if len(inner := kernels[id(outline)]) >= 3
    ]
    if placement_bounds.ring is not None and placement_bounds.ring[1] > 0.0:
        angles = np.arange(RING_SIDES) * (2.0 * np.pi / RING_SIDES)
        outlines.append(
            placement_bounds.ring[0] + placement_bounds.ring[1] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        )
    return outlines


def minkowski(one: FloatArray, two: FloatArray) -> FloatArray:
    """Sum of two convex outlines: the hull of all sums of corners, counter-clockwise."""
    sums = (one[:, None] + two[None]).reshape(-1, 2)
    return ring_of(shapely.MultiPoint(sums).convex_hull)


def free_region(placement_bounds: PlacementBounds, yaw: YawCell) -> shapely.Geometry:
    """Superset of the region of the origin over the yaw interval; if empty, there is no pose."""
    normals, bounds = linear_bounds(placement_bounds, yaw)
    far = 1e3
    region = half_planes(normals, bounds, np.array([[-far, -far], [far, -far], [far, far], [-far, far]]))
    if len(region) < 3:
        return Polygon()
    left: shapely.Geometry = Polygon(region)
    blocked = [Polygon(ring).buffer(-OUTLINE_SLACK_M, join_style="mitre") for ring in forbidden(placement_bounds, yaw)]
    return left.difference(shapely.union_all(blocked)) if blocked else left
