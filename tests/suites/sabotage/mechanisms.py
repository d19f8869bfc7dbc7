"""Kinds of damage to articulated packages. Each function edits a victim and is False where there is nothing to damage.

Amounts are drawn by the victim's generator. Nothing of acceptance is imported here.
"""

from __future__ import annotations

import math

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from tests.suites.sabotage.package import Victim


def _joint(victim: Victim) -> Usd.Prim | None:
    """A joint that has a use on record, drawn at random; else any."""
    used = {use["joint"] for use in victim.record.get("joint_uses", [])}
    joints = [j for j in victim.joints if j.GetName() in used] or victim.joints
    return joints[int(victim.random.integers(len(joints)))] if joints else None


def limits_swapped(victim: Victim) -> bool:
    """The lower limit above the upper one."""
    joint = _joint(victim)
    if joint is None or _limits(joint) is None:
        return False
    low, high = joint.GetAttribute("physics:lowerLimit"), joint.GetAttribute("physics:upperLimit")
    least, most = low.Get(), high.Get()
    low.Set(most + 1e-3)
    high.Set(least)
    return True


def limits_widened(victim: Victim) -> bool:
    """Limits so wide that links run into each other."""
    joint = _joint(victim)
    if joint is None or (limits := _limits(joint)) is None:
        return False
    if joint.GetTypeName() == "PhysicsRevoluteJoint":
        spread = victim.random.uniform(300.0, 340.0)
        joint.GetAttribute("physics:lowerLimit").Set(limits[0] - spread)
        joint.GetAttribute("physics:upperLimit").Set(limits[1] + spread)
        return True
    spread = victim.random.uniform(1.0, 2.0) * victim.size_m
    joint.GetAttribute("physics:lowerLimit").Set(limits[0] - spread)
    return True


def axis_reversed(victim: Victim) -> bool:
    """The joint moves the other way: its frames turn by half a turn about an axis across."""
    joint = _joint(victim)
    if joint is None or _limits(joint) is None:
        return False
    _turn(joint, 180.0)
    return True


def axis_tilted(victim: Victim) -> bool:
    """The axis leans by 20 to 60 degrees."""
    joint = _joint(victim)
    if joint is None or _limits(joint) is None:
        return False
    _turn(joint, victim.random.uniform(20.0, 60.0))
    return True


def frames_apart(victim: Victim) -> bool:
    """The two frames of a joint do not meet at rest."""
    joint = _joint(victim)
    if joint is None:
        return False
    attribute = joint.GetAttribute("physics:localPos1")
    offset = victim.random.normal(size=3)
    offset *= victim.random.uniform(0.05, 0.2) * victim.size_m / np.linalg.norm(offset)
    attribute.Set(attribute.Get() + Gf.Vec3f(*offset.tolist()))
    return True


def link_blocked(victim: Victim) -> bool:
    """A block on the base in the way of the moved link."""
    joint = _joint(victim)
    if joint is None:
        return False
    moved = victim.moved(joint)
    if not victim.colliders_of(moved):
        return False
    base = victim.stage.GetPrimAtPath(UsdPhysics.Joint(joint).GetBody0Rel().GetTargets()[0])
    if not victim.colliders_of(base):
        return False
    points = np.concatenate([victim.points_of(c) for c in victim.colliders_of(moved)])
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    shift = _translation(moved) - _translation(base)
    edges = victim.random.uniform(0.3, 0.5) * np.maximum(np.ptp(points, axis=0), 0.02 * victim.size_m)
    victim.add_box(base, "block", middle + shift, edges)
    return True


def link_without_collider(victim: Victim) -> bool:
    """The moved link has no colliders."""
    joint = _joint(victim)
    if joint is None:
        return False
    colliders = victim.colliders_of(victim.moved(joint))
    for collider in colliders:
        victim.remove(collider)
    return bool(colliders)


def link_grown(victim: Victim) -> bool:
    """The colliders of the moved link are a third to two thirds larger."""
    joint = _joint(victim)
    if joint is None:
        return False
    colliders = victim.colliders_of(victim.moved(joint))
    factor = victim.random.uniform(1.35, 1.7)
    for collider in colliders:
        victim.transform(collider, np.zeros(3), factor)
    return bool(colliders)


def link_heavy(victim: Victim) -> bool:
    """The inertia of the moved link is that of millimetres taken for metres."""
    joint = _joint(victim)
    if joint is None:
        return False
    attribute = UsdPhysics.MassAPI(victim.moved(joint)).GetDiagonalInertiaAttr()
    attribute.Set(attribute.Get() * 10.0 ** victim.random.uniform(4.0, 6.0))
    return True


