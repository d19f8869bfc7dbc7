"""Solver shapes of one resting orientation of a thing: convex pieces of its footprint, and prisms with heights.

A thing that carries others includes the space above its places: hulls of these up to the highest thing that may be
there are added to its prisms. So things on different owners never have to be compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2, cos, sin
from weakref import ref

import numpy as np
import shapely
from shapely import Polygon

from scenec.ir.problem import Thing
from scenec.solve.planar import hull_of, outline_of
from schemas.arrays import FloatArray
from schemas.scene.geometry import Prism, ScenePlace, Stance

AREA_NOISE = 1e-7  # share of a hull's area by which a union may miss it and still count as convex
COARSE_SHARE = 1e-3  # share of a footprint's hull that joining two pieces of it may add


@dataclass(frozen=True)
class Shape:
    """One stance before yaw. `pieces` are convex outlines (n, 2) whose union is the whole footprint, things carried
    included; the first `own` of `prisms` belong to the body. `front_rad` is the heading of the asset's +x at yaw 0."""

    pieces: tuple[FloatArray, ...]
    prisms: tuple[Prism, ...]
    own: int
    height_m: float
    origin_height_m: float
    front_rad: float
    upright: bool

    @cached_property
    def own_low_m(self) -> float:
        """Height of the body's lowest point over its support."""
        return min(prism.low_m for prism in self.prisms[: self.own])

    @cached_property
    def own_high_m(self) -> float:
        """Height of the body's highest point over its support, without what it carries."""
        return max(prism.high_m for prism in self.prisms[: self.own])

    @cached_property
    def hull(self) -> FloatArray:
        """Convex hull of the whole footprint, (n, 2) counter-clockwise."""
        return self.pieces[0] if len(self.pieces) == 1 else hull_of(np.concatenate(self.pieces))

    @cached_property
    def coarse_pieces(self) -> tuple[FloatArray, ...]:
        """Fewer convex pieces that contain the footprint and add at most COARSE_SHARE per joined pair; for
        proposals."""
        pieces: list[Polygon] = []
        for piece in sorted((Polygon(outline) for outline in self.pieces), key=lambda p: -p.area):
            for k, other in enumerate(pieces):
                both = shapely.union(piece, other)
                hull = shapely.convex_hull(both)
                if isinstance(hull, Polygon) and hull.area - both.area <= COARSE_SHARE * self.area_m2:
                    pieces[k] = hull
                    break
            else:
                pieces.append(piece)
        return tuple(map(outline_of, pieces))

    @cached_property
    def area_m2(self) -> float:
        """Area of the hull of the whole footprint."""
        x, y = self.hull.T
        return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))

    @cached_property
    def radius_m(self) -> float:
        """Distance of the farthest footprint point from the asset origin."""
        return float(np.hypot(*self.hull.T).max())

    @cached_property
    def _turned(self) -> dict[float, ShapeAtYaw]:
        return {}

    def turned(self, yaw_rad: float) -> ShapeAtYaw:
        """The shape at a yaw; cached, since searches use few yaws repeatedly."""
        known = self._turned.get(yaw_rad)
        if known is None:
            if len(self._turned) > 64:
                self._turned.clear()
            known = self._turned[yaw_rad] = ShapeAtYaw(self, yaw_rad)
        return known


