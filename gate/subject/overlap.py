"""Penetration depth (m) of the convex colliders of two links, at rest and along a joint's motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from gate.subject.body import Body, Hull
from gate.subject.joint import AXES, ONE_DOF_KINDS, Joint
from geom.convex.penetration import box_overlap, penetration_depth
from geom.pose import apply


def hulls_of(body: Body) -> list[Hull]:
    """The hulls that engines collide; a mesh that is no hull is left to the collider rules."""
    return [c.hull_W for c in body.active_colliders if c.convex and c.hull_W is not None]


def deepest_penetration(hulls_a: list[Hull], hulls_b: list[Hull]) -> tuple[float, float]:
    """The largest depth over all pairs, and the thickness of the thinner hull of that pair; zeros without a pair."""
    pairs = [(box_overlap(a.points, b.points), a, b) for a in hulls_a for b in hulls_b]
    depth_m, thickness_m = 0.0, 0.0
    for most_m, a, b in sorted(pairs, key=lambda pair: -pair[0]):
        if most_m <= depth_m:
            break  # No later pair can be deeper.
        found_m = penetration_depth(a.points, b.points)
        if found_m > depth_m:
            depth_m, thickness_m = found_m, min(a.thickness, b.thickness)
    return depth_m, thickness_m


def hulls_along_motion(
    joint: Joint, second: Body, hulls: list[Hull], shares: Sequence[float]
) -> Iterator[tuple[float, list[Hull]]]:
    """Joint coordinates, and the hulls of `second` there with the other link held still.

    `shares` are of the way from rest to either limit. Endless joints are followed for half a turn, or for the size of
    their links.
    """
    rest = joint.rest()
    if joint.kind not in ONE_DOF_KINDS or rest is None:
        return
    turning = joint.kind == "revolute"
    most_motion = 180.0 if turning else joint.size_m
    ends = np.clip(joint.limits, rest.coordinate - most_motion, rest.coordinate + most_motion)
    sign = 1.0 if joint.sides[1].body is not None and joint.sides[1].body.path == second.path else -1.0
    X_WJ = joint.sides[0].X_WJ
    axis_W = X_WJ[:3, :3] @ AXES.get(joint.axis, AXES["X"])
    for move in ((end - rest.coordinate) * share for end in ends for share in shares):
        X_WW = np.eye(4)
        if turning:
            X_WW[:3, :3] = Rotation.from_rotvec(sign * np.deg2rad(move) * axis_W).as_matrix()
            X_WW[:3, 3] = X_WJ[:3, 3] - X_WW[:3, :3] @ X_WJ[:3, 3]
        else:
            X_WW[:3, 3] = sign * move * axis_W
        yield float(rest.coordinate + move), [Hull(apply(X_WW, hull.points), hull.triangles) for hull in hulls]
