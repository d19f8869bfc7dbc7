"""Rule: every collider has a contact material."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.contact import bound_material, contact_material
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-contact-material",
    "A collider has no contact material",
    "Friction is then whatever the engine defaults to.",
    "bind a Material with PhysicsMaterialAPI for purpose physics to every collider",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """In a package: a finding per collider of a body without a bound material that has physics properties."""
    if not subject.released:
        return  # Without one the engine's default holds.
    for collider in (c for body in subject.active_bodies for c in body.active_colliders):
        if contact_material(collider.prim) is None:
            bound = bound_material(collider.prim)
            headline = "the collider has no contact material" if bound is None else "the material has no contact values"
            value = None if bound is None else str(bound.GetPath())
            yield finding(CODE, headline, where=at(collider.prim), value=value, severity=Severity.ERROR)


RULE = Rule(CODE, "a Material with PhysicsMaterialAPI, bound for purpose physics", "UsdPhysicsMaterialAPI", check)
