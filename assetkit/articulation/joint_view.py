"""One joint with the surfaces that its use is read from: the moved link, what it carries, and what stays.

From a mechanism and the surfaces of its links, in the asset frame at rest (metres).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.stage import LinkSurface
from geom.articulation.moved_shape import MovedShape, moved_shape, surface_points
from geom.mechanism_pose import joint_motion, movable_joints
from schemas.arrays import FloatArray
from schemas.mechanism import Mechanism, MechanismJoint


@dataclass(frozen=True)
class JointView:
    """A joint that moves on its own.

    limits     least and greatest position; rest and one turn where it has none.
    moved      the link that it carries, about its axis at rest.
    parent     (p, 3) surface samples of the link that it is fixed to.
    fixed      (f, 3) those of all links that it does not move.
    carried    diagonal of the links that move on the moved one, as a share of that of the moved one.
    depth      number of joints between the root and it; `chain` the most joints in a row through it.
    in_loop    whether it is part of a kinematic loop.
    """

    joint: MechanismJoint
    limits: tuple[float, float]
    moved: MovedShape
    parent: FloatArray
    fixed: FloatArray
    carried: float
    depth: int
    chain: int
    in_loop: bool

    @property
    def span(self) -> float:
        """The whole range of its position (rad or m)."""
        return self.limits[1] - self.limits[0]

    @property
    def is_endless(self) -> bool:
        """Whether it has no limits."""
        return self.joint.limits is None

    def motion(self, position: float) -> FloatArray:
        """(4, 4) what the joint does to points at rest when it is at `position`."""
        return joint_motion(self.joint, position - self.joint.rest)


def joint_views(mechanism: Mechanism, links: Sequence[LinkSurface]) -> tuple[JointView, ...]:
    """The joints of a mechanism that move on their own, in its order; `links` are the surfaces of its links."""
    samples = {s.link: surface_points(s.solid) for s in links}
    corners = {s.link: s.solid.points[np.unique(s.solid.triangles)] for s in links}
    carrier = {joint.child: joint for joint in mechanism.tree}
    below = {link.name: _below(mechanism, link.name) for link in mechanism.links}
    loops = _in_loops(mechanism, carrier)
    views: list[JointView] = []
    for joint in movable_joints(mechanism):
        subtree = {joint.child, *below[joint.child]}
        fixed = [samples[link.name] for link in mechanism.links if link.name not in subtree]
        moved = moved_shape(samples[joint.child], corners[joint.child], joint.anchor, joint.axis)
        on_it = [corners[name] for name in below[joint.child]]
        above = _above(carrier, joint.child)
        views.append(
            JointView(
                joint=joint,
                limits=joint.limits or (joint.rest, joint.rest + 2.0 * math.pi),
                moved=moved,
                parent=samples[joint.parent],
                fixed=np.concatenate(fixed),
                carried=_diagonal(np.concatenate(on_it)) / moved.diagonal_m if on_it else 0.0,
                depth=len(above) - 1,
                chain=len(above) + _deepest(mechanism, joint.child),
                in_loop=joint.name in loops,
            )
        )
    return tuple(views)


def _below(mechanism: Mechanism, link: str) -> tuple[str, ...]:
    """The links that move on a link."""
    children = [joint.child for joint in mechanism.tree if joint.parent == link]
    return tuple(name for child in children for name in (child, *_below(mechanism, child)))


def _above(carrier: Mapping[str, MechanismJoint], link: str) -> list[MechanismJoint]:
    """The joints from a link up to the root."""
    joints: list[MechanismJoint] = []
    while (joint := carrier.get(link)) is not None:
        joints.append(joint)
        link = joint.parent
    return joints


def _deepest(mechanism: Mechanism, link: str) -> int:
    """The most joints in a row below a link."""
    return max((1 + _deepest(mechanism, j.child) for j in mechanism.tree if j.parent == link), default=0)


def _in_loops(mechanism: Mechanism, carrier: Mapping[str, MechanismJoint]) -> frozenset[str]:
    """Joints of the tree that lie on a loop: between the two links of a closing joint."""
    names = set[str]()
    for joint in mechanism.joints:
        if joint.closes_loop:
            one, other = ({j.name for j in _above(carrier, link)} for link in (joint.parent, joint.child))
            names |= one ^ other
    return frozenset(names)


def _diagonal(points: FloatArray) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))
