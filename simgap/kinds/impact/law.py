"""Planar rigid impact at one contact with Coulomb friction and Poisson restitution, in closed form for many events.

Routh's method: the normal impulse grows from zero; slip and approach change linearly with it, with a kink where slip
ends (Wang and Mason, J. Appl. Mech. 59, 1992). Restitution is impulse(restitution) / impulse(compression).
"""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray

_TINY = 1e-12


def mobility(mass_kg: float, inertia_kgm2: float, com_W: FloatArray) -> FloatArray:
    """(n, 3, 3) change of (vx, vy, rate) of the reference point per impulse on it; com_W (n, 2) from that point, m."""
    shift = np.tile(np.eye(3), (len(com_W), 1, 1))
    shift[:, 0, 2], shift[:, 1, 2] = com_W[:, 1], -com_W[:, 0]
    return shift @ np.diag([1.0 / mass_kg, 1.0 / mass_kg, 1.0 / inertia_kgm2]) @ shift.transpose(0, 2, 1)


def velocity_after(
    before: FloatArray, normal: FloatArray, tangent: FloatArray, W: FloatArray, mu: float, restitution: float
) -> FloatArray:
    """(n, 3) velocity after the impact from that before; normal, tangent (n, 3) Jacobians; W as `mobility` gives it.

    Events that do not approach stay as they are.
    """
    a = np.einsum("ni,nij,nj->n", normal, W, normal)
    b = np.einsum("ni,nij,nj->n", normal, W, tangent)
    c = np.einsum("ni,nij,nj->n", tangent, W, tangent)
    approach = np.einsum("ni,ni->n", normal, before)
    slip = np.einsum("ni,ni->n", tangent, before)
    # A contact that does not slip yet starts to slip where the normal impulse drives it, if friction cannot hold.
    way = np.where(np.abs(slip) > _TINY, np.sign(slip), np.where(np.abs(b) > mu * c, np.sign(b), 0.0))
    first_ratio = np.where(way == 0.0, -b / c, -mu * way)  # tangential per normal impulse
    slip_rate = b + first_ratio * c
    ends = np.where(slip * slip_rate < 0.0, -slip / np.where(slip_rate == 0.0, 1.0, slip_rate), np.inf)
    second_ratio = np.where(np.abs(b) <= mu * c, -b / c, -mu * np.sign(b))
    compressed = _reach_zero(approach, a + first_ratio * b, ends, a + second_ratio * b)
    total = (1.0 + restitution) * compressed
    along = first_ratio * np.minimum(total, ends) + second_ratio * np.maximum(total - ends, 0.0)
    impulse = total[:, None] * normal + along[:, None] * tangent
    return before + np.einsum("nij,nj->ni", W, impulse)


def _reach_zero(approach: FloatArray, first: FloatArray, kink: FloatArray, second: FloatArray) -> FloatArray:
    """(n,) normal impulse at which the approach ends; its rates are `first` up to `kink` and `second` after it."""
    need = np.maximum(-approach, 0.0)
    straight = np.where(first > _TINY, need / np.maximum(first, _TINY), np.inf)
    at_kink = np.where(np.isfinite(kink), kink, 0.0)
    bent = at_kink + np.maximum(need - first * at_kink, 0.0) / np.maximum(second, _TINY)
    return np.where(straight <= kink, np.where(np.isfinite(straight), straight, 0.0), bent)
