"""Reads links and joints of an articulated package back from disk: bodies in their frames, the mechanism at rest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from geom.pose import inverse, matrix_of, pose
from schemas.arrays import FloatArray
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.mechanism import JointCoupling, Mechanism, MechanismJoint, MechanismJointKind, MechanismLink
from usdio.joint_frames import AXES, joint_position
from usdio.joint_names import ARMATURE, FRICTION, LEADER, MULTIPLIER, OFFSET, SPEED

_KINDS: dict[str, MechanismJointKind] = {
    "PhysicsRevoluteJoint": "revolute",
    "PhysicsPrismaticJoint": "prismatic",
    "PhysicsSphericalJoint": "ball",
}


def reread_mechanism(stage: Usd.Stage, bodies: list[Usd.Prim], main_file: Path) -> Mechanism:
    """The mechanism of a package whose bodies are `bodies`; links in the order of the joint tree.

    Raises InvalidInput (`asset/package-invalid`) for joints that Mana does not write.
    """
    root = stage.GetDefaultPrim()
    frames = {prim.GetName(): _pose_in(prim, root) for prim in bodies}
    return mechanism_between(frames, [prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)], main_file)


def mechanism_between(
    frames: dict[str, FloatArray],
    prims: Sequence[Usd.Prim],
    main_file: Path,
    scales: Mapping[str, FloatArray] = MappingProxyType({}),
) -> Mechanism:
    """The mechanism of bodies whose frames (4, 4) are rigid in the asset frame, from the prims of its joints.

    `scales` (3,) along the axes of a body, by its name, count for where joints are on it. Raises as
    `reread_mechanism` does.
    """
    joints = tuple(_joint(prim, frames, scales, main_file) for prim in prims)
    carried = {joint.child for joint in joints if not joint.closes_loop}
    order = [name for name in frames if name not in carried]
    for name in order:  # Grows while it is walked.
        order += [j.child for j in joints if j.parent == name and not j.closes_loop and j.child not in order]
    if len(order) != len(frames):
        raise _invalid("links that no joint carries", main_file)
    return Mechanism(tuple(MechanismLink(name, frames[name][:3, 3]) for name in order), joints)


def filtered_pairs(bodies: list[Usd.Prim]) -> tuple[tuple[str, str], ...]:
    """Names of bodies that do not collide with each other (UsdPhysicsFilteredPairsAPI), in the order of `bodies`."""
    names = {prim.GetPath(): prim.GetName() for prim in bodies}
    relations = [(prim.GetName(), prim.GetRelationship("physics:filteredPairs")) for prim in bodies]
    return tuple(
        (first, names[target])
        for first, relation in relations
        if relation
        for target in relation.GetTargets()
        if target in names
    )


def _joint(
    prim: Usd.Prim, frames: dict[str, FloatArray], scales: Mapping[str, FloatArray], main_file: Path
) -> MechanismJoint:
    kind = _KINDS.get(str(prim.GetTypeName()))
    joint = UsdPhysics.Joint(prim)
    ends = [rel.GetTargets() for rel in (joint.GetBody0Rel(), joint.GetBody1Rel())]
    if kind is None or any(len(targets) != 1 or targets[0].name not in frames for targets in ends):
        raise _invalid("a joint of another kind, or without two links", main_file, prim)
    parent, child = (targets[0].name for targets in ends)
    X_A0 = frames[parent] @ _local(joint.GetLocalPos0Attr().Get(), joint.GetLocalRot0Attr().Get(), scales.get(parent))
    X_A1 = frames[child] @ _local(joint.GetLocalPos1Attr().Get(), joint.GetLocalRot1Attr().Get(), scales.get(child))
    axis = AXES[str(prim.GetAttribute("physics:axis").Get() or "X") if kind != "ball" else "Z"]
    limits = _limits(prim, kind)
    rest = joint_position(kind, axis, inverse(X_A0) @ X_A1, limits)
    if kind == "revolute" and limits is None:
        kind = "continuous"
    bare = MechanismJoint(
        prim.GetName(),
        kind,
        parent,
        child,
        X_A1[:3, 3],
        X_A1[:3, :3] @ axis,
        rest,
        limits,
        closes_loop=bool(joint.GetExcludeFromArticulationAttr().Get()),
        source_name=str(prim.GetCustomDataByKey("mana:sourceName") or prim.GetName()),
    )
    return _with_dynamics(bare, prim)


def _limits(prim: Usd.Prim, kind: MechanismJointKind) -> tuple[float, float] | None:
    """In rad or m, of ball joints (0, angle of the cone); None where the joint moves without end."""
    if kind == "ball":
        cone_deg = float(UsdPhysics.SphericalJoint(prim).GetConeAngle0LimitAttr().Get())
        return (0.0, math.radians(cone_deg)) if cone_deg >= 0.0 else None
    lower, upper = (float(prim.GetAttribute(f"physics:{n}Limit").Get()) for n in ("lower", "upper"))
    if not (math.isfinite(lower) and math.isfinite(upper)):
        return None
    return (lower, upper) if kind == "prismatic" else (math.radians(lower), math.radians(upper))


def _with_dynamics(joint: MechanismJoint, prim: Usd.Prim) -> MechanismJoint:
    per_unit = math.degrees(1.0) if joint.is_angular else 1.0  # of a number per degree, per radian
    name = "angular" if joint.is_angular else "linear"
    if prim.HasAPI(UsdPhysics.DriveAPI, name):
        drive = UsdPhysics.DriveAPI(prim, name)
        force = float(drive.GetMaxForceAttr().Get())
        joint = replace(
            joint,
            stiffness=float(drive.GetStiffnessAttr().Get()) * per_unit,
            damping=float(drive.GetDampingAttr().Get()) * per_unit,
            spring_rest=float(drive.GetTargetPositionAttr().Get()) / per_unit,
            effort=force if math.isfinite(force) else None,
        )
    numbers = {key: prim.GetAttribute(key).Get() for key in (FRICTION, ARMATURE, SPEED, OFFSET, MULTIPLIER)}
    leader = prim.GetRelationship(LEADER).GetTargets() if prim.HasRelationship(LEADER) else []
    coupling = None
    if leader:
        other = prim.GetStage().GetPrimAtPath(leader[0])
        leader_unit = 1.0 if other.GetTypeName() == "PhysicsPrismaticJoint" else math.degrees(1.0)
        multiplier = float(numbers[MULTIPLIER]) * leader_unit / per_unit
        coupling = JointCoupling(leader[0].name, multiplier, float(numbers[OFFSET]) / per_unit)
    return replace(
        joint,
        friction=float(numbers[FRICTION] or 0.0),
        armature=float(numbers[ARMATURE] or 0.0),
        velocity=None if numbers[SPEED] is None else float(numbers[SPEED]) / per_unit,
        coupling=coupling,
    )


def _local(position: Gf.Vec3f, rotation: Gf.Quatf, scale: FloatArray | None) -> FloatArray:
    quat_wxyz = np.array([rotation.GetReal(), *rotation.GetImaginary()], dtype=np.float64)
    at = np.array(position, dtype=np.float64)
    return pose(matrix_of(quat_wxyz), at if scale is None else at * scale)


def _pose_in(prim: Usd.Prim, ancestor: Usd.Prim) -> FloatArray:
    cache = UsdGeom.XformCache()
    to_world = cache.GetLocalToWorldTransform(prim)
    return np.array(to_world * cache.GetLocalToWorldTransform(ancestor).GetInverse()).T


def _invalid(content: str, main_file: Path, prim: Usd.Prim | None = None) -> InvalidInput:
    where = Location(file=main_file.name, prim=None if prim is None else str(prim.GetPath()))
    return InvalidInput(finding("asset/package-invalid", f"the package holds {content}", where=where))
