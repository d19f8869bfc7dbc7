"""Polygons of the plane as convex outlines (n, 2) that cover them exactly, and with fewer corners."""

from __future__ import annotations

from itertools import combinations
from typing import Any, cast

import shapely
from shapely import Polygon
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


def few_convex_outlines(area: BaseGeometry, share: float) -> list[FloatArray]:
    """Few convex outlines whose union contains `area`: its convex outlines, joined in pairs, first those whose hull
    adds least, as long as a hull adds at most `share` of the whole area to the two."""
    spare = share * area.area
    alive: dict[int, BaseGeometry] = {k: Polygon(outline) for k, outline in enumerate(convex_outlines(area))}
    added: dict[tuple[int, int], float] = {(i, j): _added(alive[i], alive[j]) for i, j in combinations(alive, 2)}
    while added:
        (i, j), least = min(added.items(), key=lambda item: item[1])
        if least > spare:
            break
        hull, name = alive[i].union(alive[j]).convex_hull, max(alive) + 1
        del alive[i], alive[j]
        added = {(m, n): value for (m, n), value in added.items() if not {i, j} & {m, n}}
        added |= {(k, name): _added(piece, hull) for k, piece in alive.items()}
        alive[name] = hull
    return [_shapely.get_coordinates(_shapely.orient_polygons(piece))[:-1] for piece in alive.values()]


def _added(one: BaseGeometry, two: BaseGeometry) -> float:
    """The area that the hull of two areas adds to them."""
    both = one.union(two)
    return float(both.convex_hull.area - both.area)


def with_fewer_corners(area: BaseGeometry, by_m: float) -> BaseGeometry:
    """An area with fewer corners that contains `area` and reaches twice `by_m` beyond its sides, farther beyond sharp
    corners; for negative `by_m` one that is contained in it, and may be empty.

    Douglas-Peucker moves no point of a border by more than its tolerance, here from a border that is as far outside.
    """
    return area.buffer(by_m, join_style="mitre").simplify(abs(by_m))
