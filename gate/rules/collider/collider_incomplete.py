"""Rule: every part of the visible surface has a collider near it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.body import diagonal, stacked
from gate.subject.values import at
from schemas.arrays import FloatArray
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-collider-incomplete",
    "Part of the visible surface has no collider",
    "A hand reaches into what looks solid.",
    "add the missing collision shapes, or enable them",
)
REACH = 0.05  # of the diagonal
MOST_UNCOVERED_SHARE, ELSEWHERE_SHARE = 0.02, 0.5
_FACE_SAMPLES = 1000


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body of whose visible faces a share lies far outside all of its colliders."""
    for body in subject.active_bodies:
        faces = _face_centres(body)
        hulls = [c.hull_W for c in body.active_colliders if c.hull_W is not None]
        if len(faces) == 0 or not hulls or not np.all(np.isfinite(faces)):
            continue  # Flat colliders are reported by the collider-shape rule.
        away = np.full(len(faces), np.inf)
        for hull in hulls:
            normals, offsets = hull.planes
            away = np.minimum(away, (faces @ normals.T - offsets).max(axis=1))
        share = float((away > REACH * diagonal(body.visible_points_W)).mean())
        bound = MOST_UNCOVERED_SHARE if subject.released else ELSEWHERE_SHARE
        if share > bound:
            yield finding(
                CODE,
                "part of the visible surface has no collider",
                where=at(body.prim),
                value=share,
                bound=bound,
                severity=Severity.ERROR if subject.released else Severity.WARNING,
            )


def _face_centres(body: Body) -> FloatArray:
    """(n, 3) centres of the visible faces, every k-th so that there are at most 1000."""
    centres = stacked([s.points_W[s.triangles].mean(axis=1) for s in body.surfaces if len(s.triangles)])
    return centres[:: max(1, -(-len(centres) // _FACE_SAMPLES))]


RULE = Rule(
    CODE,
    "2 % of the visible faces further than 5 % of the diagonal from every collider (50 % outside packages)",
    "signed distance to convex hulls; packages of real assets have none",
    check,
)
