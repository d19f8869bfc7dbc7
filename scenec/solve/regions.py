"""Exact feasible regions of the asset origin of a thing at one orientation and yaw, given the things already placed.

The place eroded by the footprint, less the Minkowski sums of obstacles with the reflected footprint (no-fit polygons),
intersected with ranges, limits and relations. Circles are polygons of SEGMENTS sides per quarter turn, on the safe
side; footprints of many pieces are replaced by slightly larger ones (COARSE_SHARE). Frame P of the owner, metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from math import atan2, cos, hypot, inf, pi, sin
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from scenec.ir.problem import WORLD_PARENT, RelationIR, Slab
from scenec.solve.check import Assignment
from scenec.solve.frames import Pose2, pose_of, turned_direction
from scenec.solve.model import SLACK_M, Site, SolverModel
from scenec.solve.placed import Placed
from scenec.solve.planar import ROUND_OUT, SEGMENTS, hulls, outline_of, polygon
from scenec.solve.relations import direction_B, extent, front_B, origin_B, outlines_B
from scenec.solve.shapes import ShapeAtYaw
from schemas.arrays import FloatArray

NOWHERE = Polygon()
FEW_PIECES = 16  # product of the piece counts of two footprints below which no-fit polygons are not cached
_NO_FIT: WeakKeyDictionary[ShapeAtYaw, WeakKeyDictionary[ShapeAtYaw, dict[float, BaseGeometry]]] = WeakKeyDictionary()
FEW_CORNERS = 100  # product of the corner counts of two outlines below which the hull of all differences is as fast


def no_fit_polygons(outline: FloatArray, reflected: Sequence[FloatArray]) -> list[BaseGeometry]:
    """No-fit polygons of one convex obstacle (n, 2): its Minkowski sums with the reflected footprint's pieces."""
    return hulls([minkowski_sum_points(outline, piece) for piece in reflected])


def minkowski_sum_points(a: FloatArray, b: FloatArray) -> FloatArray:
    """Points (k, 2) whose hull is the Minkowski sum of a convex outline and a reflected one: all differences of corners
    where these are few, else the corners found by merging the edges of both by direction."""
    if len(a) * len(b) <= FEW_CORNERS:
        return (a[:, None, :] - b[None, :, :]).reshape(-1, 2)
    one, two = _from_lowest(a), _from_lowest(-b)
    edges = np.concatenate([np.roll(one, -1, axis=0) - one, np.roll(two, -1, axis=0) - two])
    order = np.argsort(np.arctan2(edges[:, 1], edges[:, 0]) % (2.0 * pi), kind="stable")
    passed = np.cumsum(order < len(one))
    at = np.concatenate([[0], passed[:-1]])
    return one[at % len(one)] + two[(np.arange(len(order)) - at) % len(two)]


def _from_lowest(outline: FloatArray) -> FloatArray:
    # Counter-clockwise, beginning at the lowest corner (the leftmost of these): edges turn from 0 to a whole turn.
    x, y = outline.T
    if float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) < 0.0:
        outline = outline[::-1]
    return np.roll(outline, -int(np.lexsort((outline[:, 0], outline[:, 1]))[0]), axis=0)


def eroded(area: Polygon, pieces: Sequence[FloatArray]) -> BaseGeometry:
    """Region of the origin for which the union of convex pieces lies inside a polygon with holes (Minkowski
    erosion)."""
    corners = pieces[0] if len(pieces) == 1 else np.concatenate(pieces)
    x0, y0, x1, y1 = area.bounds
    hull = area.convex_hull
    lows, highs = corners.min(axis=0), corners.max(axis=0)
    if x1 - x0 - highs[0] + lows[0] < -SLACK_M or y1 - y0 - highs[1] + lows[1] < -SLACK_M:
        return NOWHERE
    inner = _box(x0 - lows[0], y0 - lows[1], x1 - highs[0], y1 - highs[1])
    if hull.area < (x1 - x0) * (y1 - y0) - 1e-12:
        outline = shapely.get_coordinates(hull)[None] - corners[:, None]  # one moved hull for each corner
        inner = shapely.intersection_all([inner, *map(polygon, outline)])
    if hull.area - area.area > 1e-12:
        gaps = shapely.constrained_delaunay_triangles(hull.difference(area))
        no_fit = [
            s for gap in shapely.get_parts(gaps) for s in no_fit_polygons(shapely.get_coordinates(gap)[:-1], pieces)
        ]
        inner = inner.difference(shapely.union_all(no_fit))
    return inner


