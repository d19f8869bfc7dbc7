"""A parallel-jaw gripper on its mount as a robot description, which `formats.urdf` writes and every engine loads.

The mount is three slides along the axes of the world and a turn about an axis through the grip centre, the vertical
unless another is given, with a wrist that turns about the closing axis there for motions that need it, so that the
motion of the hand is prescribed and its contacts are not. Two fingers slide in the hand; the right one mimics the left,
for without that both drift to one side with the body between them. All joints are at 0 where the hand is at its grasp
and the pads are at their opening before they close; fingers close towards positive positions.
"""

from __future__ import annotations

import numpy as np

from geom.grasp.gripper import Gripper, boxes
from geom.pose import pose
from schemas.arrays import FloatArray
from schemas.robot_description import (
    DescribedJoint,
    DescribedLink,
    DescribedShape,
    Inertial,
    JointLimits,
    Mimic,
    RobotDescription,
)

MOUNT = ("mount_x", "mount_y", "mount_z", "mount_turn", "mount_wrist")  # the last one only where it turns
LEFT, RIGHT, HAND = "left_finger", "right_finger", "hand"
LINK_KG = 0.5  # each link: a hand of the size of the Franka Hand weighs 0.73 kg
_MOUNT_RADIUS_M = 0.05  # of the ball whose inertia a link of the mount has
_TRAVEL_M = 10.0  # of the mount
UP = np.array([0.0, 0.0, 1.0])


def mount_joints(turns_wrist: bool) -> tuple[str, ...]:
    """The names of the joints of the mount, in the order of the places of a `sim.grasp_trial.HandMotion`."""
    return MOUNT if turns_wrist else MOUNT[:-1]


def describe_gripper(
    gripper: Gripper,
    opening_m: float,
    R_WG: FloatArray,
    scale: float = 1.0,
    turn_axis_W: FloatArray = UP,
    *,
    turns_wrist: bool = False,
) -> RobotDescription:
    """The gripper, opened by `opening_m`, with its grip centre at the origin of the base and turned by R_WG (3, 3).

    The turn of its mount is about `turn_axis_W` (3,), a unit vector.

    All lengths are `scale` times their true size, forces scale^3 (`sim.port.model_scale`).
    """
    X_GB, half = boxes(gripper, np.array([opening_m]))
    left, right, hand = (scale * X_GB[0, b, :3, 3] for b in range(3))
    X_mount_hand = pose(R_WG, R_WG @ hand)
    links = [DescribedLink("base", inertial=_ball(scale), inertia_source="declared")]
    joints: list[DescribedJoint] = []
    for name, axis in zip(mount_joints(False), np.vstack([np.eye(3), turn_axis_W]), strict=True):
        links.append(DescribedLink(f"{name}_link", inertial=_ball(scale), inertia_source="declared"))
        limits = None if name == "mount_turn" else JointLimits(-_TRAVEL_M * scale, _TRAVEL_M * scale)
        kind = "continuous" if name == "mount_turn" else "prismatic"
        joints.append(
            DescribedJoint(name, kind, links[-2].name, links[-1].name, axis_C=axis, limits=limits, effort=1e9,
                           velocity=1e9)
        )  # fmt: skip
    if turns_wrist:
        links.append(DescribedLink(f"{MOUNT[-1]}_link", inertial=_ball(scale), inertia_source="declared"))
        joints.append(
            DescribedJoint(
                MOUNT[-1], "continuous", links[-2].name, links[-1].name, X_PC=pose(R_WG),
                axis_C=np.array([1.0, 0.0, 0.0]), effort=1e9, velocity=1e9,
            )
        )  # fmt: skip
        X_mount_hand = pose(None, hand)
    joints.append(DescribedJoint("wrist", "fixed", links[-1].name, HAND, X_PC=X_mount_hand))
    links.append(_box(HAND, scale * half[0, 2]))
    spare = 0.5 * scale * max(gripper.opening_m - opening_m, 0.0)
    limits = JointLimits(-spare, 0.5 * scale * opening_m)
    force, speed = gripper.force_n * scale**3, gripper.speed_mps * scale**0.5
    for name, at, direction in ((LEFT, left, 1.0), (RIGHT, right, -1.0)):
        links.append(_box(name, scale * half[0, 0]))
        joints.append(
            DescribedJoint(
                name, "prismatic", HAND, name, X_PC=pose(None, at - hand), axis_C=np.array([direction, 0.0, 0.0]),
                limits=limits, effort=force, velocity=speed, mimic=Mimic(LEFT) if name == RIGHT else None,
            )
        )  # fmt: skip
    return RobotDescription(
        name=f"{gripper.name}_gripper", format="urdf", links=tuple(links), joints=tuple(joints), root="base"
    )


def _ball(scale: float) -> Inertial:
    return Inertial(LINK_KG, np.eye(4), 0.4 * LINK_KG * (scale * _MOUNT_RADIUS_M) ** 2 * np.eye(3))


def _box(name: str, half_m: FloatArray) -> DescribedLink:
    x, y, z = (2.0 * half_m) ** 2
    inertia = LINK_KG / 12.0 * np.diag([y + z, x + z, x + y])
    size = tuple(float(2.0 * h) for h in half_m)
    shape = DescribedShape(name, "box", size, np.eye(4), collides=True, drawn=True)
    return DescribedLink(name, (shape,), Inertial(LINK_KG, np.eye(4), inertia), "declared")
