"""The swept volume of each joint of an articulated object, from the collision shapes of its links.

What the links that a joint moves may occupy at any position within its limits, the other joints at rest; joints that
follow it move with it. Asset frame at rest, metres.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from assetkit.affordances.anchors import anchor_polygon
from geom.articulation.swept_prisms import Sweep, swept_prisms
from geom.convex.circumscribed_hull import circumscribed_hull
from geom.mechanism_pose import joint_positions, link_motions, movable_joints
from schemas.arrays import FloatArray
from schemas.articulation import JointUse, SweptPrism, SweptVolume
from schemas.mechanism import Mechanism, MechanismJoint
from schemas.physics import CollisionShape

_SAME_POSITION = 1e-9  # rad or m


def swept_volumes(mechanism: Mechanism, shapes: Mapping[str, Sequence[CollisionShape]]) -> dict[str, SweptVolume]:
    """Swept volume by joint that moves on its own, from the collision shapes of each link by name."""
    volumes: dict[str, SweptVolume] = {}
    for joint in movable_joints(mechanism):
        sweeps = [
            sweep
            for link in mechanism.links
            if shapes.get(link.name)
            for sweep in _sweeps(mechanism, joint, link.name, shapes[link.name])
        ]
        prisms, volume_m3 = swept_prisms(sweeps)
        if prisms:
            volumes[joint.name] = SweptVolume(
                prisms=tuple(
                    SweptPrism(polygon=anchor_polygon(p.polygon), low_m=p.low_m, high_m=p.high_m) for p in prisms
                ),
                volume_m3=volume_m3,
            )
    return volumes


def with_swept_volumes(uses: Sequence[JointUse], swept: Mapping[str, SweptVolume]) -> tuple[JointUse, ...]:
    """The uses of joints with the swept volume of each."""
    return tuple(use.model_copy(update={"swept": swept.get(use.joint)}) for use in uses)


def _sweeps(mechanism: Mechanism, joint: MechanismJoint, link: str, shapes: Sequence[CollisionShape]) -> list[Sweep]:
    """The motions of the shapes of one link under a joint; none where it stays."""
    limits = joint.limits or (joint.rest, joint.rest + 2.0 * math.pi)
    rates = _rates(mechanism, joint, limits)
    chain = [j for j in _chain(mechanism, link) if rates[j.name] != 0.0]
    if not chain:
        return []

    def motion(position: float) -> FloatArray:
        return link_motions(mechanism, {joint.name: position})[link]

    bodies = [circumscribed_hull(shape) for shape in shapes]
    if chain == [joint] and not _displaced(mechanism, joint):
        turn = (joint.axis, joint.anchor) if joint.is_angular else (None, None)
        return [Sweep(body, motion, limits, *turn) for body in bodies]
    return [Sweep(body, motion, limits, exact=False, speed=_fastest(body, chain, rates, limits)) for body in bodies]


def _chain(mechanism: Mechanism, link: str) -> list[MechanismJoint]:
    """The joints from the root to a link."""
    carrier = {joint.child: joint for joint in mechanism.tree}
    joints: list[MechanismJoint] = []
    while (joint := carrier.get(link)) is not None:
        joints.append(joint)
        link = joint.parent
    return joints[::-1]


def _rates(mechanism: Mechanism, joint: MechanismJoint, limits: tuple[float, float]) -> dict[str, float]:
    """How fast each joint moves by name, per unit of `joint`: couplings are linear."""
    low, high = (joint_positions(mechanism, {joint.name: q}) for q in limits)
    span = max(limits[1] - limits[0], 1e-300)
    return {name: (high[name] - low[name]) / span for name in low}


def _displaced(mechanism: Mechanism, joint: MechanismJoint) -> bool:
    """Whether joints that follow others stand elsewhere than at rest, so that axes lie elsewhere than in the record."""
    at_rest = joint_positions(mechanism, {joint.name: joint.rest})
    return any(abs(at_rest[j.name] - j.rest) > _SAME_POSITION for j in mechanism.tree)


def _fastest(
    body: FloatArray, chain: Sequence[MechanismJoint], rates: Mapping[str, float], limits: tuple[float, float]
) -> float:
    """A bound (m per unit) on the speed of the corners (n, 3) of a body at the end of a chain of moving joints.

    A turn moves a point at most by its distance from the axis; that is at most the length of the line from anchor to
    anchor to the point, whose pieces are rigid but for what slides add.
    """
    reach, bound = 0.0, 0.0
    ends = [*chain[1:], None]
    for joint, following in reversed(list(zip(chain, ends, strict=True))):
        if following is None:
            reach = float(np.linalg.norm(body - joint.anchor, axis=1).max())
        else:
            reach += float(np.linalg.norm(following.anchor - joint.anchor))
        if joint.is_angular:
            bound += abs(rates[joint.name]) * reach
        else:
            bound += abs(rates[joint.name])
            reach += abs(rates[joint.name]) * (limits[1] - limits[0])
    return bound
