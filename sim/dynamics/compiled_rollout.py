"""Roll-outs of mechanisms compiled for the processor: one world at a time, the steps of `sim.dynamics.mechanism`.

Input and output are those of `mechanism.rollout`, whose NumPy form is the reference and the fallback. Laws of effects
are called through function pointers of one signature, so that a new effect needs no change here. Compiled code is
cached on disk by Numba, beside each source file.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numba
import numpy as np
from numba.extending import overload  # Numba has no stubs

from schemas.arrays import FloatArray, IntArray
from sim.dynamics import elementwise
from sim.dynamics.hooks import EffortMap, JointFriction, JointState, JointTorque, StepHook, StepLaw
from sim.dynamics.joint_dynamics import CoupledJoints, PlanarChain, SeparateJoints, joint_dynamics

if TYPE_CHECKING:
    from sim.dynamics.mechanism import Law, MechanismModel, Windows

MOST_LAWS = 8  # that one roll-out may hold: the kernel is compiled for a fixed number of pointers
_MOST_VALUES, _MOST_MEMORY = 8, 64  # parameters and remembered numbers of a law
_SWEEPS = 12  # of friction impulses over the joints, as in `joint_dynamics`
_LARGEST_RATE = 1e4  # as in `mechanism`
_NONE, _EFFORT, _PD = 0, 1, 2
_EFFORT_LAW, _TORQUE_LAW, _FRICTION_LAW = 1, 2, 3
_PLANAR, _TREE = 1, 2
_DRIVES = {"none": _NONE, "effort": _EFFORT, "position_pd": _PD}
_KINDS = {EffortMap: _EFFORT_LAW, JointTorque: _TORQUE_LAW, JointFriction: _FRICTION_LAW}

warnings.filterwarnings("ignore", category=numba.NumbaExperimentalFeatureWarning)
_STATE = numba.types.NamedUniTuple(numba.float64, len(JointState._fields), JointState)
_LAW = numba.float64(_STATE, numba.float64[::1], numba.float64[::1])


@overload(elementwise.where)
def _where(condition: Any, one: Any, other: Any) -> Callable[..., Any]:
    def choose(condition: Any, one: Any, other: Any) -> Any:
        return one if condition else other

    return choose


def _no_law(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    """Fills the places of laws that a roll-out lacks."""
    return 0.0


@cache
def _compiled(law: StepLaw) -> Any:
    return numba.njit(_LAW, cache=True, error_model="numpy")(law)


def rollout(
    model: MechanismModel, windows: Windows, laws: Sequence[Law], steps: IntArray, typical_s: FloatArray, supply: str
) -> tuple[FloatArray, FloatArray]:
    """Positions and rates (w, k, j) of windows whose intervals have `steps` (k - 1,) of about `typical_s` / steps."""
    worlds, stamps = windows.t_s.shape
    joints = len(model.tree)
    drive = model.drive
    none = np.zeros((0, 0, 0))
    values, memory = np.zeros((MOST_LAWS, _MOST_VALUES)), np.zeros((MOST_LAWS, _MOST_MEMORY))
    kinds, places = np.zeros(MOST_LAWS, dtype=np.int64), np.zeros(MOST_LAWS, dtype=np.int64)
    for i, law in enumerate(laws):
        hook = law.hook
        assert isinstance(hook, EffortMap | JointTorque | JointFriction)
        values[i, : len(hook.names)] = [law.params[name] for name in hook.names]
        memory[i, : hook.memory] = np.nan
        kinds[i], places[i] = _KINDS[type(hook)], law.joint
    pointers = tuple(
        _compiled(law.hook.law) for law in laws if isinstance(law.hook, EffortMap | JointTorque | JointFriction)
    )
    pointers += (_compiled(_no_law),) * (MOST_LAWS - len(laws))
    by_load = any(isinstance(law.hook, JointFriction) and law.hook.by_load for law in laws)
    friction = (kinds == _FRICTION_LAW).any() or bool(model.friction.any())
    volts = windows.aux.get(supply)
    form = joint_dynamics(model.tree, model.gravity_W)
    inputs = (
        np.ascontiguousarray(windows.t_s, dtype=float),
        steps.astype(np.int64),
        np.ascontiguousarray(typical_s, dtype=float),
        np.ascontiguousarray(windows.q0, dtype=float),
        np.ascontiguousarray(windows.qd0, dtype=float),
        _inputs(windows.command, windows.effort, drive.type, none),
        _DRIVES[drive.type] if _has_input(windows, drive.type) else _NONE,
        np.broadcast_to(np.asarray(drive.kp, dtype=float), joints).copy(),
        np.broadcast_to(np.asarray(drive.kd, dtype=float), joints).copy(),
        float(drive.effort_per_unit),
        np.inf if drive.effort_limit is None else float(drive.effort_limit),
        np.full((worlds, stamps), np.nan) if volts is None else np.ascontiguousarray(volts, dtype=float),
        np.broadcast_to(np.asarray(model.friction, dtype=float), joints).copy(),
        np.broadcast_to(np.asarray(model.damping, dtype=float), joints).copy(),
        pointers,
        kinds,
        places,
        values,
        memory,
        bool(by_load),
        bool(friction),
    )
    if isinstance(form, SeparateJoints):
        remembers = any(law.hook.memory for law in laws if isinstance(law.hook, StepHook))
        return _roll_separate(*inputs, remembers, _separate_numbers(form))
    return _roll(*inputs, *_numbers(form, joints))


def _has_input(windows: Windows, drive_type: str) -> bool:
    return (windows.effort if drive_type == "effort" else windows.command) is not None


def _inputs(command: FloatArray | None, effort: FloatArray | None, drive_type: str, none: FloatArray) -> FloatArray:
    chosen = effort if drive_type == "effort" else command
    return none if chosen is None else np.ascontiguousarray(chosen, dtype=float)


def _separate_numbers(form: SeparateJoints) -> FloatArray:
    """(9, j) inertia, gravity's effort (level, along, across), and the terms of the bearing load."""
    rows = (form.inertia, form.level, form.along, form.across, form.weight2, *form.pull, form.spin)
    return np.array(rows, dtype=float)


