"""Rule: colliders are not drawn on top of the visible surface."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-collider-rendered",
    "A collider is drawn on top of the visible surface",
    "Pictures and segmentation show hulls instead of the object.",
    "set purpose to guide on the collider",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per collider of a package that a final render draws; elsewhere one mesh may well serve as both."""
    if not subject.released:
        return
    colliders = {str(c.prim.GetPath()) for c in subject.colliders}
    drawn = {str(prim.GetPath()): prim for prim in subject.visible_prims}
    only_colliders = set(drawn) <= colliders
    for path in sorted(colliders & set(drawn)):
        severity = Severity.WARNING if only_colliders else Severity.ERROR
        headline = "the collider is drawn: its purpose is not guide"
        yield finding(CODE, headline, where=at(drawn[path]), bound="guide", severity=severity)


RULE = Rule(CODE, "purpose guide", "SimReady VM.MAT.001, VG.008; UsdGeomImageable purpose", check)
