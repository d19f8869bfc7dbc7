"""Authors the joints of an articulated package (UsdPhysics): `<root>/Joints/<name>`, angles in degrees.

Drives hold damping and springs per degree. What UsdPhysics has no attribute for is written for the engines that read
it: dry friction, armature and couplings in the names of Newton's schemas, speed limits in those of PhysX.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from geom.pose import quat_of, rotation_about, shortest_rotation
from schemas.arrays import FloatArray
from schemas.mechanism import Mechanism, MechanismJoint
from usdio.joint_frames import AXES
from usdio.joint_names import ARMATURE, FRICTION, LEADER, MULTIPLIER, OFFSET, SPEED

JOINTS = "Joints"
_SCHEMAS = {
    "revolute": UsdPhysics.RevoluteJoint,
    "continuous": UsdPhysics.RevoluteJoint,
    "prismatic": UsdPhysics.PrismaticJoint,
    "ball": UsdPhysics.SphericalJoint,
}


def author_joints(stage: Usd.Stage, root: Sdf.Path, mechanism: Mechanism) -> None:
    """Define every joint; the bodies are the children of `root` by the names of their links, posed at rest.

    Both frames of a joint coincide with its axis; their relative position is the joint's at rest.
    """
    scope = UsdGeom.Scope.Define(stage, root.AppendChild(JOINTS)).GetPath()
    origins = {link.name: link.origin for link in mechanism.links}
    by_name = {joint.name: joint for joint in mechanism.joints}
    for joint in mechanism.joints:
        prim = _SCHEMAS[joint.kind].Define(stage, scope.AppendChild(joint.name))
        prim.CreateBody0Rel().SetTargets([root.AppendChild(joint.parent)])
        prim.CreateBody1Rel().SetTargets([root.AppendChild(joint.child)])
        prim.CreateCollisionEnabledAttr(False)
        if joint.closes_loop:
            prim.CreateExcludeFromArticulationAttr(True)
        _frames(prim, joint, origins)
        _limits(prim, joint)
        _drive(prim.GetPrim(), joint)
        _extras(prim.GetPrim(), joint, scope, by_name)
        prim.GetPrim().SetCustomDataByKey("mana:sourceName", joint.source_name or joint.name)


def author_filtered_pairs(stage: Usd.Stage, root: Sdf.Path, pairs: Sequence[tuple[str, str]]) -> None:
    """Switch off contacts between links, by the first of each pair."""
    for first in dict.fromkeys(first for first, _ in pairs):
        api = UsdPhysics.FilteredPairsAPI.Apply(UsdGeom.Xform.Define(stage, root.AppendChild(first)).GetPrim())
        targets = [root.AppendChild(second) for other, second in pairs if other == first]
        api.CreateFilteredPairsRel().SetTargets(targets)


def _frames(prim: UsdPhysics.Joint, joint: MechanismJoint, origins: dict[str, FloatArray]) -> None:
    token = next((t for t, axis in AXES.items() if np.allclose(joint.axis, axis, atol=1e-9)), "Z")
    R = np.eye(3) if np.allclose(joint.axis, AXES[token], atol=1e-9) else shortest_rotation(AXES[token], joint.axis)
    if joint.kind != "ball":
        prim.CreateAxisAttr(token)
    turned = rotation_about(AXES[token], -joint.rest) if joint.is_angular and joint.kind != "ball" else np.eye(3)
    slid = joint.rest * joint.axis if joint.kind == "prismatic" else np.zeros(3)
    prim.CreateLocalPos0Attr(_vector(joint.anchor - slid - origins[joint.parent]))
    prim.CreateLocalRot0Attr(_quaternion(R @ turned))
    prim.CreateLocalPos1Attr(_vector(joint.anchor - origins[joint.child]))
    prim.CreateLocalRot1Attr(_quaternion(R))


def _limits(prim: UsdPhysics.Joint, joint: MechanismJoint) -> None:
    """Limits in degrees or metres; a ball joint's upper limit is the angle of its cone."""
    if joint.kind == "ball":
        if joint.limits is not None:
            for attribute in (prim.CreateConeAngle0LimitAttr(), prim.CreateConeAngle1LimitAttr()):
                attribute.Set(math.degrees(joint.limits[1]))
        return
    lower, upper = joint.limits if joint.limits is not None else (-math.inf, math.inf)
    prim.CreateLowerLimitAttr(_in_usd(joint, lower))
    prim.CreateUpperLimitAttr(_in_usd(joint, upper))


def _drive(prim: Usd.Prim, joint: MechanismJoint) -> None:
    """A drive where the source states damping, a spring or a largest effort; it has no target but the spring's."""
    if joint.kind == "ball" or not (joint.damping or joint.stiffness or joint.effort):
        return
    per_unit = math.radians(1.0) if joint.is_angular else 1.0
    drive = UsdPhysics.DriveAPI.Apply(prim, "angular" if joint.is_angular else "linear")
    drive.CreateTypeAttr("force")
    drive.CreateStiffnessAttr(joint.stiffness * per_unit)
    drive.CreateDampingAttr(joint.damping * per_unit)
    if joint.effort:
        drive.CreateMaxForceAttr(joint.effort)
    drive.CreateTargetPositionAttr(_in_usd(joint, joint.spring_rest))
    drive.CreateTargetVelocityAttr(0.0)


def _extras(prim: Usd.Prim, joint: MechanismJoint, scope: Sdf.Path, by_name: dict[str, MechanismJoint]) -> None:
    numbers = {
        FRICTION: joint.friction or None,
        ARMATURE: joint.armature or None,
        SPEED: None if joint.velocity is None else _in_usd(joint, joint.velocity),
    }
    for name, value in numbers.items():
        if value is not None:
            prim.CreateAttribute(name, Sdf.ValueTypeNames.Float, custom=False).Set(value)
    if joint.coupling is not None:
        leader = by_name[joint.coupling.joint]
        factor = _in_usd(joint, 1.0) / _in_usd(leader, 1.0)
        prim.CreateRelationship(LEADER, custom=False).SetTargets([scope.AppendChild(leader.name)])
        prim.CreateAttribute(OFFSET, Sdf.ValueTypeNames.Float, custom=False).Set(_in_usd(joint, joint.coupling.offset))
        prim.CreateAttribute(MULTIPLIER, Sdf.ValueTypeNames.Float, custom=False).Set(joint.coupling.multiplier * factor)


def _in_usd(joint: MechanismJoint, value: float) -> float:
    """A position or speed of the joint in USD's unit: degrees for angles."""
    return math.degrees(value) if joint.is_angular else value


def _vector(values: FloatArray) -> Gf.Vec3f:
    return Gf.Vec3f(*(float(v) for v in values))


def _quaternion(R: FloatArray) -> Gf.Quatf:
    return Gf.Quatf(*(float(v) for v in quat_of(R)))
