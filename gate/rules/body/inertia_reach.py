"""Rule: no moment of inertia is larger than a body of that mass inside the shape can have."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.body import stacked
from gate.subject.inertial import mass_centre, stated_inertia
from gate.subject.values import at
from geom.mass.inertia_bounds import rms_distance_and_bound
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-inertia-reach",
    "A moment of inertia is larger than that mass inside the shape can have",
    "Even with all mass at the far ends of the object it could not turn so slowly.",
    "recompute the inertia in kg m2 about the mass centre, or correct scale and mass",
)
SLACK = 0.01  # of the diagonal, on each side: colliders may be tighter than the solid


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body whose mass would have to lie, in part, outside the hull of its colliders (`inertia_reach`)."""
    for body in subject.active_bodies:
        inertia, centre = stated_inertia(body, subject), mass_centre(body, subject)
        # Where the file claims nothing, visible parts without a collider may carry mass too.
        clouds = [body.collider_points_W] if subject.released else [body.collider_points_W, body.visible_points_W]
        points = body.in_body(stacked(clouds))
        if inertia is None or centre is None or body.mass_kg is None or len(points) == 0:
            continue
        value, bound = rms_distance_and_bound(inertia / body.mass_kg, points - centre, SLACK * body.diagonal_m)
        if value > bound > 0.0:
            yield finding(
                CODE,
                f"the inertia needs mass outside the colliders: {value / bound:.3g} times what fits inside",
                where=at(body.prim),
                value=value,
                bound=bound,
                unit="m",
                severity=subject.suspect_severity,
            )


RULE = Rule(
    CODE,
    "mean square distance along each axis <= reach to one side x reach to the other, 1 % of the diagonal to spare",
    "Bhatia and Davis 2000, A better bound on the variance",
    check,
)
