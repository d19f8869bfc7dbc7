"""Distance (m) between two convex shapes, each answer proved by a separating plane.

FCL's GJK gives nearest points; now and then they are wrong by millimetres. So the returned distance is the width of the
empty slab across their direction: a lower bound whatever the solver does, equal to the distance where it was right.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import fcl
import numpy as np

from geom.pose import pose
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

TRUSTED_GAP_M = 1e-6  # Where the slab is narrower than this against FCL's answer, the query is repeated with a nudge.
NUDGES_M = (1e-6, 1e-5, 1e-4, 1e-3)


@dataclass(frozen=True)
class DistanceShape:
    """A shape as FCL holds it. It lies in its body B at X_BS (4, 4); `points` (n, 3) in S of a hull or a box."""

    shape: CollisionShape
    geometry: fcl.CollisionGeometry = field(repr=False)
    X_BS: FloatArray
    points: FloatArray | None

    @property
    def moves_alone(self) -> bool:
        """Whether the frame of the shape is that of its body."""
        return bool(np.array_equal(self.X_BS, np.eye(4)))


def distance_shape(shape: CollisionShape) -> DistanceShape:
    """The shape for distance queries."""
    size = shape.size_m
    if shape.points is not None and shape.triangles is not None:
        faces = np.concatenate([np.full((len(shape.triangles), 1), 3), shape.triangles], axis=1)
        points = np.ascontiguousarray(shape.points, dtype=np.float64)
        geometry = fcl.Convex(points, len(shape.triangles), faces.astype(np.int32).ravel())
        return DistanceShape(shape, geometry, np.eye(4), points)
    if shape.kind == "box":
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        return DistanceShape(shape, fcl.Box(*size), shape.X_AS, 0.5 * signs * size)
    makers = {"sphere": fcl.Sphere, "capsule": fcl.Capsule, "cylinder": fcl.Cylinder}
    return DistanceShape(shape, makers[shape.kind](*size), shape.X_AS, None)


def support_coordinate(body: DistanceShape, X_WB: FloatArray, direction_W: FloatArray) -> float:
    """The largest coordinate of the shape along a unit vector (3,)."""
    X_WS = X_WB @ body.X_BS
    u = X_WS[:3, :3].T @ direction_W
    size, at = body.shape.size_m, float(direction_W @ X_WS[:3, 3])
    if body.points is not None:
        return at + float((body.points @ u).max())
    if body.shape.kind == "sphere":
        return at + size[0]
    across = size[0] if body.shape.kind == "capsule" else size[0] * float(np.hypot(u[0], u[1]))
    return at + across + 0.5 * size[1] * abs(float(u[2]))


def centre_and_radius(body: DistanceShape) -> tuple[FloatArray, float]:
    """A ball in B that holds the shape: middle of its box and half the largest extent from there."""
    if body.points is not None:
        points = body.points @ body.X_BS[:3, :3].T + body.X_BS[:3, 3]
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        return centre, float(np.linalg.norm(points - centre, axis=1).max())
    size = body.shape.size_m
    if body.shape.kind == "sphere":
        return body.X_BS[:3, 3], size[0]
    half = 0.5 * size[1]
    return body.X_BS[:3, 3], half + size[0] if body.shape.kind == "capsule" else float(np.hypot(half, size[0]))


def box_W(body: DistanceShape, X_WB: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest corner (3,) of the shape's box along the axes of W."""
    high = np.array([support_coordinate(body, X_WB, axis) for axis in np.eye(3)])
    low = np.array([-support_coordinate(body, X_WB, -axis) for axis in np.eye(3)])
    return low, high


def separation_m(a: DistanceShape, X_WA: FloatArray, b: DistanceShape, X_WB: FloatArray) -> float:
    """The distance between two shapes, never more than the true one; 0 where they touch or overlap."""
    best = 0.0
    for nudge in (0.0, *NUDGES_M):
        distance, direction = _nearest(a, X_WA, b, X_WB @ pose(None, nudge * np.array([0.61, -0.53, 0.59])))
        if direction is None:
            if nudge == 0.0:
                return 0.0
            continue
        slab = -support_coordinate(b, X_WB, -direction) - support_coordinate(a, X_WA, direction)
        best = max(best, slab)
        if nudge == 0.0 and distance - best <= TRUSTED_GAP_M:
            break
    return best


def _nearest(a: DistanceShape, X_WA: FloatArray, b: DistanceShape, X_WB: FloatArray) -> tuple[float, FloatArray | None]:
    """FCL's distance and the unit vector from its nearest point of a to that of b; None where they meet."""
    result = fcl.DistanceResult()
    request = fcl.DistanceRequest(enable_nearest_points=True)
    objects = [fcl.CollisionObject(s.geometry, _transform(X @ s.X_BS)) for s, X in ((a, X_WA), (b, X_WB))]
    distance = fcl.distance(*objects, request, result)
    ends = np.asarray(result.nearest_points)
    across = ends[1] - ends[0]
    length = float(np.linalg.norm(across))
    return (distance, across / length) if distance > 0.0 and length > 0.0 else (0.0, None)


def _transform(X: FloatArray) -> fcl.Transform:
    return fcl.Transform(np.ascontiguousarray(X[:3, :3]), np.ascontiguousarray(X[:3, 3]))
