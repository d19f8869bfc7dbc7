"""What is tried on each joint of a package: where it is pushed, what is put into its link, how often it is moved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from assetkit.acceptance.joints.policy import POLICY
from geom.convex.support_function import surface
from geom.mechanism_pose import movable_joints
from geom.pose import pose
from schemas.anchors import Anchor
from schemas.arrays import FloatArray
from schemas.articulation import JointContact
from schemas.mechanism import Mechanism, MechanismJoint
from schemas.physics import CollisionShape, RigidBody
from sim.joint_exercise import ALL_RUNS, Actuation, Articulation, JointTask, Pace, moved_links

_QUICK: tuple[tuple[Actuation, Pace], ...] = (("drive", "slow"), ("push", "fast"))
_LEAST: tuple[tuple[Actuation, Pace], ...] = (("drive", "fast"),)
LEVEL_DEG = 10.0  # A probe stays in what slides level or turns about an upright axis.
# Edge of a cubic probe as a share of the widest ball that gets in and of the height: small beside its container, large
# beside the tolerances of an engine.
PROBE_OF_PASSING, PROBE_OF_HEIGHT = 0.25, 0.4


def joint_tasks(
    articulation: Articulation, contacts: Mapping[str, JointContact], anchors: Sequence[Anchor]
) -> tuple[JointTask, ...]:
    """A task per joint that moves on its own, at most `POLICY.most_joints`.

    `contacts` (by joint, asset frame) say where a hand pushes; else it pushes at the point of the link that is farthest
    from the axis. A link with a containment volume among `anchors` gets a probe.
    """
    joints = movable_joints(articulation.mechanism)
    count = len(joints)
    runs = ALL_RUNS if count <= POLICY.thorough_joints else _QUICK if count <= POLICY.quick_joints else _LEAST
    return tuple(
        JointTask(
            joint.name,
            _contact_point(articulation, joint, contacts.get(joint.name)),
            _probe(articulation.mechanism, joint, anchors),
            runs,
        )
        for joint in joints[: POLICY.most_joints]
    )


def farthest_point(articulation: Articulation, joint: MechanismJoint) -> FloatArray:
    """(3,) the point of the link of `joint` farthest from the axis; of a sliding joint the one that lies foremost."""
    points = link_points(articulation, joint.child)
    if not joint.is_angular:
        return points[int(np.argmax(points @ joint.axis))]
    return points[int(np.argmax(np.linalg.norm(np.cross(points - joint.anchor, joint.axis), axis=1)))]


def link_points(articulation: Articulation, link: str) -> FloatArray:
    """(n, 3) corners of the collision shapes of a link, in the asset frame at rest."""
    body, origin = body_of(articulation, link)
    return np.concatenate([np.zeros((0, 3)), *(surface(shape)[0] for shape in body.shapes)]) + origin


def body_of(articulation: Articulation, link: str) -> tuple[RigidBody, FloatArray]:
    """The body of a link, and (3,) the origin of its frame."""
    number = [one.name for one in articulation.mechanism.links].index(link)
    return articulation.links[number], articulation.mechanism.links[number].origin


def _contact_point(articulation: Articulation, joint: MechanismJoint, contact: JointContact | None) -> FloatArray:
    return farthest_point(articulation, joint) if contact is None else np.array(contact.position_m)


def _probe(mechanism: Mechanism, joint: MechanismJoint, anchors: Sequence[Anchor]) -> CollisionShape | None:
    """A cube on the floor of the largest volume in the moved links, if the motion keeps it level."""
    upright = abs(float(joint.axis[2]))
    tilt = np.sin(np.radians(LEVEL_DEG))
    keeps_level = upright < tilt if joint.kind == "prismatic" else upright > np.sqrt(1.0 - tilt**2)
    moved = moved_links(mechanism, (joint,))
    volumes = [anchor for anchor in anchors if anchor.kind == "volume" and anchor.link in moved]
    if not volumes or not keeps_level:
        return None
    volume = max(volumes, key=lambda v: v.volume_m3)
    edge = min(PROBE_OF_PASSING * volume.passes_m, PROBE_OF_HEIGHT * volume.height_m)
    x, y, z = volume.position_m
    return CollisionShape("box", (edge, edge, edge), pose(None, (x, y, z + 0.55 * edge)))
