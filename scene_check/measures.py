"""Measures of outlines, polygons and spans of height."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scene_check.model import TOLERANCE_M, CheckPlace, FloatArray


def to_place(points_W: FloatArray, place: CheckPlace) -> FloatArray:
    """Points (n, 2) of W in A."""
    return (points_W - place.origin_m[:2]) @ place.turn_WA


def outside(outline: FloatArray, polygon: Polygon) -> float:
    """How far a convex outline sticks out of a polygon, 0 within the tolerance: the farthest corner, or the radius of
    the largest circle over a hole."""
    shape = Polygon(outline)
    if polygon.covers(shape) or polygon.buffer(TOLERANCE_M, join_style="mitre").covers(shape):
        return 0.0
    beyond = shape.difference(polygon)
    corners = float(shapely.distance(shapely.points(outline), polygon).max())
    return max(corners, float(shapely.maximum_inscribed_circle(largest(beyond)).length), TOLERANCE_M)


def farthest_outside(outlines: list[FloatArray], polygon: Polygon) -> float:
    """How far any of some convex outlines sticks out of a polygon; as `outside` for each."""
    if not outlines or polygon.covers(shapely.convex_hull(shapely.multipoints(np.concatenate(outlines)))):
        return 0.0
    shapely.prepare(polygon)
    left = np.flatnonzero(~shapely.covers(polygon, polygons(outlines))).tolist()
    return max((outside(outlines[k], polygon) for k in left), default=0.0)


def largest(shape: shapely.Geometry) -> Polygon:
    """The largest polygon of what an intersection or a difference left."""
    return max((part for part in shapely.get_parts(shape).tolist() if isinstance(part, Polygon)), key=lambda p: p.area)


def separation(one: FloatArray, two: FloatArray) -> float:
    """Largest gap between two convex outlines along any edge normal; negative: minus the depth (separating axes)."""
    return max(_gap_along_normals(one, two), _gap_along_normals(two, one))


def _gap_along_normals(one: FloatArray, two: FloatArray) -> float:
    edges = np.roll(one, -1, axis=0) - one
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    lengths = np.hypot(normals[:, 0], normals[:, 1])
    normals = normals[lengths > 0.0] / lengths[lengths > 0.0, None]
    return float(((two @ normals.T).min(axis=0) - (one @ normals.T).max(axis=0)).max())


def overlap(one: tuple[float, float], two: tuple[float, float]) -> bool:
    """Whether two spans (low, high) share more than the tolerance."""
    return min(one[1], two[1]) - max(one[0], two[0]) > TOLERANCE_M


def polygons(outlines: list[FloatArray]) -> NDArray[np.object_]:
    """Outlines (n, 2) as polygons, made in one call."""
    rings = [np.vstack([outline, outline[:1]]) for outline in outlines]
    index = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    return np.asarray(shapely.polygons(shapely.linearrings(np.concatenate(rings), indices=index)))
