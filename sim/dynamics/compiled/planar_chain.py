"""The kernel of planar chains: links that all turn about y, in angles measured from the base.

All in one file, because the cache of compiled code looks at the file of a function alone. What depends on the positions
alone (directions of links, mass matrix, its factors) is computed once a step, also where a drive takes two.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.dynamics.compiled.inputs import (
    EFFORT_DRIVE,
    EFFORT_LAW,
    FRICTION_LAW,
    LARGEST_RATE,
    PD_DRIVE,
    TORQUE_LAW,
    Inputs,
    call_law,
    jit,
)
from sim.dynamics.hooks import JointState

_SWEEPS = 12  # of friction impulses over the joints, as in `joint_dynamics`
# Rows of the working numbers by joint.
_SENT, _LAST, _AHEAD, _AFTER, _BIAS, _COSINE, _SINE, _RATE2, _EFFORT, _NET, _LARGEST, _LOAD, _IMPULSE = range(13)
_WORKING = 13


@jit
def roll_planar_chain(given: Inputs, rows: Any, coupled: Any, outboard: Any, gravity: Any) -> Any:
    """Positions and rates (w, k, j) of a planar chain.

    The numbers are those of `PlanarChain`, complex ones as real and imaginary parts:
    rows                (6, j): zero, turning, armature, outboard mass, weight (two rows).
    coupled, outboard   (2, j, j).
    gravity             (3,): along z, x and y.
    """
    (
        t_s, steps, typical_s, q0, qd0, inputs, drive, kp, kd, per_unit, limit, volts, dry,
        damping, laws, kinds, places, values, fresh, by_load, has_friction,
    ) = given  # fmt: skip
    worlds, stamps = t_s.shape
    joints = q0.shape[1]
    Q, QD = np.empty((worlds, stamps, joints)), np.empty((worlds, stamps, joints))
    q, qd = np.zeros(joints), np.zeros(joints)
    work = np.zeros((_WORKING, joints))
    M, factors, inverse = np.zeros((joints, joints)), np.zeros((joints, joints)), np.zeros((joints + 1, joints))
    memory, trial = fresh.copy(), fresh.copy()
    remembered = memory.size
    for w in range(worlds):
        for j in range(joints):
            q[j], qd[j], work[_LAST, j] = q0[w, j], qd0[w, j], 0.0
            Q[w, 0, j], QD[w, 0, j] = q[j], qd[j]
        for m in range(remembered):
            memory.flat[m] = fresh.flat[m]
        before = 0.0
        for k in range(stamps - 1):
            h = (t_s[w, k + 1] - t_s[w, k]) / steps[k]
            dt_s = typical_s[k] / steps[k]
            half = 0.5 * h
            if k > 0 and joints > 1:
                share = h / before if before > 0.0 else 0.0
                for j in range(joints):
                    work[_LAST, j] *= share
            before = h
            for s in range(steps[k]):
                for j in range(joints):
                    q[j] += half * qd[j]
                now = t_s[w, k] + (s + 0.5) * h
                _configure(q, qd, h, damping, rows, coupled, gravity, work, M, factors)
                if has_friction:
                    _invert(factors, inverse)
                    if by_load:
                        _load(qd, rows, outboard, gravity, work)
                if drive == PD_DRIVE:
                    for j in range(joints):
                        value = (kp[j] * (inputs[w, k, j] - q[j]) - kd[j] * qd[j]) * per_unit
                        work[_SENT, j] = min(max(value, -limit), limit)
                    for m in range(remembered):
                        trial.flat[m] = memory.flat[m]
                    _kick(
                        q, qd, now, h, dt_s, volts[w, k], dry, laws, kinds, places, values, trial, by_load,
                        has_friction, M, factors, inverse, work, _AHEAD,
                    )  # fmt: skip
                    for j in range(joints):
                        middle = 0.5 * (qd[j] + work[_AHEAD, j])
                        value = (kp[j] * (inputs[w, k, j] - q[j]) - kd[j] * middle) * per_unit
                        work[_SENT, j] = min(max(value, -limit), limit)
                else:
                    for j in range(joints):
                        value = inputs[w, k, j] * per_unit if drive == EFFORT_DRIVE else 0.0
                        work[_SENT, j] = min(max(value, -limit), limit)
                _kick(
                    q, qd, now, h, dt_s, volts[w, k], dry, laws, kinds, places, values, memory, by_load,
                    has_friction, M, factors, inverse, work, _AFTER,
                )  # fmt: skip
                for j in range(joints):
                    work[_LAST, j] = work[_AFTER, j] - qd[j]
                    qd[j] = work[_AFTER, j]
                    q[j] += half * qd[j]
            for j in range(joints):
                Q[w, k + 1, j], QD[w, k + 1, j] = q[j], qd[j]
    return Q, QD


@jit
def _configure(
    q: Any,
    qd: Any,
    h: Any,
    damping: Any,
    rows: Any,
    coupled: Any,
    gravity: Any,
    work: Any,
    M: Any,
    factors: Any,
) -> None:
    """Directions of the links, bias efforts at the middle of the step, mass matrix, its factors with damping."""
    joints = len(q)
    angle = rate = 0.0
    for j in range(joints):
        angle += q[j] + rows[0, j]
        rate += qd[j] + 0.5 * work[_LAST, j] if joints > 1 else qd[j]
        work[_COSINE, j], work[_SINE, j] = np.cos(angle), np.sin(angle)
        work[_RATE2, j] = rate * rate
    for i in range(joints):
        # The imaginary part of conj(weight * direction) * gravity.
        real = rows[4, i] * work[_COSINE, i] - rows[5, i] * work[_SINE, i]
        imaginary = rows[4, i] * work[_SINE, i] + rows[5, i] * work[_COSINE, i]
        work[_BIAS, i] = real * gravity[1] - imaginary * gravity[0]
    for i in range(joints):
        M[i, i] = coupled[0, i, i] + rows[1, i]
        for j in range(i + 1, joints):
            cosine = work[_COSINE, i] * work[_COSINE, j] + work[_SINE, i] * work[_SINE, j]
            sine = work[_COSINE, i] * work[_SINE, j] - work[_SINE, i] * work[_COSINE, j]
            M[i, j] = M[j, i] = coupled[0, i, j] * cosine - coupled[1, i, j] * sine
            across = coupled[0, i, j] * sine + coupled[1, i, j] * cosine
            work[_BIAS, i] += across * work[_RATE2, j]
            work[_BIAS, j] -= across * work[_RATE2, i]
    # From angles to joints: a joint turns all links from its own on.
    for i in range(joints - 2, -1, -1):
        work[_BIAS, i] += work[_BIAS, i + 1]
        for j in range(joints):
            M[i, j] += M[i + 1, j]
    for i in range(joints):
        work[_BIAS, i] = -work[_BIAS, i]
        for j in range(joints - 2, -1, -1):
            M[i, j] += M[i, j + 1]
    for i in range(joints):
        M[i, i] += rows[2, i]
    _factor(M, damping, h, factors)


@jit
def _factor(M: Any, damping: Any, h: Any, factors: Any) -> None:
    """L D L' of the mass matrix with implicit damping: L below the diagonal, 1 / D on it."""
    joints = len(damping)
    for i in range(joints):
        for j in range(i + 1):
            value = M[i, j]
            if i == j:
                value += h * damping[i]
            for m in range(j):
                value -= factors[i, m] * factors[j, m] / factors[m, m]
            factors[i, j] = value * factors[j, j] if i != j else 1.0 / value


