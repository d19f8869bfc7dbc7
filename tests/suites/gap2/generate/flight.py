"""Motion of a flying body, compiled: gravity, drag, lift, gusts, and Euler's equations."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

_GUST_HZ = 4.0

njit: Any = numba.njit(cache=True)


@njit
def flight_rates(x, t, pull, forces, inertia, dx):
    """Time derivative of one flying body; forces (drag, square drag, lift, gust) are per mass."""
    qw, qx, qy, qz = x[3], x[4], x[5], x[6]
    vx, vy, vz = x[7], x[8], x[9]
    wx, wy, wz = x[10], x[11], x[12]
    dx[0], dx[1], dx[2] = vx, vy, vz
    dx[3] = -0.5 * (qx * wx + qy * wy + qz * wz)
    dx[4] = 0.5 * (qw * wx + qy * wz - qz * wy)
    dx[5] = 0.5 * (qw * wy - qx * wz + qz * wx)
    dx[6] = 0.5 * (qw * wz + qx * wy - qy * wx)
    drag = forces[0] + forces[1] * np.sqrt(vx * vx + vy * vy + vz * vz)
    dx[7], dx[8], dx[9] = pull[0] - drag * vx, pull[1] - drag * vy, pull[2] - drag * vz
    if forces[2] != 0.0:  # angular velocity in the world: w + 2 qw (u x w) + 2 u x (u x w)
        ax, ay, az = qy * wz - qz * wy, qz * wx - qx * wz, qx * wy - qy * wx
        sx = wx + 2.0 * (qw * ax + qy * az - qz * ay)
        sy = wy + 2.0 * (qw * ay + qz * ax - qx * az)
        sz = wz + 2.0 * (qw * az + qx * ay - qy * ax)
        dx[7] += forces[2] * (sy * vz - sz * vy)
        dx[8] += forces[2] * (sz * vx - sx * vz)
        dx[9] += forces[2] * (sx * vy - sy * vx)
    if forces[3] != 0.0:
        push = forces[3] * np.sin(2.0 * np.pi * _GUST_HZ * t)
        dx[7] += push
        dx[8] += 0.5 * push
    dx[10] = (inertia[1] - inertia[2]) * wy * wz / inertia[0]
    dx[11] = (inertia[2] - inertia[0]) * wz * wx / inertia[1]
    dx[12] = (inertia[0] - inertia[1]) * wx * wy / inertia[2]


@njit
def flight_step(x, now, h, pull, forces, inertia, k):
    """State after h by a fourth-order Runge-Kutta step; k (4, 13) holds the derivative at x in its first row."""
    flight_rates(x + 0.5 * h * k[0], now + 0.5 * h, pull, forces, inertia, k[1])
    flight_rates(x + 0.5 * h * k[1], now + 0.5 * h, pull, forces, inertia, k[2])
    flight_rates(x + h * k[2], now + h, pull, forces, inertia, k[3])
    return x + h / 6.0 * (k[0] + 2.0 * k[1] + 2.0 * k[2] + k[3])
