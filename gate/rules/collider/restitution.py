"""Rule: restitution lies in 0 .. 1."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, number
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-restitution",
    "Restitution lies outside 0 to 1",
    "Above 1 every bounce adds energy; below 0 is undefined.",
    "set physics:restitution between 0 and 1",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per contact material whose restitution would add energy or is negative."""
    for prim in subject.contact_materials:
        value = number(prim, "physics:restitution", 0.0)
        if not 0.0 <= value <= 1.0:
            headline = "restitution is outside 0 .. 1"
            yield finding(CODE, headline, where=at(prim), value=value, bound=1.0 if value > 1.0 else 0.0)


RULE = Rule(CODE, "0 .. 1", "conservation of energy; UsdPhysicsMaterialAPI", check)
