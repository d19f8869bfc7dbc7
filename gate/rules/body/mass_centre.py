"""Rule: the mass centre lies inside the hull of the body."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.body import diagonal, hull_of, stacked
from gate.subject.values import at, vector
from schemas.arrays import FloatArray
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-mass-centre-outside",
    "The mass centre lies outside the colliders",
    "The object would topple or balance in ways its shape forbids.",
    "check the frame of physics:centerOfMass: it is the body's own",
)
_OUTSIDE_SHARE = 0.01  # of the diagonal: colliders may be tighter than the solid by their fidelity
_UNSTATED = -np.inf  # UsdPhysicsMassAPI: the engine computes it


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body whose mass centre is over 1 % of the diagonal outside the convex hull of its colliders."""
    for body in subject.active_bodies:
        centre = vector(body.prim, "physics:centerOfMass", (_UNSTATED,) * 3)
        points = body.collider_points_W
        if body.mass_kg is None or len(points) == 0:
            continue
        if np.all(centre == _UNSTATED):
            if subject.released:
                yield finding(CODE, "the mass centre is not stated", where=at(body.prim))
            continue
        matrix = subject.frames.matrix(body.prim)
        # Where the file claims nothing, visible parts without a collider may carry mass too.
        cloud = points if subject.released else stacked([points, body.visible_points_W])
        outside_m = _distance_outside(matrix[:3, :3] @ centre + matrix[:3, 3], cloud, body, subject.released)
        bound_m = _OUTSIDE_SHARE * diagonal(cloud)
        if not outside_m <= bound_m:
            yield finding(
                CODE,
                "the mass centre lies outside the colliders",
                where=at(body.prim),
                value=outside_m,
                bound=bound_m,
                unit="m",
                severity=subject.suspect_severity if np.isfinite(outside_m) else Severity.ERROR,
            )


def _distance_outside(centre_W: FloatArray, cloud: FloatArray, body: Body, colliders_only: bool) -> float:
    """How far `centre_W` lies beyond the worst face plane of the hull, or of the bounding box when it is flat."""
    hull = body.hull_W if colliders_only else hull_of(cloud)
    if hull is None:
        return float(np.max([cloud.min(axis=0) - centre_W, centre_W - cloud.max(axis=0)]))
    normals, offsets = hull.planes
    return float(np.max(normals @ centre_W - offsets))


RULE = Rule(CODE, "inside the hull, or within 1 % of its diagonal", "a convex combination of points of the body", check)
