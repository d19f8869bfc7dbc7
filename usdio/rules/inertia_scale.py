"""Rule: the inertia fits the mass and the size of the colliders."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import Usd, UsdPhysics

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.subject import at, bodies, collider_points, mass_kg

# A hollow box of corners alone has 3 times the spread of the full box; a lamp with a lead foot has a small one.
LEAST_RATIO, MOST_RATIO = 1.0 / 30.0, 4.5


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per body whose `trace(I) / 2` is far from that of a solid box around its colliders.

    `trace(I) / 2` is the sum of `m r^2` about the mass centre, whatever the axes; for a solid box with edges a, b, c
    it is `m (a^2 + b^2 + c^2) / 12`.
    """
    for body in bodies(stage):
        mass, points = mass_kg(body), collider_points(body)
        if mass is None or len(points) == 0:
            continue
        moments = np.asarray(UsdPhysics.MassAPI(body).GetDiagonalInertiaAttr().Get(), dtype=np.float64)
        if not np.all(moments > 0.0):
            continue  # The inertia rule says so.
        box = mass * float(np.sum(np.ptp(points, axis=0) ** 2)) / 12.0
        ratio = 0.5 * float(moments.sum()) / box if box > 0.0 else 1.0
        if not LEAST_RATIO <= ratio <= MOST_RATIO:
            yield finding(
                "asset/gate-inertia-scale",
                f"the inertia is {ratio:.3g} times that of a solid box of this size and mass",
                where=at(body),
                value=ratio,
                bound=LEAST_RATIO if ratio < 1.0 else MOST_RATIO,
            )
