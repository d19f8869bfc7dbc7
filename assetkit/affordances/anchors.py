"""Proposes anchors (support surfaces, containment volumes; metres, asset frame) from the solid of an upright object."""

from __future__ import annotations

from collections.abc import Sequence

import shapely
from shapely.affinity import translate

from geom.features.cavities import Cavity
from geom.features.containment import Containment, find_containments
from geom.features.support_surfaces import SupportFace, find_supports
from schemas.anchors import (
    Anchor,
    AnchorPolygon,
    ContainmentVolume,
    Point3,
    Ring,
    SupportSurface,
    VolumeSlice,
)
from schemas.arrays import FloatArray
from schemas.physics import Solid

ANCHOR_DIGITS = 7  # of lengths in metres: a tenth of a micrometre
# The floor of a volume deeper than this many times its width is no surface to set things on.
DEEPEST = 1.0


def propose_anchors(solid: Solid, cavities: Sequence[Cavity]) -> tuple[Anchor, ...]:
    """Surfaces, the main one first, then volumes, the largest first; `cavities` are those of the solid.

    None where a hull stands in for the solid: its inside is unknown.
    """
    if solid.kind == "hull":
        return ()
    volumes = find_containments(solid, cavities)
    surfaces = usable_supports(solid, volumes)
    return (
        *(surface_anchor(f"surface_{i}", s) for i, s in enumerate(surfaces)),
        *(volume_anchor(f"volume_{i}", v) for i, v in enumerate(volumes)),
    )


def usable_supports(solid: Solid, volumes: Sequence[Containment]) -> list[SupportFace]:
    """The support surfaces of a solid without the floors of deep `volumes`."""
    return [s for s in find_supports(solid) if not any(_is_ground(s, volume) for volume in volumes)]


def _is_ground(surface: SupportFace, volume: Containment) -> bool:
    """Whether a surface is the floor of a volume too deep to set things down in."""
    middle = surface.polygon.point_on_surface()
    within = volume.floor_m - 0.1 * (volume.rim_m - volume.floor_m) <= surface.height_m < volume.rim_m
    if not (within and volume.opening.contains(middle)):
        return False
    width_m = 2.0 * shapely.maximum_inscribed_circle(surface.polygon).length
    return volume.rim_m - surface.height_m > DEEPEST * width_m


def surface_anchor(anchor_id: str, support: SupportFace, link: str | None = None) -> SupportSurface:
    """The anchor of a support surface, on a link of an articulated object if one is given."""
    x, y = _middle(support.polygon)
    return SupportSurface(
        anchor_id=anchor_id,
        link=link,
        position_m=_point((x, y, support.height_m)),
        polygon=_polygon(support.polygon, x, y),
        normal=_point(support.normal),
        area_m2=float(support.polygon.area),
        clearance_m=None if support.clearance_m is None else round(support.clearance_m, ANCHOR_DIGITS),
        load_directions=tuple(_point(side) for side in support.load_directions),
    )


def volume_anchor(anchor_id: str, inside: Containment, link: str | None = None) -> ContainmentVolume:
    """The anchor of a containment volume, in a link of an articulated object if one is given."""
    x, y = _middle(inside.opening)
    return ContainmentVolume(
        anchor_id=anchor_id,
        link=link,
        position_m=_point((x, y, inside.floor_m)),
        opening=_polygon(inside.opening, x, y),
        direction=_point(inside.cavity.direction),
        height_m=round(inside.rim_m - inside.floor_m, ANCHOR_DIGITS),
        volume_m3=inside.volume_m3,
        passes_m=round(2.0 * inside.cavity.probe_m, ANCHOR_DIGITS),
        slices=tuple(
            VolumeSlice(
                height_m=round(float(height) - inside.floor_m, ANCHOR_DIGITS),
                polygons=tuple(_polygon(part, x, y) for part in shapely.get_parts(layer) if part.area > 0.0),
            )
            for height, layer in zip(inside.heights_m, inside.layers, strict=True)
        ),
    )


def shape_of(polygon: AnchorPolygon, x: float = 0.0, y: float = 0.0) -> shapely.Polygon:
    """The polygon as a geometry, with the anchor's origin at x, y."""
    return translate(shapely.Polygon(polygon.outline_m, polygon.holes_m), x, y)


def _middle(polygon: shapely.Polygon) -> tuple[float, float]:
    """The centre of the bounding box."""
    x0, y0, x1, y1 = polygon.bounds
    return 0.5 * (x0 + x1), 0.5 * (y0 + y1)


def anchor_polygon(polygon: shapely.Polygon) -> AnchorPolygon:
    """The polygon as a record holds it, in the axes that it is given in."""
    return _polygon(polygon, 0.0, 0.0)


def _polygon(polygon: shapely.Polygon, x: float, y: float) -> AnchorPolygon:
    """In the frame whose origin is at x, y, rounded so that it stays simple; each ring starts at its lowest corner."""
    rounded = shapely.set_precision(translate(polygon.buffer(0.0), -x, -y), 10.0**-ANCHOR_DIGITS)
    largest = max(shapely.get_parts(rounded), key=shapely.area)
    turned = shapely.orient_polygons(shapely.normalize(largest))
    return AnchorPolygon(outline_m=_ring(turned.exterior), holes_m=tuple(_ring(hole) for hole in turned.interiors))


def _ring(ring: shapely.LinearRing) -> Ring:
    return tuple((round(x, ANCHOR_DIGITS) + 0.0, round(y, ANCHOR_DIGITS) + 0.0) for x, y in ring.coords[:-1])


def _point(values: FloatArray | Sequence[float]) -> Point3:
    x, y, z = (round(float(v), ANCHOR_DIGITS) + 0.0 for v in values)
    return x, y, z
