"""Rule: bodies start at rest, with zero linear and angular velocity."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, format_numbers, vector
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-velocity",
    "A body starts with a velocity",
    "It leaves its place in the first step.",
    "remove physics:velocity and physics:angularVelocity",
)
NAMES = {"physics:velocity": "units/s", "physics:angularVelocity": "deg/s"}


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body with a starting velocity; NaN or infinite is wrong in any file."""
    for body in subject.bodies:
        for name, unit in NAMES.items():
            value = vector(body.prim, name, (0.0, 0.0, 0.0))
            if np.all(value == 0.0):
                continue
            yield finding(
                CODE,
                f"{name} is not zero",
                where=at(body.prim),
                value=format_numbers(value),
                bound="(0, 0, 0)",
                unit=unit,
                severity=subject.suspect_severity if np.all(np.isfinite(value)) else Severity.ERROR,
            )


RULE = Rule(CODE, "0", "UsdPhysicsRigidBodyAPI; a scene places assets at rest", check)
