"""Poses of things in many layouts with bounds on their motion, as relations measure them. Metres, radians.

A *layout* is a seed pose of each thing; by clipping, each may move from there so far that neither its origin nor any
point of its footprint moves farther than a bound. Frame: the axes of the relation, at a base that carries all things.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from geom.planar import inner_radius
from scenec.solve.shapes import Shape
from schemas.arrays import FloatArray, IntArray

ROUND_M = 1e-3  # footprints with a boundary in a ring narrower than this may turn freely
ROUNDING = 2e-6  # of values in plans, metres and radians


@dataclass(frozen=True)
class RelativePoses:
    """Poses of a thing relative to a base: `at_m` (l, 2) and `yaw_rad` (l,) in the layouts; bounds (l,) on the motion
    of its origin, of any point of its footprint, and of its yaw. `floor_m` (l,) is the height over the base's origin of
    what it rests on, the same for all its poses in a layout."""

    at_m: FloatArray
    yaw_rad: FloatArray
    stance: IntArray
    floor_m: FloatArray
    origin_m: FloatArray
    outline_m: FloatArray
    turn_rad: FloatArray
    shapes: tuple[Shape, ...] = ()

    @property
    def radius_m(self) -> FloatArray:
        """(l,) radius of the footprint about its origin."""
        return np.array([shape.radius_m for shape in self.shapes])[self.stance]

    @property
    def front_rad(self) -> FloatArray:
        """(l,) heading of the front (+x of the asset frame)."""
        return self.yaw_rad + np.array([shape.front_rad for shape in self.shapes])[self.stance]

    @property
    def low_m(self) -> FloatArray:
        """(l,) height of its lowest point over the base's origin."""
        return self.floor_m + np.array([shape.own_low_m for shape in self.shapes])[self.stance]

    @property
    def high_m(self) -> FloatArray:
        """(l,) height of its highest point, without what it carries, over the base's origin."""
        return self.floor_m + np.array([shape.own_high_m for shape in self.shapes])[self.stance]

    def hull_along(self, direction: tuple[float, float]) -> FloatArray:
        """(l, v) corners of the footprint's hull along a direction; repeated where a stance has fewer."""
        most = max(len(shape.hull) for shape in self.shapes)
        hulls = np.stack([np.resize(shape.hull, (most, 2)) for shape in self.shapes])[self.stance]
        dx, dy = direction
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        along_x, along_y = (c * dx + s * dy)[:, None], (c * dy - s * dx)[:, None]
        return along_x * hulls[..., 0] + along_y * hulls[..., 1] + (self.at_m @ np.array(direction))[:, None]

    def pieces(self, rows: IntArray) -> Sequence[np.ndarray]:
        """Polygons in some layouts (r,), an array for each piece that any stance has; None where a stance has fewer."""
        most = max(len(shape.pieces) for shape in self.shapes)
        polygons = [np.full(len(rows), None, dtype=object) for _ in range(most)]
        for stance, shape in enumerate(self.shapes):
            mine = np.flatnonzero(self.stance[rows] == stance)
            yaw, at = self.yaw_rad[rows[mine]], self.at_m[rows[mine]]
            c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
            for polygons_of_piece, piece in zip(polygons, shape.pieces, strict=False):
                x, y = piece.T
                if len(mine):
                    polygons_of_piece[mine] = shapely.polygons(
                        np.stack([c * x - s * y, s * x + c * y], axis=-1) + at[:, None]
                    )
        return polygons


@dataclass(frozen=True)
class Motions:
    """The members of a relation in l layouts. `axes_turn_rad` (l,) bounds the turn of the relation's axes.

    `rounding_m` is that of a value between two members, `member_rounding_m` of one. `origin_box_m` (l, k, 4), boxes of
    the origins, are given where the axes are those of the boxes.
    """

    members: tuple[RelativePoses, ...]
    axes_turn_rad: FloatArray
    rounding_m: float
    member_rounding_m: float
    origin_box_m: FloatArray | None = None

    @property
    def origins_m(self) -> FloatArray:
        """(l, k, 2) origins in the layouts."""
        return np.stack([one.at_m for one in self.members], axis=1)

    @property
    def origin_shifts_m(self) -> list[FloatArray]:
        """Bounds (l,) on the motion of each origin, rounding included."""
        return [one.origin_m + self.member_rounding_m for one in self.members]


def box_intervals(boxes_m: FloatArray, dx: float, dy: float) -> tuple[FloatArray, FloatArray]:
    """Where boxes (l, k, 4) begin and end along (dx, dy), each (l, k)."""
    x, y = dx * boxes_m[..., :2], dy * boxes_m[..., 2:]
    return x.min(axis=-1) + y.min(axis=-1), x.max(axis=-1) + y.max(axis=-1)


def sway(turn_rad: FloatArray) -> FloatArray:
    """Motion of a point at 1 m from the origin of a turning owner."""
    return 2.0 * np.sin(np.minimum(turn_rad, np.pi) / 2.0)


def unevenness(shape: Shape) -> float:
    """Width of the ring about the origin that contains the boundary of a footprint: its change by any turn."""
    if len(shape.pieces) > 1:
        return np.inf
    inner = inner_radius(shape.hull)
    return shape.radius_m - inner if inner > 0.0 else np.inf


def footprint_distances(one: RelativePoses, two: RelativePoses, most_m: float = np.inf) -> FloatArray:
    """Distances (l,) of footprints; lower bounds where the circles around both are farther apart than `most_m`."""
    gap = np.hypot(*(two.at_m - one.at_m).T) - one.radius_m - two.radius_m
    rows = np.flatnonzero(gap <= most_m)
    gaps = [shapely.distance(piece, other) for piece in one.pieces(rows) for other in two.pieces(rows)]
    gap[rows] = np.nanmin(np.stack(gaps), axis=0)
    return gap


def overlap_depths(one: RelativePoses, two: RelativePoses) -> FloatArray:
    """By how much (l,) both footprints together may move and still overlap; 0 where they do not.

    Each footprint contains a disc around the centroid of the overlap of two pieces, and the discs meet as long as they
    move no farther than the sum of their radii.
    """
    rows, depth_m = np.arange(len(one.yaw_rad)), np.zeros(len(one.yaw_rad))
    for piece in one.pieces(rows):
        for other in two.pieces(rows):
            middle = shapely.centroid(shapely.intersection(piece, other))
            radii = [shapely.distance(middle, shapely.boundary(polygon)) for polygon in (piece, other)]
            depth_m = np.fmax(depth_m, radii[0] + radii[1])
    return depth_m
