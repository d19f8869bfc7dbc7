"""Rule: the rest pose lies within the joint limits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.joint import ONE_DOF_KINDS
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-joint-rest",
    "A joint starts outside its limits",
    "The solver throws the body inside at once.",
    "shift the limits, or author the bodies in a pose within them",
)
_TOLERANCE = {"revolute": 0.5, "prismatic": 1e-3}  # degrees, metres
_FAR_SHARE = 0.5  # of the range: beyond, limits or frames are wrong; below, some robots have such a zero pose


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per joint that starts outside its limits, so that the engine throws its body inside at once."""
    for joint in subject.joints:
        rest, (lower, upper) = joint.rest(), joint.limits
        if joint.kind not in ONE_DOF_KINDS or rest is None or not lower <= upper:
            continue
        coordinate = rest.coordinate
        outside = max(lower - coordinate, coordinate - upper)
        if not outside <= _TOLERANCE[joint.kind]:
            far = outside > _FAR_SHARE * (upper - lower) and np.isfinite(upper - lower)
            yield finding(
                CODE,
                "the joint starts outside its limits",
                where=at(joint.prim),
                value=coordinate,
                bound=lower if coordinate < lower else upper,
                unit=joint.unit,
                severity=subject.suspect_severity if far else Severity.WARNING,
            )


RULE = Rule(CODE, "within the limits, to 0.5 deg or 1 mm (error beyond half the range)", "UsdPhysicsJoint", check)
