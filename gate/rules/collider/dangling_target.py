"""Rule: the targets of physics relationships exist."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-dangling-target",
    "A physics relationship names a prim that does not exist",
    "The filter, group or scene that was meant has no effect.",
    "name an existing prim or remove the target",
)
PREFIXES = ("physics:", "physx", "newton:", "mjc:", "collection:colliders:")
ELSEWHERE = ("physics:body0", "physics:body1")  # the joint-bodies rule


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per filtered pair, collision group or scene that a relationship names and that is not there."""
    for prim in subject.prims:
        if prim.IsInstanceProxy():
            continue
        for relationship in prim.GetAuthoredRelationships():
            name = relationship.GetName()
            if not name.startswith(PREFIXES) or name in ELSEWHERE:
                continue
            for target in relationship.GetForwardedTargets():
                if not subject.stage.GetObjectAtPath(target):
                    headline = f"{name} names a prim that does not exist"
                    yield finding(CODE, headline, where=at(prim), value=str(target), severity=subject.suspect_severity)


RULE = Rule(CODE, "every target exists", "UsdPhysics: filtered pairs, collision groups, simulation owner", check)
