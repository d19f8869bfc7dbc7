"""Exact feasible regions of the asset origin of a thing at one orientation and yaw, given the things already placed.

The place eroded by the footprint, less the Minkowski sums of obstacles with the reflected footprint (no-fit polygons),
intersected with ranges, limits and relations. Circles are polygons of SEGMENTS sides per quarter turn, on the safe
side; footprints of many pieces are replaced by slightly larger ones (COARSE_SHARE). Frame P of the owner, metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import inf
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from scenec.relations.protocol import Mover
from scenec.relations.table import RELATIONS
from scenec.solve.check import Assignment
from scenec.solve.frames import Pose2, pose_of
from scenec.solve.model import Site, SolverModel
from scenec.solve.placed import Placed
from scenec.solve.planar import ROUND_OUT, SEGMENTS, SLACK_M, hulls, outline_of, polygon
from scenec.solve.region_geometry import NOWHERE, half_plane, minkowski_sum_points, no_fit_polygons
from scenec.solve.shapes import ShapeAtYaw
from schemas.arrays import FloatArray
from schemas.scene.geometry import BACKGROUND, Prism

FEW_PIECES = 16  # product of the piece counts of two footprints below which no-fit polygons are not cached
_NO_FIT: WeakKeyDictionary[ShapeAtYaw, WeakKeyDictionary[ShapeAtYaw, dict[float, BaseGeometry]]] = WeakKeyDictionary()


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
    height = shape.height_m if site.is_surface else max(prism.high_m for prism in shape.prisms[: shape.own])
    if base_m + height > site.top_m + SLACK_M:
        return NOWHERE
    prisms = list(zip(turned.outlines, shape.prisms, strict=True))
    base_P_m = site.base_P_m + base_m
    if len(site.layers) == 1:
        area = eroded(site.layers[0][2], turned.pieces)
    else:
        area = None
        # The narrowest first, which most often leave nothing.
        for low, high, layer in sorted(site.layers, key=lambda layer: layer[2].area):
            if outlines := _within(prisms, low - base_m, high - base_m):
                here = eroded(layer, outlines)
                area = here if area is None else area.intersection(here)
                if area.is_empty:
                    return NOWHERE
        area = NOWHERE if area is None else area
    blocked = [
        s
        for part, low, high in site.above
        for outline, prism in prisms
        if prism.low_m + base_P_m < high - SLACK_M and prism.high_m + base_P_m > low + SLACK_M
        for s in no_fit_polygons(shapely.get_coordinates(part)[:-1], [outline])
    ]
    for keep, low, high in site.keep_outs:
        parts = shapely.get_parts(shapely.constrained_delaunay_triangles(keep))
        blocked += [
            s
            for outline, prism in prisms
            if prism.low_m + base_P_m < high - SLACK_M and prism.high_m + base_P_m > low + SLACK_M
            for part in parts
            for s in no_fit_polygons(shapely.get_coordinates(part)[:-1], [outline])
        ]
    return area.difference(shapely.union_all(blocked)) if blocked and not area.is_empty else area


def _within(prisms: Sequence[tuple[FloatArray, Prism]], low_m: float, high_m: float) -> list[FloatArray]:
    # Outlines of the prisms between two heights over the lowest point of a thing.
    return [outline for outline, prism in prisms if prism.low_m < high_m - SLACK_M and prism.high_m > low_m + SLACK_M]


def feasible_region(
    model: SolverModel,
    name: str,
    turned: ShapeAtYaw,
    assignment: Assignment,
    unary_region: BaseGeometry,
    base_m: float = 0.0,
) -> tuple[BaseGeometry, set[str]]:
    """(region of the origin, names of the things that reduced it below `unary_region`), `base_m` over its place.

    Relations with things not placed yet (unless they constrain early), or in the frame of the thing itself, are left to
    the check."""
    if unary_region.is_empty:
        return unary_region, set()
    area, culprits = unary_region, set[str]()
    thing = model.things[name]
    base_P_m = model.site(thing).base_P_m + base_m
    for rule in model.rules_of.get(name, ()):
        placed = rule
        if RELATIONS[rule.kind].constrains_early:
            members = tuple(n for n in rule.things if n == name or n in assignment)
            if len(members) < 2:
                continue
            placed = rule if len(members) == len(rule.things) else replace(rule, things=members)
        others = {n for n in (*placed.things, rule.frame) if n not in (name, BACKGROUND)}
        links = model.depends_on(placed) - {name}
        if name not in rule.things or not links.issubset(assignment) or any(name in model.chains[n] for n in others):
            continue
        owner = pose_of(thing.parent, assignment)
        mover = Mover(name, turned, owner, area.bounds, base_P_m)
        allowed = RELATIONS[rule.kind].region(rule, mover, assignment)
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
            for outline, low, high in placed.prisms:
                wide = outline.buffer(clearance * ROUND_OUT, quad_segs=SEGMENTS) if clearance > 0.0 else outline
                for mine, prism in zip(turned.outlines, turned.shape.prisms, strict=True):
                    if prism.low_m + base < high - SLACK_M and low < prism.high_m + base - SLACK_M:
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


def _reach_region(model: SolverModel, owner: Pose2, around: tuple[float, float, float, float]) -> BaseGeometry:
    reach = model.problem.reach
    assert reach is not None
    base_B = np.linalg.inv(model.problem.X_WB) @ (*reach.base_m, 1.0)
    centre = shapely.Point(owner.inverse_point(float(base_B[0]), float(base_B[1])))
    ring: BaseGeometry = centre.buffer(reach.most_m, quad_segs=8 * SEGMENTS)
    if reach.least_m > 0.0:
        ring = ring.difference(centre.buffer(reach.least_m * ROUND_OUT, quad_segs=SEGMENTS))
    return ring


def exact_yaw(model: SolverModel, placed: Placed, assignment: Assignment) -> float | None:
    """The yaw at which a thing exactly fulfils a relation with placed things; None where no relation fixes its yaw."""
    trial = {**assignment, placed.name: placed}
    for rule in model.rules_of.get(placed.name, ()):
        if trial.keys() >= set(rule.things) and model.depends_on(rule).issubset(trial):
            yaw = RELATIONS[rule.kind].exact_yaw(rule, placed, trial)
            if yaw is not None:
                return yaw
    return None
