"""Rule: mass over collider volume is a density that some material has (kg/m3)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.body import SKIN_M, hull_of, stacked
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-density",
    "Mass and volume give a density no material has",
    "The object would push like lead or float like smoke.",
    "check the mass, the scale and the colliders against each other",
)
LEAST_KGM3, MOST_KGM3 = 1.0, 25000.0  # A balloon; a little above osmium, the densest element.
USUAL_LEAST_KGM3, USUAL_MOST_KGM3 = 4.0, 12000.0  # A lampshade; a little above lead.


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body whose mass is too large for its colliders or too small for their common hull.

    Hulls hold more than the material (hollow things), so the lower bound is generous. For the upper bound they get a
    skin of 1 mm, because the collider of a sheet may be thinner than the sheet.
    """
    for body in subject.active_bodies:
        if body.mass_kg is None or (len(body.collider_points_W) == 0 and len(body.visible_points_W) == 0):
            continue
        solid_m3, hull_m3 = _volumes(body)
        least, most = body.mass_kg / solid_m3, body.mass_kg / hull_m3 if hull_m3 > 0.0 else np.inf
        if least > USUAL_MOST_KGM3:
            impossible, headline = least > MOST_KGM3, "the body is heavier than any material of its size"
            value, bound = least, MOST_KGM3 if impossible else USUAL_MOST_KGM3
        elif most < USUAL_LEAST_KGM3:
            impossible, headline = most < LEAST_KGM3, "the body is lighter than air of its size"
            value, bound = most, LEAST_KGM3 if impossible else USUAL_LEAST_KGM3
        else:
            continue
        yield finding(
            CODE,
            headline if impossible else "the density is unusual",
            where=at(body.prim),
            value=value,
            bound=bound,
            unit="kg/m3",
            severity=subject.suspect_severity if impossible else Severity.WARNING,
        )


def _volumes(body: Body) -> tuple[float, float]:
    """The largest volume the material can have, and that of the hull around everything (m3)."""
    cloud = stacked([body.collider_points_W, body.visible_points_W])
    hull = body.hull_W or hull_of(cloud)
    edges = np.ptp(cloud, axis=0)
    box_area = 2.0 * float(edges[0] * edges[1] + edges[1] * edges[2] + edges[2] * edges[0])
    if hull is None:
        return float(np.prod(edges)) + SKIN_M * box_area, float(np.prod(edges))
    hull_m3 = hull.volume.volume_m3
    filled_m3 = body.collider_volume.volume_m3 if body.collider_volume is not None else hull_m3
    return min(filled_m3, hull_m3) + SKIN_M * box_area, hull_m3


RULE = Rule(CODE, "4 .. 12000 kg/m3 (error beyond 1 .. 25000)", "densities of materials, hollow things allowed", check)
