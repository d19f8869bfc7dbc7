"""Rule: the mass centre lies inside the hull of the colliders."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import Usd

from schemas.diagnostics import Diagnostic, finding
from schemas.model import FloatArray
from usdio.rules.subject import at, bodies, collider_points, hull, mass_centre_m, mass_kg

_TOLERANCE = 0.01  # of the diagonal: colliders may be tighter than the solid by their fidelity


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per body whose mass centre is over 1 % of the diagonal outside the convex hull of its colliders."""
    for body in bodies(stage):
        points = collider_points(body)
        if mass_kg(body) is None or len(points) == 0:
            continue
        outside_m = _distance_outside(mass_centre_m(body), points)
        bound_m = _TOLERANCE * float(np.linalg.norm(np.ptp(points, axis=0)))
        if not outside_m <= bound_m:
            yield finding(
                "asset/gate-mass-centre-outside",
                "the mass centre lies outside the colliders",
                where=at(body),
                value=outside_m,
                bound=bound_m,
                unit="m",
            )


def _distance_outside(centre: FloatArray, points: FloatArray) -> float:
    """How far `centre` lies beyond the worst face plane of the hull, or of the bounding box when it is flat."""
    found = hull(points)
    if found is None:
        return float(np.max([points.min(axis=0) - centre, centre - points.max(axis=0)]))
    return float(np.max(found.equations[:, :3] @ centre + found.equations[:, 3]))
