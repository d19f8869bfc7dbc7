"""Rule: the mass centre lies near the middle of the body."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from schemas.diagnostics import Diagnostic, Severity, finding
from usdio.rules.rule import Rule
from usdio.subject import Subject
from usdio.subject.values import at, vector

CODE = "asset/gate-mass-centre-far"
MOST_SHARE = 0.3  # of the diagonal; a hammer with a steel head reaches 0.25


def check(subject: Subject) -> Iterator[Diagnostic]:
    """In a package: a finding per body whose mass centre is far from that of its colliders filled evenly."""
    for body in subject.active_bodies if subject.released else ():
        if body.filled is None or body.mass_kg is None:
            continue
        matrix = subject.frames.matrix(body.prim)
        centre_W = matrix[:3, :3] @ vector(body.prim, "physics:centerOfMass", (np.nan,) * 3) + matrix[:3, 3]
        off_m = float(np.linalg.norm(body.in_body(centre_W[None])[0] - body.filled.centre_of_mass_m))
        bound_m = MOST_SHARE * body.diagonal_m
        if off_m > bound_m:
            headline = "the mass centre is far from the middle of the colliders"
            where, severity = at(body.prim), Severity.WARNING
            yield finding(CODE, headline, where=where, value=off_m, bound=bound_m, unit="m", severity=severity)


RULE = Rule(
    CODE, "within 30 % of the diagonal from the centre of evenly filled colliders", "even density; real assets", check
)
