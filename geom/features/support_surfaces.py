"""Support surfaces of a solid: table tops, shelf boards, seats, tray floors. z is up; lengths in metres.

All thresholds are shares of the object's own size, so that a doll's table has the anchors of a table. A support is a
connected, broad and flat part of the near-horizontal area at one level. It is cut where something rises from it or
where the clearance above it changes, and dropped where no object can be brought from above or from a side.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from shapely.geometry.base import BaseGeometry

from geom.mesh.cross_sections import CrossSections
from geom.mesh.rays import Rays
from geom.planar import DETAIL_SHARE
from geom.polygon_measures import areas
from geom.pose import UP
from schemas.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from schemas.physics import Solid

# Largest tilt of a single face, and of a whole surface.
STEEPEST_RAD, TILT_RAD = np.radians(12.0), np.radians(4.0)
LEVEL_RAD = np.radians(0.2)  # a smaller tilt is level
# Bumps, planks and seams within this share of the diagonal are one level, also gaps of twice the share of the breadth,
# the root of the area of the hull of the footprint.
STEP_SHARE, GAP_SHARE = 0.008, 0.01
# What is broad: a disc of this radius fits (share of the breadth), and the area is this share of the footprint.
DISC_SHARE, AREA_SHARE = 0.06, 0.04
# What is flat: the median distance from the plane, as a share of the radius of the largest disc that fits; lips, dents
# and the noise of scans count little. Round things have 0.026, from their top down to where they get too steep.
ROUGH_SHARE = 0.016
# Neighbouring places belong together while the clearances differ by less than this share.
SAME_CLEARANCE = 0.2
# A side is open if the rays from this share of the samples leave through it.
OPEN_SHARE = 0.6
MAIN_SHARE = 0.5


@dataclass(frozen=True)
class SupportFace:
    """One surface in the asset frame.

    polygon     x and y of its outline and holes.
    height_m    z on which an object rests: of the higher parts where the surface is uneven.
    normal      (3,) upward unit normal of the plane through it.
    clearance_m least free height over it, None where nothing is above it.
    load_directions  (k, 3) unit vectors along which an object can leave: up, or over the sides of the box around it.
    """

    polygon: shapely.Polygon
    height_m: float
    normal: FloatArray
    clearance_m: float | None
    load_directions: FloatArray


@dataclass(frozen=True)
class _Scale:
    """Absolute thresholds for one object: lengths in metres, `area` in square metres."""

    step: float
    gap: float
    disc: float
    area: float
    detail: float


def find_supports(solid: Solid) -> tuple[SupportFace, ...]:
    """Support surfaces of an upright solid, the main one first: the highest of those of at least half the largest
    area, then these from top to bottom, then the others likewise. Both sides of a sheet (kind `shell`) may carry.
    """
    points, triangles = solid.points, solid.triangles
    scale = _scale_of(points[np.unique(triangles)])
    if scale is None:
        return ()
    rays, cuts = Rays(points, triangles), CrossSections(solid)
    supports: list[SupportFace] = []
    for corners, polygon in _levels(points[triangles], scale, sheet=solid.kind != "closed"):
        plane = _plane_of(corners, polygon)
        if plane is None or plane.tilt_rad > TILT_RAD:
            continue
        if plane.rough_m > ROUGH_SHARE * shapely.maximum_inscribed_circle(polygon).length:
            continue
        standing = cuts.section_at(plane.upper_m + 1.5 * scale.step)
        for free in _parts(polygon.difference(standing), scale):
            supports += _clear_parts(free, plane, rays, scale)
    return _in_order(supports)


def _scale_of(points: FloatArray) -> _Scale | None:
    """The thresholds for an object with these points (n, 3); None without a footprint."""
    footprint = shapely.MultiPoint(points[:, :2]).convex_hull.area
    breadth, diagonal = float(np.sqrt(footprint)), float(np.linalg.norm(np.ptp(points, axis=0)))
    if breadth <= 1e-6 * diagonal:
        return None
    detail = DETAIL_SHARE * breadth
    return _Scale(STEP_SHARE * diagonal, GAP_SHARE * breadth, DISC_SHARE * breadth, AREA_SHARE * footprint, detail)


def _levels(corners: FloatArray, scale: _Scale, *, sheet: bool) -> Iterator[tuple[FloatArray, shapely.Polygon]]:
    """Corners (k, 3, 3) of the near-horizontal faces of each level, and each broad polygon of theirs.

    A level is the window of two steps of height with the most area, then all faces within a step of the plane through
    the largest polygon there: a large face may tilt by more than the window. It is removed, and so on.
    """
    left = _carrying(corners, sheet=sheet)
    while len(left):
        heights = left[:, :, 2].mean(axis=1)
        covered = np.concatenate([[0.0], np.cumsum(_plan_areas(left))])
        ends = cast(IntArray, np.searchsorted(heights, heights + 2.0 * scale.step, side="right"))
        held = covered[ends] - covered[:-1]
        start = int(held.argmax())
        if held[start] < 0.5 * scale.area:  # Gaps are closed later: half of the area may do.
            return
        taken = np.zeros(len(left), dtype=bool)
        taken[start : ends[start]] = True
        polygons = _parts(_closed_union(left[taken], scale.gap), scale, least_hole=scale.disc**2)
        plane = _plane_of(left[taken], polygons[0]) if polygons else None
        if plane is not None and LEVEL_RAD < plane.tilt_rad <= TILT_RAD:
            near = np.abs(plane.heights_over(left.mean(axis=1))) <= scale.step
            if near[taken].any():
                polygons = _parts(_closed_union(left[near], scale.gap), scale, least_hole=scale.disc**2)
                taken = near
        for polygon in polygons:
            yield left[taken], polygon
        left = left[~taken]


def _carrying(corners: FloatArray, *, sheet: bool) -> FloatArray:
    """The near-horizontal upward faces (k, 3, 3) from the bottom up, of sheets also the downward ones."""
    vectors = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.maximum(np.linalg.norm(vectors, axis=1), np.finfo(float).tiny)
    upward = (np.abs(vectors[:, 2]) if sheet else vectors[:, 2]) / length
    carrying = corners[upward >= np.cos(STEEPEST_RAD)]
    return carrying[np.argsort(carrying[:, :, 2].mean(axis=1), kind="stable")]


def _closed_union(corners: FloatArray, gap: float) -> BaseGeometry:
    """The union of faces (k, 3, 3) seen from above, gaps up to twice `gap` closed."""
    faces = np.atleast_1d(np.asarray(shapely.polygons(corners[:, :, :2]), dtype=object))
    merged = _side_by_side(faces)
    if merged is None:
        merged = shapely.union_all(faces, grid_size=1e-4 * gap)
    return merged.buffer(gap, join_style="mitre").buffer(-gap, join_style="mitre")


def _side_by_side(faces: ObjectArray) -> BaseGeometry | None:
    """The union of faces that do not overlap, by a fast method; None where some overlap.

    GEOS rejects most faces that overlap; for others its result is invalid or of another area.
    """
    try:
        merged = shapely.coverage_union_all(faces)
    except shapely.errors.GEOSException:
        return None
    sound = merged.is_valid and abs(merged.area - float(areas(faces).sum())) <= 1e-9 * merged.area
    return merged if sound else None


def _parts(geometry: BaseGeometry, scale: _Scale, *, least_hole: float = 0.0) -> list[shapely.Polygon]:
    """The broad polygons of a geometry, in a fixed order, without small detail and without holes
    smaller than `least_hole` (area).
    """
    filled = [
        shapely.Polygon(p.exterior, [ring for ring in p.interiors if shapely.Polygon(ring).area > least_hole])
        for p in shapely.get_parts(geometry)
        if isinstance(p, shapely.Polygon)
    ]
    simple = [s for p in filled if isinstance(s := p.simplify(scale.detail), shapely.Polygon)]
    broad = [p for p in simple if p.area >= scale.area and not p.buffer(-scale.disc).is_empty]
    return sorted(broad, key=lambda p: (-p.area, p.centroid.x, p.centroid.y))


@dataclass(frozen=True)
class _Plane:
    """The plane `z = middle z + slopes . (x, y)` through faces, their median distance from it, and their height."""

    middle: FloatArray
    slopes: FloatArray
    rough_m: float
    upper_m: float

    @property
    def tilt_rad(self) -> float:
        return float(np.arctan(np.linalg.norm(self.slopes)))

    @property
    def normal(self) -> FloatArray:
        up = np.array([*-self.slopes, 1.0])
        return up / np.linalg.norm(up) + 0.0

    def heights_over(self, points: FloatArray) -> FloatArray:
        """(k,) heights of points (k, 3) over the plane."""
        local = points - self.middle
        return local[:, 2] - local[:, :2] @ self.slopes


def _plane_of(corners: FloatArray, polygon: shapely.Polygon) -> _Plane | None:
    """Least-squares plane, by area, through the faces (k, 3, 3) whose middles lie in `polygon`; None where none do.

    Quadrature over a face: three quarters in its middle, the rest in its corners, exact for quadratic integrands.
    `upper_m` is the height that nine tenths of the area stay below: an object rests there where the surface is uneven.
    """
    centres = corners.mean(axis=1)
    covers_centre = cast(BoolArray, shapely.contains_xy(polygon, centres[:, 0], centres[:, 1]))
    areas_m2 = _plan_areas(corners) * covers_centre
    total = float(areas_m2.sum())
    if total <= 0.0:
        return None
    places = np.concatenate([corners.reshape(-1, 3), centres])
    weights = np.concatenate([np.repeat(areas_m2 / 12.0, 3), 0.75 * areas_m2]) / total
    middle = weights @ places
    local = places - middle
    weighted = local[:, :2] * weights[:, None]
    slopes = np.linalg.lstsq(weighted.T @ local[:, :2], weighted.T @ local[:, 2], rcond=None)[0]
    over = local[:, 2] - local[:, :2] @ slopes
    rough_m = _quantile(np.abs(over - _quantile(over, weights, 0.5)), weights, 0.5)
    return _Plane(middle, np.asarray(slopes, dtype=np.float64), rough_m, _quantile(centres[:, 2], areas_m2, 0.9))


def _quantile(values: FloatArray, weights: FloatArray, share: float) -> float:
    """Weighted quantile: the least of `values` (k,) that this share of the weight does not exceed."""
    order = np.argsort(values, kind="stable")
    held = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(held, share * held[-1] * (1.0 - 1e-9))]])


def _clear_parts(polygon: shapely.Polygon, plane: _Plane, rays: Rays, scale: _Scale) -> Iterator[SupportFace]:
    """The parts of `polygon` of even clearance; parts that are too low or that no object can reach are left out."""
    axes = _box_axes(polygon)
    cells = _cells(polygon, axes, 0.5 * scale.disc)
    inside = shapely.get_coordinates(shapely.point_on_surface(cells.geometries))
    starts = np.column_stack([inside, np.full(len(inside), plane.upper_m + scale.step)])
    clearance = rays.hit_distances(starts, UP) + scale.step
    count, label = _patches(cells.index, clearance, clearance > scale.disc)
    for k in range(count):
        in_patch = label == k
        whole = in_patch.all()
        for part in [polygon] if whole else _parts(shapely.union_all(cells.geometries[in_patch]), scale):
            here = (
                in_patch
                if whole
                else in_patch & shapely.contains_xy(part.buffer(scale.gap), inside[:, 0], inside[:, 1])
            )
            least = float(clearance[here].min()) if here.any() else 0.0
            levels = starts[here] + [0.0, 0.0, 0.5 * min(least, 2.0 * scale.disc) - scale.step]
            sides = [side for side in axes if np.isinf(rays.hit_distances(levels, side)).mean() >= OPEN_SHARE]
            loads = np.array([UP, *sides] if np.isinf(least) else sides)
            if len(loads):
                yield SupportFace(part, plane.upper_m, plane.normal, None if np.isinf(least) else least, loads)


@dataclass(frozen=True)
class _Cells:
    """Pieces of a polygon on a square grid, and the grid index (k, 2) of each."""

    geometries: ObjectArray
    index: IntArray


def _cells(polygon: shapely.Polygon, axes: FloatArray, edge: float) -> _Cells:
    """The polygon cut into squares of `edge` along its own box, so that they rotate with it."""
    R_BA = axes[:2, :2]
    low, high = (f(shapely.get_coordinates(polygon.exterior) @ R_BA.T, axis=0) for f in (np.min, np.max))
    count = np.maximum(np.ceil((high - low) / edge - 1e-9).astype(int), 1)
    index = np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), axis=-1).reshape(-1, 2)
    corners = low + (index[:, None] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])) * (high - low) / count
    squares = cast(ObjectArray, shapely.polygons(corners @ R_BA))
    pieces = shapely.intersection(squares, polygon)
    not_empty = areas(pieces) > 1e-6 * edge**2
    return _Cells(pieces[not_empty], index[not_empty])


def _box_axes(polygon: shapely.Polygon) -> FloatArray:
    """(4, 3) horizontal unit vectors along the narrowest box around a polygon: two right-handed axes, their opposites.

    The first lies within 45 degrees of +x.
    """
    corners = shapely.get_coordinates(polygon.minimum_rotated_rectangle)
    along = max((corners[1] - corners[0], corners[2] - corners[1]), key=lambda v: (abs(v[0]) - abs(v[1]), v[0]))
    x = along / np.linalg.norm(along) * (1.0 if along[0] > 0.0 else -1.0)
    x = np.array([*np.where(np.abs(x) < 1e-9, 0.0, x), 0.0])
    y = np.array([-x[1], x[0], 0.0])
    return np.array([x, y, -x, -y])


def _patches(index: IntArray, clearance: FloatArray, is_clear: BoolArray) -> tuple[int, IntArray]:
    """Number of patches of similar clearance, and the patch (k,) of each cell, -1 where it is not clear."""
    number = {(i, j): k for k, (i, j) in enumerate(index.tolist()) if is_clear[k]}
    pairs = [
        (k, other)
        for (i, j), k in number.items()
        for other in (number.get((i + 1, j)), number.get((i, j + 1)))
        if other is not None and _similar(clearance[k], clearance[other])
    ]
    a, b = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(index), len(index)))
    label = connected_components(graph, directed=False)[1]
    patch_labels, renumbered = np.unique(label[is_clear], return_inverse=True)
    result = np.full(len(index), -1)
    result[is_clear] = renumbered
    return len(patch_labels), result


def _similar(a: float, b: float) -> bool:
    return a == b or abs(a - b) <= SAME_CLEARANCE * min(a, b)


def _plan_areas(corners: FloatArray) -> FloatArray:
    """Areas (k,) of triangles (k, 3, 3) projected on z = 0."""
    u, v = corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]
    return 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def _in_order(supports: Sequence[SupportFace]) -> tuple[SupportFace, ...]:
    largest = max((s.polygon.area for s in supports), default=0.0)

    def place(s: SupportFace) -> tuple[float | bool, ...]:
        centre = s.polygon.centroid
        is_small = s.polygon.area < MAIN_SHARE * largest
        return is_small, -s.height_m, -s.polygon.area, centre.x, centre.y

    return tuple(sorted(supports, key=place))
