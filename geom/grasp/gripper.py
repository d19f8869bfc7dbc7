"""Parallel-jaw grippers of three sizes, each as three boxes (metres): for collision tests and for trials.

Frame G: origin between the pads, +z along the approach, x the closing axis.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from geom.pose import pose
from schemas.affordances import GripperSize
from schemas.arrays import FloatArray


@dataclass(frozen=True)
class Gripper:
    """Sizes in metres, force of each pad in newtons; by default about those of the Franka Hand (80 mm, 70 N).

    pad_m     width (y) and height (z) of a pad, which is as wide as its finger; the fingers end with the pads.
    palm_to_pad_m  from the hand to the middle of the pads; hand_m the box of hand and wrist (x, y, z).
    spare_m   clearance of each pad before it closes, where the opening allows; at least `least_m`.
    speed_mps of each finger.
    """

    name: GripperSize = "medium"
    opening_m: float = 0.08
    pad_m: tuple[float, float] = (0.02, 0.02)
    finger_m: float = 0.012
    palm_to_pad_m: float = 0.045
    hand_m: tuple[float, float, float] = (0.2, 0.064, 0.1)
    spare_m: float = 0.005
    least_m: float = 0.002
    force_n: float = 70.0
    speed_mps: float = 0.05

    def widest_m(self) -> float:
        """The largest width that it can grasp, in metres."""
        return self.opening_m - 2.0 * self.least_m

    def open_for(self, width_m: FloatArray) -> FloatArray:
        """Openings (k,) in metres before the pads close on widths (k,)."""
        return np.minimum(width_m + 2.0 * self.spare_m, self.opening_m)


# By opening. Strokes, forces and speeds are about those of Robotiq's Hand-E and 2F-140 beside the Franka Hand.
SMALL = Gripper(
    "small",
    opening_m=0.05,
    pad_m=(0.02, 0.016),
    finger_m=0.01,
    palm_to_pad_m=0.035,
    hand_m=(0.12, 0.06, 0.1),
    force_n=60.0,
)
MEDIUM = Gripper()
LARGE = Gripper(
    "large",
    opening_m=0.14,
    pad_m=(0.025, 0.03),
    finger_m=0.014,
    palm_to_pad_m=0.07,
    hand_m=(0.26, 0.08, 0.12),
    force_n=125.0,
    speed_mps=0.1,
)
GRIPPERS: Mapping[GripperSize, Gripper] = {gripper.name: gripper for gripper in (SMALL, MEDIUM, LARGE)}


def boxes(gripper: Gripper, opening_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses X_GB (k, 3, 4, 4) and half edges (k, 3, 3) of left finger, right finger and hand for openings (k,)."""
    tip, root = 0.5 * gripper.pad_m[1], -gripper.palm_to_pad_m
    finger = 0.5 * np.array([gripper.finger_m, gripper.pad_m[0], tip - root])
    half = np.stack([finger, finger, 0.5 * np.array(gripper.hand_m)])
    X_GB = np.tile(pose(), (len(opening_m), 3, 1, 1))
    side = 0.5 * (opening_m + gripper.finger_m)
    X_GB[:, 0, 0, 3], X_GB[:, 1, 0, 3] = -side, side
    X_GB[:, :2, 2, 3] = 0.5 * (tip + root)
    X_GB[:, 2, 2, 3] = root - half[2, 2]
    return X_GB, np.broadcast_to(half, (len(opening_m), 3, 3))


def lowest(X_AB: FloatArray, half_m: FloatArray, up_A: FloatArray) -> FloatArray:
    """Lowest coordinate (k,) along `up_A` (3,) of boxes with poses (k, b, 4, 4) and half edges (k, b, 3)."""
    centres = X_AB[..., :3, 3] @ up_A
    half_extent = (np.abs(np.einsum("i,kbij->kbj", up_A, X_AB[..., :3, :3])) * half_m).sum(axis=2)
    return (centres - half_extent).min(axis=1)
