"""Surfaces and volumes of an asset as scenes use them: from its record, or drawn in the program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.affinity import scale as stretch
from shapely.affinity import translate

from scenec.ir import Surface, Volume
from scenec.slabs import slabs_between
from schemas.anchors import AnchorPolygon, ContainmentVolume, SupportSurface
from schemas.physics import CollisionShape
from schemas.scene_program import AuthoredPolygon

# Collision shapes differ a little from what is seen: what rises over a floor by no more than this is part of it.
STEP_M = 0.004


def recorded_surface(anchor: SupportSurface, shapes: Sequence[CollisionShape], scale: float) -> Surface:
    """A surface of a record, enlarged by `scale`; `shapes` of the owner are so already."""
    polygon, origin = _polygon(anchor.polygon, scale), np.asarray(anchor.position_m) * scale
    clearance = np.inf if anchor.clearance_m is None else anchor.clearance_m * scale
    return with_owner(Surface(anchor.anchor_id, polygon, origin, clearance), shapes)


def drawn_surface(name: str, drawn: AuthoredPolygon, shapes: Sequence[CollisionShape]) -> Surface:
    """A surface drawn in the asset frame, in metres as written."""
    polygon, origin = _centred(shapely.Polygon(drawn.outline, drawn.holes), drawn.z)
    clearance = np.inf if drawn.height is None else drawn.height
    return with_owner(Surface(name, polygon, origin, clearance), shapes)


def with_owner(surface: Surface, shapes: Sequence[CollisionShape]) -> Surface:
    """The surface with what its owner has over it. It is raised to what collision shapes really carry there."""
    over = slabs_between(shapes, float(surface.origin_P_m[2]), np.inf)
    x, y, z = surface.origin_P_m
    local = [replace(slab, outline_m=slab.outline_m - [x, y]) for slab in over]
    floor = [slab.high_m for slab in local if slab.high_m <= STEP_M and _meets(slab.outline_m, surface.polygon)]
    rise = max(floor, default=0.0)
    above = tuple(
        replace(slab, low_m=max(slab.low_m - rise, 0.0), high_m=slab.high_m - rise)
        for slab in local
        if slab.high_m > max(STEP_M, rise)
    )
    origin = np.array([x, y, z + rise])
    return replace(surface, origin_P_m=origin, clearance_m=surface.clearance_m - rise, above=above)


def recorded_volume(anchor: ContainmentVolume, scale: float) -> Volume:
    """A volume of a record: layers of equal height about its slices, of each the largest piece."""
    step = anchor.height_m * scale / max(len(anchor.slices), 1)
    layers = tuple(
        (i * step, (i + 1) * step, max((_polygon(p, scale) for p in part.polygons), key=shapely.area))
        for i, part in enumerate(anchor.slices)
        if part.polygons
    )
    return Volume(anchor.anchor_id, layers, _polygon(anchor.opening, scale), np.asarray(anchor.position_m) * scale)


def drawn_volume(name: str, drawn: AuthoredPolygon) -> Volume:
    """A volume drawn in the asset frame: one layer with upright walls."""
    polygon, origin = _centred(shapely.Polygon(drawn.outline, drawn.holes), drawn.z)
    assert drawn.height is not None, "the checks of the text ask for it"
    return Volume(name, ((0.0, drawn.height, polygon),), polygon, origin)


def _polygon(anchor: AnchorPolygon, scale: float) -> shapely.Polygon:
    return stretch(shapely.Polygon(anchor.outline_m, anchor.holes_m), scale, scale, origin=(0.0, 0.0))


def _centred(polygon: shapely.Polygon, z: float) -> tuple[shapely.Polygon, np.ndarray]:
    """The polygon in the anchor frame, and the origin of that in the asset frame."""
    x0, y0, x1, y1 = polygon.bounds
    x, y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    return translate(polygon, -x, -y), np.array([x, y, z])


def _meets(outline_m: np.ndarray, polygon: shapely.Polygon) -> bool:
    return shapely.Polygon(outline_m).intersection(polygon).area > 0.0
