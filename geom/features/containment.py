"""Containment volumes of upright receptacles (mugs, boxes, bins, drawers) as stacks of cross-sections, in metres.

The openings are those of `geom.features.cavities`. Below the rim each horizontal section of the solid leaves free
regions; those that are visible from the region above belong to the inside. Where a region is open to the outside, as at
the slots of a basket, the region above bounds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from geom.features.cavities import Cavity
from geom.mesh.cross_sections import CrossSections
from geom.mesh.rays import Rays
from geom.planar import DETAIL_SHARE
from geom.pose import DOWN
from schemas.arrays import FloatArray
from schemas.physics import Solid

# Cosine: an opening faces up within 25 degrees.
UPWARD_COSINE = 0.9
LAYERS = 12
REFINED_SHARE = 1e-3  # of the volume: what half a step between two layers may be wrong by
# The rim is known to a grid cell: the topmost closed section is searched from there down, at these shares of the depth.
RIM_STEPS = (0.005, 0.02, 0.05, 0.1, 0.2, 0.3)
# The opening is at least this share of the largest disc that fits, as the grid of `geom.features.cavities` sees it.
LEAST_OPENING = 0.5
FLOOR_GRID = 24


@dataclass(frozen=True)
class Containment:
    """One containment volume in the asset frame.

    opening        x and y of the free cross-section just below the rim.
    floor_m, rim_m heights of its lowest point and of the rim, or of the topmost closed section.
    heights_m      (k,) middles of equally high layers from the floor up; `layers` are the free regions there.
    volume_m3      of the inside: the layers, refined between two of them where the section jumps, as at a shoulder.
    """

    cavity: Cavity
    opening: shapely.Polygon
    floor_m: float
    rim_m: float
    heights_m: FloatArray
    layers: tuple[BaseGeometry, ...]
    volume_m3: float


def find_containments(solid: Solid, cavities: Sequence[Cavity]) -> tuple[Containment, ...]:
    """The containment volumes of those `cavities` that face up, the largest first."""
    upright = [c for c in cavities if not c.through and c.direction[2] >= UPWARD_COSINE]
    if not upright:
        return ()
    cuts, rays = CrossSections(solid), Rays(solid.points, solid.triangles)
    containments = [inside for c in upright if (inside := _inside(cuts, rays, c)) is not None]
    return tuple(sorted(containments, key=lambda c: (-c.volume_m3, *c.cavity.opening_m.tolist())))


def _inside(cuts: CrossSections, rays: Rays, cavity: Cavity) -> Containment | None:
    """The containment volume of one cavity; None where no section near the rim is closed."""
    solid = cuts.solid
    top, depth_m = float(cavity.opening_m[2]), cavity.depth_m * float(cavity.direction[2])
    least = LEAST_OPENING * np.pi * (0.5 * cavity.diameter_m) ** 2
    rims = ((step, _opening_at(cuts, top - step * depth_m, cavity)) for step in RIM_STEPS)
    closed = next(((step, cut) for step, cut in rims if cut is not None and cut.area >= least), None)
    if closed is None:
        return None
    step, opening = closed
    rim_m = top if step == RIM_STEPS[0] else top - step * depth_m
    floor_m = _floor(rays, opening, top - step * depth_m)
    if floor_m is None:
        return None
    floor_m += 0.5 * (solid.wall_thickness_m or 0.0)
    thickness = (rim_m - floor_m) / LAYERS
    heights = floor_m + thickness * (np.arange(LAYERS, dtype=np.float64) + 0.5)
    sections = [_Section(top - step * depth_m, opening)]
    for height_m in heights[::-1].tolist():
        sections.append(_section_below(cuts, rays, sections[-1], height_m))
    layers = tuple(_simple(section.free, cavity) for section in reversed(sections[1:]))
    least_m3 = REFINED_SHARE * thickness * sum(section.free.area for section in sections[1:])
    ends = 0.5 * thickness * (sections[1].free.area + sections[-1].free.area)
    volume = ends + sum(_volume_between(cuts, rays, *pair, least_m3) for pair in pairwise(sections[1:]))
    outline = _simple(opening, cavity)
    assert isinstance(outline, shapely.Polygon), "a simplified polygon is a polygon"
    return Containment(cavity, outline, floor_m, rim_m, heights, layers, volume)


class _Section(NamedTuple):
    """The part of a horizontal section that belongs to the inside."""

    height_m: float
    free: BaseGeometry


def _section_below(cuts: CrossSections, rays: Rays, above: _Section, height_m: float) -> _Section:
    return _Section(height_m, _free_below(cuts, rays, height_m, above.free, max(above.height_m - height_m, 0.0)))


def _volume_between(cuts: CrossSections, rays: Rays, above: _Section, below: _Section, least_m3: float) -> float:
    """The volume (m3) between two sections, halved until the area in the middle changes it by at most `least_m3`."""
    depth_m = above.height_m - below.height_m
    even = 0.5 * depth_m * (above.free.area + below.free.area)
    if 0.5 * depth_m * abs(above.free.area - below.free.area) <= least_m3:
        return even
    middle = _section_below(cuts, rays, above, 0.5 * (above.height_m + below.height_m))
    if abs(depth_m * middle.free.area - even) <= least_m3:
        return (even + 2.0 * depth_m * middle.free.area) / 3.0
    return _volume_between(cuts, rays, above, middle, least_m3) + _volume_between(cuts, rays, middle, below, least_m3)


def _opening_at(cuts: CrossSections, height_m: float, cavity: Cavity) -> shapely.Polygon | None:
    """The free region around the middle of the opening; None where it is not closed all around."""
    middle = shapely.Point(cavity.opening_m[:2])
    closed, _ = _free(cuts, height_m)
    return next((part for part in closed if part.contains(middle)), None)


def _free_below(cuts: CrossSections, rays: Rays, height_m: float, above: BaseGeometry, drop_m: float) -> BaseGeometry:
    """The free region at a height below the region `above`, which lies `drop_m` higher: closed regions whole, open
    ones as far as they lie under it; only those visible from there, not behind a wall.
    """
    closed, opened = _free(cuts, height_m)
    under = [above.intersection(part) for part in opened]
    regions = [r for r in (*closed, *(p for piece in under for p in shapely.get_parts(piece))) if r.intersects(above)]
    return shapely.union_all([r for r in regions if _in_sight(rays, above.intersection(r), height_m, drop_m)])


def _in_sight(rays: Rays, region: BaseGeometry, height_m: float, drop_m: float) -> bool:
    """Whether any point of a region at a height is visible from `drop_m` above."""
    places = _places(region)
    starts = np.column_stack([places, np.full(len(places), height_m + drop_m)])
    return bool((rays.hit_distances(starts, DOWN) >= drop_m).any())


def _free(cuts: CrossSections, height_m: float) -> tuple[list[shapely.Polygon], list[shapely.Polygon]]:
    """The free regions of a horizontal section: those enclosed by material all around, and the others."""
    points = cuts.solid.points
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    (west, south), (east, north) = low - 0.1 * (high - low), high + 0.1 * (high - low)
    sheet = shapely.box(float(west), float(south), float(east), float(north))
    free = shapely.get_parts(sheet.difference(cuts.section_at(height_m)))
    closed, opened = list[shapely.Polygon](), list[shapely.Polygon]()
    for part in free:
        (opened if part.intersects(sheet.exterior) else closed).append(part)
    return closed, opened


def _floor(rays: Rays, opening: shapely.Polygon, height_m: float) -> float | None:
    """Height of the lowest ground seen straight down through the opening; None where there is no ground."""
    places = _places(opening)
    starts = np.column_stack([places, np.full(len(places), height_m)])
    drops = rays.hit_distances(starts, DOWN)
    ground = height_m - drops[np.isfinite(drops)]
    return float(ground.min()) if len(ground) else None


def _places(region: BaseGeometry) -> FloatArray:
    """x and y (k, 2) of places spread over a region, at least one."""
    low, high = np.array(region.bounds).reshape(2, 2)
    shares = (np.arange(FLOOR_GRID) + 0.5) / FLOOR_GRID
    grid = low + np.stack(np.meshgrid(shares, shares, indexing="ij"), axis=-1).reshape(-1, 2) * (high - low)
    within = grid[shapely.contains_xy(region, grid[:, 0], grid[:, 1])]
    return np.concatenate([within, shapely.get_coordinates(region.point_on_surface())])


def _simple(region: BaseGeometry, cavity: Cavity) -> BaseGeometry:
    return region.simplify(DETAIL_SHARE * cavity.diameter_m)
