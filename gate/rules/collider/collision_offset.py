"""Rule: contact and rest offsets of colliders are ordered and below the collider size."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, number
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-collision-offset",
    "Contact and rest offsets are out of order",
    "Objects float above what they stand on or sink into it; engines refuse a rest offset above the contact one.",
    "remove the offsets or keep 0 <= restOffset <= contactOffset, both small",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per collider whose PhysX offsets are no lengths, out of order or larger than the collider."""
    for collider in subject.colliders:
        contact = number(collider.prim, "physxCollision:contactOffset", -np.inf) * subject.frames.meters_per_unit
        rest = number(collider.prim, "physxCollision:restOffset", -np.inf) * subject.frames.meters_per_unit
        points = collider.points_W
        size_m = float(np.ptp(points, axis=0).max()) if len(points) else np.inf
        # -inf leaves the choice to the engine; a rest offset may be negative.
        ordered = contact == -np.inf or (0.0 <= contact <= size_m and (rest == -np.inf or rest <= contact))
        possible = rest == -np.inf or abs(rest) <= size_m
        if not (ordered and possible):
            headline = "contact and rest offset are out of order"
            yield finding(CODE, headline, where=at(collider.prim), value=contact, bound=rest, unit="m")


RULE = Rule(CODE, "0 <= contactOffset, restOffset <= contactOffset, both below the size", "PhysX schema", check)
