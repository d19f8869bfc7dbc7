"""Rule: the world transform of a body has no scale, shear or mirroring."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, format_numbers
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-body-scale",
    "A rigid body is scaled, sheared or mirrored",
    "Engines drop, bake or misread the scale of a body, each in its own way.",
    "apply the scale to the points and leave the body at scale 1",
)
_SCALE_TOLERANCE = 1e-4


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body whose transform, ancestors included, is no rigid motion: engines drop or misread the rest."""
    for body in subject.bodies:
        if not np.all(np.isfinite(body.linear)):
            continue  # Reported by the transform rule.
        deviation = float(np.abs(body.linear.T @ body.linear - np.eye(3)).max())
        if deviation > _SCALE_TOLERANCE or np.linalg.det(body.linear) < 0.0:
            yield finding(
                CODE,
                "the body is scaled, sheared or mirrored",
                where=at(body.prim),
                value=format_numbers(np.linalg.norm(body.linear, axis=0)),
                bound="(1, 1, 1)",
                severity=subject.suspect_severity,
            )


RULE = Rule(CODE, "scale 1, no shear, no mirror, to 1e-4", "SimReady RB.007, RB.009, RB.010", check)
