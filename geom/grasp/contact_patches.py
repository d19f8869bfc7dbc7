"""Contact patches of gripper pads on a body (metres), and the grip force (newtons) that holds its weight.

Howe and Cutkosky 1996, "Practical force-motion models for sliding manipulation": a patch of friction carries a force
and a moment about its normal as long as both together lie in an ellipsoid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geom.convex.convex_union import ConvexUnion
from geom.grasp.gripper import Gripper
from schemas.arrays import FloatArray

GIVES_M = 0.001  # Compliance of the rubber: points this far behind the first contact are still touched.
_PAD_GRID = 3  # points along an edge of a pad
LEAST_ARM_M = 0.001  # of friction about the normal: no contact is a point


@dataclass(frozen=True)
class ContactPatches:
    """For each grasp (k,): `share` of the smaller patch of its pad, `arm_m` of the friction of both pads about their
    normal (mean distance from the middle of the patch), and the middle of both patches (k, 3).
    """

    share: FloatArray
    arm_m: FloatArray
    middle_m: FloatArray


def contact_patches(union: ConvexUnion, X_AG: FloatArray, width_m: FloatArray, gripper: Gripper) -> ContactPatches:
    """Contact patches of pads in poses X_AG (k, 4, 4) on a body that is `width_m` (k,) wide between them."""
    steps = (np.arange(_PAD_GRID) + 0.5) / _PAD_GRID - 0.5
    y, z = (axis.ravel() for axis in np.meshgrid(gripper.pad_m[0] * steps, gripper.pad_m[1] * steps, indexing="ij"))
    share, arm, middle = np.full(len(X_AG), np.inf), np.zeros(len(X_AG)), np.zeros((len(X_AG), 3))
    for side in (-1.0, 1.0):
        away = 0.5 * width_m + gripper.spare_m
        starts_G = np.stack(np.broadcast_arrays(side * away[:, None], y, z), axis=2)  # (k, p, 3)
        starts = np.einsum("kij,kpj->kpi", X_AG[:, :3, :3], starts_G) + X_AG[:, None, :3, 3]
        inward = np.repeat(-side * X_AG[:, :3, 0], len(y), axis=0)
        depth = union.first_entry(starts.reshape(-1, 3), inward).reshape(len(X_AG), len(y))
        touched = depth <= depth.min(axis=1, keepdims=True) + GIVES_M
        weight = touched / touched.sum(axis=1, keepdims=True)
        centre = np.stack([weight @ y, weight @ z], axis=1)  # (k, 2) in the pad
        distance = np.hypot(y - centre[:, :1], z - centre[:, 1:])
        share = np.minimum(share, touched.mean(axis=1))
        arm += 0.5 * np.maximum((weight * distance).sum(axis=1), LEAST_ARM_M)
        middle += 0.5 * np.einsum("kij,kj->ki", X_AG[:, :3, 1:3], centre)
    return ContactPatches(share, arm, X_AG[:, :3, 3] + middle)


def holding_force(
    weight_n: float, lever_m: FloatArray, arm_m: FloatArray, angle_rad: FloatArray, friction: float
) -> FloatArray:
    """Force (k,) in newtons with which each of two pads just holds a weight at `lever_m` (k,) from their line.

    The weight acts along the pads and as a moment about their normal. A grip force along a line at `angle_rad` to a
    normal uses up part of the friction itself.
    """
    left = np.sqrt(np.maximum(friction**2 - np.tan(angle_rad) ** 2, (0.1 * friction) ** 2))
    return weight_n / (2.0 * left) * np.hypot(1.0, lever_m / arm_m)
