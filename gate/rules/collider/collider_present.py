"""Rule: every dynamic body has an enabled collider."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-no-collider",
    "A moving body has no collider, or a disabled one",
    "It falls through everything.",
    "add collision shapes below the body and enable them",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body without an enabled collider, per disabled collider, and one when a package has no body."""
    if subject.released and not subject.bodies:
        yield finding(CODE, "there is no rigid body")
    joined = {body.path for joint in subject.joints for body in joint.bodies}
    for body in subject.active_bodies:
        if not body.active_colliders:
            # A link without shape is a mere frame; robots have them at their tool and sensors.
            frame = body.path in joined and not body.surfaces
            severity = Severity.WARNING if frame and subject.released else subject.suspect_severity
            if not frame or subject.released:
                headline = "the body has no enabled collider"
                yield finding(CODE, headline, where=at(body.prim), severity=severity)
        for collider in body.colliders:
            if not collider.enabled:
                headline = "a collider is disabled"
                yield finding(CODE, headline, where=at(collider.prim), severity=subject.suspect_severity)


RULE = Rule(CODE, "one enabled collider per body", "SimReady RB.COL.001", check)
