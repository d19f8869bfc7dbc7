"""Polygons of the plane as convex outlines (n, 2) that cover them exactly."""

from __future__ import annotations

from typing import Any, cast

import shapely
from shapely.geometry.base import BaseGeometry

from schemas.arrays import FloatArray

_CONVEX_M2 = 1e-12  # of a hull beyond its polygon: rounding

_shapely = cast(Any, shapely)


def convex_outlines(area: BaseGeometry) -> list[FloatArray]:
    """Convex outlines, counter-clockwise, with the union `area`: itself where it is convex, else its triangles
    (constrained Delaunay)."""
    hull = area.convex_hull
    convex = hull.geom_type == "Polygon" and hull.area - area.area <= _CONVEX_M2
    parts = [hull] if convex else list(_shapely.get_parts(_shapely.constrained_delaunay_triangles(area)))
    return [_shapely.get_coordinates(_shapely.orient_polygons(part))[:-1] for part in parts if part.area > 0.0]
