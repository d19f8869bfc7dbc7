"""Boxes that tumble on a board: rigid contact by impulses at corners, in small steps of an integrator of its own; SI.

A corner that would be below the board at the end of a step is stopped there: the normal velocities of all such corners
are made non-negative by impulses that never pull, within Coulomb's cone, one after another until they settle (projected
Gauss-Seidel; Moreau 1988). Nothing bounces. Far from the board steps are those of free flight.
"""

from __future__ import annotations

import numpy as np

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.flight import flight_rates, flight_step, njit

_STEP_S = 2.5e-4
_SWEEPS, _SETTLED = 60, 1e-7  # of impulses, and their change over mass (m/s) that ends them
_SLOW_MPS = 0.3  # speed at which fading takes half of its share


def box_corners(size_m: Array) -> Array:
    """(8, 3) corners of a box about its middle."""
    signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return signs * size_m


@njit
def on_board(friction, board, x_m, speed_mps):
    """Friction there and at that speed; board (roughness, its repeats in rad/m, share that speed takes)."""
    rubs = friction * (1.0 + board[0] * np.sin(board[1] * x_m))
    return rubs * (1.0 - board[2] * speed_mps / (speed_mps + _SLOW_MPS))


@njit
def _matrix(q, R):
    w, x, y, z = q
    R[0, 0], R[0, 1], R[0, 2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    R[1, 0], R[1, 1], R[1, 2] = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    R[2, 0], R[2, 1], R[2, 2] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


@njit
def _push(v, w, r, inverse, jx, jy, jz):
    """Adds an impulse over mass at lever r to the velocities."""
    v[0] += jx
    v[1] += jy
    v[2] += jz
    tx, ty, tz = r[1] * jz - r[2] * jy, r[2] * jx - r[0] * jz, r[0] * jy - r[1] * jx
    for a in range(3):
        w[a] += inverse[a, 0] * tx + inverse[a, 1] * ty + inverse[a, 2] * tz


@njit
def _speed(v, w, r):
    """Velocity of a point at lever r."""
    return v[0] + w[1] * r[2] - w[2] * r[1], v[1] + w[2] * r[0] - w[0] * r[2], v[2] + w[0] * r[1] - w[1] * r[0]


@njit
def _yielding(r, inverse):
    """Velocity along the world's axes that a unit impulse over mass along each gives a point at r."""
    x, y, z = r
    along_x = 1.0 + inverse[1, 1] * z * z - 2.0 * inverse[1, 2] * y * z + inverse[2, 2] * y * y
    along_y = 1.0 + inverse[2, 2] * x * x - 2.0 * inverse[2, 0] * z * x + inverse[0, 0] * z * z
    along_z = 1.0 + inverse[0, 0] * y * y - 2.0 * inverse[0, 1] * x * y + inverse[1, 1] * x * x
    return along_x, along_y, along_z


@njit
def _stop_corners(height, x_m, levers, v, w, inverse, mu, board, h):
    """Changes velocities v, w (3,) of a body whose corners at `levers` (8, 3) meet the board within the step."""
    normal, along, yields = np.zeros(8), np.zeros((8, 2)), np.zeros((8, 2))
    active, count = np.zeros(8, dtype=np.int64), 0
    for i in range(8):
        if height + levers[i, 2] + h * _speed(v, w, levers[i])[2] < 0.0:
            x, y, z = _yielding(levers[i], inverse)
            yields[i, 0], yields[i, 1] = max(x, y), z
            active[count] = i
            count += 1
    for _ in range(_SWEEPS if count else 0):
        change = 0.0
        for i in active[:count]:
            r, gap = levers[i], height + levers[i, 2]
            # A corner above the board may come down to it; one below is let out slowly.
            wanted = -gap / h if gap > 0.0 else min(-0.02 * gap / h, 0.05)
            j = max(normal[i] + (wanted - _speed(v, w, r)[2]) / yields[i, 1], 0.0)
            change = max(change, abs(j - normal[i]))
            _push(v, w, r, inverse, 0.0, 0.0, j - normal[i])
            normal[i] = j
            ux, uy, _uz = _speed(v, w, r)
            speed = np.sqrt(ux * ux + uy * uy)
            most = on_board(mu, board, x_m + r[0], speed) * j
            jx, jy = along[i, 0] - ux / yields[i, 0], along[i, 1] - uy / yields[i, 0]
            size = np.sqrt(jx * jx + jy * jy)
            if size > most:
                jx, jy = jx * most / size, jy * most / size
            change = max(change, max(abs(jx - along[i, 0]), abs(jy - along[i, 1])))
            _push(v, w, r, inverse, jx - along[i, 0], jy - along[i, 1], 0.0)
            along[i, 0], along[i, 1] = jx, jy
        if change < _SETTLED:
            break


@njit
def tumble_runs(t, start, pull, forces, inertia, corners, mu, board, out):
    """Every run into out (r, rows, 13); inertia (3,) and forces are per mass, board as in `on_board`."""
    k, R = np.empty((4, 13)), np.empty((3, 3))
    radius = np.sqrt((corners**2).sum(axis=1)).max()
    for run in range(len(t)):
        x = start[run].copy()
        out[run, 0] = x
        for row in range(t.shape[1] - 1):
            span = t[run, row + 1] - t[run, row]
            steps = max(1, int(np.ceil(span / _STEP_S)))
            h = span / steps
            for s in range(steps):
                now = t[run, row] + s * h
                speed = np.sqrt((x[7:10] ** 2).sum()) + radius * np.sqrt((x[10:] ** 2).sum())
                flight_rates(x, now, pull, forces, inertia, k[0])
                _matrix(x[3:7], R)
                lowest = x[2] + (corners @ R[2]).min()
                if lowest > 2.0 * h * speed + 10.0 * h * h * np.sqrt((pull**2).sum()):
                    x = flight_step(x, now, h, pull, forces, inertia, k)
                else:
                    v = x[7:10] + h * k[0][7:10]
                    w = R @ (x[10:] + h * k[0][10:])
                    inverse = R @ np.diag(1.0 / inertia) @ R.T
                    _stop_corners(x[2], x[0], corners @ R.T, v, w, inverse, mu, board, h)
                    x[:3] += h * v
                    x[7:10] = v
                    w = R.T @ w
                    a, b, c, d = x[3], x[4], x[5], x[6]
                    angle = h * np.sqrt((w**2).sum())
                    cosine, sine = np.cos(0.5 * angle), np.sin(0.5 * angle) * h / max(angle, 1e-300)
                    e, f, g = sine * w[0], sine * w[1], sine * w[2]
                    x[3] = a * cosine - b * e - c * f - d * g
                    x[4] = a * e + b * cosine + c * g - d * f
                    x[5] = a * f - b * g + c * cosine + d * e
                    x[6] = a * g + b * f - c * e + d * cosine
                    x[10:] = w
                x[3:7] /= np.sqrt((x[3:7] ** 2).sum())
            out[run, row + 1] = x
