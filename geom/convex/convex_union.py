"""The union of convex collision shapes as half-spaces (metres): ray entries and exits, inside tests, clear boxes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geom.convex.hull import face_planes
from geom.convex.support_function import surface
from geom.mesh.farthest_points import farthest_points
from geom.mesh.surface_distance import sample_surface
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.physics import CollisionShape

_AXES = 64
_JOINED = 1e-4  # of the size: shapes closer than this along a ray count as one solid


@dataclass(frozen=True)
class _Convex:
    """Corners (n, 3); faces as outward unit normals (f, 3) with offsets (f,): inside where `normals @ x <= offsets`.

    `axes` (a,) are the faces whose normals are candidate separating axes: all, or a subset for a round shape.
    """

    points: FloatArray
    normals: FloatArray
    offsets: FloatArray
    axes: IntArray


class ConvexUnion:
    """A union of convex shapes (curved ones inscribed) in one frame, in metres."""

    def __init__(self, shapes: Sequence[CollisionShape]) -> None:
        """At least one shape, each with volume."""
        surfaces = [surface(shape) for shape in shapes]
        self._parts = [_convex(points, triangles) for points, triangles in surfaces]
        firsts = np.cumsum([0, *(len(points) for points, _ in surfaces)])[:-1]
        self._points = np.concatenate([points for points, _ in surfaces])
        self._triangles: IntArray = np.concatenate([t + first for (_, t), first in zip(surfaces, firsts, strict=True)])
        self.low, self.high = self._points.min(axis=0), self._points.max(axis=0)
        self.size = float(np.linalg.norm(self.high - self.low))

    def outer_samples(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Points (k, 3) spread over the outer surface, k <= `count`, and outward unit normals (k, 3) there."""
        points, index = sample_surface(self._points, self._triangles, count, 0)
        corners = self._points[self._triangles[index]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        outer = ~self.inside(points + 2.0 * _JOINED * self.size * normals)
        return points[outer], normals[outer]

    def inside(self, points: FloatArray) -> BoolArray:
        """(k,) True where points (k, 3) lie in any shape."""
        is_inside = np.zeros(len(points), dtype=bool)
        for part in self._parts:
            is_inside |= (points @ part.normals.T <= part.offsets).all(axis=1)
        return is_inside

    def first_exit(self, starts: FloatArray, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lengths (k,) of rays from surface points along inward unit `directions` to the first gap behind them, and the
        outward normals (k, 3) there.
        """
        spans = [_span(part, starts, directions) for part in self._parts]
        length, normal = np.zeros(len(starts)), np.zeros_like(starts)
        slack = _JOINED * self.size
        for _ in spans:
            before = length.copy()
            for enter, leave, outward in spans:
                further = (enter <= length + slack) & (leave > length)
                length = np.where(further, leave, length)
                normal = np.where(further[:, None], outward, normal)
            if np.array_equal(before, length):
                break
        return length, normal

    def first_entry(self, starts: FloatArray, directions: FloatArray) -> FloatArray:
        """Lengths (k,) of rays from outside along unit `directions` (k, 3) to the first shape; inf without one."""
        length = np.full(len(starts), np.inf)
        for part in self._parts:
            middle = 0.5 * (part.points.min(axis=0) + part.points.max(axis=0))
            radius = np.linalg.norm(part.points - middle, axis=1).max()
            beside = np.linalg.norm(np.cross(middle - starts, directions), axis=1)
            near = np.flatnonzero(beside <= radius)  # The other rays miss the shape.
            enter, leave, _ = _span(part, starts[near], directions[near])
            met = (leave > 0.0) & (enter < length[near])
            length[near] = np.where(met, np.maximum(enter, 0.0), length[near])
        return length

    def last_exit(self, starts: FloatArray, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lengths (k,) of rays to their exit from the furthest shape ahead, and the outward normals (k, 3) there."""
        length, normal = np.zeros(len(starts)), np.zeros_like(starts)
        for part in self._parts:
            _, leave, outward = _span(part, starts, directions)
            further = leave > length
            length = np.where(further, leave, length)
            normal = np.where(further[:, None], outward, normal)
        return length, normal

    def box_clear(self, X_AB: FloatArray, half_m: FloatArray) -> FloatArray:
        """(k,) True where boxes with poses (k, 4, 4) and half edges (k, 3) certainly touch no shape.

        A box and a shape are apart when an axis of the box or a face normal of the shape separates them. Pairs that
        only a cross product of two edges would separate count as touching, which is conservative.
        """
        centres, R_AB = X_AB[:, :3, 3], X_AB[:, :3, :3]
        radius = np.linalg.norm(half_m, axis=1)
        clear = np.ones(len(X_AB), dtype=bool)
        for part in self._parts:
            low, high = part.points.min(axis=0), part.points.max(axis=0)
            gap = np.maximum(np.maximum(low - centres, centres - high), 0.0)
            near = np.flatnonzero(clear & ((gap**2).sum(axis=1) <= radius**2))
            if not len(near):
                continue
            local = np.einsum("kji,knj->kni", R_AB[near], part.points[None] - centres[near, None])
            apart = ((local.min(axis=1) > half_m[near]) | (local.max(axis=1) < -half_m[near])).any(axis=1)
            left = near[~apart]
            normals, offsets = part.normals[part.axes], part.offsets[part.axes]
            half_width = np.abs(np.einsum("fj,kji->kfi", normals, R_AB[left])) @ half_m[left][:, :, None]
            nearest = centres[left] @ normals.T - half_width[:, :, 0]
            clear[left[~(nearest > offsets).any(axis=1)]] = False
        return clear


def _convex(points: FloatArray, triangles: IntArray) -> _Convex:
    planes = np.column_stack(face_planes(points, triangles))
    _, first = np.unique(np.round(planes, 9), axis=0, return_index=True)
    planes = planes[np.sort(first)]
    axes = farthest_points(planes[:, :3], 0, _AXES, 0.0) if len(planes) > _AXES else np.arange(len(planes))
    return _Convex(points, planes[:, :3], planes[:, 3], np.array(axes))


def _span(part: _Convex, starts: FloatArray, directions: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Lengths (k,) at which rays enter and leave a convex shape, and normals (k, 3) of the exit faces; a ray that
    misses it leaves at -inf. Source: Cyrus and Beck 1978.
    """
    speed = directions @ part.normals.T
    margin = part.offsets - starts @ part.normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        at = margin / speed
    leaves = np.where(speed > 1e-12, at, np.inf)
    enter = np.where(speed < -1e-12, at, -np.inf).max(axis=1)
    last = leaves.argmin(axis=1)
    leave = leaves[np.arange(len(starts)), last]
    misses = ((np.abs(speed) <= 1e-12) & (margin < 0.0)).any(axis=1) | (leave < enter)
    return np.where(misses, np.inf, enter), np.where(misses, -np.inf, leave), part.normals[last]
