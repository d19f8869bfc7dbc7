"""Regions of a surface by shape: protrusions of a round body, level plates and their posts, bosses on a level face.

All thresholds are relative to the size of the object, which rests on its lowest point with z up. A shape that is not
clearly of a kind has no region of that kind.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely
from scipy.ndimage import maximum_filter1d

from geom.mesh.decimate import decimate
from geom.mesh.edges import edges_of, face_components
from geom.mesh.surface_distance import sample_surface, triangle_areas
from geom.mesh.topology import repeats_point
from geom.mesh.weld import weld_points
from schemas.arrays import BoolArray, FloatArray, IntArray

# loop, arm: protrusions of a round upright body that return to it, or do not. slab: a level plate, post: a support
# under it, upright: a part above it. boss: a small body on top of a level face. `geom.features.axial_regions` has the
# others: wider and narrower, thicker and thinner end of a tool; narrow end of a bottle; stem of a glass, with its two
# ends.
Role = Literal[
    "loop",
    "arm",
    "slab",
    "post",
    "upright",
    "boss",
    "broad",
    "slim",
    "stout",
    "thin",
    "neck",
    "stopper",
    "stem",
    "over",
    "foot",
]
_OUTLINE_FACES, _WIDTH_SAMPLES = 1000, 4000
_ROUND = 0.6  # of all directions, in which the outline of a round body is a circle
_PROTRUDING = 1.06  # times the radius of the body: points further out belong to protrusions
_WIDTH_LAYERS = 24
_LEVEL = 0.9  # vertical component of the normal of a level face
_PLATE_SHARE = 0.35  # of the footprint's box that the face of a plate covers


@dataclass(frozen=True)
class SurfaceRegion:
    """`faces` (m,) True at the triangles of the region, and its role by shape."""

    role: Role
    faces: BoolArray


@dataclass(frozen=True)
class FaceGeometry:
    """A welded surface with the middles (m, 3), areas (m,) and unit normals (m, 3) of its triangles."""

    points: FloatArray
    triangles: IntArray
    middle: FloatArray
    area: FloatArray
    normal: FloatArray

    @property
    def low(self) -> FloatArray:
        """(3,) lowest corner of the bounding box."""
        return self.points.min(axis=0)

    @property
    def extent(self) -> FloatArray:
        """(3,) edge lengths of the bounding box."""
        return np.ptp(self.points, axis=0)

    def pieces(self, chosen: BoolArray) -> Iterator[BoolArray]:
        """Masks (m,) of the edge-connected pieces of the triangles `chosen` (m,), the largest first."""
        indices = np.flatnonzero(chosen & ~repeats_point(self.triangles))
        if len(indices) == 0:
            return
        count, label = face_components(edges_of(self.triangles[indices]))
        size = np.bincount(label, self.area[indices], count)
        for piece in np.argsort(-size, kind="stable"):
            mask = np.zeros(len(self.triangles), dtype=bool)
            mask[indices[label == piece]] = True
            yield mask

    def box(self, chosen: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner (3,) of the triangles `chosen` (m,), at least one."""
        points = self.points[np.unique(self.triangles[chosen])]
        return points.min(axis=0), points.max(axis=0)