def handle_missing(victim: Victim) -> bool:
    """The colliders of a handle or knob are gone, if its link has others."""
    for use in victim.record.get("joint_uses", []):
        contact = (use.get("contact") or {"value": None})["value"]
        if contact is None or contact["kind"] == "edge":
            continue
        link = next(body for body in victim.bodies if body.GetName() == contact["link"])
        low, high = np.array(contact["low_m"]), np.array(contact["high_m"])
        slack = 0.1 * float(np.linalg.norm(high - low))
        colliders = victim.colliders_of(link)
        there = [victim.points_of(collider) + _translation(link) for collider in colliders]
        within = [bool(np.all(p >= low - slack) and np.all(p <= high + slack)) for p in there]
        if any(within) and not all(within):
            for collider in (c for c, inside in zip(colliders, within, strict=True) if inside):
                victim.remove(collider)
            return True
    return False


def contact_behind(victim: Victim) -> bool:
    """The place to take a joint by lies on the far side of the object, in the air."""
    uses = [use for use in victim.record.get("joint_uses", []) if use.get("contact")]
    for use in uses:
        contact = use["contact"]["value"]
        direction = np.array(contact["pull"], dtype=float)
        away = victim.random.uniform(1.2, 2.0) * victim.size_m
        position = np.array(contact["position_m"]) - away * direction
        contact["position_m"] = position.tolist()
    return bool(uses)


def root_missing(victim: Victim) -> bool:
    """The object has joints but is no articulation."""
    prims = [prim for prim in victim.stage.Traverse() if prim.HasAPI(UsdPhysics.ArticulationRootAPI)]
    for prim in prims:
        prim.RemoveAPI(UsdPhysics.ArticulationRootAPI)
    return bool(prims)


def drive_wild(victim: Victim) -> bool:
    """A drive with negative damping."""
    joint = _joint(victim)
    if joint is None:
        return False
    kind = "angular" if joint.GetTypeName() == "PhysicsRevoluteJoint" else "linear"
    drive = UsdPhysics.DriveAPI.Apply(joint, kind)
    drive.CreateDampingAttr(-victim.random.uniform(1.0, 100.0))
    return True


def limits_narrowed(victim: Victim) -> bool:
    """Limits that leave a tenth to a third of the way from rest to either end."""
    joint = _joint(victim)
    if joint is None or (limits := _limits(joint)) is None:
        return False
    share = victim.random.uniform(0.1, 0.33)
    joint.GetAttribute("physics:lowerLimit").Set(share * limits[0])
    joint.GetAttribute("physics:upperLimit").Set(share * limits[1])
    return limits[0] <= 0.0 <= limits[1]


def joint_jammed(victim: Victim) -> bool:
    """Damping so strong that no hand moves the joint."""
    joint = _joint(victim)
    if joint is None or _limits(joint) is None:
        return False
    is_angular = joint.GetTypeName() == "PhysicsRevoluteJoint"
    drive = UsdPhysics.DriveAPI.Apply(joint, "angular" if is_angular else "linear")
    drive.CreateDampingAttr(10.0 ** victim.random.uniform(4.0, 6.0))
    return True


def body_doubled(victim: Victim) -> bool:
    """A joint that connects a link with itself."""
    joint = _joint(victim)
    if joint is None:
        return False
    relationship = UsdPhysics.Joint(joint)
    relationship.GetBody0Rel().SetTargets(relationship.GetBody1Rel().GetTargets())
    return True


def _turn(joint: Usd.Prim, angle_deg: float) -> None:
    """Turn both frames of a joint about an axis across its own: the links stay where they are."""
    axis = joint.GetAttribute("physics:axis").Get()
    across = Gf.Vec3d(0, 0, 1) if axis == "X" else Gf.Vec3d(1, 0, 0)
    turn = Gf.Quatf(Gf.Rotation(across, angle_deg).GetQuat())
    for name in ("physics:localRot0", "physics:localRot1"):
        attribute = joint.GetAttribute(name)
        attribute.Set(attribute.Get() * turn)


def _limits(joint: Usd.Prim) -> tuple[float, float] | None:
    low, high = joint.GetAttribute("physics:lowerLimit").Get(), joint.GetAttribute("physics:upperLimit").Get()
    return (low, high) if low is not None and math.isfinite(low) and high is not None and math.isfinite(high) else None


def _translation(prim: Usd.Prim) -> np.ndarray:
    return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim).ExtractTranslation())