def _numbers(form: Any, joints: int) -> tuple[int, Any, Any]:
    """The form of the dynamics, and its numbers: a planar chain, a tree."""
    places = np.zeros(joints, dtype=complex), np.zeros(joints)  # for directions and squared rates of links
    planar = (
        np.zeros((5, joints)),
        np.zeros((2, joints, joints), dtype=complex),
        np.zeros(joints, dtype=complex),
        0j,
        0.0,
        *places,
    )
    tree = (
        np.zeros(joints, dtype=np.int64),
        np.zeros(joints, dtype=np.bool_),
        np.zeros((joints, 3)),
        np.zeros((joints, 3, 3)),
        np.zeros((joints, 3)),
        np.zeros((3, joints)),
        np.zeros((joints, 3)),
        np.zeros((joints, 3, 3)),
        np.zeros(3),
    )
    if isinstance(form, PlanarChain):
        rows = (form.zero, form.turning, form.armature, form.outboard_mass, np.zeros(joints))
        matrices = np.ascontiguousarray(np.stack([form.coupled, form.outboard]))
        numbers = (np.array(rows, dtype=float), matrices, form.weight, complex(form.gravity), form.gravity_y, *places)
        return _PLANAR, numbers, tree
    assert isinstance(form, CoupledJoints)
    links = form.tree
    numbers = (
        np.array([link.parent for link in links], dtype=np.int64),
        np.array([link.prismatic for link in links], dtype=np.bool_),
        np.array([link.axis_J for link in links], dtype=float),
        np.array([link.X_PJ[:3, :3] for link in links], dtype=float),
        np.array([link.X_PJ[:3, 3] for link in links], dtype=float),
        np.array([[link.mass_kg, link.armature, link.gravity_factor] for link in links], dtype=float).T.copy(),
        np.array([link.com_J for link in links], dtype=float),
        np.array([link.inertia_J for link in links], dtype=float),
        np.asarray(form.gravity_W, dtype=float).copy(),
    )
    return _TREE, planar, numbers


