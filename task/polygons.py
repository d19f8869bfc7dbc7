"""Points in polygons of anchors, elementwise over frames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.anchors import AnchorPolygon, ContainmentVolume, Ring
from schemas.arrays import BoolArray, FloatArray


def in_polygon(x: FloatArray, y: FloatArray, polygon: AnchorPolygon) -> BoolArray:
    """Whether points of any shape lie inside the outline and outside the holes, by the number of edges to the right."""
    inside = _in_ring(x, y, polygon.outline_m)
    for hole in polygon.holes_m:
        inside = inside & ~_in_ring(x, y, hole)
    return inside


def in_any(x: FloatArray, y: FloatArray, polygons: Sequence[AnchorPolygon]) -> BoolArray:
    """Whether points lie in one of the polygons."""
    inside = np.zeros(np.shape(x), dtype=bool)
    for polygon in polygons:
        inside |= in_polygon(x, y, polygon)
    return inside


def in_volume(points: FloatArray, volume: ContainmentVolume) -> BoolArray:
    """Whether points (..., 3) in the frame of a volume lie between its floor and its rim, within its section there."""
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    within = (z >= 0.0) & (z <= volume.height_m)
    if not volume.slices:
        return within & in_polygon(x, y, volume.opening)
    layer = volume.height_m / len(volume.slices)
    result = np.zeros(np.shape(x), dtype=bool)
    for number, cut in enumerate(volume.slices):
        last = number == len(volume.slices) - 1
        there = within & (z >= number * layer) & ((z < (number + 1) * layer) | last)
        if there.any():
            result |= there & in_any(x, y, cut.polygons)
    return result


def _in_ring(x: FloatArray, y: FloatArray, ring: Ring) -> BoolArray:
    inside = np.zeros(np.shape(x), dtype=bool)
    for (x0, y0), (x1, y1) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if y0 == y1:
            continue
        crosses = (y0 > y) != (y1 > y)
        inside ^= crosses & (x < x0 + (y - y0) * ((x1 - x0) / (y1 - y0)))
    return inside
