"""Verdict on the joints of a package on disk: exercised in simulation, and compared with both twins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import networkx as nx
import numpy as np

from assetkit.acceptance.body_checks import distance_outside
from assetkit.acceptance.joints.checks import (
    NOT_FINITE,
    JointSubject,
    JudgedJoint,
    joined,
    judge_contact,
    judge_damping,
    judge_joint,
)
from assetkit.acceptance.joints.policy import POLICY
from assetkit.acceptance.joints.tasks import body_of, joint_tasks, link_points
from assetkit.acceptance.joints.twins import check_twins
from assetkit.geometry.joint_damping import damping_force_n
from schemas.acceptance import Check
from schemas.anchors import Anchor
from schemas.articulation import JointContact
from schemas.diagnostics import Diagnostic, finding
from schemas.mechanism import Mechanism, MechanismJoint
from sim.joint_exercise import Articulation, LinkOverlap
from sim.port import Simulator
from usdio.reread.body import RereadPackage


def judge_joints(
    main_file: Path,
    content: RereadPackage,
    simulator: Simulator,
    *,
    declared: Mechanism,
    contacts: Mapping[str, JointContact] | None = None,
    anchors: Sequence[Anchor] = (),
    has_twins: bool = True,
) -> JudgedJoint:
    """Checks and findings on all joints of a package; nothing for a rigid one.

    `content` was re-read from `main_file`; `declared` is the mechanism that it should hold, in the asset frame. For
    `contacts` and `anchors` see `joint_tasks`. `has_twins`: it is of Mana, so that URDF and MJCF must
    agree. Codes: those of `schemas.codes.joints`.
    """
    if content.mechanism is None:
        return JudgedJoint((), ())
    articulation = Articulation(content.mechanism, content.links, content.filtered_pairs)
    contacts = contacts or {}
    tasks = joint_tasks(articulation, contacts, anchors)
    exercised = simulator.exercise_joints(articulation, tasks)
    by_name = {joint.name: joint for joint in content.mechanism.joints}
    meant = {joint.name: joint for joint in declared.joints}
    looped = joints_in_loops(content.mechanism)
    points = {link.name: link_points(articulation, link.name) for link in content.mechanism.links}
    parts = [_at_rest(exercised.at_rest)]
    for exercise in exercised.joints:
        joint = by_name[exercise.joint]
        subject = JointSubject(joint, meant.get(joint.name, joint), exercise, exercised.at_rest, joint.name in looped)
        parts.append(judge_joint(subject))
        parts.append(judge_damping(joint, damping_force_n(content.mechanism, joint, points)))
        if joint.name in contacts:
            parts.append(_contact(articulation, joint, contacts[joint.name]))
    if has_twins:
        checks, findings = check_twins(content.mechanism, main_file.parents[1] / "export", main_file.stem)
        parts.append(JudgedJoint(tuple(checks), tuple(findings)))
    parts.append(JudgedJoint((), tuple(_left_out(content.mechanism, {t.joint for t in tasks}, looped))))
    return joined(parts)


def joints_in_loops(mechanism: Mechanism) -> frozenset[str]:
    """Names of the joints of the tree that a closing joint makes part of a loop."""
    tree = nx.Graph([(joint.parent, joint.child, {"joint": joint.name}) for joint in mechanism.tree])
    names: set[str] = set()
    for closing in (joint for joint in mechanism.joints if joint.closes_loop):
        path = nx.shortest_path(tree, closing.parent, closing.child)
        names |= {tree.edges[a, b]["joint"] for a, b in pairwise(path)}
    return frozenset(names)


def _at_rest(overlaps: Sequence[LinkOverlap]) -> JudgedJoint:
    """Links that collide must be apart at rest; the depth of the others is a figure of its own."""
    colliding = max((o for o in overlaps if o.collides), key=lambda o: o.depth_m, default=None)
    silent = max((o.depth_m for o in overlaps if not o.collides), default=0.0)
    depth = 0.0 if colliding is None else colliding.depth_m
    bound = POLICY.penetration_m
    checks = (
        Check(name="links_overlap_colliding", value=depth, bound=bound, unit="m", passed=depth <= bound),
        Check(name="links_overlap_filtered", value=silent, bound=max(silent, bound), unit="m", passed=True),
    )
    if checks[0].passed or colliding is None:
        return JudgedJoint(checks, ())
    headline = f"'{colliding.first}' and '{colliding.second}' collide and overlap by {depth:.3g} m at rest"
    return JudgedJoint(checks, (finding("asset/links-interpenetrate", headline, value=depth, bound=bound, unit="m"),))


def _contact(articulation: Articulation, joint: MechanismJoint, contact: JointContact) -> JudgedJoint:
    if contact.link not in {link.name for link in articulation.mechanism.links}:
        return JudgedJoint((), ())
    body, origin = body_of(articulation, contact.link)
    point = np.array([contact.position_m]) - origin
    distances = [float(distance_outside(shape, point)[0]) for shape in body.shapes]
    return judge_contact(joint, contact, body, origin, min(distances, default=NOT_FINITE))


def _left_out(mechanism: Mechanism, exercised: set[str], looped: frozenset[str]) -> list[Diagnostic]:
    """Joints that were not exercised on their own, or with their loop open, by the reason."""
    balls = [j.name for j in mechanism.tree if j.kind == "ball"]
    beyond = [j.name for j in mechanism.tree if j.kind != "ball" and j.coupling is None and j.name not in exercised]
    reasons = {
        "ball joints are judged by their frames alone": balls,
        f"only {POLICY.most_joints} joints are exercised": beyond,
        "exercised with the loop open, as in the URDF": sorted(looped & exercised),
    }
    return [
        finding("asset/joint-not-exercised", f"{', '.join(names[:5])}{' ...' if len(names) > 5 else ''}: {reason}")
        for reason, names in reasons.items()
        if names
    ]
