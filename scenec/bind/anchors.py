"""Support surfaces and containment volumes of an asset for scenes, from its record or drawn in the program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import shapely
from shapely.affinity import scale as stretch
from shapely.affinity import translate

from geom.pose import UP
from scenec.bind.prisms import prisms_between
from schemas.anchors import AnchorPolygon, ContainmentVolume, SupportSurface
from schemas.physics import CollisionShape
from schemas.scene.geometry import PlaceLayer, Prism, ScenePlace
from schemas.scene.program import AuthoredPolygon

# Collision shapes differ slightly from the visible surface: those that rise at most this far over a floor belong to it.
FLOOR_STEP_M = 0.004
DRAWN_LAYERS = 8  # of a volume drawn by hand, so that parts of its owner inside count at their heights only


def recorded_surface(anchor: SupportSurface, shapes: Sequence[CollisionShape], scale: float) -> ScenePlace:
    """A surface of a record, enlarged by `scale`; `shapes` of the owner are so already."""
    polygon, origin = _polygon(anchor.polygon, scale), np.asarray(anchor.position_m) * scale
    clearance = np.inf if anchor.clearance_m is None else anchor.clearance_m * scale
    return with_owner(ScenePlace(anchor.anchor_id, polygon, origin, clearance, link=anchor.link), shapes)


def drawn_surface(name: str, drawn: AuthoredPolygon, shapes: Sequence[CollisionShape]) -> ScenePlace:
    """A surface drawn in the asset frame, in metres as written."""
    polygon, origin = _centred(shapely.Polygon(drawn.outline, drawn.holes), drawn.z)
    clearance = np.inf if drawn.height is None else drawn.height
    return with_owner(ScenePlace(name, polygon, origin, clearance), shapes)


def with_owner(surface: ScenePlace, shapes: Sequence[CollisionShape]) -> ScenePlace:
    """The surface with the parts of its owner above it, raised to the top of the collision shapes that form its
    floor."""
    above = _over(shapes, surface.origin_P_m)
    rise = _rise(above, surface.polygon)
    above = tuple(_lowered(prism, rise) for prism in above if prism.high_m > max(FLOOR_STEP_M, rise))
    origin = surface.origin_P_m + rise * UP
    return replace(surface, origin_P_m=origin, height_m=surface.height_m - rise, above=above)


def recorded_volume(anchor: ContainmentVolume, shapes: Sequence[CollisionShape], scale: float) -> ScenePlace:
    """A volume of a record: layers of equal height about its slices, of each the largest piece."""
    step = anchor.height_m * scale / max(len(anchor.slices), 1)
    layers = tuple(
        PlaceLayer(i * step, (i + 1) * step, max((_polygon(p, scale) for p in part.polygons), key=shapely.area))
        for i, part in enumerate(anchor.slices)
        if part.polygons
    )
    origin = np.asarray(anchor.position_m) * scale
    opening = _polygon(anchor.opening, scale)
    return _carved(ScenePlace.volume(anchor.anchor_id, layers, opening, origin, anchor.link), shapes)


def drawn_volume(name: str, drawn: AuthoredPolygon, shapes: Sequence[CollisionShape]) -> ScenePlace:
    """A volume drawn in the asset frame: upright walls, less the parts of its owner inside."""
    polygon, origin = _centred(shapely.Polygon(drawn.outline, drawn.holes), drawn.z)
    assert drawn.height is not None, "the checks of the text ask for it"
    heights = np.linspace(0.0, drawn.height, DRAWN_LAYERS + 1)
    layers = tuple(PlaceLayer(float(low), float(high), polygon) for low, high in pairwise(heights))
    return _carved(ScenePlace.volume(name, layers, polygon, origin), shapes)


def _carved(inside: ScenePlace, shapes: Sequence[CollisionShape]) -> ScenePlace:
    """The volume less the collision shapes of its owner, its floor raised to their tops.

    Walls are approximated by convex pieces that extend slightly further in than the visible walls. Layers above the
    first that is completely filled cannot be reached from the floor and are left out.
    """
    if not inside.layers:
        return inside
    rise = _rise(_over(shapes, inside.origin_P_m), inside.floor)
    layers: list[PlaceLayer] = []
    for low, high, polygon in inside.layers:
        base = max(low, rise)
        if high <= base:
            continue
        filled = _over(shapes, inside.origin_P_m + base * UP, high - base)
        free = polygon.difference(shapely.union_all([shapely.Polygon(prism.outline_m) for prism in filled]))
        largest = max(shapely.get_parts(free), key=shapely.area, default=shapely.Polygon())
        if not isinstance(largest, shapely.Polygon) or largest.is_empty:
            break
        layers.append(PlaceLayer(base - rise, high - rise, largest))
    origin = inside.origin_P_m + rise * UP
    return ScenePlace.volume(inside.name, tuple(layers), inside.polygon, origin, inside.link)


def _over(shapes: Sequence[CollisionShape], origin_P_m: np.ndarray, height_m: float = np.inf) -> tuple[Prism, ...]:
    """Prisms of shapes over the origin of an anchor, up to a height: outlines and heights in the anchor frame."""
    x, y, z = (float(v) for v in origin_P_m)
    return tuple(replace(s, outline_m=s.outline_m - [x, y]) for s in prisms_between(shapes, z, z + height_m))


def _rise(over: Sequence[Prism], polygon: shapely.Polygon) -> float:
    """Height over the floor of the collision shapes that belong to it."""
    floor = [s.high_m for s in over if s.high_m <= FLOOR_STEP_M and shapely.Polygon(s.outline_m).intersects(polygon)]
    return max(floor, default=0.0)


def _lowered(prism: Prism, rise: float) -> Prism:
    return replace(prism, low_m=max(prism.low_m - rise, 0.0), high_m=prism.high_m - rise)


def _polygon(anchor: AnchorPolygon, scale: float) -> shapely.Polygon:
    return stretch(shapely.Polygon(anchor.outline_m, anchor.holes_m), scale, scale, origin=(0.0, 0.0))


def _centred(polygon: shapely.Polygon, z: float) -> tuple[shapely.Polygon, np.ndarray]:
    """The polygon in its anchor frame, and the origin of that frame in the asset frame."""
    x0, y0, x1, y1 = polygon.bounds
    x, y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    return translate(polygon, -x, -y), np.array([x, y, z])
