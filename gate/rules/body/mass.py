"""Rule: every body has a positive, finite mass."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import UsdPhysics

from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.values import at, authored, number
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-mass",
    "A body has no possible mass",
    "Engines then invent one (often 1 kg) or refuse the body.",
    "author physics:mass in kilograms on the body, with PhysicsMassAPI applied",
)
LEAST_KG, MOST_KG = 1e-7, 1e6  # A grain of salt weighs 6e-8 kg, a loaded truck 4e4 kg.


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per mass that is absent, zero, negative, not finite, absurd, or authored where engines ignore it."""
    for prim in subject.prims:
        if authored(prim, "physics:mass"):
            yield from _authored(subject, prim)
    for body in subject.active_bodies:
        stated = number(body.prim, "physics:mass", 0.0) if body.prim.HasAPI(UsdPhysics.MassAPI) else 0.0
        if stated == 0.0:
            yield from _absent(subject, body)


def _authored(subject: Subject, prim: Any) -> Iterator[Diagnostic]:
    mass = number(prim, "physics:mass") * subject.kilograms_per_unit
    if not (np.isfinite(mass) and mass >= 0.0):
        yield finding(CODE, "the mass is not positive", where=at(prim), value=mass, bound=0.0, unit="kg")
    elif mass > 0.0 and not LEAST_KG <= mass <= MOST_KG:
        bound = LEAST_KG if mass < LEAST_KG else MOST_KG
        headline = "the mass is absurd"
        yield finding(CODE, headline, where=at(prim), value=mass, bound=bound, unit="kg", severity=Severity.WARNING)
    if not prim.HasAPI(UsdPhysics.MassAPI):
        headline = "physics:mass is ignored: PhysicsMassAPI is not applied"
        yield finding(CODE, headline, where=at(prim), value=mass, unit="kg", severity=subject.suspect_severity)


def _absent(subject: Subject, body: Body) -> Iterator[Diagnostic]:
    """Zero means "not stated" (UsdPhysicsMassAPI): the engine takes volume times density, or invents a mass."""
    computable = body.collider_volume is not None
    headline = "the mass is left to the engine" if computable else "there is no mass and no volume to compute it from"
    if subject.released:
        headline = "the body has no mass"
    severity = subject.required_severity if computable else subject.suspect_severity
    if severity is not Severity.INFO:
        yield finding(CODE, headline, where=at(body.prim), value=0.0, bound=LEAST_KG, unit="kg", severity=severity)


RULE = Rule(
    CODE,
    "> 0 (warning outside 1e-7 .. 1e6 kg), on a prim with PhysicsMassAPI",
    "UsdPhysicsMassAPI; SimReady RB.MB",
    check,
)
