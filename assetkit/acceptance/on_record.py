"""What a record says of its package, tried on the files again: mass, stable poses, anchors; and its joints as declared.

A release measures these on the bytes that it ships, so a sound package gives the same again. One whose USD or record
was changed afterwards does not: scenes would set it down in poses that do not hold, and put things where none stay.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import shapely

from assetkit.acceptance.stable_poses import holds, recovers, resting_pose
from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import CheckList, Subject, SuiteRun, at_least, at_most
from assetkit.affordances.anchor_trials import OFF_SHARE, VerifiedAnchors, verify_anchors
from assetkit.affordances.anchors import shape_of
from assetkit.articulation.link_anchor_trials import placed, verify_link_anchors
from geom.convex.support_function import diagonal, surface
from geom.pose import DOWN, matrix_of, pose
from schemas.diagnostics import Location
from schemas.evidence import Evidence
from schemas.mechanism import Mechanism, MechanismJoint
from sim.port import Simulator

ROUNDING = 1e-6  # share of a value: USD has masses in single precision


def judge_record(subject: Subject, simulator: Simulator) -> SuiteRun:
    """Checks of mass, stable poses and anchors on record; nothing where the record has none.

    Findings: `asset/mass-beyond-bounds`, `asset/stable-pose-lost`, `asset/anchor-lost`.
    """
    checks = CheckList(Location(file=subject.main_file.name))
    _mass(checks, subject)
    _poses(checks, subject, simulator)
    _anchors(checks, subject, simulator)
    return checks.run()


def declared_on_record(mechanism: Mechanism, stated: Sequence[Evidence[dict[str, Any]]]) -> Mechanism:
    """The mechanism with axes and limits of its joints as a record states them; joints that it leaves out stay."""
    by_name = {evidence.value.get("name"): evidence.value for evidence in stated}
    return replace(mechanism, joints=tuple(_as_stated(joint, by_name.get(joint.name)) for joint in mechanism.joints))


def _as_stated(joint: MechanismJoint, stated: dict[str, Any] | None) -> MechanismJoint:
    if stated is None:
        return joint
    limits = stated.get("limits_rad" if joint.is_angular else "limits_m")
    axis = np.asarray(stated.get("axis", joint.axis), dtype=np.float64)
    return replace(joint, axis=axis, limits=None if limits is None else (float(limits[0]), float(limits[1])))


def _mass(checks: CheckList, subject: Subject) -> None:
    if subject.mass_bounds_kg is None:
        return
    mass_kg, (low, high) = subject.body.mass.mass_kg, subject.mass_bounds_kg
    headline = f"it weighs {mass_kg:.3g} kg, and is believed to weigh {low:.3g} to {high:.3g} kg"
    code = "asset/mass-beyond-bounds"
    checks.add(code, headline, at_least("mass_above_least", mass_kg, low * (1.0 - ROUNDING), "kg"))
    checks.add(code, headline, at_most("mass_below_most", mass_kg, high * (1.0 + ROUNDING), "kg"))


def _poses(checks: CheckList, subject: Subject, simulator: Simulator) -> None:
    """The most probable ones: the lowest point lies as deep below the origin as it did, and the pose holds."""
    size = diagonal(subject.body.shapes)
    code = "asset/stable-pose-lost"
    for number, stable in enumerate(subject.poses[: POLICY.poses], 1):
        down_A = matrix_of(np.array(stable.quat_wxyz)).T @ DOWN
        offset_m = float(resting_pose(subject.body, down_A, gap_m=0.0)[2, 3])
        off = abs(offset_m - stable.support_offset_m) / size
        headline = f"pose {number} on record: it rests with its origin at {offset_m:.3g} m"
        checks.add(code, headline, at_most(f"pose_{number}_height", off, POLICY.pose_share, "of diagonal"))
        stays = holds(subject.body, simulator, down_A) and recovers(subject.body, simulator, down_A)
        headline = f"pose {number} on record: set down in it, it does not stay"
        checks.add(code, headline, at_least(f"pose_{number}_holds", float(stays), 1.0, ""))


def _anchors(checks: CheckList, subject: Subject, simulator: Simulator) -> None:
    """Surfaces and volumes: the probes that verified them stay on and in them again."""
    if not subject.anchors:
        return
    held = _tried_again(subject, simulator)
    names = {evidence.value.anchor_id for evidence in held.anchors}
    lost = [anchor.anchor_id for anchor in subject.anchors if anchor.anchor_id not in names]
    reasons = [d.headline.removesuffix(", so it is left out") for d in held.diagnostics]
    headline = "; ".join(reasons or [f"{', '.join(lost)}: nothing is there"])
    share = at_least("anchors_holding", len(subject.anchors) - len(lost), len(subject.anchors), "anchors")
    checks.add("asset/anchor-lost", headline, share)
    if not subject.is_articulated:  # Other links may lie above a surface.
        _surfaces(checks, subject)


def _surfaces(checks: CheckList, subject: Subject) -> None:
    """No corner of a collider stands above a surface, below its clearance; its margin is left out."""
    size = diagonal(subject.body.shapes)
    points = np.concatenate([surface(shape)[0] for shape in subject.body.shapes])
    for anchor in subject.anchors:
        if anchor.kind != "surface":
            continue
        x, y, z = anchor.position_m
        polygon = shape_of(anchor.polygon, x, y).buffer(-POLICY.surface_margin * size)
        above = points[shapely.contains_xy(polygon, points[:, 0], points[:, 1]), 2] - z
        free = np.inf if anchor.clearance_m is None else anchor.clearance_m - OFF_SHARE * size
        highest = float(above[(above > 0.0) & (above < free)].max(initial=0.0))
        headline = f"{anchor.anchor_id}: colliders stand {1000 * highest:.3g} mm above it"
        clear = at_most(f"{anchor.anchor_id}_above", highest / size, OFF_SHARE, "of diagonal")
        checks.add("asset/anchor-lost", headline, clear)


def _tried_again(subject: Subject, simulator: Simulator) -> VerifiedAnchors:
    """Each anchor of a rigid object on its shapes; of an articulated object link by link."""
    content = subject.content
    if content.mechanism is None:
        return verify_anchors(subject.anchors, content.body.shapes, simulator)
    by_link = {
        link.name: [placed(shape, pose(None, link.origin)) for shape in body.shapes]
        for link, body in zip(content.mechanism.links, content.links, strict=True)
    }
    names = {joint.name for joint in content.mechanism.joints}
    uses = [use for use in subject.joint_uses if use.joint in names]
    return verify_link_anchors(subject.anchors, by_link, content.mechanism, uses, simulator)
