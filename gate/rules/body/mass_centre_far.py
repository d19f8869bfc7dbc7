"""Rule: the mass centre lies near the middle of the body."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.inertial import mass_centre, shows_one_material
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-mass-centre-far",
    "The mass centre is far from the middle of the body",
    "Few things are that much heavier at one end; an origin left as mass centre looks like this.",
    "recompute physics:centerOfMass from the solid, in the frame of the body",
)
# Shares of the diagonal. A hammer with a steel head reaches 0.25; packages that show one material stay below 0.07.
MOST_OFFSET_SHARE, ONE_MATERIAL_SHARE = 0.3, 0.12


def check(subject: Subject) -> Iterator[Diagnostic]:
    """In a package: a finding per body whose mass centre is far from that of its colliders filled evenly."""
    for body in subject.active_bodies if subject.released else ():
        centre = mass_centre(body, subject)
        if body.collider_volume is None or body.mass_kg is None or centre is None:
            continue
        off_m = float(np.linalg.norm(centre - body.collider_volume.centre_m))
        bound_m = (ONE_MATERIAL_SHARE if shows_one_material(body) else MOST_OFFSET_SHARE) * body.diagonal_m
        if off_m > bound_m:
            headline = "the mass centre is far from the middle of the colliders"
            where, severity = at(body.prim), Severity.WARNING
            yield finding(CODE, headline, where=where, value=off_m, bound=bound_m, unit="m", severity=severity)


RULE = Rule(
    CODE,
    "within 30 % of the diagonal from the centre of evenly filled colliders, 12 % where one material shows",
    "even density; real assets",
    check,
)
