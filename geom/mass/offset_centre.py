"""The tensor of a body whose mass centre is not that of its even filling, when nothing else is known about it."""

from __future__ import annotations

import numpy as np

from geom.mass.inertia_bounds import inertia_reach
from schemas.model import FloatArray

# How near to the most that fits inside the shape (`inertia_reach`) the squeezed mass may come along any axis.
MOST_REACH = 0.8


def squeeze_towards(
    centre_m: FloatArray, points: FloatArray, even_centre_m: FloatArray, inertia_m2: FloatArray
) -> FloatArray:
    """(3, 3) map S by which mass spread evenly about its centre is squeezed so that it fits about `centre_m`.

    points      (n, 3) of the shape; `centre_m` (3,) lies inside their hull.
    inertia_m2  (3, 3) of the even filling per kilogram, about `even_centre_m` (3,).

    Along the way from the even centre to the stated one the mass comes as near as it must: to `MOST_REACH` of the root
    of `a b`, where the shape reaches a to one side and b to the other (Bhatia and Davis 2000). Other directions stay,
    unless the whole must shrink to fit there too. The identity where the even filling fits; turns with the shape.
    """
    away = centre_m - even_centre_m
    length = float(np.linalg.norm(away))
    S = np.eye(3)
    if length > 0.0:
        u = away / length
        along = (points - centre_m) @ u
        most = np.sqrt(max(float(along.max()), 0.0) * max(float(-along.min()), 0.0))
        spread = np.sqrt(max(float(0.5 * np.trace(inertia_m2) - u @ inertia_m2 @ u), np.finfo(float).tiny))
        S -= (1.0 - min(1.0, MOST_REACH * most / spread)) * np.outer(u, u)
    reach, most = inertia_reach(squeezed(inertia_m2, S), points - centre_m)
    return S * min(1.0, MOST_REACH * most / reach) if reach > 0.0 and most > 0.0 else S


def squeezed(inertia: FloatArray, S: FloatArray) -> FloatArray:
    """`inertia` (3, 3) about the mass centre, after all mass was moved towards it by the map `S` (3, 3)."""
    second = S @ (0.5 * np.trace(inertia) * np.eye(3) - inertia) @ S.T
    return np.trace(second) * np.eye(3) - second


def skin_share(centre_m: FloatArray, points: FloatArray, even_centre_m: FloatArray) -> float:
    """How deep `centre_m` lies below the skin on the way out from the even centre, as a share of the shape there.

    0.5 where the even centre is half way and the stated one beside it; 0 on the skin, negative outside.
    """
    away = centre_m - even_centre_m
    length = float(np.linalg.norm(away))
    if length == 0.0:
        return 0.5
    along = (points - centre_m) @ (away / length)
    return float(along.max() / max(np.ptp(along), np.finfo(float).tiny))
