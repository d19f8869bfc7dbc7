"""Bodies, colliders and visible meshes as plain arrays. All lengths in metres; `W` is the stage's world at rest.

A collider or mesh belongs to its nearest ancestor (or itself) with a rigid body; without one it is static.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geom.convex.hull import convex_hull
from geom.mass.inertia import combine_volumes, enclosed_volume
from geom.pose import apply, inverse
from schemas.arrays import FloatArray, IntArray
from schemas.physics import VolumeProperties

SKIN_M = 1e-3  # by which a mesh may be tighter than the thing
_FLAT = 1e-9  # A volume below this share of the cubed diagonal counts as flat.


@dataclass(frozen=True)
class Hull:
    """A convex hull with volume: points (n, 3), outward triangles (m, 3), planes `normals @ p <= offsets`."""

    points: FloatArray
    triangles: IntArray

    @cached_property
    def planes(self) -> tuple[FloatArray, FloatArray]:
        """Outward unit normals (m, 3) and offsets (m,)."""
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        normals = np.cross(b - a, c - a)
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        return normals, np.einsum("ij,ij->i", normals, a)

    @cached_property
    def thickness(self) -> float:
        """The least distance between two parallel planes that touch it on either side, one of them along a face."""
        normals, offsets = self.planes
        return float((offsets - (self.points @ normals.T).min(axis=0)).min())

    @cached_property
    def volume(self) -> VolumeProperties:
        """The volume inside."""
        return enclosed_volume(self.points, self.triangles)


def hull_of(points: FloatArray) -> Hull | None:
    """The hull of (n, 3) points; None when they are flat, too few or not finite."""
    if len(points) < 4 or not np.all(np.isfinite(points)):
        return None
    try:
        hull = Hull(*convex_hull(points))
    except ValueError:
        return None
    return hull if hull.volume.volume_m3 > _FLAT * float(np.linalg.norm(np.ptp(points, axis=0))) ** 3 else None


@dataclass(frozen=True)
class Collider:
    """A prim with a collision API. `points_W` (n, 3) lie on its surface; empty for a type that has none.

    `approximation` is that of a mesh ("" for other prims); `convex` is true when engines collide with exactly the hull
    of the points.
    """

    prim: Any
    enabled: bool
    points_W: FloatArray
    approximation: str
    convex: bool

    @cached_property
    def hull_W(self) -> Hull | None:
        """The convex hull, in the world."""
        return hull_of(self.points_W)


@dataclass(frozen=True)
class VisibleSurface:
    """A visible mesh or implicit shape as triangles: points (n, 3) in the world, triangles (m, 3) wound outwards by
    the prim's orientation. Triangles are empty when the topology is broken.
    """

    prim: Any
    points_W: FloatArray
    triangles: IntArray


@dataclass(frozen=True)
class Body:
    """A prim with a rigid-body API.

    X_WB     (4, 4) its pose with scale and shear taken out; `linear` (3, 3) its axes in the world, scaled and sheared.
    mass_kg  as authored on the body; None when absent, zero or impossible, which only the mass rule reports.
    """

    prim: Any
    enabled: bool
    X_WB: FloatArray
    linear: FloatArray
    colliders: tuple[Collider, ...]
    surfaces: tuple[VisibleSurface, ...]
    mass_kg: float | None

    @property
    def path(self) -> str:
        """The prim path."""
        return str(self.prim.GetPath())

    @property
    def active_colliders(self) -> tuple[Collider, ...]:
        """Colliders that are enabled."""
        return tuple(c for c in self.colliders if c.enabled)

    @cached_property
    def collider_points_W(self) -> FloatArray:
        """(n, 3) points on all enabled colliders."""
        return stacked([c.points_W for c in self.active_colliders])

    @cached_property
    def visible_points_W(self) -> FloatArray:
        """(n, 3) points of all visible meshes."""
        return stacked([s.points_W for s in self.surfaces])

    @cached_property
    def hull_W(self) -> Hull | None:
        """The hull of all enabled colliders."""
        return hull_of(self.collider_points_W)

    @cached_property
    def collider_volume(self) -> VolumeProperties | None:
        """The volume of the enabled colliders' hulls, in the body frame; overlaps count twice.

        None when no collider has volume.
        """
        hulls = [c.hull_W for c in self.active_colliders]
        X_BW = inverse(self.X_WB)
        volumes = [enclosed_volume(apply(X_BW, h.points), h.triangles) for h in hulls if h is not None]
        return combine_volumes(volumes) if volumes else None

    @cached_property
    def diagonal_m(self) -> float:
        """Diagonal of the bounds of colliders and visible meshes; zero when there is nothing."""
        return diagonal(stacked([self.collider_points_W, self.visible_points_W]))

    def in_body(self, points_W: FloatArray) -> FloatArray:
        """World points (n, 3) in the body frame."""
        return apply(inverse(self.X_WB), points_W)


def stacked(clouds: list[FloatArray]) -> FloatArray:
    """(n, 3) all points of several clouds."""
    return np.concatenate(clouds) if clouds else np.zeros((0, 3))


def diagonal(points: FloatArray) -> float:
    """Length of the bounding-box diagonal; zero for no points."""
    return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