class ShapeAtYaw:
    """A shape at one yaw, origin at 0: `pieces` and prism outlines (n, 2), and `bounds` (x0, y0, x1, y1)."""

    def __init__(self, shape: Shape, yaw_rad: float):
        self.shape, self.yaw_rad = shape, yaw_rad
        self._turn_T = _turn_T(yaw_rad)
        self.pieces = tuple(piece @ self._turn_T for piece in shape.pieces)
        points = self.pieces[0] if len(self.pieces) == 1 else np.concatenate(self.pieces)
        (x0, y0), (x1, y1) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        self.bounds = (x0, y0, x1, y1)

    @cached_property
    def hull(self) -> FloatArray:
        """Convex hull of the footprint at this yaw."""
        return self.pieces[0] if len(self.pieces) == 1 else self.shape.hull @ self._turn_T

    @cached_property
    def coarse_pieces(self) -> tuple[FloatArray, ...]:
        """The shape's broad pieces at this yaw."""
        return tuple(piece @ self._turn_T for piece in self.shape.coarse_pieces)

    @cached_property
    def outlines(self) -> tuple[FloatArray, ...]:
        """Outlines of all prisms at this yaw."""
        return tuple(prism.outline_m @ self._turn_T for prism in self.shape.prisms)


def _turn_T(yaw_rad: float) -> FloatArray:
    # Quarter turns are exact, so that boxes stay boxes and contacts stay contacts.
    c, s = (float(round(v)) if abs(v - round(v)) < 1e-15 else v for v in (cos(yaw_rad), sin(yaw_rad)))
    return np.array([[c, s], [-s, c]])


_BARE: dict[int, tuple[ref[Stance], Shape]] = {}  # shapes without load of existing stances, by id


def shape_of(stance: Stance, carried: Sequence[Prism] = ()) -> Shape:
    """Solver shape of a stance with prisms for its load (see the module); without load it is made once per stance."""
    if carried:
        return _shape_of(stance, carried)
    known = _BARE.get(id(stance))
    if known is None or known[0]() is not stance:
        key = id(stance)
        known = _BARE[key] = (ref(stance, lambda _: _BARE.pop(key, None)), _shape_of(stance, ()))
    return known[1]


def _shape_of(stance: Stance, carried: Sequence[Prism]) -> Shape:
    prisms = (*stance.prisms, *carried)
    w, x, y, z = stance.quat_wxyz
    return Shape(
        pieces=_convex_pieces([prism.outline_m for prism in prisms]),
        prisms=prisms,
        own=len(stance.prisms),
        height_m=max(prism.high_m for prism in prisms),
        origin_height_m=stance.origin_height_m,
        front_rad=atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z)),
        upright=x * x + y * y + z * z < 1e-12,
    )


def carried_prisms(stance: Stance, loads: Sequence[tuple[ScenePlace, float]]) -> tuple[Prism, ...]:
    """Slabs over the places of an upright stance: (place, height of the highest thing there) for each place in use."""
    prisms = []
    for place, height_m in loads:
        area = place.layers[-1].polygon if place.is_volume else place.polygon
        low = float(place.origin_P_m[2]) + stance.origin_height_m
        outline = hull_of(shapely.get_coordinates(area)) + np.asarray(place.origin_P_m[:2])
        prisms.append(Prism(outline, low, low + height_m))
    return tuple(prisms)


def _convex_pieces(outlines: list[FloatArray]) -> tuple[FloatArray, ...]:
    # Few convex pieces with the union of the outlines: their hull where it is convex, else without covered ones.
    if len(outlines) == 1:
        return (outlines[0],)
    polygons: list[Polygon] = sorted((Polygon(o) for o in outlines), key=lambda p: -p.area)
    hull = shapely.convex_hull(shapely.union_all(polygons))
    if hull.area - shapely.union_all(polygons).area <= AREA_NOISE * hull.area:
        return (outline_of(hull),)
    uncovered: list[Polygon] = []
    for piece in polygons:
        if not any(other.covers(piece) for other in uncovered):
            uncovered.append(piece)
    return tuple(outline_of(p) for p in uncovered)


def tallest(thing: Thing, shapes: Sequence[Shape]) -> float:
    """Largest height of a thing over its place, over all its orientations and fixed poses."""
    fixed_poses = max(
        (fixed_pose.z_m - shape.origin_height_m for fixed_pose in thing.domain.fixed_poses for shape in shapes),
        default=0.0,
    )
    return max(shape.height_m for shape in shapes) + max(fixed_poses, 0.0)
