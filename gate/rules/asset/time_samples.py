"""Rule: the asset has no time samples, which engines ignore."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-time-samples",
    "Values of the asset are animated",
    "Engines read physics at the default time only; an asset at rest has no motion of its own.",
    "author default values instead of time samples",
)
PHYSICS = ("physics:", "drive:", "limit:", "physx", "newton:", "mjc:")


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per prim whose physics values are animated, which engines ignore; in a package, per animated prim."""
    seen: set[str] = set()
    for attribute in subject.attributes:
        if attribute.GetNumTimeSamples() == 0:
            continue
        physical = attribute.GetName().startswith(PHYSICS)
        prim = attribute.GetPrim()
        path = str(prim.GetPath())
        if path in seen or not (physical or subject.released):
            continue
        seen.add(path)
        yield finding(
            CODE,
            f"{attribute.GetName()} is animated",
            where=at(prim),
            value=attribute.GetNumTimeSamples(),
            bound=0,
            unit="samples",
            severity=Severity.ERROR if subject.released else Severity.WARNING,
        )


RULE = Rule(CODE, "no time samples", "UsdPhysics reads values at the default time", check)
