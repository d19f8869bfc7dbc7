"""Anchors of an articulated object, link by link: insides of drawers, compartments behind doors, shelves, tops.

Proposed from the solid of each link, in the asset frame at rest (metres), as `<link>/inside`, `<link>/surface_0` and so
on. Room that other links take at rest is left out: the floor below a closed drawer carries nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from assetkit.affordances.anchors import surface_anchor, usable_supports, volume_anchor
from assetkit.articulation.joint_uses import ArticulatedObject
from assetkit.stage import LinkSurface
from geom.features.cavities import Cavity, find_cavities
from geom.features.containment import Containment, find_containments
from geom.features.side_compartments import find_side_compartments
from geom.features.support_surfaces import AREA_SHARE, DISC_SHARE, SupportFace
from geom.mechanism_pose import joint_motion
from geom.mesh.cross_sections import CrossSections
from geom.mesh.rays import Rays
from geom.pose import UP, apply
from schemas.anchors import Anchor
from schemas.arrays import FloatArray
from schemas.articulation import JointUse
from schemas.physics import Solid

MOST_BLOCKED = 0.5  # of a surface or volume: the room that other links take at rest
DOORS = ("hinged_door", "sliding_door", "hinged_lid")
BEYOND = 0.1  # of the object's diagonal: a shut door lies within it before the opening
_PLACES_EACH_WAY = 12  # positions each way by which blocked room over a surface is measured


def cavities_of_links(links: Sequence[LinkSurface]) -> dict[str, tuple[Cavity, ...]]:
    """The openings of the links, by name, whose footprint is broad enough to hold an anchor of the whole object."""
    breadth = _breadth(links)
    return {s.link: find_cavities(s.solid) for s in links if _is_broad(s.solid, breadth)}


def propose_link_anchors(
    item: ArticulatedObject, uses: Sequence[JointUse], cavities: Mapping[str, Sequence[Cavity]]
) -> tuple[Anchor, ...]:
    """Anchors of the links with known `cavities`: volumes, the largest first, then surfaces, the main one first."""
    breadth = _breadth(item.links)
    anchors: list[Anchor] = []
    for surface in item.links:
        if surface.link not in cavities:
            continue
        others = _Others([s for s in item.links if s.link != surface.link])
        anchors += _of_link(item, uses, surface, cavities[surface.link], others, breadth)
    return tuple(anchors)


def _breadth(links: Sequence[LinkSurface]) -> float:
    """Root of the area of the hull of the footprint of all links."""
    whole = np.concatenate([s.solid.points for s in links])
    return float(np.sqrt(shapely.MultiPoint(whole[:, :2]).convex_hull.area))


def _is_broad(solid: Solid, breadth: float) -> bool:
    """Whether a link can hold any anchor of an object of this breadth; of a hull the inside is unknown."""
    footprint = float(np.prod(np.ptp(solid.points[:, :2], axis=0)))
    return solid.kind != "hull" and footprint >= AREA_SHARE * breadth**2


class _Others:
    """All links but one, as obstacles."""

    def __init__(self, links: Sequence[LinkSurface]) -> None:
        self._cuts = [CrossSections(s.solid) for s in links]
        counts = np.cumsum([0, *(len(s.solid.points) for s in links)])
        points = np.concatenate([s.solid.points for s in links])
        triangles = np.concatenate([s.solid.triangles + n for s, n in zip(links, counts, strict=False)])
        self._rays = Rays(points, triangles)

    def section_at(self, height_m: float) -> BaseGeometry:
        """The area (x, y) that they take at a height."""
        return shapely.union_all([cut.section_at(height_m) for cut in self._cuts])

    def room_above(self, places: FloatArray) -> FloatArray:
        """Free heights (k,) above places (k, 3)."""
        return self._rays.hit_distances(places, UP)


def _of_link(
    item: ArticulatedObject,
    uses: Sequence[JointUse],
    surface: LinkSurface,
    cavities: Sequence[Cavity],
    others: _Others,
    breadth: float,
) -> Iterator[Anchor]:
    link, solid = surface.link, surface.solid
    upward = find_containments(solid, cavities)
    behind_doors = [c for c in find_side_compartments(solid, cavities) if _has_door(item, uses, link, c.cavity)]
    volumes = sorted((*upward, *behind_doors), key=lambda c: -c.volume_m3)
    free = [f for v in volumes if (f := _free_volume(v, others, breadth)) is not None]
    for number, volume in enumerate(free):
        yield volume_anchor(f"{link}/inside" + (f"_{number}" if number else ""), volume, link)
    supports = [f for s in usable_supports(solid, upward) if (f := _free_surface(s, others, breadth)) is not None]
    for number, support in enumerate(supports):
        yield surface_anchor(f"{link}/surface_{number}", support, link)


def _has_door(item: ArticulatedObject, uses: Sequence[JointUse], link: str, cavity: Cavity) -> bool:
    """Whether a door on the link, shut, lies before an opening."""
    doors = [u for u in uses if u.group.value in DOORS]
    by_name = {joint.name: joint for joint in item.mechanism.joints}
    size = float(np.linalg.norm(np.ptp(np.concatenate([s.solid.points for s in item.links]), axis=0)))
    seed = cavity.opening_m - 0.5 * cavity.reach_m * cavity.direction
    for use in doors:
        joint = by_name[use.joint]
        if joint.parent != link:
            continue
        solid = next(s.solid for s in item.links if s.link == joint.child)
        shut = apply(joint_motion(joint, use.closed.value - joint.rest), solid.points)
        hit = float(Rays(shut, solid.triangles).hit_distances(seed[None], cavity.direction)[0])
        if hit <= 0.5 * cavity.reach_m + BEYOND * size:
            return True
    return False


def _free_volume(volume: Containment, others: _Others, breadth: float) -> Containment | None:
    """The volume without the room that other links take at rest; None for a small one, or where little is left."""
    if volume.cavity.probe_m < 0.5 * DISC_SHARE * breadth:
        return None
    layers = [
        layer if layer.is_empty else layer.difference(others.section_at(float(height)))
        for height, layer in zip(volume.heights_m, volume.layers, strict=True)
    ]
    before, after = (sum(layer.area for layer in stack) for stack in (volume.layers, layers))
    if after < (1.0 - MOST_BLOCKED) * before:
        return None
    return replace(volume, layers=tuple(layers), volume_m3=volume.volume_m3 * after / before)


def _free_surface(support: SupportFace, others: _Others, breadth: float) -> SupportFace | None:
    """The surface where other links leave room above at rest, with its clearance; None for what is too small."""
    step = 0.1 * DISC_SHARE * breadth
    polygon = support.polygon.difference(others.section_at(support.height_m + step))
    part = max(shapely.get_parts(polygon), key=shapely.area, default=None)
    if not isinstance(part, shapely.Polygon) or part.area < AREA_SHARE * breadth**2:
        return None
    if part.buffer(-DISC_SHARE * breadth).is_empty or part.area < (1.0 - MOST_BLOCKED) * support.polygon.area:
        return None
    places = _places(part)
    above = others.room_above(np.column_stack([places, np.full(len(places), support.height_m + step)])) + step
    blocked = above < 0.5 * DISC_SHARE * breadth
    if float(blocked.mean()) > MOST_BLOCKED:
        return None
    least = min(float(above[~blocked].min()), np.inf if support.clearance_m is None else support.clearance_m)
    return replace(support, polygon=part, clearance_m=None if np.isinf(least) else least)


def _places(region: shapely.Polygon) -> FloatArray:
    """x and y (k, 2) of places spread over a region, at least one."""
    low, high = np.array(region.bounds).reshape(2, 2)
    shares = (np.arange(_PLACES_EACH_WAY) + 0.5) / _PLACES_EACH_WAY
    grid = low + np.stack(np.meshgrid(shares, shares, indexing="ij"), axis=-1).reshape(-1, 2) * (high - low)
    within = grid[shapely.contains_xy(region, grid[:, 0], grid[:, 1])]
    return np.concatenate([within, shapely.get_coordinates(region.point_on_surface())])
