"""Forward kinematics of a description: poses of its links in the frame of the root at given joint positions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from formats.tree import breadth_first, joints_of
from geom.pose import matrix_of, pose, rotation_about
from schemas.arrays import FloatArray
from schemas.robot_description import DescribedJoint, RobotDescription

POSITIONS: Mapping[str, int] = {
    "fixed": 0,
    "revolute": 1,
    "continuous": 1,
    "prismatic": 1,
    "planar": 3,
    "ball": 4,
    "floating": 7,
}
"""Count of numbers of a joint's position: planar (x, y, angle), ball a quaternion wxyz, floating a pose."""


def link_poses(
    description: RobotDescription, positions: Mapping[str, float | Sequence[float] | FloatArray]
) -> dict[str, FloatArray]:
    """X_RL (4, 4) of every link by name, R the root. Joints without a position are at their reference.

    `positions` are by joint: rad or m; of planar joints (x, y, angle) in the frame that takes z to the axis, of ball
    joints a quaternion wxyz, of floating ones the position in the parent and a quaternion. A mimic joint without a
    position of its own follows the joint that it mimics.
    """
    by_name = {joint.name: joint for joint in description.joints}
    carriers = joints_of(description.joints)
    X_RL: dict[str, FloatArray] = {description.root: np.eye(4)}
    for link in breadth_first(description)[1:]:
        joints = carriers[link]
        placed = joints[0].X_PC  # the child in the parent, moved joint by joint
        for joint in joints:
            q = _position(joint, by_name, positions)
            if joint.kind == "floating" and q is not None:
                values = np.asarray(q, dtype=np.float64)
                placed = pose(matrix_of(values[3:]), values[:3])
            elif q is not None:
                placed = placed @ motion(joint, q)
        X_RL[link] = X_RL[joints[0].parent] @ placed
    return X_RL


def motion(joint: DescribedJoint, position: float | Sequence[float] | FloatArray) -> FloatArray:
    """M (4, 4) of a joint other than a floating one: the child's motion in its frame at the reference."""
    values = np.atleast_1d(np.asarray(position, dtype=np.float64))
    if joint.kind == "prismatic":
        return pose(None, (values[0] - joint.reference) * joint.axis_C)
    if joint.kind == "planar":
        along_x, along_y = _across(joint.axis_C)
        return pose(rotation_about(joint.axis_C, float(values[2])), values[0] * along_x + values[1] * along_y)
    if joint.kind == "fixed":
        return np.eye(4)
    turned = (
        matrix_of(values) if joint.kind == "ball" else rotation_about(joint.axis_C, float(values[0] - joint.reference))
    )
    return pose(turned, joint.anchor_C - turned @ joint.anchor_C)


def _across(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors normal to an axis; x and y where it is z."""
    x = np.array([1.0, 0.0, 0.0]) if abs(axis[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = x - (x @ axis) * axis
    x = x / np.linalg.norm(x)
    return x, np.cross(axis, x)


def _position(
    joint: DescribedJoint,
    by_name: Mapping[str, DescribedJoint],
    positions: Mapping[str, float | Sequence[float] | FloatArray],
) -> float | Sequence[float] | FloatArray | None:
    """A joint's own position, or through the joints that it mimics; None where none is given."""
    gain, offset, at = 1.0, 0.0, joint
    while at.name not in positions:
        if at.mimic is None:
            return None if at is joint else gain * at.reference + offset
        offset += gain * at.mimic.offset
        gain *= at.mimic.multiplier
        at = by_name[at.mimic.joint]
    if at is joint:
        return positions[joint.name]
    return gain * float(np.atleast_1d(positions[at.name])[0]) + offset