def half_plane(dx: float, dy: float, end: float, around: tuple[float, float, float, float]) -> Polygon:
    """The part of a large square around the box `around` with p . (dx, dy) <= end, for a unit direction."""
    cx, cy = (around[0] + around[2]) / 2, (around[1] + around[3]) / 2
    size = 2.0 * (around[2] - around[0] + around[3] - around[1]) + 1.0
    past = min(end - cx * dx - cy * dy, 0.7 * size)  # a border far beyond the box must not leave the box behind
    px, py = cx + past * dx, cy + past * dy
    return Polygon(
        [
            (px + size * -dy, py + size * dx),
            (px + size * (-dy - 2 * dx), py + size * (dx - 2 * dy)),
            (px + size * (dy - 2 * dx), py + size * (-dx - 2 * dy)),
            (px + size * dy, py - size * dx),
        ]
    )


def region_alone(model: SolverModel, name: str, turned: ShapeAtYaw, base_m: float = 0.0) -> BaseGeometry:
    """Region of a thing by its unary constraints, `base_m` over its place: place, ranges, limits, parts, keep-outs."""
    thing = model.things[name]
    site = model.site(thing)
    area = on_site_region(site, turned, base_m)
    if area.is_empty:
        return area
    ox, oy = float(thing.place.origin_P_m[0]), float(thing.place.origin_P_m[1])
    (xa, xb), (ya, yb) = thing.domain.x_m, thing.domain.y_m
    if max(-xa, xb, -ya, yb) > -inf and (xa > -inf or xb < inf or ya > -inf or yb < inf):
        x0, y0, x1, y1 = area.bounds
        low = (max(x0, xa + ox), max(y0, ya + oy))
        high = (min(x1, xb + ox), min(y1, yb + oy))
        if low[0] > high[0] + SLACK_M or low[1] > high[1] + SLACK_M:
            return NOWHERE
        area = area.intersection(_box(*low, *high))
    for dx, dy, end in model.limits.get(name, ()):
        if area.is_empty:
            return area
        area = area.intersection(half_plane(dx, dy, end - float((turned.hull @ (dx, dy)).max()), area.bounds))
    return area


def _box(x0: float, y0: float, x1: float, y1: float) -> BaseGeometry:
    # Ranges may be a line or a point.
    if x1 - x0 > SLACK_M and y1 - y0 > SLACK_M:
        return shapely.box(x0, y0, x1, y1)
    if x1 - x0 <= SLACK_M and y1 - y0 <= SLACK_M:
        return shapely.Point((x0 + x1) / 2, (y0 + y1) / 2)
    return shapely.LineString([(x0, y0), (x1, y1)])


