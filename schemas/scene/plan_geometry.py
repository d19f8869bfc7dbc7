"""The one conversion between plan documents and scene geometry (places, stances, domains, relations, rules).

`written_*` make the parts of a document, in whole nanometres; the others read them. Imports shapely, which the sampler
of plans does without.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite, pi

import numpy as np
import shapely
from shapely import Polygon

from schemas.arrays import FloatArray
from schemas.diagnostics import InvalidInput, finding
from schemas.scene.geometry import (
    Domain,
    FixedPose,
    KeepClear,
    KeepOutVolume,
    PlaceLayer,
    ReachRing,
    ScenePlace,
    SceneRelation,
    Stance,
    rounded_points,
)
from schemas.scene.runtime_plan import (
    PlanKeepClear,
    PlanKeepOut,
    PlanLayer,
    PlanPlace,
    PlanPolygon,
    PlanReach,
    PlanRelation,
    PlanSpot,
    PlanStance,
    PlanThing,
)

_CROSSED_SHARE = 1e-6  # of the area; outlines are rounded to 1e-9 m
_OPEN_M = 1e3  # an open end of a range, or of a height, where a document needs a number


def stance_of(document: PlanStance) -> Stance:
    """The stance of a document."""
    return Stance(document.quat_wxyz, document.prisms, document.origin_height_m, document.name)


def written_stance(stance: Stance) -> PlanStance:
    """The document of a stance."""
    return PlanStance(
        name=stance.name,
        quat_wxyz=stance.quat_wxyz,
        origin_height_m=round(stance.origin_height_m, 9),
        prisms=tuple(prism.rounded() for prism in stance.prisms),
    )


def _bounds_area(polygon: Polygon) -> bool:
    """Whether the rings bound an area that no crossing of theirs changes."""
    if polygon.is_valid:
        return polygon.area > 0.0
    clean = polygon.buffer(0)
    return clean.area > 0.0 and abs(clean.area - polygon.area) <= _CROSSED_SHARE * clean.area


def polygon_of(document: PlanPolygon) -> Polygon:
    """The polygon of a document. Raises InvalidInput (`plan/inconsistent`) for rings that bound no area.

    Rounding lets corners touch an edge; such an outline is taken as it is, since crossing changes next to no area.
    """
    try:
        polygon = Polygon(document.outline_m, document.holes_m)
    except ValueError:  # fewer than three corners
        polygon = Polygon()
    if polygon.is_empty or not _bounds_area(polygon):
        text = f"an outline of {len(document.outline_m)} corners crosses itself or bounds no area"
        raise InvalidInput(finding("plan/inconsistent", text))
    return polygon


def written_polygon(area: Polygon) -> PlanPolygon:
    """The document of a polygon: its outline counter-clockwise, its holes clockwise."""
    area = shapely.orient_polygons(area)
    rings = [_pairs(np.asarray(ring.coords)[:-1]) for ring in (area.exterior, *area.interiors)]
    return PlanPolygon(outline_m=rings[0], holes_m=tuple(rings[1:]))


def _pairs(points_m: FloatArray) -> tuple[tuple[float, float], ...]:
    return tuple((x, y) for x, y in rounded_points(points_m).tolist())


def place_of(document: PlanPlace) -> ScenePlace:
    """The place of a document. A document leaves out the opening of a volume: it is that of the highest layer."""
    layers = tuple(map(_layer_of, document.layers))
    polygon = layers[-1].polygon if layers else Polygon()
    return ScenePlace(
        name=document.name,
        polygon=polygon if document.polygon is None else polygon_of(document.polygon),
        origin_P_m=np.array(document.origin_m),
        height_m=inf if document.height_m is None else document.height_m,
        above=document.above,
        layers=layers,
        kind=document.kind,
        link=document.link,
    )


def _layer_of(document: PlanLayer) -> PlaceLayer:
    return PlaceLayer(document.low_m, document.high_m, polygon_of(document.polygon))


def _written_layer(layer: PlaceLayer) -> PlanLayer:
    return PlanLayer(low_m=layer.low_m, high_m=layer.high_m, polygon=written_polygon(layer.polygon))


def written_place(place: ScenePlace) -> PlanPlace:
    """The document of a place."""
    return PlanPlace(
        name=place.name,
        kind=place.kind,
        origin_m=_triple(place.origin_P_m),
        polygon=None if place.is_volume else written_polygon(place.polygon),
        layers=tuple(map(_written_layer, place.layers)),
        height_m=float(place.height_m) if isfinite(place.height_m) else None,
        above=tuple(prism.rounded() for prism in place.above),
        link=place.link,
    )


def domain_of(document: PlanThing) -> Domain:
    """Where a thing of a document may be."""
    return Domain(
        x_m=document.x_m or (-inf, inf),
        y_m=document.y_m or (-inf, inf),
        yaw_rad=document.yaw_rad or (-pi, pi),
        orientation_indices=document.stances,
        fixed_poses=tuple(
            FixedPose(*spot.position_m, yaw_rad=spot.yaw_rad, stance=spot.stance) for spot in document.spots
        ),
    )


def written_thing(
    name: str,
    domain: Domain,
    bodies: Sequence[int],
    parent: str,
    place: int,
    tags: Sequence[str],
    is_frame: bool = False,
) -> PlanThing:
    """The document of a thing: its domain, with the numbers of its bodies and of its place."""
    return PlanThing(
        id=name,
        bodies=tuple(bodies),
        parent=parent,
        place=place,
        x_m=_range(domain.x_m),
        y_m=_range(domain.y_m),
        yaw_rad=_range(domain.yaw_rad),
        stances=domain.orientation_indices,
        spots=tuple(
            PlanSpot(position_m=(pose.x_m, pose.y_m, pose.z_m), yaw_rad=pose.yaw_rad, stance=pose.stance)
            for pose in domain.fixed_poses
        ),
        semantic_tags=tuple(tags),
        is_frame=is_frame,
    )


def _range(span: tuple[float, float]) -> tuple[float, float] | None:
    low, high = span
    return None if low == -inf and high == inf else (max(low, -_OPEN_M), min(high, _OPEN_M))


def relation_of(document: PlanRelation) -> SceneRelation:
    """The relation of a document."""
    return SceneRelation(
        kind=document.kind,
        things=document.things,
        direction=document.direction,
        gap_m=document.gap_m,
        tolerance=document.tolerance,
        angle_rad=document.angle_rad,
        frame=document.frame,
        word=document.word,
    )


def written_relation(relation: SceneRelation) -> PlanRelation:
    """The document of a relation."""
    return PlanRelation(
        kind=relation.kind,
        things=relation.things,
        direction=relation.direction,
        gap_m=relation.gap_m,
        tolerance=relation.tolerance,
        angle_rad=relation.angle_rad,
        frame=relation.frame,
        word=relation.word,
    )


def keep_out_of(document: PlanKeepOut, parent: str, place: ScenePlace) -> KeepOutVolume:
    """The keep-out of a document on a place of `parent`."""
    return KeepOutVolume(parent, place, polygon_of(document.polygon), document.height_m)


def written_keep_out(keep_out: KeepOutVolume, place: int) -> PlanKeepOut:
    """The document of a keep-out on the place of that number."""
    height_m = float(keep_out.height_m) if isfinite(keep_out.height_m) else 0.0
    return PlanKeepOut(place=place, polygon=written_polygon(keep_out.polygon), height_m=height_m or _OPEN_M)


def keep_clear_of(document: PlanKeepClear) -> KeepClear:
    """The swept space of a document."""
    return KeepClear(document.owner, document.joint, document.links, tuple(map(_layer_of, document.layers)))


def written_keep_clear(space: KeepClear) -> PlanKeepClear:
    """The document of a swept space."""
    return PlanKeepClear(
        owner=space.owner, joint=space.joint, links=space.links, layers=tuple(map(_written_layer, space.layers))
    )


def reach_of(document: PlanReach) -> ReachRing:
    """The reach of a document."""
    return ReachRing(np.array(document.base_m), document.least_m, document.most_m, document.members)


def written_reach(reach: ReachRing) -> PlanReach:
    """The document of a reach."""
    return PlanReach(base_m=_triple(reach.base_m), least_m=reach.least_m, most_m=reach.most_m, members=reach.members)


def _triple(point_m: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in point_m)
    return x, y, z