@jit
def _solve(factors: Any, right: Any, row: Any) -> None:
    """Solves in place for a row of the right sides."""
    joints = len(factors)
    for i in range(joints):
        for m in range(i):
            right[row, i] -= factors[i, m] * right[row, m]
    for i in range(joints - 1, -1, -1):
        right[row, i] *= factors[i, i]
        for m in range(i + 1, joints):
            right[row, i] -= factors[m, i] * right[row, m]


@jit
def _invert(factors: Any, inverse: Any) -> None:
    """The inverse of the mass matrix with damping, symmetric, from its factors; the last row holds 1 / its diagonal."""
    joints = len(factors)
    for j in range(joints):
        # Column j of the inverse of L, from the diagonal down, then back through D and L'.
        for i in range(j, joints):
            value = 1.0 if i == j else 0.0
            for m in range(j, i):
                value -= factors[i, m] * inverse[j, m]
            inverse[j, i] = value
        for i in range(joints - 1, j - 1, -1):
            value = inverse[j, i] * factors[i, i]
            for m in range(i + 1, joints):
                value -= factors[m, i] * inverse[j, m]
            inverse[j, i] = value
            inverse[i, j] = value
    for j in range(joints):
        inverse[joints, j] = 1.0 / inverse[j, j]


@jit
def _load(qd: Any, rows: Any, outboard: Any, gravity: Any, work: Any) -> None:
    """Force that each bearing transmits, without that of joint accelerations."""
    joints = len(qd)
    rate = 0.0
    for i in range(joints):
        along, across = -rows[3, i] * gravity[0], -rows[3, i] * gravity[1]
        rate = 0.0
        for j in range(joints):
            rate += qd[j]
            real, imaginary = work[_COSINE, j] * rate * rate, work[_SINE, j] * rate * rate
            along -= real * outboard[0, i, j] - imaginary * outboard[1, i, j]
            across -= real * outboard[1, i, j] + imaginary * outboard[0, i, j]
        level = rows[3, i] * gravity[2]
        work[_LOAD, i] = np.sqrt(along * along + across * across + level * level)