def on_site_region(site: Site, turned: ShapeAtYaw, base_m: float = 0.0) -> BaseGeometry:
    """Region of a footprint on a place, on its floor or `base_m` over it, without ranges and limits."""
    shape = turned.shape
    height = shape.height_m if site.is_surface else max(slab.high_m for slab in shape.slabs[: shape.own])
    if base_m + height > site.top_m + SLACK_M:
        return NOWHERE
    slabs = list(zip(turned.outlines, shape.slabs, strict=True))
    base_P_m = site.base_P_m + base_m
    if len(site.layers) == 1:
        area = eroded(site.layers[0][2], turned.pieces)
    else:
        area = None
        # The narrowest first, which most often leave nothing.
        for low, high, layer in sorted(site.layers, key=lambda layer: layer[2].area):
            if outlines := _within(slabs, low - base_m, high - base_m):
                here = eroded(layer, outlines)
                area = here if area is None else area.intersection(here)
                if area.is_empty:
                    return NOWHERE
        area = NOWHERE if area is None else area
    blocked = [
        s
        for part, low, high in site.above
        for outline, slab in slabs
        if slab.low_m + base_P_m < high - SLACK_M and slab.high_m + base_P_m > low + SLACK_M
        for s in no_fit_polygons(shapely.get_coordinates(part)[:-1], [outline])
    ]
    for keep, low, high in site.keep_outs:
        parts = shapely.get_parts(shapely.constrained_delaunay_triangles(keep))
        blocked += [
            s
            for outline, slab in slabs
            if slab.low_m + base_P_m < high - SLACK_M and slab.high_m + base_P_m > low + SLACK_M
            for part in parts
            for s in no_fit_polygons(shapely.get_coordinates(part)[:-1], [outline])
        ]
    return area.difference(shapely.union_all(blocked)) if blocked and not area.is_empty else area


def _within(slabs: Sequence[tuple[FloatArray, Slab]], low_m: float, high_m: float) -> list[FloatArray]:
    # Outlines of the slabs between two heights over the lowest point of a thing.
    return [outline for outline, slab in slabs if slab.low_m < high_m - SLACK_M and slab.high_m > low_m + SLACK_M]


def feasible_region(
    model: SolverModel,
    name: str,
    turned: ShapeAtYaw,
    assignment: Assignment,
    unary_region: BaseGeometry,
    base_m: float = 0.0,
) -> tuple[BaseGeometry, set[str]]:
    """(region of the origin, names of the things that reduced it below `unary_region`), `base_m` over its place.

    Relations with things not placed yet, or in the frame of the thing itself, are left to the check."""
    if unary_region.is_empty:
        return unary_region, set()
    area, culprits = unary_region, set[str]()
    thing = model.things[name]
    for rule in model.rules_of.get(name, ()):
        others = {n for n in (*rule.things, rule.frame) if n not in (name, WORLD_PARENT)}
        links = model.depends_on(rule) - {name}
        if name not in rule.things or not links.issubset(assignment) or any(name in model.chains[n] for n in others):
            continue
        owner = pose_of(thing.parent, assignment)
        allowed = _rule_region(rule, name, turned, owner, assignment, area.bounds)
        culprits |= links
        if allowed is not None:
            area = area.intersection(allowed)
        if area.is_empty:
            return area, culprits
    if model.problem.reach is not None and name in model.problem.reach.members:
        area = area.intersection(_reach_region(model, pose_of(thing.parent, assignment), area.bounds))
        culprits |= set(model.chains[name]) - {name}
        if area.is_empty:
            return area, culprits
    no_fit, blamed = _obstacles(model, name, turned, assignment, area.bounds, base_m)
    if no_fit:
        area = area.difference(shapely.union_all(no_fit))
        culprits |= blamed
    return area, culprits


