"""Rule: a body below another body is joined to something, and no body sits inside an instance."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-nested-body",
    "A rigid body lies below another one, or inside an instance",
    "Engines either tear nested bodies apart or weld them together; instances cannot hold bodies.",
    "put bodies side by side, or join the inner to the outer one",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body below another one that no joint connects, and per body inside an instance."""
    joined = {body.path for joint in subject.joints for body in joint.bodies}
    for body in subject.bodies:
        if body.prim.IsInstanceProxy():
            yield finding(CODE, "the body lies inside an instance", where=at(body.prim))
        outer = subject.body_of(body.prim.GetParent())
        if outer is not None and body.path not in joined:
            headline = f"the body lies below the body {outer.path} and nothing joins them"
            yield finding(CODE, headline, where=at(body.prim), severity=subject.suspect_severity)


RULE = Rule(CODE, "bodies side by side, or nested and joined; none in an instance", "SimReady RB.006, RB.012", check)
