"""Supports: level top faces of fixtures (W, m) on which objects may be placed."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import MultiPoint, Point, Polygon

from geom.convex.circumscribed_hull import CIRCLE_CORNERS, circumscribed_hull
from geom.pose import apply
from replay.recording.episode import Episode, Fixture
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

LEVEL_M = 1e-4  # corners of a top face lie this close to its highest
LEAST_SUPPORT_M2 = 1e-3
_TOUCH_M = 1e-6  # faces of one height this close are one
_REST_M = 0.01  # an object this close over a face rests on it


@dataclass(frozen=True)
class Support:
    """A level region: `area` in x and y of W (with holes), at height_m. Called by the shape that gives most of it."""

    name: str
    fixture: str
    height_m: float
    area: Polygon


def supports(episode: Episode) -> tuple[Support, ...]:
    """All level top faces of fixtures, faces of one fixture and height that touch as one; largest first."""
    all_supports = [support for fixture in episode.fixtures for support in _of_fixture(fixture)]
    return tuple(sorted(all_supports, key=lambda support: (-support.area.area, support.name)))


def used_supports(episode: Episode, known: tuple[Support, ...]) -> tuple[Support, ...]:
    """Supports on which a recorded object rested at the first or the last stamp."""
    return tuple(support for support in known if any(_rested_on(support, spot) for spot in _resting_points(episode)))


def _of_fixture(fixture: Fixture) -> list[Support]:
    by_height: defaultdict[int, list[tuple[str, float, Polygon]]] = defaultdict(list)
    for name, shape in zip(fixture.shape_names, fixture.shapes, strict=True):
        height, face = _top(shape, fixture.X_WB)
        if face.area >= LEAST_SUPPORT_M2:
            by_height[round(height / LEVEL_M)].append((name, height, face))
    supports_of_fixture = []
    for faces in by_height.values():
        whole = shapely.union_all([face.buffer(_TOUCH_M, join_style="mitre") for _, _, face in faces])
        for part in shapely.get_parts(whole.buffer(-_TOUCH_M, join_style="mitre")):
            name, _, _ = max(faces, key=lambda one: one[2].intersection(part).area)
            supports_of_fixture.append(Support(name, fixture.name, max(height for _, height, _ in faces), part))
    return supports_of_fixture


def _top(shape: CollisionShape, X_WB: FloatArray) -> tuple[float, Polygon]:
    corners = apply(X_WB, circumscribed_hull(shape))
    height = float(corners[:, 2].max())
    top = corners[corners[:, 2] > height - LEVEL_M][:, :2]
    face = MultiPoint(top).convex_hull
    if not isinstance(face, Polygon) or shape.kind in ("sphere", "capsule"):
        return height, Polygon()
    if (
        shape.kind == "cylinder" and len(top) < CIRCLE_CORNERS
    ):  # it lies: what is level is a side of the polygon around it
        return height, Polygon()
    if shape.kind == "cylinder":  # its corners lie around the circle, by at most this share of the radius
        face = face.buffer(-shape.size_m[0] * (1.0 / np.cos(np.pi / CIRCLE_CORNERS) - np.cos(np.pi / CIRCLE_CORNERS)))
    return height, face


def _resting_points(episode: Episode) -> list[FloatArray]:
    """Lowest point (3,) below the origin of each object at both ends of the recording."""
    spots = []
    for body in [body for body in episode.objects if body.shapes]:
        for X_WB in (body.X_WB[0], body.X_WB[-1]):
            lowest = min(float(apply(X_WB, circumscribed_hull(shape))[:, 2].min()) for shape in body.shapes)
            spots.append(np.array([X_WB[0, 3], X_WB[1, 3], lowest]))
    return spots


def _rested_on(support: Support, spot: FloatArray) -> bool:
    return abs(spot[2] - support.height_m) < _REST_M and bool(support.area.covers(Point(spot[:2])))
