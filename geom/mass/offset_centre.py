"""Inertia tensor (3, 3) of a body whose stated mass centre differs from that of its uniform filling."""

from __future__ import annotations

import numpy as np

from geom.mass.inertia_bounds import rms_distance_and_bound
from schemas.arrays import FloatArray

# The contracted mass may have this share of the RMS distance that fits inside the shape (`rms_distance_and_bound`).
MAX_RMS_SHARE = 0.8


def contraction_about(
    centre_m: FloatArray, points: FloatArray, even_centre_m: FloatArray, inertia_m2: FloatArray
) -> FloatArray:
    """Linear map S (3, 3) that contracts uniformly spread mass so that it fits inside the shape about `centre_m` (m).

    points      (n, 3) of the shape; `centre_m` (3,) lies inside their hull.
    inertia_m2  (3, 3) of the uniform filling per kilogram, about `even_centre_m` (3,).

    Along the line from the uniform centre to the stated one the RMS distance shrinks to `MAX_RMS_SHARE` of the root of
    `a b`, where the shape extends a to one side and b to the other (Bhatia and Davis 2000). Other directions stay,
    unless all must shrink to fit there too. S is the identity where the uniform filling fits; it rotates with the
    shape.
    """
    away = centre_m - even_centre_m
    length = float(np.linalg.norm(away))
    shrinkage = np.zeros((3, 3))
    if length > 0.0:
        u = away / length
        along = (points - centre_m) @ u
        rms_bound = np.sqrt(max(float(along.max()), 0.0) * max(float(-along.min()), 0.0))
        spread = np.sqrt(max(float(0.5 * np.trace(inertia_m2) - u @ inertia_m2 @ u), np.finfo(float).tiny))
        shrinkage = (1.0 - min(1.0, MAX_RMS_SHARE * rms_bound / spread)) * np.outer(u, u)
    S = np.eye(3) - shrinkage
    rms, rms_bound = rms_distance_and_bound(contracted_inertia(inertia_m2, S), points - centre_m)
    return S * min(1.0, MAX_RMS_SHARE * rms_bound / rms) if rms > 0.0 and rms_bound > 0.0 else S


def contracted_inertia(inertia: FloatArray, S: FloatArray) -> FloatArray:
    """`inertia` (3, 3) about the mass centre, after all mass was moved towards the centre by the map `S` (3, 3)."""
    second = S @ (0.5 * np.trace(inertia) * np.eye(3) - inertia) @ S.T
    return np.trace(second) * np.eye(3) - second


def relative_depth(centre_m: FloatArray, points: FloatArray, even_centre_m: FloatArray) -> float:
    """Depth of `centre_m` below the surface, on the line out from the uniform centre, as a share of the extent there.

    0.5 where the uniform centre is half way and the stated one beside it; 0 on the surface, negative outside.
    """
    away = centre_m - even_centre_m
    length = float(np.linalg.norm(away))
    if length == 0.0:
        return 0.5
    along = (points - centre_m) @ (away / length)
    return float(along.max() / max(np.ptp(along), np.finfo(float).tiny))
