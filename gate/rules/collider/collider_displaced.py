"""Rule: position and size of the colliders match the visible surface, by their support functions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.body import diagonal
from gate.subject.values import at
from geom.convex.penetration import even_directions
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-collider-displaced",
    "Colliders and visible surface do not coincide",
    "Contacts would happen where nothing is seen.",
    "check place, scale and completeness of the colliders",
)
# Shares of the diagonal of the visible bounds. Packages meet all three with room; elsewhere one coarse box is usual.
MOST_GAP, MOST_SHIFT, MOST_GROWTH = 0.1, 0.025, 0.06
SUSPICIOUS_SHIFT = 0.0125  # packages of real assets stay below 0.007
ELSEWHERE_GAP = 0.25
_SUPPORT_DIRECTIONS = 128


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body whose colliders, seen from outside, are moved, scaled or bounded otherwise than its surface.

    Shift and growth are fitted to the difference of the two support functions: moving a shape by t changes its support
    in direction d by t . d, growing it about its centre changes all of them in proportion.
    """
    for body in subject.active_bodies:
        colliders, visible = body.collider_points_W, body.visible_points_W
        if len(colliders) == 0 or len(visible) == 0 or not np.all(np.isfinite([*colliders.sum(0), *visible.sum(0)])):
            continue
        yield from _compare(subject, body, body.in_body(colliders), body.in_body(visible))


def _compare(subject: Subject, body: Body, colliders: np.ndarray, visible: np.ndarray) -> Iterator[Diagnostic]:
    size_m = diagonal(visible)
    gaps = [colliders.min(axis=0) - visible.min(axis=0), colliders.max(axis=0) - visible.max(axis=0)]
    gap_m, bound_m = float(np.abs(gaps).max()), (MOST_GAP if subject.released else ELSEWHERE_GAP) * size_m
    if gap_m > bound_m:
        headline = "colliders and visible surface have different bounds"
        severity = subject.suspect_severity
        yield finding(CODE, headline, where=at(body.prim), value=gap_m, bound=bound_m, unit="m", severity=severity)
    if not subject.released or gap_m > bound_m:
        return
    shift_m, growth = _shift_and_growth(colliders, visible)
    if shift_m > SUSPICIOUS_SHIFT * size_m:
        wrong = shift_m > MOST_SHIFT * size_m
        headline, bound_m = (
            "the colliders are moved against the visible surface",
            (MOST_SHIFT if wrong else SUSPICIOUS_SHIFT) * size_m,
        )
        severity = Severity.ERROR if wrong else Severity.WARNING
        yield finding(CODE, headline, where=at(body.prim), value=shift_m, bound=bound_m, unit="m", severity=severity)
    elif abs(growth - 1.0) > MOST_GROWTH:
        headline = "the colliders are larger or smaller than the visible surface"
        yield finding(
            CODE, headline, where=at(body.prim), value=growth, bound=1.0 + np.sign(growth - 1.0) * MOST_GROWTH
        )


def _shift_and_growth(colliders: np.ndarray, visible: np.ndarray) -> tuple[float, float]:
    """Least-squares shift in metres, and the median ratio of extents about the visible centre."""
    directions = even_directions(_SUPPORT_DIRECTIONS)
    centre = 0.5 * (visible.min(axis=0) + visible.max(axis=0))
    outer, inner = (((cloud - centre) @ directions.T).max(axis=0) for cloud in (colliders, visible))
    columns = np.concatenate([directions, np.ones((_SUPPORT_DIRECTIONS, 1))], axis=1)
    shift = np.linalg.lstsq(columns, outer - inner, rcond=None)[0][:3]
    return float(np.linalg.norm(shift)), float(np.median(outer / np.maximum(inner, 1e-12)))


RULE = Rule(
    CODE,
    "bounds within 10 % of the diagonal, shift within 2.5 % (warning: 1.25 %), size within 6 % (outside packages: "
    "bounds within 25 %)",
    "support functions of convex bodies; bounds met by packages of real assets",
    check,
)
