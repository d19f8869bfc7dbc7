"""The kernel of trees that are no planar chain, by recursive Newton and Euler.

All in one file, because the cache of compiled code looks at the file of a function alone.
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


@jit
def roll_tree(given: Inputs, tree: Any) -> Any:
    """Positions and rates (w, k, j) of a tree, from parents, axes, poses and masses of its links."""
    (
        t_s, steps, typical_s, q0, qd0, inputs, drive, kp, kd, per_unit, limit, volts, dry,
        damping, laws, kinds, places, values, fresh, by_load, has_friction,
    ) = given  # fmt: skip
    worlds, stamps = t_s.shape
    joints = q0.shape[1]
    Q, QD = np.empty((worlds, stamps, joints)), np.empty((worlds, stamps, joints))
    commanded, ahead, after = np.zeros(joints), np.zeros(joints), np.zeros(joints)
    middle = np.zeros(joints)
    vectors = np.zeros((8, joints))
    matrices = np.zeros((4, joints, joints))
    spatial = np.zeros((8, joints, 3))
    rotations = np.zeros((joints, 3, 3))
    memory, trial = fresh.copy(), fresh.copy()
    for w in range(worlds):
        q, qd = q0[w].copy(), qd0[w].copy()
        last = np.zeros(joints)
        memory[:] = fresh
        before = 0.0
        Q[w, 0], QD[w, 0] = q, qd
        for k in range(stamps - 1):
            h = (t_s[w, k + 1] - t_s[w, k]) / steps[k]
            dt_s = typical_s[k] / steps[k]
            half = 0.5 * h
            if k > 0 and joints > 1:
                share = h / before if before > 0.0 else 0.0
                for j in range(joints):
                    last[j] *= share
            before = h
            for s in range(steps[k]):
                for j in range(joints):
                    q[j] += half * qd[j]
                now = t_s[w, k] + (s + 0.5) * h
                _command(drive, inputs, w, k, q, qd, kp, kd, per_unit, limit, commanded)
                if drive == PD_DRIVE:
                    trial[:] = memory
                    _kick(
                        q, qd, last, commanded, now, h, dt_s, volts[w, k], dry, damping, laws, kinds, places, values,
                        trial, by_load, has_friction, tree, vectors, matrices, spatial,
                        rotations, ahead,
                    )  # fmt: skip
                    for j in range(joints):
                        middle[j] = 0.5 * (qd[j] + ahead[j])
                    _command(drive, inputs, w, k, q, middle, kp, kd, per_unit, limit, commanded)
                _kick(
                    q, qd, last, commanded, now, h, dt_s, volts[w, k], dry, damping, laws, kinds, places, values,
                    memory, by_load, has_friction, tree, vectors, matrices, spatial,
                    rotations, after,
                )  # fmt: skip
                for j in range(joints):
                    last[j] = after[j] - qd[j]
                    qd[j] = after[j]
                    q[j] += half * qd[j]
            Q[w, k + 1], QD[w, k + 1] = q, qd
    return Q, QD


@jit
def _command(
    drive: Any, inputs: Any, w: Any, k: Any, q: Any, qd: Any, kp: Any, kd: Any, per_unit: Any, limit: Any, out: Any
) -> None:
    for j in range(len(q)):
        if drive == EFFORT_DRIVE:
            value = inputs[w, k, j] * per_unit
        elif drive == PD_DRIVE:
            value = (kp[j] * (inputs[w, k, j] - q[j]) - kd[j] * qd[j]) * per_unit
        else:
            value = 0.0
        out[j] = np.minimum(np.maximum(value, -limit), limit)


@jit
def _kick(
    q: Any,
    qd: Any,
    last: Any,
    commanded: Any,
    t_s: Any,
    h: Any,
    dt_s: Any,
    volts: Any,
    dry: Any,
    damping: Any,
    laws: Any,
    kinds: Any,
    places: Any,
    values: Any,
    memory: Any,
    by_load: Any,
    has_friction: Any,
    tree: Any,
    vectors: Any,
    matrices: Any,
    spatial: Any,
    rotations: Any,
    out: Any,
) -> None:
    """Joint rates after one step into `out`: the step of `mechanism._Forces.kick` in one world."""
    joints = len(q)
    effort, net, largest, load, middle = vectors[0], vectors[1], vectors[2], vectors[3], vectors[4]
    M, A, inverse = matrices[0], matrices[1], matrices[2]
    nan = np.nan
    for j in range(joints):
        effort[j] = commanded[j]
        middle[j] = qd[j] + 0.5 * last[j] if joints > 1 else qd[j]
    for i in range(len(kinds)):
        if kinds[i] == EFFORT_LAW:
            j = places[i]
            state = JointState(t_s, q[j], qd[j], effort[j], dt_s, nan, nan, nan, volts)
            effort[j] = call_law(laws[i], state, values[i], memory[i])
    _bias(tree, q, middle, matrices, spatial, rotations, net)
    for j in range(joints):
        net[j] = effort[j] - net[j]
    for i in range(len(kinds)):
        if kinds[i] == TORQUE_LAW:
            j = places[i]
            state = JointState(t_s, q[j], qd[j], effort[j], dt_s, nan, nan, nan, volts)
            net[j] += call_law(laws[i], state, values[i], memory[i])
    _mass(tree, q, matrices, spatial, rotations, vectors)
    for i in range(joints):
        momentum = h * net[i]
        for j in range(joints):
            momentum += M[i, j] * qd[j]
        out[i] = momentum
    A[:] = M
    for j in range(joints):
        A[j, j] += h * damping[j]
    matrices[3][:] = A
    _solve(matrices[3], out)
    if has_friction:
        if by_load:
            _load(tree, q, qd, matrices, spatial, rotations, load)
        for j in range(joints):
            largest[j] = dry[j]
        for i in range(len(kinds)):
            if kinds[i] == FRICTION_LAW:
                j = places[i]
                direction = -1.0 if out[j] < -1e-9 else 1.0
                state = JointState(
                    t_s, q[j], qd[j], effort[j], dt_s, load[j] if by_load else nan, largest[j], direction, volts
                )
                largest[j] += call_law(laws[i], state, values[i], memory[i])
        for j in range(joints):
            largest[j] = h * np.maximum(largest[j], 0.0)
        for j in range(joints):
            matrices[3][:] = A
            for i in range(joints):
                middle[i] = 1.0 if i == j else 0.0
            _solve(matrices[3], middle)
            for i in range(joints):
                inverse[i, j] = middle[i]
        _impulses(inverse, largest, out, effort)
    for j in range(joints):
        out[j] = np.fmin(np.fmax(out[j], -LARGEST_RATE), LARGEST_RATE)


@jit
def _impulses(inverse: Any, limits: Any, rates: Any, impulse: Any) -> None:
    """Projected Gauss-Seidel over the joints; changes `rates`."""
    joints = len(rates)
    impulse[:] = 0.0
    for _ in range(_SWEEPS):
        same = True
        for j in range(joints):
            target = impulse[j] - rates[j] / inverse[j, j]
            applied = np.minimum(np.maximum(target, -limits[j]), limits[j])
            change = applied - impulse[j]
            if applied != impulse[j]:
                same = False
            for i in range(joints):
                rates[i] += inverse[i, j] * change
            impulse[j] = applied
        if same:
            break


@jit
def _solve(A: Any, b: Any) -> None:
    """b becomes x with A x = b, for symmetric positive definite A, which is overwritten."""
    n = len(b)
    for i in range(n):
        for k in range(i + 1, n):
            share = A[i, k] / A[i, i]
            b[k] -= share * b[i]
            for m in range(k, n):
                A[k, m] -= share * A[i, m]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= A[i, k] * b[k]
        b[i] /= A[i, i]


@jit
def _bias(tree: Any, q: Any, qd: Any, matrices: Any, spatial: Any, R: Any, out: Any) -> None:
    joints = len(q)
    zero, load = np.zeros(joints), np.zeros(joints)
    _inverse_dynamics(tree, q, qd, zero, True, spatial, R, out, load)


@jit
def _load(tree: Any, q: Any, qd: Any, matrices: Any, spatial: Any, R: Any, out: Any) -> None:
    joints = len(q)
    zero, effort = np.zeros(joints), np.zeros(joints)
    _inverse_dynamics(tree, q, qd, zero, True, spatial, R, effort, out)


@jit
def _mass(tree: Any, q: Any, matrices: Any, spatial: Any, R: Any, vectors: Any) -> None:
    """The mass matrix into matrices[0]."""
    joints = len(q)
    M = matrices[0]
    zero, unit = np.zeros(joints), np.zeros(joints)
    column, load = np.zeros(joints), np.zeros(joints)
    for i in range(joints):
        unit[:] = 0.0
        unit[i] = 1.0
        _inverse_dynamics(tree, q, zero, unit, False, spatial, R, column, load)
        for j in range(joints):
            matrices[3][j, i] = column[j]
    for i in range(joints):
        for j in range(joints):
            M[i, j] = 0.5 * (matrices[3][i, j] + matrices[3][j, i])


@jit
def _cross_into(a: Any, b: Any, out: Any) -> None:
    x = a[1] * b[2] - a[2] * b[1]
    y = a[2] * b[0] - a[0] * b[2]
    z = a[0] * b[1] - a[1] * b[0]
    out[0], out[1], out[2] = x, y, z


@jit
def _inverse_dynamics(
    tree: Any, q: Any, qd: Any, qdd: Any, with_gravity: Any, spatial: Any, R: Any, effort: Any, load: Any
) -> None:
    """`tree.inverse_dynamics` in one world: efforts and bearing loads into `effort` and `load`."""
    parent, slides, axes, R0, p0, scalars, com, inertia, gravity_W = tree
    joints = len(q)
    w, dw, a, F, N, p, g = spatial[0], spatial[1], spatial[2], spatial[3], spatial[4], spatial[5], spatial[6]
    wp, dwp, ap = np.zeros(3), np.zeros(3), np.zeros(3)
    one, two, three = np.zeros(3), np.zeros(3), np.zeros(3)
    K, turn = np.zeros((3, 3)), np.zeros((3, 3))
    for i in range(joints):
        axis = axes[i]
        if slides[i]:
            R[i] = R0[i]
            for r in range(3):
                p[i, r] = p0[i, r]
                for c in range(3):
                    p[i, r] += R0[i, r, c] * axis[c] * q[i]
        else:
            K[0, 1], K[0, 2], K[1, 0], K[1, 2], K[2, 0], K[2, 1] = (
                -axis[2], axis[1], axis[2], -axis[0], -axis[1], axis[0],
            )  # fmt: skip
            sine, versine = np.sin(q[i]), 1.0 - np.cos(q[i])
            for r in range(3):
                for c in range(3):
                    square = 0.0
                    for m in range(3):
                        square += K[r, m] * K[m, c]
                    turn[r, c] = (1.0 if r == c else 0.0) + sine * K[r, c] + versine * square
            for r in range(3):
                p[i, r] = p0[i, r]
                for c in range(3):
                    total = 0.0
                    for m in range(3):
                        total += R0[i, r, m] * turn[m, c]
                    R[i, r, c] = total
        if parent[i] >= 0:
            wp[:], dwp[:], ap[:] = w[parent[i]], dw[parent[i]], a[parent[i]]
        else:
            wp[:] = 0.0
            dwp[:] = 0.0
            for r in range(3):
                ap[r] = -gravity_W[r] if with_gravity else 0.0
        _cross_into(dwp, p[i], one)
        _cross_into(wp, p[i], two)
        _cross_into(wp, two, three)
        for r in range(3):
            one[r] = ap[r] + one[r] + three[r]
        for c in range(3):
            w[i, c] = dw[i, c] = a[i, c] = g[i, c] = 0.0
            for r in range(3):
                w[i, c] += R[i, r, c] * wp[r]
                dw[i, c] += R[i, r, c] * dwp[r]
                a[i, c] += R[i, r, c] * one[r]
                if parent[i] >= 0:
                    g[i, c] += R[i, r, c] * g[parent[i], r]
                else:
                    g[i, c] += R[i, r, c] * gravity_W[r]
        for r in range(3):
            one[r] = qd[i] * axis[r]
        _cross_into(w[i], one, two)
        if slides[i]:
            for r in range(3):
                a[i, r] += qdd[i] * axis[r] + 2.0 * two[r]
        else:
            for r in range(3):
                dw[i, r] += qdd[i] * axis[r] + two[r]
                w[i, r] += one[r]
        _cross_into(dw[i], com[i], one)
        _cross_into(w[i], com[i], two)
        _cross_into(w[i], two, three)
        for r in range(3):
            F[i, r] = scalars[0, i] * (a[i, r] + one[r] + three[r])
            if with_gravity and scalars[2, i] != 1.0:
                F[i, r] -= (scalars[2, i] - 1.0) * scalars[0, i] * g[i, r]
        for c in range(3):
            one[c] = two[c] = 0.0
            for r in range(3):
                one[c] += w[i, r] * inertia[i, r, c]
                two[c] += dw[i, r] * inertia[i, r, c]
        _cross_into(w[i], one, three)
        _cross_into(com[i], F[i], one)
        for r in range(3):
            N[i, r] = two[r] + three[r] + one[r]
    for i in range(joints - 1, -1, -1):
        axis = axes[i]
        along = moment = 0.0
        for r in range(3):
            along += F[i, r] * axis[r]
            moment += N[i, r] * axis[r]
        square = 0.0
        for r in range(3):
            part = F[i, r] - along * axis[r] if slides[i] else F[i, r]
            square += part * part
        load[i] = np.sqrt(square)
        effort[i] = (along if slides[i] else moment) + scalars[1, i] * qdd[i]
        if parent[i] >= 0:
            for r in range(3):
                one[r] = two[r] = 0.0
                for c in range(3):
                    one[r] += R[i, r, c] * F[i, c]
                    two[r] += R[i, r, c] * N[i, c]
            _cross_into(p[i], one, three)
            for r in range(3):
                F[parent[i], r] += one[r]
                N[parent[i], r] += two[r] + three[r]