@jit
def _kick(
    q: Any,
    qd: Any,
    t_s: Any,
    h: Any,
    dt_s: Any,
    volts: Any,
    dry: Any,
    laws: Any,
    kinds: Any,
    places: Any,
    values: Any,
    memory: Any,
    by_load: Any,
    has_friction: Any,
    M: Any,
    factors: Any,
    inverse: Any,
    work: Any,
    out: Any,
) -> None:
    """Joint rates after one step into a row of the working numbers: the step of `mechanism._Forces.kick`."""
    joints = len(q)
    nan = np.nan
    for j in range(joints):
        work[_EFFORT, j] = work[_SENT, j]
    for i in range(len(kinds)):
        if kinds[i] == EFFORT_LAW:
            j = places[i]
            state = JointState(t_s, q[j], qd[j], work[_EFFORT, j], dt_s, nan, nan, nan, volts)
            work[_EFFORT, j] = call_law(laws[i], state, values[i], memory[i])
    for j in range(joints):
        work[_NET, j] = work[_EFFORT, j] - work[_BIAS, j]
    for i in range(len(kinds)):
        if kinds[i] == TORQUE_LAW:
            j = places[i]
            state = JointState(t_s, q[j], qd[j], work[_EFFORT, j], dt_s, nan, nan, nan, volts)
            work[_NET, j] += call_law(laws[i], state, values[i], memory[i])
    for i in range(joints):
        momentum = h * work[_NET, i]
        for j in range(joints):
            momentum += M[i, j] * qd[j]
        work[out, i] = momentum
    _solve(factors, work, out)
    if has_friction:
        for j in range(joints):
            work[_LARGEST, j] = dry[j]
        for i in range(len(kinds)):
            if kinds[i] == FRICTION_LAW:
                j = places[i]
                direction = -1.0 if work[out, j] < -1e-9 else 1.0
                load = work[_LOAD, j] if by_load else nan
                state = JointState(t_s, q[j], qd[j], work[_EFFORT, j], dt_s, load, work[_LARGEST, j], direction, volts)
                work[_LARGEST, j] += call_law(laws[i], state, values[i], memory[i])
        for j in range(joints):
            work[_LARGEST, j] = h * max(work[_LARGEST, j], 0.0)
        _rub(inverse, work, out)
    for j in range(joints):
        work[out, j] = np.fmin(np.fmax(work[out, j], -LARGEST_RATE), LARGEST_RATE)


@jit
def _rub(inverse: Any, work: Any, out: Any) -> None:
    """Impulses of friction by projected Gauss-Seidel over the joints; changes the rates."""
    joints = inverse.shape[1]
    for j in range(joints):
        work[_IMPULSE, j] = 0.0
    for _ in range(_SWEEPS):
        same = True
        for j in range(joints):
            target = work[_IMPULSE, j] - work[out, j] * inverse[joints, j]
            applied = min(max(target, -work[_LARGEST, j]), work[_LARGEST, j])
            change = applied - work[_IMPULSE, j]
            if change != 0.0:
                same = False
                for i in range(joints):
                    work[out, i] += inverse[j, i] * change
                work[_IMPULSE, j] = applied
        if same:
            break
