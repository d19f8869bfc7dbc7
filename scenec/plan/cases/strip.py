"""Strips: cases of a single thing that cover its whole feasible region, for each orientation and sector of yaws.

A strip is a rectangle of the *origin*; it holds for every yaw of its sector, because the footprint swept over the
sector stays on the place there. Weights are areas times yaws, so that draws are uniform over the covered region.
"""

from __future__ import annotations

from itertools import pairwise
from math import ceil, cos, pi

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from geom.planar import inner_radius
from scenec.plan.cases.cells import SPARE_M
from scenec.plan.cases.pool_model import GRAIN_M, GRAIN_RAD, Member, PoolModel
from scenec.solve.model import Site
from scenec.solve.planar import ROUND_OUT, SEGMENTS, hull_of
from scenec.solve.regions import eroded, no_fit_polygons
from scenec.solve.shapes import Shape
from scenec.solve.shelf import free_intervals
from schemas.arrays import FloatArray
from schemas.scene.geometry import ReachRing
from schemas.scene.runtime_plan import PlanCase

SECTOR_RAD = pi / 8.0
SWEEP_RAD = pi / 90.0
STRIPS = 16  # across the region
LEAST_SHARE = 1e-3  # strips with less than this of a region are dropped
ROUND = 1.002  # ratio of outer to inner radius of a footprint below which it needs no sectors


def strips(pool: PoolModel, reach: ReachRing | None, base_P_m: FloatArray) -> list[PlanCase]:
    """Cases of the only member of a pool that cover its feasible region; none where no sector has any region."""
    (member,) = pool.members
    site = pool.model.site(member.thing)
    cases: list[PlanCase] = []
    for stance in sorted(member.yaw_extents):
        shape, span = member.shapes[stance], member.thing.domain.yaw_rad
        for low, high in _sectors(shape, site, span):
            swept = _swept(shape, low, high)
            region = _region(member, site, shape, swept, reach, base_P_m)
            if not region.is_empty and region.area > 0.0:
                cases += _cut(member, stance, swept, region, low, high)
    most = max((case.weight for case in cases), default=0.0)
    return [case for case in cases if case.weight >= LEAST_SHARE * most]


def _sectors(shape: Shape, site: Site, span_rad: tuple[float, float]) -> list[tuple[float, float]]:
    low, high = span_rad
    if high == low or _is_round(shape):
        return [(low, high)]
    count = ceil((high - low) / SECTOR_RAD - 1e-9)
    edges = np.linspace(low, high, count + 1).tolist()
    return list(pairwise(edges))


def _is_round(shape: Shape) -> bool:
    return len(shape.pieces) == 1 and shape.radius_m < ROUND * inner_radius(shape.hull)


def _swept(shape: Shape, low: float, high: float) -> FloatArray:
    # Convex outline (n, 2) that contains the footprint at all yaws of a sector, rounding included.
    count = max(1, ceil((high - low) / SWEEP_RAD))
    yaws = np.linspace(low - GRAIN_RAD, high + GRAIN_RAD, count + 1)
    step = float(yaws[1] - yaws[0])
    points = np.concatenate([shape.turned(float(yaw)).hull for yaw in yaws])
    # A corner moves on an arc: outside the chord between two yaws by at most radius * (1 - cos(step / 2)).
    return hull_of(points / cos(step / 2.0))


def _region(
    member: Member, site: Site, shape: Shape, swept: FloatArray, reach: ReachRing | None, base_P_m: FloatArray
) -> BaseGeometry:
    # Region of the origin (P) that is valid for all yaws of the sector.
    low, high = site.base_P_m, site.base_P_m + shape.height_m
    layers = [area for below, _, area in site.layers if below < shape.height_m - 1e-9]
    region = shapely.intersection_all([eroded(area, [swept]) for area in layers or [site.layers[0][2]]])
    blocked = [
        no_fit
        for part, part_low, part_high in (*site.above, *site.keep_outs)
        if part_low < high - 1e-9 and part_high > low + 1e-9
        for piece in shapely.get_parts(shapely.constrained_delaunay_triangles(part))
        for no_fit in no_fit_polygons(shapely.get_coordinates(piece)[:-1], [swept])
    ]
    region = region.difference(shapely.union_all(blocked)) if blocked else region
    x0, x1, y0, y1 = np.clip(member.origin_m, -1e3, 1e3)
    # A range without width leaves no area; other families handle it.
    region = region.intersection(shapely.box(x0, y0, x1, y1))
    if reach is not None and member.name in reach.members:
        centre = shapely.Point(base_P_m)
        region = region.intersection(centre.buffer(reach.most_m, quad_segs=8 * SEGMENTS))
        if reach.least_m > 0.0:
            region = region.difference(centre.buffer(reach.least_m * ROUND_OUT, quad_segs=SEGMENTS))
    return region


def _cut(
    member: Member, stance: int, swept: FloatArray, region: BaseGeometry, low: float, high: float
) -> list[PlanCase]:
    shift = np.asarray(member.thing.place.origin_P_m[:2], dtype=np.float64)
    _, y0, _, y1 = region.bounds
    plain = shapely.get_num_geometries(region) == 1 and shapely.box(*region.bounds).area - region.area <= 1e-9
    borders = np.linspace(y0, y1, 2 if plain else STRIPS + 1).tolist()
    x_low, y_low = swept.min(axis=0) - SPARE_M
    x_high, y_high = swept.max(axis=0) + SPARE_M
    cases = []
    for below, above in pairwise(borders):
        for left, right in free_intervals(region, below, above):
            box = np.array([left, right, below, above]) - shift[[0, 0, 1, 1]]
            origins = [*np.ceil(box[[0, 2]] / GRAIN_M - 1e-3), *np.floor(box[[1, 3]] / GRAIN_M + 1e-3)]
            ox0, oy0, ox1, oy1 = (int(v) for v in origins)
            if ox0 > ox1 or oy0 > oy1:
                continue
            cell = np.array([ox0, ox1, oy0, oy1]) + np.array([x_low, x_high, y_low, y_high]) / GRAIN_M
            a, b = int(np.ceil(low / GRAIN_RAD)), int(np.floor(high / GRAIN_RAD))
            if a > b:
                a = b = round(low / GRAIN_RAD)
            cases.append(
                PlanCase(
                    family="free_rectangle" if plain else "strip",
                    weight=round(float((right - left) * (above - below) * max(high - low, 1e-3)) * 1e6, 3),
                    cells_um=(tuple(int(v) for v in np.round(cell)),),  # pyright: ignore[reportArgumentType]
                    origins_um=((ox0, ox1, oy0, oy1),),
                    yaws_urad=(((a, b),),),
                    stances=(stance,),
                    base_um=(0,),
                )
            )
    return cases
