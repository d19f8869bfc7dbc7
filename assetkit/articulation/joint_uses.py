"""The uses of all joints of an articulated object: group, opening sense and contact, from surfaces and names.

Everything in the asset frame at rest, metres and radians. Swept volumes follow when collision shapes are known
(`assetkit.articulation.swept_volumes`).
"""

from __future__ import annotations

from dataclasses import dataclass

from assetkit.articulation.contact import MovedLink, find_contact
from assetkit.articulation.ends_of_use import find_ends
from assetkit.articulation.group_by_shape import read_shape
from assetkit.articulation.group_by_words import read_words
from assetkit.articulation.interaction_group import decide_group, task_of
from assetkit.articulation.joint_view import JointView, joint_views
from assetkit.stage import LinkSurface
from geom.articulation.closed_position import closed_position
from schemas.articulation import JointUse
from schemas.evidence import Evidence
from schemas.mechanism import Mechanism
from schemas.model import Mesh
from schemas.parts import Part


@dataclass(frozen=True)
class ArticulatedObject:
    """What the uses of joints are read from: mechanism, surfaces of its links, visible meshes, parts, and the usual
    group of things of its category, if known.
    """

    mechanism: Mechanism
    links: tuple[LinkSurface, ...]
    meshes: tuple[Mesh, ...] = ()
    parts: tuple[Evidence[Part], ...] = ()
    usual_group: Evidence[str] | None = None


def joint_uses(item: ArticulatedObject) -> tuple[JointUse, ...]:
    """The use of each joint that moves on its own, in the order of the mechanism."""
    return tuple(_use(item, view) for view in joint_views(item.mechanism, item.links))


def _use(item: ArticulatedObject, view: JointView) -> JointUse:
    joint = view.joint
    link = next(link for link in item.mechanism.links if link.name == joint.child)
    shut = None
    if not view.is_endless:
        shut = closed_position(view.moved.points, view.fixed, view.motion, view.limits, joint.rest)
    group = decide_group(read_shape(view, shut), read_words(joint, link), item.usual_group, joint.kind)
    ends = find_ends(view, group.value, shut)
    sense = 1 if ends.open.value >= ends.closed.value else -1
    moved = MovedLink(
        joint.child,
        next(s.solid for s in item.links if s.link == joint.child),
        tuple(m for m in item.meshes if m.link == joint.child and len(m.triangles)),
        tuple(p for p in item.parts if p.value.link == joint.child),
    )
    return JointUse(
        joint=joint.name,
        group=group,
        task=task_of(group.value, angular=joint.is_angular),
        closed=ends.closed,
        open=ends.open,
        contact=find_contact(view, moved, group.value, sense),
    )
