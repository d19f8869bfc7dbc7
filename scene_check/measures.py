"""Distances between convex outlines (n, 2), polygons and height intervals (low, high), in metres."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import Polygon

from geom.polygon_measures import distances
from scene_check.model import TOLERANCE_M, PosedPlace
from schemas.arrays import FloatArray, ObjectArray


def to_place(points_W: FloatArray, place: PosedPlace) -> FloatArray:
    """Points (n, 2) of W in A."""
    return (points_W - place.origin_m[:2]) @ place.turn_WA


def outside(outline: FloatArray, polygon: Polygon) -> float:
    """Distance that a convex outline extends out of a polygon, 0 within the tolerance: of the farthest corner, or the
    radius of the largest circle over a hole."""
    shape = Polygon(outline)
    if polygon.covers(shape) or polygon.buffer(TOLERANCE_M, join_style="mitre").covers(shape):
        return 0.0
    beyond = shape.difference(polygon)
    corners = float(distances(shapely.points(outline), polygon).max())
    return max(corners, float(shapely.maximum_inscribed_circle(largest(beyond)).length), TOLERANCE_M)


def farthest_outside(outlines: list[FloatArray], polygon: Polygon) -> float:
    """Largest distance that one of several convex outlines extends out of a polygon (`outside`)."""
    if not outlines or polygon.covers(shapely.convex_hull(shapely.multipoints(np.concatenate(outlines)))):
        return 0.0
    shapely.prepare(polygon)
    left = np.flatnonzero(~shapely.covers(polygon, polygons(outlines))).tolist()
    return max((outside(outlines[k], polygon) for k in left), default=0.0)


def largest(shape: shapely.Geometry) -> Polygon:
    """The largest polygon of an intersection or a difference."""
    return max((part for part in shapely.get_parts(shape).tolist() if isinstance(part, Polygon)), key=lambda p: p.area)


def separation(outline_a: FloatArray, outline_b: FloatArray) -> float:
    """Largest gap between two convex outlines along any edge normal; negative: minus the depth (separating axes)."""
    return max(_gap_along_normals(outline_a, outline_b), _gap_along_normals(outline_b, outline_a))


def _gap_along_normals(outline_a: FloatArray, outline_b: FloatArray) -> float:
    edges = np.roll(outline_a, -1, axis=0) - outline_a
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    lengths = np.hypot(normals[:, 0], normals[:, 1])
    normals = normals[lengths > 0.0] / lengths[lengths > 0.0, None]
    return float(((outline_b @ normals.T).min(axis=0) - (outline_a @ normals.T).max(axis=0)).max())


def overlap(span_a: tuple[float, float], span_b: tuple[float, float]) -> bool:
    """Whether two spans (low, high) share more than the tolerance."""
    return min(span_a[1], span_b[1]) - max(span_a[0], span_b[0]) > TOLERANCE_M


def polygons(outlines: list[FloatArray]) -> ObjectArray:
    """Outlines (n, 2) as shapely polygons, created in one call."""
    rings = [np.vstack([outline, outline[:1]]) for outline in outlines]
    index = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    return np.asarray(shapely.polygons(shapely.linearrings(np.concatenate(rings), indices=index)))
