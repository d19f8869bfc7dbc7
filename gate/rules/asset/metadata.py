"""Rule: mass and number of bodies in the metadata equal those of the bodies."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import STATED_TOLERANCE, at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-metadata",
    "The metadata state another mass or number of bodies than there are",
    "Catalogues and schedulers read the metadata, not the prims.",
    "write the metadata again from the prims",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding when `mass` is not the sum over the bodies, or `rigid_body_count` not their number."""
    masses = [body.mass_kg for body in subject.active_bodies]
    stated, count = _number(subject.metadata.get("mass")), _number(subject.metadata.get("rigid_body_count"))
    if stated is not None and masses and None not in masses:
        total = float(sum(m for m in masses if m is not None))
        if not abs(stated - total) <= STATED_TOLERANCE * total:
            headline = "the metadata state another mass than the bodies have"
            yield finding(CODE, headline, where=at(subject.root), value=total, bound=stated, unit="kg")
    if count is not None and count != len(subject.bodies):
        headline = "the metadata count other bodies than there are"
        yield finding(CODE, headline, where=at(subject.root), value=len(subject.bodies), bound=count)


def _number(value: Any) -> float | None:
    """None where the field is absent; NaN where it is no number, which equals nothing."""
    if value is None:
        return None
    return float(value) if isinstance(value, int | float) else float(np.nan)


RULE = Rule(CODE, "mass to 0.1 %, rigid_body_count exactly", "SimReady SR.004", check)
