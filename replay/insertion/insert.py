"""Put objects where nothing ever comes: on a support, outside the envelope, clear of all that stands there.

For a body in a stance and at a yaw the region of allowed origins is computed whole, so that a place is found wherever
there is one, at that yaw; the spot is then drawn evenly from it. Regions that a recorded camera sees come first.
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
from replay.insertion.candidates import Candidate, outlines
from replay.insertion.free_space import Room, grown
from replay.recording.episode import Camera
from replay.views.visible_area import seen_area
from schemas.model import FloatArray
from schemas.replay import Inserted
from schemas.scene.runtime_plan import PlanBody

TRIES = 2  # of a body in a stance, at other headings each time
YAWS = 6  # headings tried for a candidate on a support before the next one is tried
SEEN_SHARE = 0.8  # of objects are put where a camera sees them, if there is room
LEAST_AREA_M2 = 1e-7  # regions smaller than a third of a millimetre square are rounding


@dataclass(frozen=True)
class Site:
    """A room and the part of its support that cameras see; `places` of plans that this support stands for."""

    room: Room
    seen: BaseGeometry
    places: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Put:
    """An object at its place; `outline` is its hull from above in W, from `low_m` to `high_m`."""

    stated: Inserted
    body: PlanBody
    outline: Polygon
    low_m: float
    high_m: float


def sites(rooms: Sequence[Room], cameras: tuple[Camera, ...], stands_for: Mapping[str, str]) -> tuple[Site, ...]:
    """Rooms with what cameras see of them. `stands_for` maps places of plans to supports, besides equal names."""
    sites_seen = []
    for room in rooms:
        support = room.support
        named = {place for place, name in stands_for.items() if name == support.name} | {support.name}
        sites_seen.append(Site(room, seen_area(cameras, support.height_m, support.area), frozenset(named)))
    return tuple(sites_seen)


def insert(
    places: Sequence[Site], candidates: Sequence[Candidate], count: int, rng: np.random.Generator
) -> tuple[Put, ...]:
    """Up to `count` objects; fewer where no candidate finds room at any heading tried.

    Room only shrinks, so that a body found without room in a stance and a place `TRIES` times is not tried so again.
    """
    put: list[Put] = []
    refused: Counter[tuple[str, float, str, str]] = Counter()
    for candidate in candidates:
        kind = (candidate.body.asset_id, candidate.body.scale, candidate.stance.name, candidate.place)
        if len(put) == count:
            break
        if refused[kind] == TRIES:
            continue
        made = _placed(places, candidate, put, rng)
        if made is None:
            refused[kind] += 1
        else:
            put.append(made)
    return tuple(put)


def _placed(places: Sequence[Site], candidate: Candidate, put: Sequence[Put], rng: np.random.Generator) -> Put | None:
    points = np.concatenate(list(outlines(candidate.stance)))
    top_m = max(prism.high_m for prism in candidate.stance.prisms)
    wants_seen = rng.random() < SEEN_SHARE
    places = [site for site in places if candidate.place in site.places] or places
    areas = np.array([site.room.free(top_m).area for site in places])
    start = rng.uniform(-np.pi, np.pi)
    fallback: tuple[Site, BaseGeometry, float] | None = None
    for site in _shuffled(places, areas, rng):
        free = site.room.free(top_m)
        taken = [
            grown(other.outline, site.room.envelope.clearance_m)
            for other in put
            if _same_heights(other, site.room, top_m)
        ]
        for turn in range(YAWS):
            yaw = float(np.remainder(start + turn * 2.0 * np.pi / YAWS + np.pi, 2.0 * np.pi) - np.pi)
            outline = _hull(points @ _turned(yaw).T)
            region = eroded(free, outline).difference(
                shapely.union_all([minkowski_difference(one, outline) for one in taken])
            )
            seen = region.intersection(site.seen) if wants_seen else region
            if seen.area > LEAST_AREA_M2:
                return _at(site, candidate, points, seen, yaw, len(put), rng)
            if region.area > LEAST_AREA_M2 and fallback is None:
                fallback = (site, region, yaw)
    if fallback is None:
        return None
    site, region, yaw = fallback
    return _at(site, candidate, points, region, yaw, len(put), rng)


def _shuffled(places: Sequence[Site], areas: FloatArray, rng: np.random.Generator) -> list[Site]:
    """Sites in an order drawn by their free area; those without any are left out."""
    some = np.flatnonzero(areas > 0.0)
    if not len(some):
        return []
    order = rng.choice(some, size=len(some), replace=False, p=areas[some] / areas[some].sum())
    return [places[k] for k in order]


def _at(
    site: Site,
    candidate: Candidate,
    points: FloatArray,
    region: BaseGeometry,
    yaw: float,
    number: int,
    rng: np.random.Generator,
) -> Put:
    x, y = _spot(region, rng)
    body, stance = candidate.body, candidate.stance
    R_WS = np.eye(3)
    R_WS[:2, :2] = _turned(yaw)
    w, i, j, k = quat_of(R_WS @ matrix_of(np.array(stance.quat_wxyz))).tolist()
    stated = Inserted(
        name=f"inserted_{number:02d}_{body.asset_id}",
        asset_id=body.asset_id,
        position_m=(x, y, site.room.support.height_m + stance.origin_height_m),
        quat_wxyz=(w, i, j, k),
        support=site.room.support.name,
        stance=stance.name,
        package=body.package,
        package_hash=body.package_hash,
        scale=body.scale,
        primitive=body.primitive,
        mass_kg=body.mass_kg,
        material=candidate.material,
    )
    outline = Polygon(_hull(points @ _turned(yaw).T) + np.array([x, y]))
    ground = site.room.support.height_m
    return Put(stated, body, outline, ground, ground + max(prism.high_m for prism in stance.prisms))


def _same_heights(other: Put, room: Room, top_m: float) -> bool:
    clearance, low = room.envelope.clearance_m, room.support.height_m
    return other.low_m < low + top_m + clearance and other.high_m > low - clearance


def _spot(region: BaseGeometry, rng: np.random.Generator) -> tuple[float, float]:
    """A point drawn evenly from a region, by its triangles."""
    triangles = np.array(
        [
            part.exterior.coords[:3]
            for part in shapely.get_parts(shapely.constrained_delaunay_triangles(_polygons(region)))
        ]
    )
    sides = triangles[:, 1:] - triangles[:, :1]
    areas = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    one = triangles[rng.choice(len(triangles), p=areas / areas.sum())]
    u, v = rng.random(2)
    if u + v > 1.0:
        u, v = 1.0 - u, 1.0 - v
    x, y = one[0] + u * (one[1] - one[0]) + v * (one[2] - one[0])
    return float(x), float(y)


def _polygons(region: BaseGeometry) -> BaseGeometry:
    return shapely.multipolygons([part for part in shapely.get_parts(region) if isinstance(part, Polygon)])


def _hull(points: FloatArray) -> FloatArray:
    """(n, 2) corners of the hull of points, counter-clockwise, the first not repeated."""
    return points[ConvexHull(points).vertices]


def _turned(yaw: float) -> FloatArray:
    return np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
