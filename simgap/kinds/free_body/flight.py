"""Direct estimates from free flight: the mass centre falls on a parabola but for forces that are not gravity.

Positions are compared with double integrals of accelerations, less a straight line per flight: nothing is
differentiated. Terms of the model that are forces are integrated along.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import cumulative_trapezoid

from schemas.arrays import FloatArray
from sim.dynamics.hooks import BodyState
from simgap.kinds.free_body.normal_equations import NormalEquations, of_values
from simgap.kinds.free_body.toss import Toss

Columns = Callable[[Toss, FloatArray], FloatArray]  # velocity (n, 3) -> accelerations (n, 3, k)


def gravity(toss: Toss) -> NormalEquations | None:
    """gravity_mps2."""
    size = float(np.linalg.norm(toss.gravity))
    return _fitted(toss, lambda toss, v: _steady(v, toss.gravity[:, None] / size), np.array([size]))


def length_scale(toss: Toss) -> NormalEquations | None:
    """factor, as fall over expected fall."""
    return _fitted(toss, lambda toss, v: _steady(v, toss.gravity[:, None]), np.ones(1))


def clock(toss: Toss) -> NormalEquations | None:
    """factor: accelerations go with its inverse square."""
    fall = length_scale(toss)
    if fall is None:
        return None
    return of_values(np.maximum(1.0 + fall.g / fall.H[:, 0], 0.05) ** -0.5, 1.0)


def tilt(toss: Toss) -> NormalEquations | None:
    """about_x_rad, about_y_rad in world axes."""
    turned = np.cross(np.eye(3)[:2], toss.body.gravity_W)
    return _fitted(toss, lambda toss, v: _steady(v, toss.support_rotation.apply(turned).T), np.zeros(2))


def force(toss: Toss) -> NormalEquations | None:
    """x_N, y_N, z_N in world axes."""
    pushed = toss.support_rotation.as_matrix() / toss.body.mass_kg
    return _fitted(toss, lambda toss, v: _steady(v, pushed), np.zeros(3))


def linear_drag(toss: Toss) -> NormalEquations | None:
    """drag_Nspm, with the pull of gravity left open: only what changes with speed is drag."""
    return _fitted(toss, lambda toss, v: _beside_gravity(toss, v, -v / toss.body.mass_kg), np.zeros(2))


def quadratic_drag(toss: Toss) -> NormalEquations | None:
    """drag_Ns2pm2, with the pull of gravity left open."""

    def columns(toss: Toss, v: FloatArray) -> FloatArray:
        speed = np.linalg.norm(v, axis=1, keepdims=True)
        return _beside_gravity(toss, v, -speed * v / toss.body.mass_kg)

    return _fitted(toss, columns, np.zeros(2))


def com_offset(toss: Toss) -> NormalEquations | None:
    """x_m, y_m, z_m: whatever the pull, the mass centre does not wobble."""
    H, g = np.zeros((3, 3)), np.zeros(3)
    for part in _long(toss):
        basis = _powers(toss.t_s[part], 2)
        wobble = np.stack([_without(basis, -toss.matrices[part][:, :, k]).ravel() for k in range(3)], axis=1)
        H += wobble.T @ wobble
        g += wobble.T @ _without(basis, toss.com[part]).ravel()
    return NormalEquations(H, g, toss.body.com_B) if H.any() else None


def _fitted(toss: Toss, columns: Columns, origin: FloatArray) -> NormalEquations | None:
    k = len(origin)
    H, g = np.zeros((k, k)), np.zeros(k)
    for part in _long(toss):
        t = toss.t_s[part]
        basis = _powers(t, 1)
        c = np.polynomial.polynomial.polyfit(t - t.mean(), toss.com[part], 2)
        v = c[1] + 2.0 * (t - t.mean())[:, None] * c[2]
        design = columns(toss, v)
        moved = np.stack([_without(basis, _twice(t, design[:, :, j])).ravel() for j in range(k)], axis=1)
        seen = _without(basis, toss.com[part] - _twice(t, _expected(toss, part, v))).ravel()
        H += moved.T @ moved
        g += moved.T @ seen
    return NormalEquations(H, g, origin) if H.any() else None


def _expected(toss: Toss, part: slice, v: FloatArray) -> FloatArray:
    """(n, 3) acceleration by gravity and the forces of the model."""
    total = np.repeat(toss.gravity[None], len(v), axis=0)
    if toss.applied.wrenches:
        p, quat = toss.series.columns["p"][part], toss.series.columns["quat_wxyz"][part]
        spin = toss.support_rotation.inv().apply(toss.R[part].apply(toss.series.columns["w_B"][part]))
        state = BodyState(toss.t_s[part][:, None], p, quat, toss.support_rotation.inv().apply(v), spin)
        for hook, values in toss.applied.wrenches:
            total = total + toss.support_rotation.apply(np.array(hook.wrench(state, values)[0])) / toss.body.mass_kg
    return total


def _beside_gravity(toss: Toss, v: FloatArray, drag: FloatArray) -> FloatArray:
    return np.stack([drag, np.broadcast_to(toss.gravity, v.shape)], axis=2)


def _steady(v: FloatArray, columns: FloatArray) -> FloatArray:
    return np.broadcast_to(columns, (len(v), *columns.shape))


def _long(toss: Toss) -> list[slice]:
    return [f for f in toss.flights if f.stop - f.start >= toss.flight_rows]


def _powers(t_s: FloatArray, order: int) -> FloatArray:
    """Orthonormal (n, order + 1)."""
    t = t_s - t_s.mean()
    return np.linalg.qr(np.stack([t**k for k in range(order + 1)], axis=1))[0]


def _without(basis: FloatArray, values: FloatArray) -> FloatArray:
    return values - basis @ (basis.T @ values)


def _twice(t_s: FloatArray, acceleration: FloatArray) -> FloatArray:
    """(n, 3) double integral over time from the first row."""
    v = cumulative_trapezoid(acceleration, t_s, axis=0, initial=0.0)
    return cumulative_trapezoid(v, t_s, axis=0, initial=0.0)
