"""Rule: mass and collider volume together give a density some material has."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import Usd

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.subject import at, bodies, collider_points, hull, mass_kg

LEAST_KGM3, MOST_KGM3 = 1.0, 25000.0  # A balloon; a little above osmium, the densest element.
_SKIN_M = 1e-3


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per body whose mass over the convex hull of its colliders lies outside 1 .. 25000 kg/m3.

    The hull holds more than the material (hollow things), so only the upper bound is strict. There the hull gets a
    skin of 1 mm, because the collider of a sheet may be thinner than the sheet.
    """
    for body in bodies(stage):
        mass, points = mass_kg(body), collider_points(body)
        if mass is None or len(points) == 0:
            continue
        volume_m3, area_m2 = _volume_and_area(points)
        least, most = mass / (volume_m3 + _SKIN_M * area_m2), mass / volume_m3 if volume_m3 > 0.0 else np.inf
        if least > MOST_KGM3:
            yield finding(
                "asset/gate-density",
                "the body is heavier than any material of its size",
                where=at(body),
                value=least,
                bound=MOST_KGM3,
                unit="kg/m3",
            )
        elif most < LEAST_KGM3:
            yield finding(
                "asset/gate-density",
                "the body is lighter than air of its size",
                where=at(body),
                value=most,
                bound=LEAST_KGM3,
                unit="kg/m3",
            )


def _volume_and_area(points: np.ndarray) -> tuple[float, float]:
    """Of the convex hull; of the bounding box when the points are flat."""
    found = hull(points)
    if found is not None:
        return float(found.volume), float(found.area)
    x, y, z = np.ptp(points, axis=0)
    return float(x * y * z), float(2.0 * (x * y + y * z + z * x))
