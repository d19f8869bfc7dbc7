"""Reads joint prims (UsdPhysics) into `Joint`, lengths in metres, angles in degrees."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pxr import Usd, UsdPhysics

from gate.subject.body import Body
from gate.subject.frames import Frames
from gate.subject.joint import Joint, JointSide
from gate.subject.values import authored, flag, number, quaternion, text, vector
from geom.pose import matrix_of
from schemas.arrays import FloatArray

_KINDS = {
    "PhysicsRevoluteJoint": "revolute",
    "PhysicsPrismaticJoint": "prismatic",
    "PhysicsSphericalJoint": "spherical",
    "PhysicsFixedJoint": "fixed",
    "PhysicsDistanceJoint": "distance",
}
_LEAST_QUATERNION = 1e-3  # Anything shorter is no rotation; reported by the joint-axis rule.


def is_joint(prim: Usd.Prim) -> bool:
    """True for every type that derives from PhysicsJoint."""
    return prim.IsA(UsdPhysics.Joint)


def read_joint(prim: Usd.Prim, frames: Frames, body_of: Callable[[Any], Body | None]) -> Joint:
    """The joint as the file states it; nothing is repaired. Lengths in metres, angles in degrees."""
    kind = _KINDS.get(str(prim.GetTypeName()), "generic")
    length = frames.meters_per_unit if kind == "prismatic" else 1.0
    lower, upper = number(prim, "physics:lowerLimit", -np.inf), number(prim, "physics:upperLimit", np.inf)
    return Joint(
        prim,
        kind,
        flag(prim, "physics:jointEnabled", fallback=True),
        text(prim, "physics:axis", "X"),
        (_side(prim, 0, frames, body_of), _side(prim, 1, frames, body_of)),
        (lower * length, upper * length),
        (authored(prim, "physics:lowerLimit"), authored(prim, "physics:upperLimit")),
        flag(prim, "physics:collisionEnabled", fallback=False),
        not flag(prim, "physics:excludeFromArticulation", fallback=False),
    )


def _side(prim: Usd.Prim, index: int, frames: Frames, body_of: Callable[[Any], Body | None]) -> JointSide:
    relationship = prim.GetRelationship(f"physics:body{index}")
    targets = tuple(str(t) for t in relationship.GetForwardedTargets()) if relationship else ()
    target = prim.GetStage().GetPrimAtPath(targets[0]) if targets else None
    named = target if target is not None and target.IsValid() else None
    position = vector(prim, f"physics:localPos{index}", (0.0, 0.0, 0.0))
    quat_wxyz = quaternion(prim, f"physics:localRot{index}")
    return JointSide(
        targets, named, None if named is None else body_of(named), _pose(named, position, quat_wxyz, frames)
    )


def _pose(prim: Usd.Prim | None, position: FloatArray, quat_wxyz: FloatArray, frames: Frames) -> FloatArray:
    """(4, 4) the joint frame in the world. The local position is scaled by the prim it is given in, the local
    rotation is not (UsdPhysicsJoint).
    """
    if not (np.all(np.isfinite(quat_wxyz)) and np.linalg.norm(quat_wxyz) > _LEAST_QUATERNION):
        return np.full((4, 4), np.nan)
    X_WJ = np.eye(4)
    if prim is None:
        X_WJ[:3, 3] = position * frames.meters_per_unit
        X_WJ[:3, :3] = matrix_of(quat_wxyz)
        return X_WJ
    matrix = frames.matrix(prim)
    X_WJ[:3, 3] = matrix[:3, :3] @ position + matrix[:3, 3]
    X_WJ[:3, :3] = frames.rigid(prim)[0][:3, :3] @ matrix_of(quat_wxyz)
    return X_WJ
