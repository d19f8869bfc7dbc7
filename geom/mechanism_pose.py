"""Placement of a mechanism: the same in another object frame, and the poses of its links at joint positions.

The *opening* of joints is a share 0..1 of their range: 0 at the limit nearer to the rest state, 1 at the other one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from geom.pose import apply, pose, rotation_about
from schemas.arrays import FloatArray
from schemas.mechanism import Mechanism, MechanismJoint


def in_frame(mechanism: Mechanism, R_AM: FloatArray, scale: float, p_AoMo_A: FloatArray) -> Mechanism:
    """The mechanism, given in frame M, in frame A: a point p is at scale * R_AM p + p_AoMo_A.

    Positions of sliding joints are scaled like lengths; forces, dampings and masses keep their numbers.
    """
    X_AM = pose(scale * R_AM, p_AoMo_A)

    def placed(joint: MechanismJoint) -> MechanismJoint:
        factor = 1.0 if joint.is_angular else scale
        limits = None if joint.limits is None else (joint.limits[0] * factor, joint.limits[1] * factor)
        return replace(
            joint,
            anchor=apply(X_AM, joint.anchor[None])[0],
            axis=R_AM @ joint.axis,
            rest=joint.rest * factor,
            limits=limits,
            velocity=None if joint.velocity is None else joint.velocity * factor,
            spring_rest=joint.spring_rest * factor,
        )

    links = tuple(replace(link, origin=apply(X_AM, link.origin[None])[0]) for link in mechanism.links)
    return replace(mechanism, links=links, joints=tuple(placed(joint) for joint in mechanism.joints))


def joint_positions(mechanism: Mechanism, given: Mapping[str, float]) -> dict[str, float]:
    """Positions of all joints by name: as given, of coupled joints by the joint that they follow, else at rest."""
    by_name = {joint.name: joint for joint in mechanism.joints}

    def position(joint: MechanismJoint) -> float:
        if joint.name in given:
            return given[joint.name]
        if joint.coupling is None:
            return joint.rest
        return joint.coupling.multiplier * position(by_name[joint.coupling.joint]) + joint.coupling.offset

    return {joint.name: position(joint) for joint in mechanism.joints}


def link_frames(mechanism: Mechanism, positions: Mapping[str, float]) -> dict[str, FloatArray]:
    """X_AL (4, 4) of every link by name at joint positions (rad, m; ball joints stay at rest), root at its rest pose.

    Product of exponentials (Brockett 1984) over the joints of the tree, each about its axis in the rest state.
    """
    motions = link_motions(mechanism, positions)
    return {link.name: motions[link.name] @ pose(None, link.origin) for link in mechanism.links}


def link_motions(mechanism: Mechanism, positions: Mapping[str, float]) -> dict[str, FloatArray]:
    """M (4, 4) of the object frame for every link by name: what joint positions do to its points at rest."""
    at = joint_positions(mechanism, positions)
    carrier = {joint.child: joint for joint in mechanism.tree}
    motions: dict[str, FloatArray] = {}
    for link in mechanism.links:
        joint = carrier.get(link.name)
        motions[link.name] = (
            np.eye(4) if joint is None else motions[joint.parent] @ joint_motion(joint, at[joint.name] - joint.rest)
        )
    return motions


def movable_joints(mechanism: Mechanism) -> tuple[MechanismJoint, ...]:
    """The joints of the tree that move on their own: not those that follow another one, nor ball joints."""
    return tuple(joint for joint in mechanism.tree if joint.coupling is None and joint.kind != "ball")


def opened(joints: Iterable[MechanismJoint], share: float) -> dict[str, float]:
    """Positions by name of joints opened by `share`; a joint without limits makes one turn from rest."""
    positions: dict[str, float] = {}
    for joint in joints:
        near, far = joint.limits or (joint.rest, joint.rest + 2.0 * math.pi)
        if abs(far - joint.rest) < abs(near - joint.rest):
            near, far = far, near
        positions[joint.name] = (1.0 - share) * near + share * far
    return positions


def joint_motion(joint: MechanismJoint, moved_by: float) -> FloatArray:
    """M (4, 4) of the object frame: what the joint does to its child when it moves from rest by `moved_by`."""
    if joint.kind == "prismatic":
        return pose(None, moved_by * joint.axis)
    if joint.kind == "ball":
        return np.eye(4)
    turned = rotation_about(joint.axis, moved_by)
    return pose(turned, joint.anchor - turned @ joint.anchor)