def _obstacles(
    model: SolverModel,
    name: str,
    turned: ShapeAtYaw,
    assignment: Assignment,
    around: tuple[float, float, float, float],
    base_m: float,
) -> tuple[list[BaseGeometry], set[str]]:
    # No-fit polygons of things on the same owner at common heights, as far as they intersect the box `around`.
    thing, clearance = model.things[name], model.problem.clearance_m
    base = model.site(thing).base_P_m + base_m
    top = base + turned.shape.height_m
    fx0, fy0, fx1, fy1 = turned.bounds
    x0, y0, x1, y1 = around
    whole: list[FloatArray] = []
    known: list[BaseGeometry] = []
    blamed: set[str] = set()
    for other, placed in assignment.items():
        if placed.parent != thing.parent or other == name:
            continue
        bx0, by0, bx1, by1 = placed.bounds
        if (
            bx0 - fx1 - clearance >= x1
            or bx1 - fx0 + clearance <= x0
            or by0 - fy1 - clearance >= y1
            or by1 - fy0 + clearance <= y0
        ):
            continue
        if not (placed.base_P_m < top - SLACK_M and base < placed.top_P_m - SLACK_M):
            continue
        blamed.add(other)
        if placed.place == thing.place.name and len(placed.turned.pieces) * len(turned.pieces) > FEW_PIECES:
            shift = (placed.x_P_m, placed.y_P_m)
            known.append(shapely.transform(_no_fit(placed.turned, turned, clearance), partial(np.add, shift)))
        elif placed.place == thing.place.name:
            whole += [minkowski_sum_points(piece, mine) for piece in placed.grown(clearance) for mine in turned.pieces]
        else:
            for outline, low, high in placed.slabs:
                wide = outline.buffer(clearance * ROUND_OUT, quad_segs=SEGMENTS) if clearance > 0.0 else outline
                for mine, slab in zip(turned.outlines, turned.shape.slabs, strict=True):
                    if slab.low_m + base < high - SLACK_M and low < slab.high_m + base - SLACK_M:
                        whole.append(minkowski_sum_points(shapely.get_coordinates(wide)[:-1], mine))
    return [*known, *hulls(whole)], blamed


def _no_fit(other: ShapeAtYaw, mine: ShapeAtYaw, clearance_m: float) -> BaseGeometry:
    """No-fit polygon of two footprints of many pieces (from their coarse pieces), the other's origin at 0; cached while
    both exist."""
    by_clearance = _NO_FIT.setdefault(other, WeakKeyDictionary()).setdefault(mine, {})
    if clearance_m not in by_clearance:
        wide = [polygon(piece).buffer(clearance_m * ROUND_OUT, quad_segs=SEGMENTS) for piece in other.coarse_pieces]
        outlines = [outline_of(area) for area in wide] if clearance_m > 0.0 else other.coarse_pieces
        by_clearance[clearance_m] = shapely.union_all(
            hulls([minkowski_sum_points(one, piece) for one in outlines for piece in mine.coarse_pieces])
        )
    return by_clearance[clearance_m]


def _rule_region(
    rule: RelationIR,
    name: str,
    turned: ShapeAtYaw,
    owner: Pose2,
    assignment: Assignment,
    around: tuple[float, float, float, float],
) -> BaseGeometry | None:
    # Region of the origin of `name` in which the relation holds, the others placed; None: left to the check.
    mates = [assignment[n] for n in rule.things if n != name]
    if rule.kind == "before":
        dx, dy = direction_B(rule, assignment)
        px, py = turned_direction((dx, dy), -owner.yaw_rad)
        start = owner.x_m * dx + owner.y_m * dy
        along = turned.hull @ (px, py)
        begin, end = extent(mates[0], (dx, dy), assignment)
        if rule.things[0] == name:
            return half_plane(px, py, begin - rule.gap_m - start - float(along.max()), around)
        return half_plane(-px, -py, -(end + rule.gap_m - start - float(along.min())), around)
    if rule.kind in ("near", "far_from"):
        no_fit = hulls(
            [
                minkowski_sum_points(_in_P(o, owner), mine)
                for o in outlines_B(mates[0], assignment)
                for mine in turned.pieces
            ]
        )
        if rule.kind == "near":
            return shapely.union_all(shapely.buffer(no_fit, rule.gap_m, quad_segs=4 * SEGMENTS))
        grown = shapely.union_all(shapely.buffer(no_fit, rule.gap_m * ROUND_OUT, quad_segs=SEGMENTS))
        return shapely.difference(shapely.box(*_widened(around)), grown)
    points = [owner.inverse_point(*origin_B(mate, assignment)) for mate in mates]
    if rule.kind == "aligned":
        px, py = turned_direction(direction_B(rule, assignment), -owner.yaw_rad)
        across = [-py * x + px * y for x, y in points]
        low, high = max(across) - rule.tolerance, min(across) + rule.tolerance
        return _strip(-py, px, low, high, around) if high - low >= -SLACK_M else NOWHERE
    if rule.kind == "facing":
        if rule.tolerance > 1.4:
            return None
        ahead = turned.yaw_rad + turned.shape.front_rad
        if rule.things[1] == name:
            ahead = front_B(mates[0], assignment) - owner.yaw_rad
        size = sum(abs(v) for v in around) + sum(abs(v) for v in points[0]) + 1.0
        away = 0.0 if rule.things[1] == name else pi
        return _wedge(points[0], ahead + away, rule.tolerance, size)
    if rule.things[0] == name:  # between
        return _beside(points[0], points[1], rule.tolerance)
    return None


