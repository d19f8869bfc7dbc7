"""The check of all readers that the coordinates of points (n, 3) are finite."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray, IntArray
from schemas.diagnostics import InvalidInput, Location, finding


def require_finite(
    points: FloatArray, where: Location, *, row: str = "vertex", numbers: IntArray | None = None
) -> None:
    """Raise InvalidInput `asset/nonfinite-vertices` when a coordinate of (n, 3) `points` is NaN or infinite.

    `row` is the word of the source format for a point; `numbers` (n,) are its point numbers unless they start at 0.
    """
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if not len(bad):
        return
    number = bad[0] if numbers is None else numbers[bad[0]]
    mesh = f" of mesh '{where.mesh}'" if where.mesh else ""
    at = ", ".join(f"{c:g}" for c in points[bad[0]])
    headline = f"{row} {number}{mesh} is ({at}); {len(bad)} of {len(points)} are not finite"
    raise InvalidInput(
        finding("asset/nonfinite-vertices", headline, where=where, value=len(bad), bound=0, unit="vertices")
    )