def _jit(function: Callable[..., Any]) -> Any:
    return numba.njit(cache=True, error_model="numpy")(function)


@_jit
def _roll_separate(
    t_s: Any,
    steps: Any,
    typical_s: Any,
    q0: Any,
    qd0: Any,
    inputs: Any,
    drive: Any,
    kp: Any,
    kd: Any,
    per_unit: Any,
    limit: Any,
    volts: Any,
    dry: Any,
    damping: Any,
    laws: Any,
    kinds: Any,
    places: Any,
    values: Any,
    fresh: Any,
    by_load: Any,
    has_friction: Any,
    remembers: Any,
    separate: Any,
) -> Any:
    """Joints that do nothing to one another: one joint of one world at a time, in scalars."""
    worlds, stamps = t_s.shape
    joints = q0.shape[1]
    Q, QD = np.empty((worlds, stamps, joints)), np.empty((worlds, stamps, joints))
    memory, trial = fresh.copy(), fresh.copy()
    for j in range(joints):
        # Laws of this joint in their order, by kind; the rest of each list is unused.
        order = np.empty(len(kinds), dtype=np.int64)
        ends = np.zeros(4, dtype=np.int64)
        count = 0
        for kind in (_EFFORT_LAW, _TORQUE_LAW, _FRICTION_LAW):
            for i in range(len(kinds)):
                if kinds[i] == kind and places[i] == j:
                    order[count] = i
                    count += 1
            ends[kind] = count
        numbers = separate[:, j].copy()
        for w in range(worlds):
            q, qd = q0[w, j], qd0[w, j]
            memory[:] = fresh
            Q[w, 0, j], QD[w, 0, j] = q, qd
            for k in range(stamps - 1):
                h = (t_s[w, k + 1] - t_s[w, k]) / steps[k]
                dt_s = typical_s[k] / steps[k]
                half = 0.5 * h
                given = inputs[w, k, j] if drive != _NONE else 0.0
                volt = volts[w, k]
                for s in range(steps[k]):
                    q += half * qd
                    now = t_s[w, k] + (s + 0.5) * h
                    if drive == _PD:
                        value = (kp[j] * (given - q) - kd[j] * qd) * per_unit
                        commanded = np.minimum(np.maximum(value, -limit), limit)
                        if remembers:
                            trial[:] = memory
                        ahead = _kick_separate(
                            q, qd, commanded, now, h, dt_s, volt, dry[j], damping[j], laws, order, ends, values,
                            trial, by_load, has_friction, numbers,
                        )  # fmt: skip
                        value = (kp[j] * (given - q) - kd[j] * (0.5 * (qd + ahead))) * per_unit
                    elif drive == _EFFORT:
                        value = given * per_unit
                    else:
                        value = 0.0
                    commanded = np.minimum(np.maximum(value, -limit), limit)
                    qd = _kick_separate(
                        q, qd, commanded, now, h, dt_s, volt, dry[j], damping[j], laws, order, ends, values, memory,
                        by_load, has_friction, numbers,
                    )  # fmt: skip
                    q += half * qd
                Q[w, k + 1, j], QD[w, k + 1, j] = q, qd
    return Q, QD


