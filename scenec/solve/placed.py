"""A thing at a provisional pose, with its geometry in the frame P of its owner. An assignment maps names to these."""

from __future__ import annotations

from functools import cached_property

import shapely
from shapely import Polygon

from scenec.ir.problem import Placement
from scenec.solve.planar import ROUND_OUT, SEGMENTS, outline_of, polygon
from scenec.solve.resting import ContactGeometry
from scenec.solve.shapes import ShapeAtYaw
from schemas.arrays import FloatArray


class Placed:
    """`placement` is in the frame A of its place; `x_P_m, y_P_m` (origin) and `base_P_m` (support height) in P."""

    def __init__(
        self, name: str, parent: str, place: str, placement: Placement, turned: ShapeAtYaw, origin_P_m: FloatArray
    ):
        self.name, self.parent, self.place, self.placement, self.turned = name, parent, place, placement, turned
        self.x_P_m = placement.x_m + float(origin_P_m[0])
        self.y_P_m = placement.y_m + float(origin_P_m[1])
        self.base_P_m = placement.base_m + float(origin_P_m[2])
        x0, y0, x1, y1 = turned.bounds
        self.bounds = (x0 + self.x_P_m, y0 + self.y_P_m, x1 + self.x_P_m, y1 + self.y_P_m)
        self._grown: tuple[float, tuple[FloatArray, ...]] | None = None
        self.top_P_m = self.base_P_m + turned.shape.height_m

    @cached_property
    def footprint(self) -> tuple[Polygon, ...]:
        """Convex pieces of the whole footprint in P."""
        shift = (self.x_P_m, self.y_P_m)
        return tuple(polygon(piece + shift) for piece in self.turned.pieces)

    def grown(self, by_m: float) -> tuple[FloatArray, ...]:
        """The pieces of the footprint in P grown by a distance (m), with circumscribed round corners; cached."""
        if self._grown is None or self._grown[0] != by_m:
            wide = by_m * ROUND_OUT
            pieces = (
                outline_of(p.buffer(wide, quad_segs=SEGMENTS)) if wide > 0.0 else outline_of(p) for p in self.footprint
            )
            self._grown = (by_m, tuple(pieces))
        return self._grown[1]

    @cached_property
    def prisms(self) -> tuple[tuple[Polygon, float, float], ...]:
        """All prisms in P as (outline, low, high); the body's own come first."""
        shift = (self.x_P_m, self.y_P_m)
        return tuple(
            (polygon(outline + shift), prism.low_m + self.base_P_m, prism.high_m + self.base_P_m)
            for outline, prism in zip(self.turned.outlines, self.turned.shape.prisms, strict=True)
        )

    @cached_property
    def contact(self) -> ContactGeometry:
        """The geometry of its own body by which it stands on others and carries them."""
        return ContactGeometry(self.prisms[: self.turned.shape.own])


def footprint_distance(a: Placed, b: Placed) -> float:
    """Least distance (m) of two whole footprints in the same frame P."""
    return min(float(shapely.distance(p, q)) for p in a.footprint for q in b.footprint)


def bounds_gap(a: Placed, b: Placed) -> float:
    """A lower bound (m) of the distance of two footprints: that of their bounding boxes along an axis."""
    ax0, ay0, ax1, ay1 = a.bounds
    bx0, by0, bx1, by1 = b.bounds
    return max(bx0 - ax1, ax0 - bx1, by0 - ay1, ay0 - by1)
