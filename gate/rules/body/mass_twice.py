"""Rule: mass is stated once, on the body alone."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import UsdPhysics

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, number
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-mass-twice",
    "Mass is stated more than once",
    "The body's mass wins, so the other number is dead or the mistake.",
    "keep the mass on the body and remove masses and densities below it",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per density beside a mass, and per collider with a mass or density of its own in a body with a mass.

    The body's mass wins everywhere (UsdPhysicsMassAPI), so that the other number is unused or a mistake.
    """
    for body in subject.active_bodies:
        if body.mass_kg is None:
            continue
        names = {body.path: ("physics:density",)}
        names |= {
            str(c.prim.GetPath()): ("physics:mass", "physics:density") for c in body.colliders if c.prim != body.prim
        }
        for path, attributes in names.items():
            prim = subject.stage.GetPrimAtPath(path)
            for name in attributes if prim.HasAPI(UsdPhysics.MassAPI) else ():
                value = number(prim, name, 0.0)
                if value != 0.0 or np.isnan(value):
                    yield finding(
                        CODE,
                        f"{name} is stated although the body has a mass",
                        where=at(prim),
                        value=value,
                        bound=body.mass_kg,
                        severity=subject.required_severity,
                    )


RULE = Rule(CODE, "mass on the body alone", "UsdPhysicsMassAPI: precedence of mass and density", check)
