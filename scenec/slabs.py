"""Collision shapes seen from above: each convex shape as an outline and the heights it spans.

Outlines hold the shape: curved ones are circumscribed by polygons of `CORNERS` corners, so that what is clear of the
outline is clear of the shape. Heights are exact.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from geom.outer_corners import AROUND, outer_corners
from geom.pose import matrix_of
from geom.support import support
from scenec.ir import FloatArray, Slab, Stance
from schemas.physics import CollisionShape


def stance_of(shapes: Sequence[CollisionShape], quat_wxyz: tuple[float, float, float, float], name: str) -> Stance:
    """How shapes (asset frame) stand when the asset frame is turned by `quat_wxyz`, the lowest point on the support."""
    R_SP = np.eye(3) if quat_wxyz == (1.0, 0.0, 0.0, 0.0) else matrix_of(np.asarray(quat_wxyz))
    spans = [_heights(shape, R_SP) for shape in shapes]
    ground = min(low for low, _ in spans)
    slabs = tuple(
        Slab(_hull(_seen(shape, R_SP)), low - ground, high - ground)
        for shape, (low, high) in zip(shapes, spans, strict=True)
    )
    return Stance(quat_wxyz, slabs, -ground, name)


def slabs_between(shapes: Sequence[CollisionShape], low_m: float, high_m: float) -> tuple[Slab, ...]:
    """What shapes hold at heights from `low_m` to `high_m` (asset frame, upright), heights counted from `low_m`."""
    found = []
    for shape in shapes:
        low, high = _heights(shape, np.eye(3))
        if high <= low_m or low >= high_m:
            continue
        part = (
            _seen(shape, np.eye(3))
            if shape.kind in ("sphere", "capsule")
            else _cut(outer_corners(shape), low_m, high_m)
        )
        outline = _hull(part)
        if len(outline) >= 3:
            found.append(Slab(outline, max(low, low_m) - low_m, min(high, high_m) - low_m))
    return tuple(found)


def scaled(shape: CollisionShape, scale: float) -> CollisionShape:
    """The shape enlarged about the origin of the asset frame."""
    X_AS = shape.X_AS.copy()
    X_AS[:3, 3] *= scale
    points = None if shape.points is None else shape.points * scale
    return CollisionShape(shape.kind, tuple(s * scale for s in shape.size_m), X_AS, points, shape.triangles)


def _heights(shape: CollisionShape, R_SP: FloatArray) -> tuple[float, float]:
    """Lowest and highest point over the origin of the asset frame, which is turned by `R_SP`."""
    up_P = R_SP[2]
    low, high = support([shape], np.stack([-up_P, up_P])) * [-1.0, 1.0]
    return float(low), float(high)


def _seen(shape: CollisionShape, R_SP: FloatArray) -> FloatArray:
    """(n, 2) points whose hull holds the projection of the shape onto the ground."""
    if shape.kind not in ("sphere", "capsule"):
        return outer_corners(shape) @ R_SP[:2].T
    half = 0.5 * shape.size_m[1] if shape.kind == "capsule" else 0.0
    ends = shape.X_AS[:3, 3] + np.outer([-half, half], shape.X_AS[:3, 2])
    return ((ends @ R_SP[:2].T)[:, None] + shape.size_m[0] * AROUND).reshape(-1, 2)


def _cut(points: FloatArray, low_m: float, high_m: float) -> FloatArray:
    """(m, 2) projection of the corners of the hull of `points` between two heights.

    A plane cuts a convex hull in the hull of the points where it cuts the segments between its corners.
    """
    z = points[:, 2]
    kept = [points[(z >= low_m) & (z <= high_m), :2]]
    for height in (low_m, high_m):
        below, above = points[z < height], points[z > height]
        share = (height - below[:, 2])[:, None] / (above[None, :, 2] - below[:, None, 2])
        kept.append((below[:, None, :2] + share[..., None] * (above[None, :, :2] - below[:, None, :2])).reshape(-1, 2))
    return np.concatenate(kept)


def _hull(points: FloatArray) -> FloatArray:
    """(k, 2) corners of the convex hull, counter-clockwise, the lowest of the leftmost first; empty when flat."""
    hull = shapely.convex_hull(shapely.multipoints(points))
    if not isinstance(hull, shapely.Polygon):
        return np.zeros((0, 2))
    ring = shapely.get_coordinates(shapely.orient_polygons(hull))[:-1]
    first = np.lexsort((ring[:, 1], ring[:, 0]))[0]
    return np.roll(ring, -first, axis=0)
