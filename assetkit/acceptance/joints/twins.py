"""Whether the twins of a package (URDF, MJCF) move their links as the USD does, from the files on disk alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from assetkit.acceptance.joints.policy import POLICY
from formats import link_poses, read_mjcf, read_urdf
from geom.mechanism_pose import joint_positions, link_frames, movable_joints
from geom.pose import angle_between, inverse, quat_of
from schemas.acceptance import Check
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding
from schemas.mechanism import Mechanism, MechanismJoint
from schemas.robot_description import RobotDescription

_READERS = {".urdf": read_urdf, ".xml": read_mjcf}


def check_twins(mechanism: Mechanism, export: Path, asset_id: str) -> tuple[list[Check], list[Diagnostic]]:
    """Poses of all links in both twins below `export`, each joint at either end of its range in the file, beside those
    of the USD.

    Checks: the largest distance (m) and angle (deg) of a link in each twin. Findings: `asset/twin-disagrees`, one per
    twin, for the joint with the largest difference.
    """
    checks, findings = list[Check](), list[Diagnostic]()
    for suffix, read in _READERS.items():
        file = export / f"{asset_id}{suffix}"
        name = suffix[1:].replace("xml", "mjcf")
        try:
            twin = read(file, export)
        except InvalidInput as unread:
            headline = f"the {name.upper()} twin cannot be read"
            findings.append(
                finding("asset/twin-disagrees", headline, where=Location(file=file.name), because=(unread.diagnostic,))
            )
            continue
        worst_m, worst_deg, at = _worst(mechanism, twin)
        checks += [
            _check(f"{name}_twin_position", worst_m, POLICY.twin_m, "m"),
            _check(f"{name}_twin_angle", worst_deg, POLICY.twin_deg, "deg"),
        ]
        failed = next((check for check in checks[-2:] if not check.passed), None)
        if failed is not None:
            headline = (
                f"the {name.upper()} twin puts a link {failed.value:.3g} {failed.unit} off when '{at}' moves, "
                f"not {failed.bound:g}"
            )
            where = Location(file=file.name)
            figures = {"value": failed.value, "bound": failed.bound, "unit": failed.unit}
            findings.append(finding("asset/twin-disagrees", headline, where=where, **figures))
    return checks, findings


def _worst(mechanism: Mechanism, twin: RobotDescription) -> tuple[float, float, str]:
    """Largest distance (m) and angle (deg) of a link, and the joint moved then, in each file to its end there."""
    states = [("", joint_positions(mechanism, {}), 0.0)]
    limits = {joint.name: joint.limits for joint in twin.joints}
    for joint in movable_joints(mechanism):
        ends = zip(_ends(joint), limits.get(joint.name) or _ends(replace(joint, limits=None)), strict=True)
        states += [(joint.name, joint_positions(mechanism, {joint.name: own}), other) for own, other in ends]
    worst_m = worst_deg = 0.0
    at = "nothing"
    known = {joint.name for joint in mechanism.tree if joint.kind != "ball"} & {joint.name for joint in twin.joints}
    for name, positions, other in states:
        moved_to = {**positions, name: other} if name else positions
        X_RL = link_poses(twin, {n: q for n, q in moved_to.items() if n in known})
        X_AL = link_frames(mechanism, positions)
        X_RA = X_RL.get(mechanism.root.name)
        for link in mechanism.links:
            if X_RA is None or link.name not in X_RL:
                return float(np.finfo(np.float32).max), 180.0, f"{link.name} is missing"
            apart = inverse(X_AL[link.name]) @ inverse(X_RA) @ X_RL[link.name]
            turned = float(np.degrees(angle_between(quat_of(apart[:3, :3]), np.array([1.0, 0.0, 0.0, 0.0]))))
            moved = float(np.linalg.norm(apart[:3, 3]))
            if moved > worst_m or turned > worst_deg:
                at = name or at
            worst_m, worst_deg = max(worst_m, moved), max(worst_deg, turned)
    return worst_m, worst_deg, at


def _ends(joint: MechanismJoint) -> tuple[float, ...]:
    return joint.limits or (joint.rest - 1.0, joint.rest + 1.0)


def _check(name: str, value: float, bound: float, unit: str) -> Check:
    return Check(name=name, value=value, bound=bound, unit=unit, passed=value <= bound)