@_jit
def _kick_separate(
    q: Any,
    qd: Any,
    effort: Any,
    t_s: Any,
    h: Any,
    dt_s: Any,
    volts: Any,
    dry: Any,
    damping: Any,
    laws: Any,
    order: Any,
    ends: Any,
    values: Any,
    memory: Any,
    by_load: Any,
    has_friction: Any,
    numbers: Any,
) -> Any:
    """The rate of a joint after one step: the step of `mechanism._Forces.kick` for one joint."""
    nan = np.nan
    for n in range(ends[_EFFORT_LAW]):
        i = order[n]
        effort = laws[i](JointState(t_s, q, qd, effort, dt_s, nan, nan, nan, volts), values[i], memory[i])
    net = effort - numbers[1]
    turns = numbers[2] != 0.0 or numbers[3] != 0.0 or by_load
    cosine, sine = (np.cos(q), np.sin(q)) if turns else (0.0, 0.0)
    if turns:
        net = effort - (numbers[1] + numbers[2] * cosine + numbers[3] * sine)
    for n in range(ends[_EFFORT_LAW], ends[_TORQUE_LAW]):
        i = order[n]
        net += laws[i](JointState(t_s, q, qd, effort, dt_s, nan, nan, nan, volts), values[i], memory[i])
    heavy = numbers[0] + h * damping
    out = (numbers[0] * qd + h * net) / heavy
    if has_friction:
        load = nan
        if by_load:
            rate2 = qd * qd
            inward = numbers[5] + numbers[6] * cosine + numbers[7] * sine
            load = np.sqrt(np.maximum(numbers[4] - 2.0 * rate2 * inward + (numbers[8] * rate2) ** 2, 0.0))
        largest = dry
        for n in range(ends[_TORQUE_LAW], ends[_FRICTION_LAW]):
            i = order[n]
            direction = -1.0 if out < -1e-9 else 1.0
            largest += laws[i](
                JointState(t_s, q, qd, effort, dt_s, load, largest, direction, volts), values[i], memory[i]
            )
        change = h * np.maximum(largest, 0.0) / heavy
        out -= np.minimum(np.maximum(out, -change), change)
    return np.fmin(np.fmax(out, -_LARGEST_RATE), _LARGEST_RATE)


@_jit
def _roll(
    t_s: Any,
    steps: Any,
    typical_s: Any,
    q0: Any,
    qd0: Any,
    inputs: Any,
    drive: Any,
    kp: Any,
    kd: Any,
    per_unit: Any,
    limit: Any,
    volts: Any,
    dry: Any,
    damping: Any,
    laws: Any,
    kinds: Any,
    places: Any,
    values: Any,
    fresh: Any,
    by_load: Any,
    has_friction: Any,
    form: Any,
    planar: Any,
    tree: Any,
) -> Any:
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
                if drive == _PD:
                    trial[:] = memory
                    _kick(
                        q, qd, last, commanded, now, h, dt_s, volts[w, k], dry, damping, laws, kinds, places, values,
                        trial, by_load, has_friction, form, planar, tree, vectors, matrices, spatial,
                        rotations, ahead,
                    )  # fmt: skip
                    for j in range(joints):
                        middle[j] = 0.5 * (qd[j] + ahead[j])
                    _command(drive, inputs, w, k, q, middle, kp, kd, per_unit, limit, commanded)
                _kick(
                    q, qd, last, commanded, now, h, dt_s, volts[w, k], dry, damping, laws, kinds, places, values,
                    memory, by_load, has_friction, form, planar, tree, vectors, matrices, spatial,
                    rotations, after,
                )  # fmt: skip
                for j in range(joints):
                    last[j] = after[j] - qd[j]
                    qd[j] = after[j]
                    q[j] += half * qd[j]
            Q[w, k + 1], QD[w, k + 1] = q, qd
    return Q, QD


@_jit
def _command(
    drive: Any, inputs: Any, w: Any, k: Any, q: Any, qd: Any, kp: Any, kd: Any, per_unit: Any, limit: Any, out: Any
) -> None:
    for j in range(len(q)):
        if drive == _EFFORT:
            value = inputs[w, k, j] * per_unit
        elif drive == _PD:
            value = (kp[j] * (inputs[w, k, j] - q[j]) - kd[j] * qd[j]) * per_unit
        else:
            value = 0.0
        out[j] = np.minimum(np.maximum(value, -limit), limit)


