"""Poses of links at joint positions by the joint frames of a USD stage alone, without an engine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from geom.pose import inverse, matrix_of, pose, rotation_about
from schemas.arrays import FloatArray

AXES = {"X": np.eye(3)[0], "Y": np.eye(3)[1], "Z": np.eye(3)[2]}
Positions = Mapping[str, float]
Poses = dict[str, FloatArray]


class UsdJoint(NamedTuple):
    """A joint as UsdPhysics has it: its frame in either body, and its axis in that frame."""

    name: str
    parent: str
    child: str
    X_PJ: FloatArray
    X_CJ: FloatArray
    axis: FloatArray
    slides: bool


def moving_joints(stage: Usd.Stage) -> list[Usd.Prim]:
    """The hinges and slides of a stage that make up its tree."""
    joints = [p for p in stage.Traverse() if p.IsA(UsdPhysics.RevoluteJoint) or p.IsA(UsdPhysics.PrismaticJoint)]
    return [p for p in joints if not UsdPhysics.Joint(p).GetExcludeFromArticulationAttr().Get()]


def stage_poses(file: Path, root: str) -> Callable[[Positions], Poses]:
    """By the frames and axes of UsdPhysics joints alone, as the file has them; bodies by the names of their prims.

    `root` stays where it is; joints may lead to it or away from it. Those without a position close loops.
    """
    stage = Usd.Stage.Open(str(file))
    cache = UsdGeom.XformCache()

    def end(prim: Usd.Prim, side: int) -> tuple[str, FloatArray, FloatArray]:
        """Name and world transform of a body, and the joint's frame in it; only the position takes its scale."""
        (target,) = prim.GetRelationship(f"physics:body{side}").GetTargets()
        X_WB = np.array(cache.GetLocalToWorldTransform(stage.GetPrimAtPath(target))).T
        quat = prim.GetAttribute(f"physics:localRot{side}").Get()
        position = np.array(prim.GetAttribute(f"physics:localPos{side}").Get(), dtype=np.float64)
        scale = np.linalg.norm(X_WB[:3, :3], axis=0)
        X_BJ = pose(matrix_of(np.array([quat.GetReal(), *quat.GetImaginary()])), position * scale)
        return target.name, pose(X_WB[:3, :3] / scale, X_WB[:3, 3]), X_BJ

    joints: list[UsdJoint] = []
    rest: Poses = {}
    for prim in moving_joints(stage):
        (parent, X_WP, X_PJ), (child, X_WC, X_CJ) = end(prim, 0), end(prim, 1)
        rest |= {parent: X_WP, child: X_WC}
        axis, slides = AXES[prim.GetAttribute("physics:axis").Get()], prim.IsA(UsdPhysics.PrismaticJoint)
        joints.append(UsdJoint(prim.GetName(), parent, child, X_PJ, X_CJ, axis, slides))

    def poses(state: Positions) -> Poses:
        X_WL = {root: rest[root]}
        waiting = [joint for joint in joints if joint.name in state]
        while waiting:
            joint = waiting.pop(0)
            q = state[joint.name]
            moved = pose(None, q * joint.axis) if joint.slides else pose(rotation_about(joint.axis, q))
            X_PC = joint.X_PJ @ moved @ inverse(joint.X_CJ)
            if joint.parent in X_WL:
                X_WL[joint.child] = X_WL[joint.parent] @ X_PC
            elif joint.child in X_WL:
                X_WL[joint.parent] = X_WL[joint.child] @ inverse(X_PC)
            else:
                waiting.append(joint)
        return X_WL

    return poses
