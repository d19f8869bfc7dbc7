"""Trimming of the hulls of curved walls by planes, so that each is as thin as the wall.

The hull of a bent plate is a lens, full between the plate and its chord. A convex shape can only be as thin as the
plate when it gives up part of the plate. So the empty side is cut off, less than half a wall deep, and the bulge of the
outer side, never deeper than a bound: the remaining slab still meets its neighbours, edge to edge.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import Manifold

from geom.mesh.manifold_arrays import manifold_arrays
from geom.mesh.surface_distance import SignedDistance, triangle_areas
from schemas.arrays import BoolArray, FloatArray

SIDES, BISECTIONS = 8, 7
# Faces within this cosine of each other are one side.
SAME_SIDE = 0.9
# The upper half of a cap's height holds at most this share of its volume; a flat end (one half) is no bulge.
BULGE = 0.42
# A face is a joint when it lies deeper inside the body than this share of the bound, empty when as far outside.
FAR = 0.2
# A side is a joint with more than this share of joints, empty with more than that share of empty area.
JOINT_AREA, EMPTY_AREA = 0.2, 0.5
EMPTY_DEPTH = 0.4  # of the wall's thickness
LEAST_CAP = 0.005
BROAD = 0.1  # share of the largest face's area from which a face counts for a side's direction
# Two ways to compute a volume agree far better than to this share; in between the body is really cut.
UNCERTAIN = 1e-6
KEPT = 1.02  # Each hull keeps the body's volume within it and this little more.


def trim_hulls(
    hulls: Sequence[Manifold], insides: Sequence[Manifold], distance: SignedDistance, depth: float
) -> list[Manifold]:
    """The hulls with empty sides and outer bulges cut off, each at most `depth` deep.

    No hull gets smaller than the part of the body inside it (`insides`); `distance` is that to the body's surface.
    """
    return [_trimmed(hull, inside, distance, depth) for hull, inside in zip(hulls, insides, strict=True)]


def _trimmed(hull: Manifold, inside: Manifold, distance: SignedDistance, depth: float) -> Manifold:
    least = KEPT * inside.volume()
    if hull.volume() * (1.0 - LEAST_CAP) <= least:
        return hull
    wall = 2.0 * inside.volume() / max(inside.surface_area(), np.finfo(float).tiny)
    cuts: list[tuple[float, float, FloatArray, float]] = []
    for normal, is_empty in outer_sides(hull, distance, FAR * depth):
        most = min(depth, EMPTY_DEPTH * wall) if is_empty else depth
        depth_reached = _depth_for(hull, normal, least, most)
        cap = hull.volume() - _cut(hull, normal, depth_reached).volume()
        if cap >= LEAST_CAP * hull.volume() and (is_empty or _upper_half(hull, normal, depth_reached) <= BULGE * cap):
            cuts.append((cap, most, normal, depth_reached))
    for number, (_, most, normal, first_depth) in enumerate(sorted(cuts, key=lambda c: -c[0])):
        # The first cut meets the hull that its depth was found for.
        hull = _cut(hull, normal, _depth_for(hull, normal, least, most) if number else first_depth)
    return hull


def _upper_half(hull: Manifold, normal: FloatArray, depth: float) -> float:
    """The volume of the upper half of a cap of this depth."""
    return hull.volume() - _cut(hull, normal, 0.5 * depth).volume()


def _depth_for(hull: Manifold, normal: FloatArray, least: float, depth: float) -> float:
    """The depth up to `depth` that leaves at least the volume `least`."""
    below = VolumeBelow(hull, normal)

    def leaves_enough(cut: float) -> bool:
        volume = below(below.top - cut)
        if abs(volume - least) > UNCERTAIN * least:
            return volume >= least
        return _cut(hull, normal, cut).volume() >= least

    if leaves_enough(depth):
        return depth
    low, high = 0.0, depth
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if leaves_enough(middle) else (low, middle)
    return low


class VolumeBelow:
    """The volume of a body below a plane, as a function of the plane's height along `normal`.

    By the divergence theorem for the field (z - height) along the normal, which vanishes on the plane: each face adds
    its projected area times the mean depth of its points below the plane, which is a cubic between its corners.
    """

    def __init__(self, body: Manifold, normal: FloatArray) -> None:
        points, triangles = manifold_arrays(body)
        a, b, c = (np.take(points, triangles[:, corner], axis=0) for corner in range(3))
        self._downward: FloatArray = -0.5 * np.cross(b - a, c - a) @ normal
        self._z: FloatArray = np.sort(np.take(points @ normal, triangles), axis=1).T
        self.top = float(self._z[2].max())

    def __call__(self, height: float) -> float:
        """Volume below `height`."""
        low, middle, high = self._z[0], self._z[1], self._z[2]
        tiny = np.finfo(float).tiny
        under, over = np.clip(height - low, 0.0, middle - low), np.clip(high - height, 0.0, high - middle)
        tip: FloatArray = under**3 / np.maximum(3.0 * (middle - low) * (high - low), tiny)
        rest: FloatArray = (
            height - (low + middle + high) / 3.0 + over**3 / np.maximum(3.0 * (high - low) * (high - middle), tiny)
        )
        mean_depths: FloatArray = np.where(height <= middle, tip, rest)
        return float(self._downward @ mean_depths)


def _cut(hull: Manifold, normal: FloatArray, depth: float) -> Manifold:
    """The hull without the part less than `depth` below its highest point along `normal`."""
    if depth <= 0.0:
        return hull
    top = float((manifold_arrays(hull)[0] @ normal).max())
    return hull.trim_by_plane((-normal[0], -normal[1], -normal[2]), depth - top)


def outer_sides(hull: Manifold, distance: SignedDistance, far: float) -> list[tuple[FloatArray, bool]]:
    """The largest sides of a hull except joints to other pieces: the normal (3,) of a central face, True if empty."""
    points, triangles = manifold_arrays(hull)
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    areas = triangle_areas(points[triangles])
    normals = np.cross(b - a, c - a) / np.maximum(2.0 * areas, np.finfo(float).tiny)[:, None]
    beyond = distance((a + b + c) / 3.0)
    left: BoolArray = areas > 0.0
    sides: list[tuple[FloatArray, bool]] = []
    while left.any() and len(sides) < SIDES:
        side = normals @ normals[np.where(left, areas, 0.0).argmax()] > SAME_SIDE
        left &= ~side
        area = areas[side].sum()
        if areas[side & (beyond < -far)].sum() <= JOINT_AREA * area:
            # A face, not the mean itself: between two flat faces lies an edge, which is no bulge.
            broad = side & (areas >= BROAD * areas[side].max())
            middle = np.where(broad, normals @ (areas[side] @ normals[side]), -np.inf).argmax()
            sides.append((normals[middle], bool(areas[side & (beyond > far)].sum() > EMPTY_AREA * area)))
    return sides
