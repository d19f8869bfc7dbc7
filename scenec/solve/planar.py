"""Shapely polygons from arrays of corners (n, 2) and back, typed where vectorised shapely calls are not."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi
from typing import cast

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from schemas.arrays import FloatArray

SLACK_M = 1e-9  # rounding allowed where geometry touches; the independent checker allows 1e-6
AXIS = 1.0 - 1e-9  # a direction closer to an axis than this is along it
SEGMENTS = 6  # sides per quarter turn of round corners
ROUND_OUT = 1.0 / cos(pi / (4 * SEGMENTS))  # a polygon of this radius contains the unit circle


def polygon(outline: FloatArray) -> Polygon:
    """The polygon of an outline (n, 2)."""
    return cast(Polygon, shapely.polygons(outline))


def outline_of(area: BaseGeometry) -> FloatArray:
    """Corners (n, 2) of a polygon without holes, counter-clockwise, the first not repeated."""
    return shapely.get_coordinates(shapely.orient_polygons(area))[:-1]


def hull_of(points: FloatArray) -> FloatArray:
    """Corners (n, 2) of the convex hull of points (m, 2), counter-clockwise."""
    return outline_of(hulls([points])[0])


def hulls(clouds: Sequence[FloatArray]) -> list[BaseGeometry]:
    """Convex hulls of several clouds of points (m, 2)."""
    if not clouds:
        return []
    index = np.repeat(np.arange(len(clouds)), [len(cloud) for cloud in clouds])
    points = cast(list[BaseGeometry], shapely.points(np.concatenate(clouds)))
    convex_hulls = shapely.convex_hull(shapely.multipoints(points, indices=index))
    return list(cast(Sequence[BaseGeometry], convex_hulls))
