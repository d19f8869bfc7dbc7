"""The inside of a compartment that opens sideways: of a cabinet, a microwave or an oven behind its door. Metres, z up.

The openings are those of `geom.features.cavities` that face a level direction. Between floor and ceiling below and
above the middle of the opening, each horizontal section of the solid leaves one free region behind the plane of the
opening; it belongs to the inside where walls and that plane close it all around.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from geom.features.cavities import Cavity
from geom.features.containment import LAYERS, RIM_STEPS, Containment
from geom.mesh.cross_sections import CrossSections
from geom.mesh.rays import Rays
from geom.planar import DETAIL_SHARE
from geom.pose import DOWN, UP
from schemas.arrays import FloatArray
from schemas.physics import Solid

LEVEL_SINE = 0.26  # an opening faces sideways within 15 degrees
SEED_DEPTH = 0.5  # of the depth that the probe ball reaches: floor and ceiling are looked for there
SAME_SHARE = 0.5  # two openings lead into one compartment when it has this share in common
CLOSED_LAYERS = 0.75  # of the layers must be closed, else it is no compartment


def find_side_compartments(solid: Solid, cavities: Sequence[Cavity]) -> tuple[Containment, ...]:
    """The compartments of those `cavities` that face sideways, the largest first.

    Their `opening` is the free cross-section in the topmost layer; `floor_m` and `rim_m` are floor and ceiling.
    """
    level = [c for c in cavities if not c.through and abs(float(c.direction[2])) <= LEVEL_SINE]
    if not level:
        return ()
    cuts, rays = CrossSections(solid), Rays(solid.points, solid.triangles)
    compartments_of_openings = [inside for c in level if (inside := _inside(cuts, rays, c)) is not None]
    compartments: list[Containment] = []
    for inside in sorted(compartments_of_openings, key=lambda c: (-c.volume_m3, *c.cavity.opening_m.tolist())):
        if all(_common_share(inside, other) < SAME_SHARE for other in compartments):
            compartments.append(inside)
    return tuple(compartments)


def _common_share(inside: Containment, other: Containment) -> float:
    """About which share of the first compartment lies in the second one, by their topmost sections and heights."""
    common_m = min(inside.rim_m, other.rim_m) - max(inside.floor_m, other.floor_m)
    area = inside.opening.intersection(other.opening).area / inside.opening.area
    return area * max(common_m, 0.0) / (inside.rim_m - inside.floor_m)


def _inside(cuts: CrossSections, rays: Rays, cavity: Cavity) -> Containment | None:
    """The compartment behind one opening; None where it has no floor or ceiling, or is open elsewhere."""
    seed = cavity.opening_m - SEED_DEPTH * cavity.reach_m * cavity.direction
    below, above = (float(rays.hit_distances(seed[None], direction)[0]) for direction in (DOWN, UP))
    if not np.isfinite([below, above]).all():
        return None
    wall = 0.5 * (cuts.solid.wall_thickness_m or 0.0)
    floor_m, ceiling_m = float(seed[2]) - below + wall, float(seed[2]) + above - wall
    thickness = (ceiling_m - floor_m) / LAYERS
    if thickness <= 0.0:
        return None
    heights = floor_m + thickness * (np.arange(LAYERS, dtype=np.float64) + 0.5)
    sections = [cuts.section_at(float(h)) for h in heights]
    # The rim is known to a grid cell, and walls that end in its plane are closed only behind it.
    for step in RIM_STEPS:
        behind = _behind(cuts.solid, cavity, step * cavity.depth_m)
        layers = [_closed_region(section, behind, seed, cavity) for section in sections]
        if sum(not layer.is_empty for layer in layers) >= CLOSED_LAYERS * LAYERS:
            break
    else:
        return None
    tolerance = DETAIL_SHARE * cavity.diameter_m
    simple = [layer.simplify(tolerance) for layer in layers]
    opening = next(layer for layer in reversed(simple) if not layer.is_empty)
    volume = float(thickness * sum(layer.area for layer in simple))
    assert isinstance(opening, shapely.Polygon), "a region is one polygon"
    return Containment(cavity, opening, floor_m, ceiling_m, heights, tuple(simple), volume)


def _behind(solid: Solid, cavity: Cavity, depth_m: float) -> shapely.Polygon:
    """The half plane (x, y) that lies `depth_m` behind the opening, as far as twice the size of the solid."""
    size = 2.0 * float(np.linalg.norm(np.ptp(solid.points, axis=0)))
    out = cavity.direction[:2] / np.linalg.norm(cavity.direction[:2])
    side = np.array([-out[1], out[0]])
    middle = cavity.opening_m[:2] - depth_m * out
    return shapely.Polygon(
        [middle + size * side, middle - size * side, middle - size * (out + side), middle - size * (out - side)]
    )


def _closed_region(section: BaseGeometry, behind: shapely.Polygon, seed: FloatArray, cavity: Cavity) -> BaseGeometry:
    """The free region around the seed behind the opening in a section; empty where it is open on another side."""
    free = shapely.get_parts(behind.difference(section))
    here = shapely.Point(seed[:2])
    region = min(free, key=lambda part: part.distance(here), default=None)
    if region is None or region.distance(here) > 0.25 * cavity.diameter_m:
        return shapely.Polygon()
    corners = shapely.get_coordinates(behind.exterior)
    elsewhere = shapely.LineString(corners[1:])  # all sides but the first one, which is the opening
    return shapely.Polygon() if region.intersects(elsewhere) else region
