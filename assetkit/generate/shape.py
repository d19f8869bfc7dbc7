"""Shapes that generators build with: a closed solid, and convex pieces that cover the same space for collisions.

Metres, in the frame of the object (z up, front +x). Round shapes are polygons with `SEGMENTS` corners on the circle;
pieces of hollow round shapes are `SECTORS` convex sectors. Volumes are those of the polygonal solid. Corners lie on a
grid of a nanometre, so that faces at one place are equal, however their place was computed, and touching bodies merge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from manifold3d import CrossSection, Manifold, OpType

from geom.convex.hull import convex_hull
from geom.mass.inertia import enclosed_volume
from geom.mesh.manifold_arrays import manifold_arrays, manifold_of
from geom.pose import pose, rotation_about
from schemas.arrays import FloatArray, IntArray
from schemas.physics import CollisionShape, VolumeProperties

SEGMENTS = 96  # corners of a circle: its area is short by 0.07 %
SECTORS = 24  # of a hollow round shape; a chord cuts 0.9 % of the inner radius off the hole
GRID_DECIMALS = 9  # of coordinates in m: a nanometre
AXES = {"x": np.array([1.0, 0.0, 0.0]), "y": np.array([0.0, 1.0, 0.0]), "z": np.array([0.0, 0.0, 1.0])}
AxisName = Literal["x", "y", "z"]
Point = Sequence[float] | FloatArray  # (3,), of a rectangle's centre (2,)
Profile = Sequence[tuple[float, float]]  # corners (radius, height) of a convex polygon, counter-clockwise


@dataclass(frozen=True)
class Shape:
    """A closed `solid`, and `convex` pieces (posed in the frame of the object) that cover it."""

    solid: Manifold
    convex: tuple[CollisionShape, ...]

    def __add__(self, other: Shape) -> Shape:
        return Shape(self.solid + other.solid, self.convex + other.convex)

    @property
    def surface(self) -> tuple[FloatArray, IntArray]:
        """Points (n, 3) and triangles (m, 3) of the solid."""
        return manifold_arrays(self.solid)

    @property
    def volume(self) -> VolumeProperties:
        """Volume, centre and second moment of the solid."""
        return enclosed_volume(*self.surface)

    def moved(self, shift_m: Point) -> Shape:
        """The shape shifted by (3,)."""
        return self._posed(pose(None, np.asarray(shift_m, dtype=np.float64)))

    def turned(self, axis: FloatArray, angle_rad: float, about_m: Point) -> Shape:
        """The shape turned about an axis through the point `about_m`."""
        centre = np.asarray(about_m, dtype=np.float64)
        return self._posed(pose(None, centre) @ pose(rotation_about(axis, angle_rad)) @ pose(None, -centre))

    def _posed(self, X: FloatArray) -> Shape:
        return Shape(self.solid.transform(np.ascontiguousarray(X[:3])), tuple(_posed(p, X) for p in self.convex))


def _posed(piece: CollisionShape, X: FloatArray) -> CollisionShape:
    if piece.points is None:
        return replace(piece, X_AS=X @ piece.X_AS)
    return replace(piece, points=piece.points @ X[:3, :3].T + X[:3, 3])


def union(shapes: Sequence[Shape]) -> Shape:
    """One shape of all: solids are merged, convex pieces put together."""
    solid = Manifold.batch_boolean([shape.solid for shape in shapes], OpType.Add)
    return Shape(solid, tuple(piece for shape in shapes for piece in shape.convex))


def box(low_m: Point, high_m: Point) -> Shape:
    """The axis-aligned box between two corners."""
    low, high = np.asarray(low_m, dtype=np.float64), np.asarray(high_m, dtype=np.float64)
    if not (high > low).all():
        raise ValueError(f"a box from {low} to {high} has no inside")
    x, y, z = (high - low).tolist()
    solid = _on_grid(Manifold.cube((x, y, z)).translate(low))
    return Shape(solid, (CollisionShape("box", (x, y, z), pose(None, 0.5 * (low + high))),))


def cylinder(radius_m: float, height_m: float, base_m: Point, axis: AxisName = "z") -> Shape:
    """The cylinder from the centre of its base along a positive axis."""
    X = pose(_from_z(axis), np.asarray(base_m, dtype=np.float64))
    solid = _on_grid(Manifold.cylinder(height_m, radius_m, radius_m, SEGMENTS).transform(np.ascontiguousarray(X[:3])))
    middle = X @ pose(None, np.array([0.0, 0.0, 0.5 * height_m]))
    return Shape(solid, (CollisionShape("cylinder", (radius_m, height_m), middle),))


def revolved(profiles: Sequence[Profile], base_m: Point = (0.0, 0.0, 0.0), axis: AxisName = "z") -> Shape:
    """The body swept by convex profiles turned about an axis through `base_m`.

    Profiles on the axis become one convex piece each, others `SECTORS` of them.
    """
    outline = CrossSection()
    for profile in profiles:
        outline = outline + CrossSection([np.array(profile)])
    X = pose(_from_z(axis), np.asarray(base_m, dtype=np.float64))
    pieces = tuple(_posed(piece, X) for profile in profiles for piece in _swept(profile))
    return Shape(_on_grid(Manifold.revolve(outline, SEGMENTS).transform(np.ascontiguousarray(X[:3]))), pieces)


def tube(inner_m: float, outer_m: float, height_m: float, base_m: Point) -> Shape:
    """The upright ring of rectangular section between two radii."""
    return revolved([((inner_m, 0.0), (outer_m, 0.0), (outer_m, height_m), (inner_m, height_m))], base_m)


def open_box(low_m: Point, high_m: Point, wall_m: float, opens: Literal["+x", "+z"] = "+z") -> Shape:
    """The box with walls of one thickness that is open on one side: five plates that overlap at no point."""
    (x0, y0, z0), (x1, y1, z1), t = low_m, high_m, wall_m
    if opens == "+z":
        plates = (
            box((x0, y0, z0), (x1, y1, z0 + t)),
            box((x0, y0, z0 + t), (x0 + t, y1, z1)),
            box((x1 - t, y0, z0 + t), (x1, y1, z1)),
            box((x0 + t, y0, z0 + t), (x1 - t, y0 + t, z1)),
            box((x0 + t, y1 - t, z0 + t), (x1 - t, y1, z1)),
        )
    else:
        plates = (
            box((x0, y0, z0), (x0 + t, y1, z1)),
            box((x0 + t, y0, z0), (x1, y0 + t, z1)),
            box((x0 + t, y1 - t, z0), (x1, y1, z1)),
            box((x0 + t, y0 + t, z0), (x1, y1 - t, z0 + t)),
            box((x0 + t, y0 + t, z1 - t), (x1, y1 - t, z1)),
        )
    return union(plates)


def frustum(
    low_size_m: FloatArray,
    high_size_m: FloatArray,
    z0: float,
    z1: float,
    low_centre_m: Point = (0.0, 0.0),
    high_centre_m: Point = (0.0, 0.0),
) -> Shape:
    """The convex body between a rectangle (x, y sizes, centre) at height z0 and another one at z1."""
    signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    corners = [
        np.column_stack([np.asarray(centre) + 0.5 * signs * size, np.full(4, z)])
        for size, centre, z in ((low_size_m, low_centre_m, z0), (high_size_m, high_centre_m, z1))
    ]
    points, triangles = convex_hull(np.concatenate(corners))
    solid = _on_grid(Manifold.hull_points(points))
    return Shape(solid, (CollisionShape("hull", (), np.eye(4), points, triangles.astype(np.int32)),))


def drilled(plate_low_m: Point, plate_high_m: Point, holes: Sequence[tuple[float, float, float]]) -> Shape:
    """A plate with round holes (x, y, radius) along z; its convex pieces are the plate without the square around each.

    Squares must lie apart, inside the plate, in one row along y.
    """
    (x0, y0, z0), (x1, _, z1) = plate_low_m, plate_high_m
    solid = box(plate_low_m, plate_high_m).solid
    pieces: list[CollisionShape] = []
    edge = y0
    for x, y, radius in sorted(holes, key=lambda hole: hole[1]):
        solid = solid - cylinder(radius, 3.0 * (z1 - z0), (x, y, z0 - (z1 - z0))).solid
        pieces += box((x0, edge, z0), (x1, y - radius, z1)).convex
        pieces += box((x0, y - radius, z0), (x - radius, y + radius, z1)).convex
        pieces += box((x + radius, y - radius, z0), (x1, y + radius, z1)).convex
        edge = y + radius
    return Shape(solid, (*pieces, *box((x0, edge, z0), plate_high_m).convex))


def _on_grid(solid: Manifold) -> Manifold:
    points, triangles = manifold_arrays(solid)
    return manifold_of(np.round(points, GRID_DECIMALS), triangles)


def _from_z(axis: AxisName) -> FloatArray:
    """Rotation (3, 3) that brings +z to the axis."""
    turns = {"x": ("y", 0.5 * np.pi), "y": ("x", -0.5 * np.pi), "z": ("z", 0.0)}
    about, angle = turns[axis]
    R = rotation_about(AXES[about], angle)
    R[np.abs(R) < 1e-15] = 0.0
    return R


def _swept(profile: Profile) -> list[CollisionShape]:
    """Convex hulls of a profile turned about z."""
    corners = np.array(profile, dtype=np.float64)
    whole = bool((corners[:, 0] <= 0.0).any())
    steps = SEGMENTS if whole else SEGMENTS // SECTORS
    pieces: list[CollisionShape] = []
    for sector in range(1 if whole else SECTORS):
        angles = (sector * steps + np.arange(steps + (not whole))) * (2.0 * np.pi / SEGMENTS)
        around = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=1)
        points = (corners[:, None, :1] * around[None] + corners[:, None, 1:] * [0.0, 0.0, 1.0]).reshape(-1, 3)
        points, triangles = convex_hull(points)
        pieces.append(CollisionShape("hull", (), np.eye(4), points, triangles.astype(np.int32)))
    return pieces