def face_geometry(points: FloatArray, triangles: IntArray) -> FaceGeometry:
    """The geometry of triangles (m, 3), in order; equal points are welded."""
    welded, faces = weld_points(points, triangles)
    corners = welded[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    return FaceGeometry(
        welded, faces, corners.mean(axis=1), triangle_areas(corners), cross / np.where(length > 0, length, 1.0)
    )


def side_regions(surface: FaceGeometry) -> tuple[SurfaceRegion, ...]:
    """Loops and arms that protrude sideways from a round upright body (mug, teapot, pan), the larger first.

    The body is the largest circle in the outline seen from above; at each height it is as wide as its surface is in the
    other directions. At most three, and none when the outline is not round otherwise.
    """
    light, triangles = decimate(surface.points, surface.triangles, _OUTLINE_FACES)
    gap = 0.004 * float(surface.extent[:2].max())  # Slivers between triangles are no notches.
    shadow = shapely.union_all([shapely.Polygon(t).buffer(gap, 2) for t in light[triangles][:, :, :2]])
    outline = shapely.Polygon(max(shapely.get_parts(shadow), key=lambda p: p.area).exterior).buffer(-gap)
    if outline.area <= 0.0:
        return ()
    circle = shapely.maximum_inscribed_circle(outline, tolerance=0.002 * float(surface.extent[:2].max()))
    centre, radius = np.asarray(circle.coords)[0], circle.length
    beyond = outline.difference(shapely.Point(*centre).buffer(_PROTRUDING * radius, 64))
    blobs = [b for b in shapely.get_parts(beyond) if b.area > 0.01 * np.pi * radius**2]
    sectors = [_sector(np.asarray(b.exterior.coords) - centre) for b in blobs]
    if not 1 <= len(sectors) <= 3 or sum(2.0 * half for _, half in sectors) > (1.0 - _ROUND) * 2.0 * np.pi:
        return ()
    widths = _widths(surface, centre, radius, sectors)
    away = surface.middle[:, :2] - centre
    radial_distance = np.linalg.norm(away, axis=1)
    proud = radial_distance > widths[_layer(surface, surface.middle)] + 0.04 * radius
    protrusions: list[SurfaceRegion] = []
    for sector in sectors:
        chosen = proud & _within(away, sector)
        if surface.area[chosen].sum() < 0.005 * surface.area.sum():
            continue
        role: Role = "loop" if _comes_back(surface, chosen, widths, centre, radius) else "arm"
        protrusions.append(SurfaceRegion(role, chosen))
    return tuple(sorted(protrusions, key=lambda r: -surface.area[r.faces].sum()))


def plate_regions(surface: FaceGeometry) -> tuple[SurfaceRegion, ...]:
    """A level plate, its posts, and the part above it: table, stool, chair. () without a plate and a post."""
    height, low = surface.extent[2], surface.low[2]
    slack = 0.012 * height
    corners = surface.points[surface.triangles][:, :, 2]
    for top in _levels(surface, up=True):
        under = next((z for z in _levels(surface, up=False) if top - 0.3 * height < z < top - slack / 4), None)
        if under is None or under < low + 0.15 * height:
            continue
        slab = (corners.min(axis=1) >= under - slack) & (corners.max(axis=1) <= top + slack)
        below = ~slab & (surface.middle[:, 2] < under)
        above = ~slab & (corners.max(axis=1) > top + slack) & ~below
        posts = [p for p in surface.pieces(below) if _carries(surface, p, under)]
        if not posts:
            return ()
        parts = [SurfaceRegion("slab", slab), *(SurfaceRegion("post", p) for p in posts)]
        if surface.area[above].sum() > 0.02 * surface.area.sum():
            parts.append(SurfaceRegion("upright", above))
        return tuple(parts)
    return ()


def boss_regions(surface: FaceGeometry) -> tuple[SurfaceRegion, ...]:
    """Small bodies on the highest level face of an object that is solid below it: the studs of a brick."""
    height, low = surface.extent[2], surface.low[2]
    slack = 0.012 * height
    top = next(iter(_levels(surface, up=True)), low)
    if not low + 0.5 * height < top < low + 0.97 * height:
        return ()
    raised = surface.points[surface.triangles][:, :, 2].min(axis=1) >= top - slack
    raised &= ~((surface.normal[:, 2] > _LEVEL) & (surface.middle[:, 2] <= top + slack))
    least = 0.002 * surface.area.sum()
    pieces = [p for p in surface.pieces(raised) if surface.area[p].sum() > least]
    small = all((np.subtract(*surface.box(p)[::-1])[:2] < 0.6 * surface.extent[:2]).all() for p in pieces)
    return tuple(SurfaceRegion("boss", p) for p in pieces) if small else ()


def _levels(surface: FaceGeometry, *, up: bool) -> Iterator[float]:
    """Heights of level faces that cover enough of the footprint's box, from the top down."""
    sign = 1.0 if up else -1.0
    level = sign * surface.normal[:, 2] > _LEVEL
    height = surface.extent[2]
    if height <= 0.0:
        return
    bins = np.minimum(((surface.middle[:, 2] - surface.low[2]) / height * 100).astype(np.int64), 99)
    cover = np.bincount(bins[level], surface.area[level], 100)
    summed = cover + np.append(cover[1:], 0.0) + np.insert(cover[:-1], 0, 0.0)
    least = (_PLATE_SHARE if up else 0.5 * _PLATE_SHARE) * float(surface.extent[:2].prod())
    enough = np.flatnonzero(summed >= least)
    for run in np.split(enough, np.flatnonzero(np.diff(enough) > 1) + 1)[::-1]:
        in_level = level & np.isin(bins, run)
        if in_level.any():
            yield float(np.average(surface.middle[in_level, 2], weights=surface.area[in_level]))


def _carries(surface: FaceGeometry, piece: BoolArray, under: float) -> bool:
    """Whether a piece is slender and extends from the ground up to the plate."""
    low, high = surface.box(piece)
    height = under - surface.low[2]
    slender = (high - low)[:2] < 0.35 * surface.extent[:2]
    reaches = low[2] < surface.low[2] + 0.1 * height and high[2] > surface.low[2] + 0.8 * height
    return bool(reaches and slender.any())


def _sector(ring: FloatArray) -> tuple[float, float]:
    """Middle direction and half the opening angle (rad) of a ring (k, 2) seen from the origin, a little widened."""
    middle = float(np.arctan2(*ring.mean(axis=0)[::-1]))
    angles = (np.arctan2(ring[:, 1], ring[:, 0]) - middle + np.pi) % (2.0 * np.pi) - np.pi
    return middle, float(np.abs(angles).max()) + 0.05


def _within(away: FloatArray, sector: tuple[float, float]) -> BoolArray:
    angles = (np.arctan2(away[:, 1], away[:, 0]) - sector[0] + np.pi) % (2.0 * np.pi) - np.pi
    return np.abs(angles) <= sector[1]


def _layer(surface: FaceGeometry, points: FloatArray) -> IntArray:
    share = (points[:, 2] - surface.low[2]) / max(float(surface.extent[2]), np.finfo(float).tiny)
    return np.clip((share * _WIDTH_LAYERS).astype(np.int64), 0, _WIDTH_LAYERS - 1)


def _widths(surface: FaceGeometry, centre: FloatArray, radius: float, sectors: list[tuple[float, float]]) -> FloatArray:
    """(_WIDTH_LAYERS,) radius of the body by height, from its surface in the directions without protrusions."""
    points = sample_surface(surface.points, surface.triangles, _WIDTH_SAMPLES, 0)[0]
    away = points[:, :2] - centre
    free = ~np.any([_within(away, s) for s in sectors], axis=0)
    widths = np.zeros(_WIDTH_LAYERS)
    np.maximum.at(widths, _layer(surface, points[free]), np.linalg.norm(away[free], axis=1))
    return np.minimum(maximum_filter1d(widths, 3, mode="nearest"), _PROTRUDING * radius)


def _comes_back(
    surface: FaceGeometry, chosen: BoolArray, widths: FloatArray, centre: FloatArray, radius: float
) -> bool:
    """Whether a region and the body together enclose a hole, seen from the side."""
    out = surface.middle[chosen][:, :2].mean(axis=0) - centre
    out /= np.linalg.norm(out) or 1.0
    light, triangles = decimate(surface.points, surface.triangles[chosen], _OUTLINE_FACES)
    flat = np.stack([(light[:, :2] - centre) @ out, light[:, 2]], axis=1)
    heights = surface.low[2] + surface.extent[2] * np.arange(_WIDTH_LAYERS + 1) / _WIDTH_LAYERS
    layers = zip(widths + 0.12 * radius, heights[:-1], heights[1:], strict=True)
    body = shapely.union_all([shapely.box(-radius, low, width, high) for width, low, high in layers])
    shape = shapely.union_all([shapely.Polygon(t).buffer(0.005 * radius, 2) for t in flat[triangles]])
    holes = sum(shapely.Polygon(r).area for p in shapely.get_parts(shape.union(body)) for r in p.interiors)
    return holes > 0.15 * max(shape.area, np.finfo(float).tiny)
