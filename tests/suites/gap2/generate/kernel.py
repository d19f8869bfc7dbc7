"""Equations of motion of one joint, a slide or a planar chain of up to three links, integrated run by run.

Fourth-order Runge-Kutta within a step in which no joint starts or stops; where dry friction stops a joint, the step is
cut at that instant, and a joint that rests stays at rest until the torque on it exceeds the friction limit. Absolute
angles give the coupling of links: H_ij = A_ij cos(theta_i - theta_j). Inputs are held between breaks.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from tests.suites.gap2.generate.parameters import Number

COULOMB, VISCOUS, QUADRATIC = int(Number.COULOMB), int(Number.VISCOUS), int(Number.QUADRATIC)
STRIBECK, STRIBECK_RATE, LOAD_RADIUS = int(Number.STRIBECK), int(Number.STRIBECK_RATE), int(Number.LOAD_RADIUS)
ASYMMETRY, SPRING, SPRING_REST = int(Number.ASYMMETRY), int(Number.SPRING), int(Number.SPRING_REST)
STOP_LOWER, STOP_UPPER = int(Number.STOP_LOWER), int(Number.STOP_UPPER)
STOP_STIFFNESS, STOP_LOSS = int(Number.STOP_STIFFNESS), int(Number.STOP_LOSS)
DETENT, DETENT_COUNT, DETENT_PHASE = int(Number.DETENT), int(Number.DETENT_COUNT), int(Number.DETENT_PHASE)
ROTOR, GRAVITY_FACTOR, TILT = int(Number.ROTOR), int(Number.GRAVITY_FACTOR), int(Number.TILT)
KP, KD, LIMIT, GAIN, BIAS = (int(Number[n]) for n in ("KP", "KD", "LIMIT", "GAIN", "BIAS"))
DEADBAND, RIPPLE, RIPPLE_COUNT = int(Number.DEADBAND), int(Number.RIPPLE), int(Number.RIPPLE_COUNT)
RIPPLE_PHASE, SAG, LAG = int(Number.RIPPLE_PHASE), int(Number.SAG), int(Number.LAG)
FILTER_RATE, FILTER_DAMPING, SATURATION = (int(Number[n]) for n in ("FILTER_RATE", "FILTER_DAMPING", "SATURATION"))
MOTOR_INERTIA, GEAR_STIFFNESS = int(Number.MOTOR_INERTIA), int(Number.GEAR_STIFFNESS)
GEAR_LOSS, GEAR_PLAY = int(Number.GEAR_LOSS), int(Number.GEAR_PLAY)
HYSTERESIS, HYSTERESIS_TRAVEL = int(Number.HYSTERESIS), int(Number.HYSTERESIS_TRAVEL)
MAGNET, MAGNET_AT, MAGNET_WIDTH = int(Number.MAGNET), int(Number.MAGNET_AT), int(Number.MAGNET_WIDTH)
SHAKE, SHAKE_RATE, HEATING = int(Number.SHAKE), int(Number.SHAKE_RATE), int(Number.HEATING)
PLACE_FRICTION, PLACE_COUNT = int(Number.PLACE_FRICTION), int(Number.PLACE_COUNT)
GAIN_FADE, GAIN_FADE_RATE = int(Number.GAIN_FADE), int(Number.GAIN_FADE_RATE)
SENSOR_LAG, SENSOR_RATE, SENSOR_DAMPING = (int(Number[n]) for n in ("SENSOR_LAG", "SENSOR_RATE", "SENSOR_DAMPING"))
MASS, LEVER = int(Number.MASS), int(Number.LEVER)

FREE, EFFORT, POSITION = 0, 1, 2  # drives
RUNGE_KUTTA, EULER = 0, 1  # methods
_EXTRA = 9  # lagged input, filtered input, its rate, motor, its rate, hysteresis, travel, reading, its rate
_SMOOTH = 2  # mode of a joint without dry friction; -1, 0, 1 are its direction where it has some
_GRAVITY = 9.81  # m/s2

# All in one file: the cache of a compiled function looks at its own file alone, not at those of what it calls.
njit: Any = numba.njit(cache=True, error_model="numpy")


@njit
def _limit(p, q, v, way, travel, load):
    """Largest dry friction at a state for motion along `way`."""
    level = p[COULOMB] + p[STRIBECK] * np.exp(-((v / max(p[STRIBECK_RATE], 1e-12)) ** 2))
    level = level + p[LOAD_RADIUS] * load + p[ASYMMETRY] * way
    level = level * (1.0 + p[PLACE_FRICTION] * np.sin(p[PLACE_COUNT] * q)) * (1.0 + p[HEATING] * travel)
    return max(level, 0.0)


@njit
def _drive_effort(p, kind, u, q, v, supply):
    """Effort that a drive gives at its shaft for an input."""
    if kind == FREE:
        return 0.0
    effort = u
    if kind == POSITION:
        fade = 1.0 - p[GAIN_FADE] * abs(v) / (abs(v) + max(p[GAIN_FADE_RATE], 1e-12))
        effort = fade * (p[KP] * (u - q) - p[KD] * v)
    if p[LIMIT] > 0.0:
        effort = min(max(effort, -p[LIMIT]), p[LIMIT])
    if p[SATURATION] > 0.0:
        effort = min(max(effort, -p[SATURATION]), p[SATURATION])
    if p[DEADBAND] > 0.0:
        effort = np.sign(effort) * max(abs(effort) - p[DEADBAND], 0.0)
    effort = effort * p[GAIN] * (1.0 + p[SAG] * (supply - 1.0))
    effort = effort * (1.0 + p[RIPPLE] * np.sin(p[RIPPLE_COUNT] * q - p[RIPPLE_PHASE]))
    return effort + p[BIAS]


@njit
def _passive(p, q, v, hysteresis, t, phase):
    """Torque of springs, stops, detents, viscous and quadratic drag and of what no library describes."""
    torque = -p[VISCOUS] * v - p[QUADRATIC] * v * abs(v) - p[SPRING] * (q - p[SPRING_REST])
    if p[STOP_STIFFNESS] > 0.0:
        above, below = q - p[STOP_UPPER], p[STOP_LOWER] - q
        if above > 0.0:
            torque -= p[STOP_STIFFNESS] * above**1.5 * max(1.0 + p[STOP_LOSS] * v, 0.0)
        if below > 0.0:
            torque += p[STOP_STIFFNESS] * below**1.5 * max(1.0 - p[STOP_LOSS] * v, 0.0)
    if p[DETENT] != 0.0:
        torque -= p[DETENT] * np.sin(p[DETENT_COUNT] * q - p[DETENT_PHASE])
    if p[MAGNET] != 0.0:
        away = (q - p[MAGNET_AT]) / p[MAGNET_WIDTH]
        torque -= p[MAGNET] * away * np.exp(0.5 - 0.5 * away * away)
    if p[SHAKE] != 0.0:
        torque += p[SHAKE] * np.sin(p[SHAKE_RATE] * t + phase)
    return torque - p[HYSTERESIS] * hysteresis


@njit
def _solve(work, mode, n):
    """Accelerations of the joints that move, the others at rest: Gaussian elimination, at most 3 by 3.

    Rows of `work`: 0-2 the mass matrix, 3 the torques, 4 the answer, 5-7 room for elimination, 8 indices.
    """
    m = 0
    for i in range(n):
        work[4, i] = 0.0
        if mode[i] != 0:
            work[8, m] = i
            m += 1
    for i in range(m):
        for j in range(m):
            work[5 + i, j] = work[int(work[8, i]), int(work[8, j])]
        work[5 + i, 3] = work[3, int(work[8, i])]
    for i in range(m):
        for k in range(i + 1, m):
            f = work[5 + k, i] / work[5 + i, i]
            for j in range(i, m):
                work[5 + k, j] -= f * work[5 + i, j]
            work[5 + k, 3] -= f * work[5 + i, 3]
    for i in range(m - 1, -1, -1):
        value = work[5 + i, 3]
        for j in range(i + 1, m):
            value -= work[5 + i, j] * work[4, int(work[8, j])]
        work[4, int(work[8, i])] = value / work[5 + i, i]


@njit
def _rates(n, A, W, P, kind, active, x, t, u, supply, phase, heavier, mode, dx, held, work):
    """Time derivative dx of a state; `held` (n,) is the torque that friction would need on joints at rest."""
    p = P[active]
    e = 2 * n
    if n == 1:
        heft = p[MASS] * heavier  # a payload at the mass centre
        weight = W[0, 0] * p[GRAVITY_FACTOR] + (heft * _GRAVITY * p[LEVER] if W[0, 0] > 0.0 else 0.0)
        work[0, 0] = A[0, 0] + p[ROTOR] + (heft * p[LEVER] ** 2 if p[LEVER] > 0.0 else heft)
        work[3, 0] = -weight * np.sin(x[0] - p[TILT])
    else:
        for i in range(n):
            work[3, i] = 0.0
            for j in range(n):
                work[i, j] = 0.0
            work[i, i] = P[i, ROTOR]
        for i in range(n):
            moment, turned = 0.0, 0.0
            for k in range(i + 1):
                turned += x[k]
            for k in range(i, n):
                moment += W[i, k] * P[k, GRAVITY_FACTOR]
            row = -moment * np.sin(turned - P[0, TILT])
            for j in range(n):
                other, spin = 0.0, 0.0
                for k in range(j + 1):
                    other += x[k]
                    spin += x[n + k]
                row -= A[i, j] * np.sin(turned - other) * spin * spin
                coupling = A[i, j] * np.cos(turned - other)
                for k in range(i + 1):  # the torque of joint k turns all links from k on
                    for m in range(j + 1):
                        work[k, m] += coupling
            for k in range(i + 1):
                work[3, k] += row
    geared = p[MOTOR_INERTIA] > 0.0
    for j in range(n):
        q, v, sent = x[j], x[n + j], u[j]
        if j == active:
            if P[j, LAG] > 0.0:
                sent = x[e]
            if P[j, FILTER_RATE] > 0.0:
                sent = x[e + 1]
        if j == active and geared:
            effort = _drive_effort(P[j], kind, sent, x[e + 3], x[e + 4], supply)
            twist, rate = x[e + 3] - q, x[e + 4] - v
            half = 0.5 * P[j, GEAR_PLAY]
            deep = np.sign(twist) * max(abs(twist) - half, 0.0)
            passed = P[j, GEAR_STIFFNESS] * deep
            if deep != 0.0 or half == 0.0:
                passed += P[j, GEAR_LOSS] * rate
            if half > 0.0 and passed * deep <= 0.0:
                passed = 0.0
            dx[e + 4] = (effort - passed) / P[j, MOTOR_INERTIA]
            effort = passed
        else:
            effort = _drive_effort(P[j], kind, sent, q, v, supply)
        hysteresis = x[e + 5] if j == active else 0.0
        work[3, j] += effort + _passive(P[j], q, v, hysteresis, t, phase)
    load = _load(P[active], x, work[3, 0], work[0, 0], W[0, 0], n) if p[LOAD_RADIUS] > 0.0 else 0.0
    for j in range(n):
        if mode[j] == 1 or mode[j] == -1:
            travel = x[e + 6] if j == active else 0.0
            work[3, j] -= mode[j] * _limit(P[j], x[j], x[n + j], mode[j], travel, load if j == active else 0.0)
    _solve(work, mode, n)
    for j in range(n):
        dx[j] = x[n + j]
        dx[n + j] = work[4, j]
        needed = work[3, j]
        for k in range(n):
            needed -= work[j, k] * work[4, k]
        held[j] = needed
    q, v = x[active], x[n + active]
    dx[e] = (u[active] - x[e]) / p[LAG] if p[LAG] > 0.0 else 0.0
    dx[e + 1] = x[e + 2]
    w = p[FILTER_RATE]
    dx[e + 2] = w * w * (u[active] - x[e + 1]) - 2.0 * p[FILTER_DAMPING] * w * x[e + 2] if w > 0.0 else 0.0
    dx[e + 3] = x[e + 4]
    if not geared:
        dx[e + 4] = 0.0
    dx[e + 5] = 0.0
    if p[HYSTERESIS] != 0.0:
        z = x[e + 5]
        dx[e + 5] = v / p[HYSTERESIS_TRAVEL] * (1.0 - z * z * (0.5 + 0.5 * np.sign(v * z)))
    dx[e + 6] = abs(v)
    if p[SENSOR_LAG] > 0.0:
        dx[e + 7] = (q - x[e + 7]) / p[SENSOR_LAG]
        dx[e + 8] = 0.0
    elif p[SENSOR_RATE] > 0.0:
        w = p[SENSOR_RATE]
        dx[e + 7] = x[e + 8]
        dx[e + 8] = w * w * (q - x[e + 7]) - 2.0 * p[SENSOR_DAMPING] * w * x[e + 8]
    else:
        dx[e + 7] = v
        dx[e + 8] = 0.0


@njit
def _load(p, x, torque, inertia, weight_Nm, n):
    """Force (N) in the bearing of a single joint: what carries the mass along its path; elsewhere its weight."""
    if n > 1 or weight_Nm == 0.0:
        return p[MASS] * _GRAVITY
    along = p[MASS] * (p[LEVER] * x[1] ** 2 + _GRAVITY * np.cos(x[0]))
    across = p[MASS] * (p[LEVER] * torque / inertia + _GRAVITY * np.sin(x[0]))
    return np.hypot(along, across)


@njit
def _integrate(n, A, W, P, kind, active, x, t, h, u, supply, phase, heavier, mode, method, k, held, work, y):
    """y: the state after h in the given modes."""
    size = 2 * n + _EXTRA
    _rates(n, A, W, P, kind, active, x, t, u, supply, phase, heavier, mode, k[0], held, work)
    if method == EULER:
        for i in range(size):
            y[i] = x[i] + h * k[0, i]
        for j in range(n):  # semi-implicit: positions move by the new rates
            y[j] = x[j] + h * y[n + j]
        return
    for i in range(size):
        y[i] = x[i] + 0.5 * h * k[0, i]
    _rates(n, A, W, P, kind, active, y, t + 0.5 * h, u, supply, phase, heavier, mode, k[1], held, work)
    for i in range(size):
        y[i] = x[i] + 0.5 * h * k[1, i]
    _rates(n, A, W, P, kind, active, y, t + 0.5 * h, u, supply, phase, heavier, mode, k[2], held, work)
    for i in range(size):
        y[i] = x[i] + h * k[2, i]
    _rates(n, A, W, P, kind, active, y, t + h, u, supply, phase, heavier, mode, k[3], held, work)
    for i in range(size):
        y[i] = x[i] + h / 6.0 * (k[0, i] + 2.0 * k[1, i] + 2.0 * k[2, i] + k[3, i])


@njit
def _rubs(p):
    return p[COULOMB] > 0.0 or p[STRIBECK] > 0.0 or p[LOAD_RADIUS] > 0.0 or p[ASYMMETRY] != 0.0


@njit
def _set_modes(n, A, W, P, kind, active, x, t, u, supply, phase, heavier, mode, k, held, work):
    """Directions of the moving joints; those that rest stay where friction can hold them."""
    for j in range(n):
        v = x[n + j]
        mode[j] = _SMOOTH if not _rubs(P[j]) else (1 if v > 0.0 else (-1 if v < 0.0 else 0))
    for _ in range(n):
        worst, which = 0.0, -1
        resting = False
        for j in range(n):
            resting = resting or mode[j] == 0
        if not resting:
            return
        _rates(n, A, W, P, kind, active, x, t, u, supply, phase, heavier, mode, k[0], held, work)
        for j in range(n):
            if mode[j] == 0:
                way = 1.0 if held[j] > 0.0 else -1.0
                travel = x[2 * n + 6] if j == active else 0.0
                load = 0.0
                if j == active and P[j, LOAD_RADIUS] > 0.0:
                    load = _load(P[j], x, 0.0, 1.0, W[0, 0], n)
                excess = abs(held[j]) - _limit(P[j], x[j], 0.0, way, travel, load)
                if excess > worst:
                    worst, which = excess, j
        if which < 0:
            return
        mode[which] = 1 if held[which] > 0.0 else -1


@njit
def _advance(n, A, W, P, kind, active, x, t, h, u, supply, phase, heavier, method, mode, k, held, work, y):
    """x after a step of length h, cut where dry friction stops a joint."""
    size = 2 * n + _EXTRA
    left = h
    for _ in range(8):
        _set_modes(n, A, W, P, kind, active, x, t, u, supply, phase, heavier, mode, k, held, work)
        while True:
            _integrate(n, A, W, P, kind, active, x, t, left, u, supply, phase, heavier, mode, method, k, held, work, y)
            again = False
            for j in range(n):  # released and pushed back at once: it rests
                if (mode[j] == 1 or mode[j] == -1) and x[n + j] == 0.0 and y[n + j] * mode[j] <= 0.0:
                    mode[j] = 0
                    again = True
            if not again:
                break
        share, which = 1.0, -1
        for j in range(n):
            if (mode[j] == 1 or mode[j] == -1) and y[n + j] * mode[j] < 0.0:
                cut = x[n + j] / (x[n + j] - y[n + j])
                if cut < share:
                    share, which = cut, j
        if which < 0:
            for i in range(size):
                x[i] = y[i]
            return
        low, high, rate_low, rate_high = 0.0, 1.0, x[n + which], y[n + which]
        for _ in range(4):  # regula falsi on the rate
            _integrate(
                n, A, W, P, kind, active, x, t, share * left, u, supply, phase, heavier, mode, method, k, held, work, y
            )
            rate = y[n + which]
            if rate * mode[which] < 0.0:
                high, rate_high = share, rate
            else:
                low, rate_low = share, rate
            if abs(rate) < 1e-12:
                break
            share = low + (high - low) * rate_low / (rate_low - rate_high)
        _integrate(
            n, A, W, P, kind, active, x, t, share * left, u, supply, phase, heavier, mode, method, k, held, work, y
        )
        for i in range(size):
            x[i] = y[i]
        for j in range(n):
            if (mode[j] == 1 or mode[j] == -1) and x[n + j] * mode[j] < 0.0:
                x[n + j] = 0.0
        x[n + which] = 0.0
        t += share * left
        left *= 1.0 - share
        if left < 1e-9 * h:
            return


@njit
def integrate_runs(n, A, W, P, kind, active, offsets, t, inputs, supply, starts, phase, heavier, method, step_s):
    """States (rows, 2 n + 2) at the breaks `t` (rows,) of all runs: positions, rates, the reading and its rate.

    offsets (r + 1,) divide the rows into runs; inputs (rows, n) and supply (rows,) hold until the next row; starts
    (r, 2 n) are the states at each run's first row; phase (r,) of the shaking, heavier (r,) the payload's share.
    """
    out = np.empty((len(t), 2 * n + 2))
    size = 2 * n + _EXTRA
    k, held, y, mode = np.zeros((4, size)), np.zeros(3), np.zeros(size), np.zeros(3, np.int64)
    work = np.zeros((9, 4))
    p = P[active]
    e = 2 * n
    for r in range(len(offsets) - 1):
        x = np.zeros(size)
        first = offsets[r]
        for i in range(2 * n):
            x[i] = starts[r, i]
        q, v = x[active], x[n + active]
        x[e] = inputs[first, active]
        x[e + 1] = inputs[first, active]
        x[e + 3], x[e + 4] = q, v
        x[e + 7] = q
        if p[SENSOR_LAG] > 0.0:
            x[e + 7] = q - p[SENSOR_LAG] * v
        elif p[SENSOR_RATE] > 0.0:
            x[e + 7], x[e + 8] = q - 2.0 * p[SENSOR_DAMPING] / p[SENSOR_RATE] * v, v
        for row in range(first, offsets[r + 1]):
            for i in range(2 * n):
                out[row, i] = x[i]
            out[row, e] = x[e + 7]
            out[row, e + 1] = x[n + active]
            if p[SENSOR_LAG] > 0.0:
                out[row, e + 1] = (x[active] - x[e + 7]) / p[SENSOR_LAG]
            elif p[SENSOR_RATE] > 0.0:
                out[row, e + 1] = x[e + 8]
            if row + 1 == offsets[r + 1]:
                break
            span = t[row + 1] - t[row]
            steps = max(1, int(np.ceil(span / step_s - 1e-9)))
            h = span / steps
            for s in range(steps):
                _advance(
                    n, A, W, P, kind, active, x, t[row] + s * h, h, inputs[row], supply[row], phase[r], heavier[r],
                    method, mode, k, held, work, y,
                )  # fmt: skip
                if not abs(x[0]) < 1e9:  # diverged: it stays there
                    x[0] = 1e9
                    break
    return out
