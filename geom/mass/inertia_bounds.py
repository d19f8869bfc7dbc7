"""Root-mean-square distance of mass from its centre: the value of an inertia tensor, and the bound of a shape (m)."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray


def rms_distance_and_bound(inertia_m2: FloatArray, points: FloatArray, slack_m: float = 0.0) -> tuple[float, float]:
    """RMS distance (m) of the mass from its centre along the axis nearest to its bound, and the bound there.

    inertia_m2  (3, 3) per kilogram, about the mass centre.
    points      (n, 3) of the shape from the mass centre, along the same axes; `slack_m` is added to every side.

    Along an axis the mean square is at most `a b`, where the shape extends a to one side of the centre and b to the
    other: the extreme has all mass at these two ends (Bhatia and Davis 2000, A better bound on the variance). A value
    above the bound belongs to no body inside the shape. The bound is 0 when the centre lies outside or a number is not
    finite.
    """
    second, axes = np.linalg.eigh(0.5 * np.trace(inertia_m2) * np.eye(3) - inertia_m2)
    along = points @ axes
    behind, before = slack_m - along.min(axis=0), along.max(axis=0) + slack_m
    if not (np.all(behind > 0.0) and np.all(before > 0.0) and np.all(np.isfinite(behind * before))):
        return 0.0, 0.0
    worst = int(np.argmax(second / (behind * before)))
    return float(np.sqrt(max(second[worst], 0.0))), float(np.sqrt(behind[worst] * before[worst]))
