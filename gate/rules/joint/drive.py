"""Rule: drives act on a degree of freedom of the joint, with possible gains and a target within its limits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Joint, Subject
from gate.subject.joint import ONE_DOF_KINDS
from gate.subject.limits import instances
from gate.subject.values import at, number, text
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-drive",
    "A drive has impossible gains or nothing to drive",
    "Negative gains push away from the target; infinite ones end the simulation in NaN.",
    "keep stiffness, damping and maxForce finite and >= 0, and match the drive to the joint type",
)
MOST_GAIN = 1e12
MATCHING = {"revolute": ("angular", "rotX", "rotY", "rotZ"), "prismatic": ("linear", "transX", "transY", "transZ")}
_NAMES = ("stiffness", "damping", "maxForce")


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per drive with negative, infinite or NaN gains, without a motion to drive, or with a target outside
    the limits; and per drive value that no applied PhysicsDriveAPI reads.
    """
    for joint in subject.joints:
        applied = instances(joint.prim, "PhysicsDriveAPI")
        for name in applied:
            yield from _gains(joint, name)
            yield from _use(subject, joint, name)
        driven = {
            a.GetName().split(":")[1] for a in joint.prim.GetAuthoredAttributes() if a.GetName().startswith("drive:")
        }
        for name in sorted(driven - set(applied)):
            headline = f"drive:{name} is ignored: PhysicsDriveAPI is not applied for it"
            yield finding(CODE, headline, where=at(joint.prim), severity=subject.suspect_severity)


def _gains(joint: Joint, name: str) -> Iterator[Diagnostic]:
    where = at(joint.prim)
    for gain in _NAMES:
        unlimited = gain == "maxForce"
        value = number(joint.prim, f"drive:{name}:physics:{gain}", np.inf if unlimited else 0.0)
        # An unlimited force is the schema's fallback; an infinite gain is never one.
        if not (value >= 0.0 and (np.isfinite(value) or unlimited)):
            headline = f"the {gain} of the {name} drive is negative or not finite"
            yield finding(CODE, headline, where=where, value=value, bound=0.0)
        elif not unlimited and value > MOST_GAIN:
            headline = f"the {gain} of the {name} drive is beyond what engines integrate"
            yield finding(CODE, headline, where=where, value=value, bound=MOST_GAIN, severity=Severity.WARNING)
    kind = text(joint.prim, f"drive:{name}:physics:type", "force")
    if kind not in ("force", "acceleration"):
        yield finding(CODE, "the drive type is unknown", where=where, value=kind, bound="force or acceleration")


def _use(subject: Subject, joint: Joint, name: str) -> Iterator[Diagnostic]:
    where, prefix = at(joint.prim), f"drive:{name}:physics:"
    if joint.kind in (*MATCHING, "fixed") and name not in MATCHING.get(joint.kind, ()):
        headline = f"a {joint.kind} joint has no {name} motion to drive"
        yield finding(CODE, headline, where=where, severity=subject.suspect_severity)
        return
    stiffness, damping = (number(joint.prim, f"{prefix}{gain}", 0.0) for gain in ("stiffness", "damping"))
    if number(joint.prim, f"{prefix}maxForce", np.inf) == 0.0 and (stiffness > 0.0 or damping > 0.0):
        yield finding(CODE, "the drive has gains but no force", where=where, severity=Severity.WARNING)
    for target in ("targetPosition", "targetVelocity"):
        value = number(joint.prim, f"{prefix}{target}", 0.0)
        if not np.isfinite(value):
            yield finding(CODE, f"the {target} of the {name} drive is not finite", where=where, value=value)
    if damping > 0.0 and abs(number(joint.prim, f"{prefix}targetVelocity", 0.0)) > 0.0 and subject.released:
        yield finding(CODE, "the drive moves the joint by itself", where=where, severity=Severity.WARNING)
    if joint.kind in ONE_DOF_KINDS and stiffness > 0.0:
        length = subject.frames.meters_per_unit if joint.kind == "prismatic" else 1.0
        target = number(joint.prim, f"{prefix}targetPosition", 0.0) * length
        lower, upper = joint.limits
        slack = 1e-6 + 1e-3 * (upper - lower if np.isfinite(upper - lower) else 0.0)
        if target < lower - slack or target > upper + slack:
            yield finding(
                CODE,
                "the drive pulls the joint outside its limits",
                where=where,
                value=target,
                bound=lower if target < lower else upper,
                unit=joint.unit,
                severity=Severity.WARNING,
            )


RULE = Rule(
    CODE,
    "0 <= stiffness, damping < 1e12; maxForce >= 0; a matching motion; target within the limits",
    "UsdPhysicsDriveAPI",
    check,
)
