"""Rule: the mass agrees with the density of the contact material."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.body.density import LEAST_KGM3, MOST_KGM3
from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.body import SKIN_M
from gate.subject.contact import contact_material
from gate.subject.values import at, number
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-density-stated",
    "The mass contradicts the density of the contact material",
    "Either the mass or the material is wrong; engines that compute mass from density differ from the others.",
    "make physics:mass and physics:density of the material agree",
)
MOST_MASS_RATIO = 1.5  # Colliders may be a little smaller than the solid.


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per impossible material density, and per body heavier than its colliders full of that material."""
    to_si = subject.kilograms_per_unit / subject.frames.meters_per_unit**3
    for prim in subject.contact_materials:
        density = number(prim, "physics:density", 0.0) * to_si
        if density != 0.0 and not LEAST_KGM3 <= density <= MOST_KGM3:
            yield finding(
                CODE,
                "the material has an impossible density",
                where=at(prim),
                value=density,
                bound=LEAST_KGM3 if density < LEAST_KGM3 else MOST_KGM3,
                unit="kg/m3",
                severity=subject.suspect_severity if density > 0.0 else Severity.ERROR,
            )
    # A package lists the material of every part; the inside of a collider may be denser than its contact material.
    listed = [number(prim, "physics:density", 0.0) * to_si for prim in subject.contact_materials]
    densest = max(listed, default=0.0) if subject.released and len(listed) > 1 else 0.0
    for body in subject.active_bodies:
        most_kg = _most_kg(body, to_si, densest)
        if body.mass_kg is not None and body.mass_kg > MOST_MASS_RATIO * most_kg:
            yield finding(
                CODE,
                "the body is heavier than its colliders full of their material",
                where=at(body.prim),
                value=body.mass_kg,
                bound=MOST_MASS_RATIO * most_kg,
                unit="kg",
                severity=subject.suspect_severity,
            )


def _most_kg(body: Body, to_si: float, least_kgm3: float) -> float:
    """Mass of all colliders, with a skin of 1 mm, filled with the density of their material; inf without a density.

    No material counts as less dense than `least_kgm3`.
    """
    total = 0.0
    for collider in body.active_colliders:
        material = contact_material(collider.prim)
        density = number(material, "physics:density", 0.0) * to_si if material is not None else 0.0
        if not density > 0.0:
            return np.inf
        x, y, z = np.ptp(collider.points_W, axis=0) if len(collider.points_W) else np.zeros(3)
        volume_m3 = collider.hull_W.volume.volume_m3 if collider.hull_W is not None else float(x * y * z)
        total += max(density, least_kgm3) * (volume_m3 + 2.0 * SKIN_M * float(x * y + y * z + z * x))
    return total if total > 0.0 else np.inf


RULE = Rule(CODE, "mass <= 1.5 x density x (volume + 1 mm skin)", "UsdPhysicsMaterialAPI", check)
