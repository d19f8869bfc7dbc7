"""Prisms of collision shapes: each convex shape becomes an outline projected onto the ground and the heights it spans.

Outlines contain the shape: curved ones are circumscribed by polygons of `CIRCLE_CORNERS` corners, so that whatever is
clear of the outline is clear of the shape. Heights are exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import shapely

from geom.convex.circumscribed_hull import CIRCUMSCRIBED_CIRCLE, circumscribed_hull
from geom.convex.support_function import support
from geom.pose import matrix_of
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape
from schemas.scene.geometry import Prism, Stance

SECTIONS = np.array([0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0])  # shares of a shape's height
END_M = 2.5e-4  # thickness of the first and last section: more than what counts as one contact in a pile
TAPERS = 0.1  # share of the whole footprint by which a section is smaller where a shape is worth cutting


def stance_of(
    shapes: Sequence[CollisionShape], quat_wxyz: tuple[float, float, float, float], name: str, sections: bool = False
) -> Stance:
    """The stance of shapes (asset frame) turned by `quat_wxyz`, with their lowest point on the support.

    With `sections` a tapering shape becomes several prisms, one on the other; the first and last are thin, since others
    touch it there.
    """
    R_SP = np.eye(3) if quat_wxyz == (1.0, 0.0, 0.0, 0.0) else matrix_of(np.asarray(quat_wxyz))
    spans = [_heights(shape, R_SP) for shape in shapes]
    ground = min(low for low, _ in spans)
    whole = [
        Prism(_hull(_seen(shape, R_SP)), low - ground, high - ground)
        for shape, (low, high) in zip(shapes, spans, strict=True)
    ]
    if sections:
        least_m2 = TAPERS * shapely.union_all([shapely.Polygon(prism.outline_m) for prism in whole]).area
        corners = [circumscribed_hull(shape) @ R_SP.T - [0.0, 0.0, ground] for shape in shapes]
        whole = [
            part for prism, points in zip(whole, corners, strict=True) for part in _cut_up(prism, points, least_m2)
        ]
    return Stance(quat_wxyz, tuple(whole), -ground, name)


def _cut_up(prism: Prism, points: FloatArray, least_m2: float) -> list[Prism]:
    # Horizontal cuts of the hull of `points` (S, the lowest of all shapes at 0), bottom up; the prism itself where none
    # is smaller by an area that counts.
    ends = (prism.low_m + (prism.high_m - prism.low_m) * SECTIONS).tolist()
    if ends[1] - ends[0] > END_M:
        ends = [ends[0], ends[0] + END_M, *ends[1:-1], ends[-1] - END_M, ends[-1]]
    cuts = [Prism(_hull(_cut(points, low, high)), low, high) for low, high in pairwise(ends)]
    cuts = [cut for cut in cuts if len(cut.outline_m) >= 3]
    smallest = min((shapely.Polygon(cut.outline_m).area for cut in cuts), default=np.inf)
    if smallest >= shapely.Polygon(prism.outline_m).area - least_m2:
        return [prism]
    cuts[0] = replace(cuts[0], low_m=prism.low_m)
    cuts[-1] = replace(cuts[-1], high_m=prism.high_m)
    return cuts


def prisms_between(shapes: Sequence[CollisionShape], low_m: float, high_m: float) -> tuple[Prism, ...]:
    """Prisms of shapes between `low_m` and `high_m` (asset frame, upright); their heights count from `low_m`."""
    prisms = []
    for shape in shapes:
        low, high = _heights(shape, np.eye(3))
        if high <= low_m or low >= high_m:
            continue
        part = (
            _seen(shape, np.eye(3))
            if shape.kind in ("sphere", "capsule")
            else _cut(circumscribed_hull(shape), low_m, high_m)
        )
        outline = _hull(part)
        if len(outline) >= 3:
            prisms.append(Prism(outline, max(low, low_m) - low_m, min(high, high_m) - low_m))
    return tuple(prisms)


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
        return circumscribed_hull(shape) @ R_SP[:2].T
    half = 0.5 * shape.size_m[1] if shape.kind == "capsule" else 0.0
    ends = shape.X_AS[:3, 3] + np.outer([-half, half], shape.X_AS[:3, 2])
    return ((ends @ R_SP[:2].T)[:, None] + shape.size_m[0] * CIRCUMSCRIBED_CIRCLE).reshape(-1, 2)


def _cut(points: FloatArray, low_m: float, high_m: float) -> FloatArray:
    """(m, 2) projection of the corners of the hull of `points` between two heights.

    A plane cuts a convex hull in the hull of the points where it cuts the segments between its corners.
    """
    z = points[:, 2]
    points_kept = [points[(z >= low_m) & (z <= high_m), :2]]
    for height in (low_m, high_m):
        below, above = points[z < height], points[z > height]
        share = (height - below[:, 2])[:, None] / (above[None, :, 2] - below[:, None, 2])
        points_kept.append(
            (below[:, None, :2] + share[..., None] * (above[None, :, :2] - below[:, None, :2])).reshape(-1, 2)
        )
    return np.concatenate(points_kept)


def _hull(points: FloatArray) -> FloatArray:
    """(k, 2) corners of the convex hull, counter-clockwise, the lowest of the leftmost first; empty when flat."""
    hull = shapely.convex_hull(shapely.multipoints(points))
    if not isinstance(hull, shapely.Polygon):
        return np.zeros((0, 2))
    ring = shapely.get_coordinates(shapely.orient_polygons(hull))[:-1]
    first = np.lexsort((ring[:, 1], ring[:, 0]))[0]
    return np.roll(ring, -first, axis=0)