@_jit
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
    form: Any,
    planar: Any,
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
        if kinds[i] == _EFFORT_LAW:
            j = places[i]
            state = JointState(t_s, q[j], qd[j], effort[j], dt_s, nan, nan, nan, volts)
            effort[j] = laws[i](state, values[i], memory[i])
    _bias(form, planar, tree, q, middle, matrices, spatial, rotations, net)
    for j in range(joints):
        net[j] = effort[j] - net[j]
    for i in range(len(kinds)):
        if kinds[i] == _TORQUE_LAW:
            j = places[i]
            state = JointState(t_s, q[j], qd[j], effort[j], dt_s, nan, nan, nan, volts)
            net[j] += laws[i](state, values[i], memory[i])
    _mass(form, planar, tree, q, matrices, spatial, rotations, vectors)
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
            _load(form, planar, tree, q, qd, matrices, spatial, rotations, load)
        for j in range(joints):
            largest[j] = dry[j]
        for i in range(len(kinds)):
            if kinds[i] == _FRICTION_LAW:
                j = places[i]
                direction = -1.0 if out[j] < -1e-9 else 1.0
                state = JointState(
                    t_s, q[j], qd[j], effort[j], dt_s, load[j] if by_load else nan, largest[j], direction, volts
                )
                largest[j] += laws[i](state, values[i], memory[i])
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
        out[j] = np.fmin(np.fmax(out[j], -_LARGEST_RATE), _LARGEST_RATE)


@_jit
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


@_jit
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


@_jit
def _bias(form: Any, planar: Any, tree: Any, q: Any, qd: Any, matrices: Any, spatial: Any, R: Any, out: Any) -> None:
    joints = len(q)
    if form == _PLANAR:
        rows, pairs, weight, gravity, _, at, rate2 = planar
        angle = rate = 0.0
        for j in range(joints):
            angle += q[j] + rows[0, j]
            rate += qd[j]
            at[j] = complex(np.cos(angle), np.sin(angle))
            rate2[j] = rate * rate
        total = 0.0
        for i in range(joints - 1, -1, -1):
            pull = (np.conj(weight[i] * at[i]) * gravity).imag
            for j in range(joints):
                pull += (pairs[0, i, j] * np.conj(at[i]) * at[j]).imag * rate2[j]
            total += pull
            out[i] = -total
    else:
        zero, load = np.zeros(joints), np.zeros(joints)
        _inverse_dynamics(tree, q, qd, zero, True, spatial, R, out, load)


@_jit
def _load(form: Any, planar: Any, tree: Any, q: Any, qd: Any, matrices: Any, spatial: Any, R: Any, out: Any) -> None:
    joints = len(q)
    if form == _PLANAR:
        rows, pairs, _, gravity, gravity_y, at, _ = planar
        angle = rate = 0.0
        for j in range(joints):
            angle += q[j] + rows[0, j]
            rate += qd[j]
            at[j] = complex(np.cos(angle), np.sin(angle)) * (rate * rate)
        for i in range(joints):
            inward = -rows[3, i] * gravity
            for j in range(joints):
                inward -= at[j] * pairs[1, i, j]
            out[i] = np.sqrt(inward.real**2 + inward.imag**2 + (rows[3, i] * gravity_y) ** 2)
    else:
        zero, effort = np.zeros(joints), np.zeros(joints)
        _inverse_dynamics(tree, q, qd, zero, True, spatial, R, effort, out)


@_jit
def _mass(form: Any, planar: Any, tree: Any, q: Any, matrices: Any, spatial: Any, R: Any, vectors: Any) -> None:
    """The mass matrix into matrices[0]."""
    joints = len(q)
    M = matrices[0]
    if form == _PLANAR:
        rows, pairs, _, _, _, at, _ = planar
        angle = 0.0
        for j in range(joints):
            angle += q[j] + rows[0, j]
            at[j] = complex(np.cos(angle), np.sin(angle))
        for i in range(joints):
            for j in range(joints):
                M[i, j] = (pairs[0, i, j] * np.conj(at[i]) * at[j]).real
            M[i, i] += rows[1, i]
        for i in range(joints - 2, -1, -1):
            for j in range(joints):
                M[i, j] += M[i + 1, j]
        for j in range(joints - 2, -1, -1):
            for i in range(joints):
                M[i, j] += M[i, j + 1]
        for i in range(joints):
            M[i, i] += rows[2, i]
    else:
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


@_jit
def _cross_into(a: Any, b: Any, out: Any) -> None:
    x = a[1] * b[2] - a[2] * b[1]
    y = a[2] * b[0] - a[0] * b[2]
    z = a[0] * b[1] - a[1] * b[0]
    out[0], out[1], out[2] = x, y, z


@_jit
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
