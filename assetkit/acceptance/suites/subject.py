"""What suites exercise, read from a package on disk: its USD, and its record where it has one of Mana."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import get_args

from assetkit.acceptance.body_checks import body_checks
from assetkit.acceptance.stable_poses import find_stable_poses
from assetkit.acceptance.suites.suite import Subject
from assetkit.affordances.grasps import grasps_along
from assetkit.package.record import read_record
from geom.grasp.gripper import LARGE, MEDIUM, SMALL
from schemas.acceptance import StablePose
from schemas.affordances import AffordanceEvidence, Grasp, Region
from schemas.anchors import Anchor
from schemas.articulation import JointUse
from schemas.asset import RECORD, AssetRecord, PhysicsSection, Role
from schemas.diagnostics import Location, finding
from schemas.evidence import Evidence
from sim.port import Simulator
from usdio.reread.body import RereadPackage, reread_package
from usdio.reread.foreign import reread_foreign

# Below, a role is a guess that no suite is asked to prove.
PROMISED = 0.5


def subject_on_disk(main_file: Path, simulator: Simulator, roles: Sequence[Role] = ()) -> Subject:
    """The package with this main USD file; `roles` replace those on record.

    A package with a record, also one that cannot be read or belongs elsewhere, is read as strictly as it was released.
    Others are read by `usdio.reread.foreign`, whose findings the subject carries. Without a record that can be read
    there are no roles but those stated. Raises InvalidInput
    (`asset/package-invalid`, `asset/foreign-unsupported`) for a file that holds no complete body.
    """
    record = record_of(main_file)
    if record is None and not is_recorded(main_file):
        return _foreign_subject(main_file, simulator, roles)
    content = reread_package(main_file)
    if record is None:
        return _bare_subject(main_file, content, simulator, roles)
    subject = subject_of(
        main_file,
        content,
        roles=record.semantics.roles,
        poses=[pose.value for pose in record.acceptance.stable_poses],
        affordances=record.affordances,
        anchors=[anchor.value for anchor in record.anchors],
        joint_uses=record.joint_uses,
        physics=record.physics,
    )
    return replace(subject, roles=tuple(roles)) if roles else subject


def _bare_subject(main_file: Path, content: RereadPackage, simulator: Simulator, roles: Sequence[Role]) -> Subject:
    """The subject of which nothing is on record; stable poses are found here, of a body that can be simulated."""
    subject = Subject(main_file, content, tuple(roles))
    if subject.is_articulated or not all(check.passed for check in body_checks(content.body)):
        return subject  # Acceptance of the whole object says what is wrong.
    return replace(subject, poses=find_stable_poses(subject.body, simulator).poses)


def _foreign_subject(main_file: Path, simulator: Simulator, roles: Sequence[Role]) -> Subject:
    """The subject of another maker; its grasps close along the lines that the file states, with the first of three
    sizes of gripper that can.
    """
    package = reread_foreign(main_file)
    subject = replace(_bare_subject(main_file, package.content, simulator, roles), findings=package.findings)
    if not package.grasp_lines_m or not subject.poses:
        return subject
    lines, reasons = package.grasp_lines_m, dict[str, None]()
    for gripper in (MEDIUM, SMALL, LARGE):
        proposed = grasps_along(lines, subject.body, subject.poses, gripper)
        if proposed.grasps:
            headline = (
                f"{len(lines)} lines of grasps became {len(proposed.grasps)} grasps of the {gripper.name} gripper"
            )
            break
        reasons[f"{proposed.reason} [{gripper.name}]"] = None
    else:
        headline = f"{len(lines)} lines of grasps became none: {'; '.join(reasons)}"
    note = finding("asset/foreign-converted", headline, where=Location(file=main_file.name))
    return replace(subject, grasps=proposed.grasps, findings=(*subject.findings, note))


def subject_of(
    main_file: Path,
    content: RereadPackage,
    *,
    roles: Sequence[Evidence[str]],
    poses: Sequence[StablePose],
    affordances: Sequence[AffordanceEvidence],
    anchors: Sequence[Anchor],
    joint_uses: Sequence[JointUse],
    physics: PhysicsSection,
) -> Subject:
    """The subject from what is on record, or about to be."""
    values = [evidence.value for evidence in affordances]
    known = [role for role in get_args(Role) if any(e.value == role and e.confidence >= PROMISED for e in roles)]
    order = [evidence.value for evidence in roles]
    contact = physics.contacts[0] if physics.contacts else None
    return Subject(
        main_file,
        content,
        roles=tuple(sorted(known, key=order.index)),
        poses=tuple(poses),
        grasps=tuple(v for v in values if isinstance(v, Grasp)),
        regions=tuple(v for v in values if isinstance(v, Region)),
        anchors=tuple(anchors),
        joint_uses=tuple(joint_uses),
        friction_bounds=None
        if contact is None or contact.bounds is None
        else (contact.bounds[0].dynamic_friction, contact.bounds[1].dynamic_friction),
        mass_bounds_kg=physics.mass_kg.bounds,
    )


def is_recorded(main_file: Path) -> bool:
    """Whether a record lies where packages of Mana have theirs, of whatever content."""
    return len(main_file.parents) > 1 and (main_file.parents[1] / RECORD).exists()


def record_of(main_file: Path) -> AssetRecord | None:
    """The record of the package with this main file; None where it is none of Mana's."""
    return read_record(main_file.parents[1]) if len(main_file.parents) > 1 else None
