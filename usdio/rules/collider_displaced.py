"""Rule: colliders stand where the visible surface is."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import Usd

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.subject import at, bodies, collider_points, visible_points

_TOLERANCE = 0.1  # of the diagonal of the visible bounds


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per body whose collider bounds differ from its visible bounds by over 10 % of their diagonal."""
    for body in bodies(stage):
        colliders, visible = collider_points(body), visible_points(stage, body)
        if len(colliders) == 0 or len(visible) == 0:
            continue
        gaps = [colliders.min(axis=0) - visible.min(axis=0), colliders.max(axis=0) - visible.max(axis=0)]
        gap_m, bound_m = float(np.abs(gaps).max()), _TOLERANCE * float(np.linalg.norm(np.ptp(visible, axis=0)))
        if not gap_m <= bound_m:
            yield finding(
                "asset/gate-collider-displaced",
                "colliders and visible surface have different bounds",
                where=at(body),
                value=gap_m,
                bound=bound_m,
                unit="m",
            )
