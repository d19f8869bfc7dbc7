"""Checks the body of a written package, as re-read from disk: frame, colliders, mass, settling, stable poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from assetkit.acceptance.body_checks import alignment_checks, body_checks, frame_checks
from assetkit.acceptance.joints.checks import JudgedJoint
from assetkit.acceptance.settling import Settling, settle_and_drop
from assetkit.acceptance.stable_poses import StablePoses, find_stable_poses
from schemas.acceptance import AcceptanceSection, Check, StablePose
from schemas.arrays import FloatArray, IntArray
from schemas.asset import Vec3
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.evidence import Evidence, measured
from schemas.physics import RigidBody
from sim.port import Simulator


@dataclass(frozen=True)
class AcceptanceResult:
    """The acceptance section of the record, findings, whether every check passed, whether it was simulated."""

    section: AcceptanceSection
    diagnostics: tuple[Diagnostic, ...]
    passed: bool
    is_simulated: bool = True

    def with_joints(self, joints: JudgedJoint) -> AcceptanceResult:
        """The result with checks and findings of joints after those of the whole object."""
        if not joints.checks:
            return self
        section = self.section.model_copy(update={"checks": (*self.section.checks, *joints.checks)})
        passed = self.passed and all(check.passed for check in joints.checks)
        return replace(self, section=section, diagnostics=(*self.diagnostics, *joints.diagnostics), passed=passed)


def accept(
    main_file: Path,
    simulator: Simulator,
    *,
    body: RigidBody,
    visual: tuple[FloatArray, IntArray],
    extent_m: Vec3 | None = None,
    links: Sequence[RigidBody] = (),
) -> AcceptanceResult:
    """Check `body` and `visual` (points (n, 3), triangles (m, 3)), both re-read from `main_file`, in its asset frame.

    Of an articulated object `body` is the whole with its joints held at rest, and `links` are its bodies.

    `extent_m` is the extent on record, checked if given. Findings, by cause: `asset/package-invalid` (frame, shapes or
    mass make no sense; nothing is simulated then), `asset/render-collision-misaligned`, `asset/unstable-settling`, and
    for information `asset/reference-pose-topples` and `asset/no-stable-pose`.
    """
    where = Location(file=main_file.name)
    static = frame_checks(visual[0], extent_m)
    static += [c for link in links for c in _named(link, body_checks(link))] if links else body_checks(body)
    refused = _failures("asset/package-invalid", "the body as written", static, where)
    if refused:
        return replace(_result(simulator, static, (), refused), is_simulated=False)

    aligned = alignment_checks(body, *visual)
    settling = settle_and_drop(body, simulator)
    stable = find_stable_poses(body, simulator)
    diagnostics = [
        *_failures("asset/render-collision-misaligned", "colliders against the visible surface", aligned, where),
        *_failures("asset/unstable-settling", "set down and dropped", settling.checks, where),
        *_remarks(settling, stable, where),
    ]
    checks = [*static, *aligned, *settling.checks, *_pose_checks(stable)]
    method = f"{stable.trials} drop-settle trials in {simulator.name}"
    poses = tuple(measured(p, method, confidence=stable.at_rest / stable.trials) for p in stable.poses)
    return _result(simulator, checks, poses, diagnostics)


def _named(link: RigidBody, checks: Sequence[Check]) -> list[Check]:
    return [check.model_copy(update={"name": f"{link.name}/{check.name}"}) for check in checks]


def _result(
    simulator: Simulator,
    checks: Sequence[Check],
    poses: tuple[Evidence[StablePose], ...],
    diagnostics: Sequence[Diagnostic],
) -> AcceptanceResult:
    section = AcceptanceSection(simulator=simulator.name, checks=tuple(checks), stable_poses=poses)
    return AcceptanceResult(section, tuple(diagnostics), all(check.passed for check in checks))


def _failures(code: str, title: str, checks: Sequence[Check], where: Location) -> list[Diagnostic]:
    """One finding for all failed checks of a kind: the first one's figures, the others as causes."""
    failed = [check for check in checks if not check.passed]
    if not failed:
        return []
    each = [
        finding(
            code,
            f"{title}: {c.name.replace('_', ' ')} is {c.value:.4g}, not {c.bound:.4g} {c.unit}".rstrip(),
            where=where,
            value=c.value,
            bound=c.bound,
            unit=c.unit,
        )
        for c in failed
    ]
    return [each[0].model_copy(update={"because": tuple(each[1:])})]


def _remarks(settling: Settling, stable: StablePoses, where: Location) -> list[Diagnostic]:
    """Findings for information, on properties of the object that are no defects."""
    remarks = []
    if settling.toppled:
        tilt_deg = float(np.degrees(settling.tilt_rad))
        headline = f"set down as authored, the object leans by {tilt_deg:.0f} deg and comes to rest elsewhere"
        remarks.append(finding("asset/reference-pose-topples", headline, where=where, value=tilt_deg, unit="deg"))
    if not stable.poses:
        headline = f"{stable.at_rest} of {stable.trials} drops came to rest, none in a pose that holds"
        remarks.append(finding("asset/no-stable-pose", headline, where=where, value=stable.at_rest, unit="drops"))
    return remarks


def _pose_checks(stable: StablePoses) -> list[Check]:
    """Figures for the record; they always pass."""
    figures = {
        "stable_poses": float(len(stable.poses)),
        "stable_poses_refuted": float(stable.refuted),
        "trials_at_rest": float(stable.at_rest),
    }
    return [Check(name=name, value=value, bound=stable.trials, unit="", passed=True) for name, value in figures.items()]
