"""Place objects on supports, outside the envelope and clear of all static obstacles and of one another.

For a body in a stance and at a yaw the region of allowed origins is computed whole, so that a place is found wherever
there is one, at that yaw; the point is then drawn evenly from it. Regions that a recorded camera sees come first.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import ConvexHull
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from geom.minkowski import eroded, minkowski_difference
from geom.pose import matrix_of, quat_of
from replay.insertion.candidates import InsertionCandidate, outlines
from replay.insertion.free_space import FreeSpace, buffered
from replay.recording.episode import Camera
from replay.views.visible_area import area_in_view
from schemas.arrays import FloatArray
from schemas.replay.documents import Inserted
from schemas.scene.runtime_plan import PlanBody

YAW_TRIES = 2  # of a body in a stance, at other yaws each time
YAWS = 6  # yaws tried for a candidate on a support before the next one is tried
VISIBLE_SHARE = 0.8  # of objects are put where a camera sees them, if space is free
ROUNDING_AREA_M2 = 1e-7  # regions smaller than a third of a millimetre square are rounding


@dataclass(frozen=True)
class InsertionSite:
    """A free space and the part of its support that cameras see; `places` are those of plans that map to it."""

    free_space: FreeSpace
    visible: BaseGeometry
    places: frozenset[str] = frozenset()


@dataclass(frozen=True)
class PlacedCandidate:
    """An object at its pose; `outline` is its hull from above in W, from `low_m` to `high_m`."""

    stated: Inserted
    body: PlanBody
    outline: Polygon
    low_m: float
    high_m: float


def sites(
    free_spaces: Sequence[FreeSpace], cameras: tuple[Camera, ...], support_of_place: Mapping[str, str]
) -> tuple[InsertionSite, ...]:
    """Free spaces with the parts that cameras see. `support_of_place` maps places of plans to supports."""
    insertion_sites = []
    for free_space in free_spaces:
        support = free_space.support
        named = {place for place, name in support_of_place.items() if name == support.name} | {support.name}
        insertion_sites.append(
            InsertionSite(free_space, area_in_view(cameras, support.height_m, support.area), frozenset(named))
        )
    return tuple(insertion_sites)


def insert(
    places: Sequence[InsertionSite], candidates: Sequence[InsertionCandidate], count: int, rng: np.random.Generator
) -> tuple[PlacedCandidate, ...]:
    """Up to `count` objects; fewer where no candidate finds free space at any heading tried.

    Free space only shrinks, so a body without any in a stance and a place `YAW_TRIES` times is not tried so again.
    """
    placed: list[PlacedCandidate] = []
    refused: Counter[tuple[str, float, str, str]] = Counter()
    for candidate in candidates:
        kind = (candidate.body.asset_id, candidate.body.scale, candidate.stance.name, candidate.place)
        if len(placed) == count:
            break
        if refused[kind] == YAW_TRIES:
            continue
        placement = _place(places, candidate, placed, rng)
        if placement is None:
            refused[kind] += 1
        else:
            placed.append(placement)
    return tuple(placed)


def _place(
    places: Sequence[InsertionSite],
    candidate: InsertionCandidate,
    placed: Sequence[PlacedCandidate],
    rng: np.random.Generator,
) -> PlacedCandidate | None:
    points = np.concatenate(list(outlines(candidate.stance)))
    top_m = max(prism.high_m for prism in candidate.stance.prisms)
    prefers_visible = rng.random() < VISIBLE_SHARE
    places = [site for site in places if candidate.place in site.places] or places
    areas = np.array([site.free_space.free(top_m).area for site in places])
    start = rng.uniform(-np.pi, np.pi)
    fallback: tuple[InsertionSite, BaseGeometry, float] | None = None
    for site in _shuffled(places, areas, rng):
        free = site.free_space.free(top_m)
        occupied = [
            buffered(other.outline, site.free_space.envelope.clearance_m)
            for other in placed
            if _same_heights(other, site.free_space, top_m)
        ]
        for attempt in range(YAWS):
            yaw = float(np.remainder(start + attempt * 2.0 * np.pi / YAWS + np.pi, 2.0 * np.pi) - np.pi)
            outline = _hull(points @ _yaw_rotation(yaw).T)
            region = eroded(free, outline).difference(
                shapely.union_all([minkowski_difference(other, outline) for other in occupied])
            )
            in_view = region.intersection(site.visible) if prefers_visible else region
            if in_view.area > ROUNDING_AREA_M2:
                return _placed_at(site, candidate, points, in_view, yaw, len(placed), rng)
            if region.area > ROUNDING_AREA_M2 and fallback is None:
                fallback = (site, region, yaw)
    if fallback is None:
        return None
    site, region, yaw = fallback
    return _placed_at(site, candidate, points, region, yaw, len(placed), rng)


def _shuffled(places: Sequence[InsertionSite], areas: FloatArray, rng: np.random.Generator) -> list[InsertionSite]:
    """Sites in an order drawn by their free area; those without any are left out."""
    some = np.flatnonzero(areas > 0.0)
    if not len(some):
        return []
    order = rng.choice(some, size=len(some), replace=False, p=areas[some] / areas[some].sum())
    return [places[k] for k in order]


def _placed_at(
    site: InsertionSite,
    candidate: InsertionCandidate,
    points: FloatArray,
    region: BaseGeometry,
    yaw: float,
    number: int,
    rng: np.random.Generator,
) -> PlacedCandidate:
    x, y = _uniform_point(region, rng)
    body, stance = candidate.body, candidate.stance
    R_WS = np.eye(3)
    R_WS[:2, :2] = _yaw_rotation(yaw)
    w, i, j, k = quat_of(R_WS @ matrix_of(np.array(stance.quat_wxyz))).tolist()
    stated = Inserted(
        name=f"inserted_{number:02d}_{body.asset_id}",
        asset_id=body.asset_id,
        position_m=(x, y, site.free_space.support.height_m + stance.origin_height_m),
        quat_wxyz=(w, i, j, k),
        support=site.free_space.support.name,
        stance=stance.name,
        package=body.package,
        package_hash=body.package_hash,
        scale=body.scale,
        primitive=body.primitive,
        mass_kg=body.mass_kg,
        material=candidate.material,
    )
    outline = Polygon(_hull(points @ _yaw_rotation(yaw).T) + np.array([x, y]))
    ground = site.free_space.support.height_m
    return PlacedCandidate(stated, body, outline, ground, ground + max(prism.high_m for prism in stance.prisms))


def _same_heights(other: PlacedCandidate, free_space: FreeSpace, top_m: float) -> bool:
    clearance, low = free_space.envelope.clearance_m, free_space.support.height_m
    return other.low_m < low + top_m + clearance and other.high_m > low - clearance


def _uniform_point(region: BaseGeometry, rng: np.random.Generator) -> tuple[float, float]:
    """A point drawn evenly from a region, by its triangles."""
    triangles = np.array(
        [
            part.exterior.coords[:3]
            for part in shapely.get_parts(shapely.constrained_delaunay_triangles(_polygons(region)))
        ]
    )
    sides = triangles[:, 1:] - triangles[:, :1]
    areas = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    triangle = triangles[rng.choice(len(triangles), p=areas / areas.sum())]
    u, v = rng.random(2)
    if u + v > 1.0:
        u, v = 1.0 - u, 1.0 - v
    x, y = triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0])
    return float(x), float(y)


def _polygons(region: BaseGeometry) -> BaseGeometry:
    return shapely.multipolygons([part for part in shapely.get_parts(region) if isinstance(part, Polygon)])


def _hull(points: FloatArray) -> FloatArray:
    """(n, 2) corners of the hull of points, counter-clockwise, the first not repeated."""
    return points[ConvexHull(points).vertices]


def _yaw_rotation(yaw: float) -> FloatArray:
    return np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
