"""Rule: static >= dynamic >= 0 friction, as materials have it."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, authored, number
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-friction",
    "Friction is impossible, missing or static below dynamic",
    "Static friction below dynamic, or below zero, gives jitter or is ignored.",
    "set static >= dynamic >= 0 friction, for dry pairs below 1.5",
)
USUAL_MOST, MOST = 2.0, 10.0  # Rubber on dry concrete reaches 1.2, racing tyres 2.
LEAST_DYNAMIC_SHARE = 0.2  # Dry pairs keep 0.6 to 0.95 of their friction once they slide.
_FRICTION_ROUNDING = 1e-6
NAMES = ("physics:staticFriction", "physics:dynamicFriction")


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per contact material with impossible, inverted, huge or missing friction."""
    for prim in subject.contact_materials:
        static, dynamic = (number(prim, name, 0.0) for name in NAMES)
        where = at(prim)
        for name, value in zip(NAMES, (static, dynamic), strict=True):
            if not 0.0 <= value <= MOST:
                headline = f"{name} is {'absurd' if value > 0.0 else 'negative or no number'}"
                severity = subject.suspect_severity if value > MOST else Severity.ERROR
                bound = MOST if value > MOST else 0.0
                yield finding(CODE, headline, where=where, value=value, bound=bound, severity=severity)
            elif value > USUAL_MOST:
                headline = f"{name} is higher than that of any dry pair"
                severity = Severity.WARNING
                yield finding(CODE, headline, where=where, value=value, bound=USUAL_MOST, severity=severity)
        if dynamic - static > _FRICTION_ROUNDING:
            headline = "static friction is below dynamic"
            yield finding(CODE, headline, where=where, value=static, bound=dynamic)
        elif 0.0 <= dynamic < LEAST_DYNAMIC_SHARE * static:
            headline = "dynamic friction is far below static"
            bound, severity = LEAST_DYNAMIC_SHARE * static, Severity.WARNING
            yield finding(CODE, headline, where=where, value=dynamic, bound=bound, severity=severity)
        if static == dynamic == 0.0:
            # The schema's fallback is 0: a material that states nothing is smoother than ice.
            stated = any(authored(prim, name) for name in NAMES)
            headline = "the material has no friction" if stated else "friction is not stated, which means none"
            severity = Severity.WARNING if stated else subject.suspect_severity
            yield finding(CODE, headline, where=where, value=0.0, bound=0.0, severity=severity)


RULE = Rule(CODE, "0 <= dynamic <= static <= 2 (error above 10)", "Coulomb friction; UsdPhysicsMaterialAPI", check)
