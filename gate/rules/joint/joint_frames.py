"""Rule: the joint frames of both bodies coincide in position and axis in the rest pose."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-joint-frames",
    "The two sides of a joint disagree in the rest pose",
    "The solver snaps the bodies together in the first step, with any force it takes.",
    "recompute localPos and localRot of one side from the other and the poses of the bodies",
)
GAP_M, TILT_DEG = 1e-3, 0.5
_GAP_SHARE = 1e-3  # of the joined bodies, for cranes
_TINY_SHARE = 0.02  # of the joined bodies, for watches


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per joint whose frames lie apart, or are tilted, in a way the joint does not allow.

    Sliding along the axis and turning about it are left out: the joint-rest rule looks at them.
    """
    for joint in subject.joints:
        rest = joint.rest()
        if rest is None or not joint.enabled or not joint.bodies:
            continue  # Reported by the joint-axis and joint-bodies rules.
        size_m = joint.size_m
        bound_m = max(_GAP_SHARE * size_m, min(GAP_M, _TINY_SHARE * size_m)) if size_m > 0.0 else GAP_M
        if rest.gap_m > bound_m:
            headline = "the joint frames of the two bodies lie apart"
            yield finding(CODE, headline, where=at(joint.prim), value=rest.gap_m, bound=bound_m, unit="m")
        if rest.tilt_deg > TILT_DEG:
            headline = "the joint frames of the two bodies are tilted against each other"
            yield finding(CODE, headline, where=at(joint.prim), value=rest.tilt_deg, bound=TILT_DEG, unit="deg")


RULE = Rule(CODE, "gap <= 1 mm (or 0.1 % of the bodies), tilt <= 0.5 deg", "UsdPhysicsJoint: local frames", check)