def _in_P(outline_B: FloatArray, owner: Pose2) -> FloatArray:
    c, s = cos(owner.yaw_rad), sin(owner.yaw_rad)
    return (outline_B - (owner.x_m, owner.y_m)) @ np.array([[c, -s], [s, c]])


def _widened(box: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    return box[0] - 1.0, box[1] - 1.0, box[2] + 1.0, box[3] + 1.0


def _strip(nx: float, ny: float, low: float, high: float, around: tuple[float, float, float, float]) -> BaseGeometry:
    # Points with low <= p . n <= high near a box; a line where both are equal.
    cx, cy = (around[0] + around[2]) / 2, (around[1] + around[3]) / 2
    size = around[2] - around[0] + around[3] - around[1] + 1.0
    at = cx * nx + cy * ny
    ends = [(cx + (v - at) * nx, cy + (v - at) * ny) for v in (low, high)]
    if high - low <= SLACK_M:
        x, y = ends[0]
        return shapely.LineString([(x - size * ny, y + size * nx), (x + size * ny, y - size * nx)])
    (xa, ya), (xb, yb) = ends
    return Polygon(
        [
            (xa - size * ny, ya + size * nx),
            (xa + size * ny, ya - size * nx),
            (xb + size * ny, yb - size * nx),
            (xb - size * ny, yb + size * nx),
        ]
    )


def _wedge(apex: tuple[float, float], heading: float, half: float, size: float) -> BaseGeometry:
    x, y = apex
    size /= cos(half)
    sides = [(x + size * cos(heading + h), y + size * sin(heading + h)) for h in (-half, half)]
    if half <= SLACK_M:
        return shapely.LineString([apex, sides[0]])
    return Polygon([apex, *sides])


def _beside(a: tuple[float, float], b: tuple[float, float], tolerance: float) -> BaseGeometry:
    length = hypot(b[0] - a[0], b[1] - a[1])
    if length < SLACK_M:
        return NOWHERE
    line = shapely.LineString([a, b])
    return line.buffer(tolerance, cap_style="flat") if tolerance > SLACK_M else line


def _reach_region(model: SolverModel, owner: Pose2, around: tuple[float, float, float, float]) -> BaseGeometry:
    reach = model.problem.reach
    assert reach is not None
    base_B = np.linalg.inv(model.problem.X_WB) @ (*reach.base_m, 1.0)
    centre = shapely.Point(owner.inverse_point(float(base_B[0]), float(base_B[1])))
    ring: BaseGeometry = centre.buffer(reach.most_m, quad_segs=8 * SEGMENTS)
    if reach.least_m > 0.0:
        ring = ring.difference(centre.buffer(reach.least_m * ROUND_OUT, quad_segs=SEGMENTS))
    return ring


def facing_yaw(model: SolverModel, placed: Placed, assignment: Assignment) -> float | None:
    """The yaw at which a thing exactly faces the placed thing that it must face; None without such a relation."""
    for rule in model.rules_of.get(placed.name, ()):
        if rule.kind == "facing" and rule.things[0] == placed.name and rule.things[1] in assignment:
            trial = {**assignment, placed.name: placed}
            if model.depends_on(rule).issubset(trial):
                (ax, ay), (bx, by) = (origin_B(trial[n], trial) for n in rule.things)
                owner = pose_of(placed.parent, trial)
                return atan2(by - ay, bx - ax) - owner.yaw_rad - placed.turned.shape.front_rad
    return None
