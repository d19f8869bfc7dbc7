"""The kernel of joints that do nothing to one another: one joint of one world at a time, in scalars."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.dynamics.compiled.inputs import (
    EFFORT_DRIVE,
    EFFORT_LAW,
    FRICTION_LAW,
    LARGEST_RATE,
    NO_DRIVE,
    PD_DRIVE,
    TORQUE_LAW,
    Inputs,
    call_law,
    jit,
)
from sim.dynamics.hooks import JointState


@jit
def roll_separate(
    given: Inputs,
    remembers: Any,
    separate: Any,
) -> Any:
    """Joints that do nothing to one another: one joint of one world at a time, in scalars."""
    (
        t_s, steps, typical_s, q0, qd0, inputs, drive, kp, kd, per_unit, limit, volts, dry,
        damping, laws, kinds, places, values, fresh, by_load, has_friction,
    ) = given  # fmt: skip
    worlds, stamps = t_s.shape
    joints = q0.shape[1]
    Q, QD = np.empty((worlds, stamps, joints)), np.empty((worlds, stamps, joints))
    memory, trial = fresh.copy(), fresh.copy()
    for j in range(joints):
        # Laws of this joint in their order, by kind; the rest of each list is unused.
        order = np.empty(len(kinds), dtype=np.int64)
        ends = np.zeros(4, dtype=np.int64)
        count = 0
        for kind in (EFFORT_LAW, TORQUE_LAW, FRICTION_LAW):
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
                sent = inputs[w, k, j] if drive != NO_DRIVE else 0.0
                volt = volts[w, k]
                for s in range(steps[k]):
                    q += half * qd
                    now = t_s[w, k] + (s + 0.5) * h
                    if drive == PD_DRIVE:
                        value = (kp[j] * (sent - q) - kd[j] * qd) * per_unit
                        commanded = np.minimum(np.maximum(value, -limit), limit)
                        if remembers:
                            trial[:] = memory
                        ahead = _kick_separate(
                            q, qd, commanded, now, h, dt_s, volt, dry[j], damping[j], laws, order, ends, values,
                            trial, by_load, has_friction, numbers,
                        )  # fmt: skip
                        value = (kp[j] * (sent - q) - kd[j] * (0.5 * (qd + ahead))) * per_unit
                    elif drive == EFFORT_DRIVE:
                        value = sent * per_unit
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


@jit
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
    for n in range(ends[EFFORT_LAW]):
        i = order[n]
        effort = call_law(laws[i], JointState(t_s, q, qd, effort, dt_s, nan, nan, nan, volts), values[i], memory[i])
    net = effort - numbers[1]
    turns = numbers[2] != 0.0 or numbers[3] != 0.0 or by_load
    cosine, sine = (np.cos(q), np.sin(q)) if turns else (0.0, 0.0)
    if turns:
        net = effort - (numbers[1] + numbers[2] * cosine + numbers[3] * sine)
    for n in range(ends[EFFORT_LAW], ends[TORQUE_LAW]):
        i = order[n]
        net += call_law(laws[i], JointState(t_s, q, qd, effort, dt_s, nan, nan, nan, volts), values[i], memory[i])
    heavy = numbers[0] + h * damping
    out = (numbers[0] * qd + h * net) / heavy
    if has_friction:
        load = nan
        if by_load:
            rate2 = qd * qd
            inward = numbers[5] + numbers[6] * cosine + numbers[7] * sine
            load = np.sqrt(np.maximum(numbers[4] - 2.0 * rate2 * inward + (numbers[8] * rate2) ** 2, 0.0))
        largest = dry
        for n in range(ends[TORQUE_LAW], ends[FRICTION_LAW]):
            i = order[n]
            direction = -1.0 if out < -1e-9 else 1.0
            largest += call_law(
                laws[i], JointState(t_s, q, qd, effort, dt_s, load, largest, direction, volts), values[i], memory[i]
            )
        change = h * np.maximum(largest, 0.0) / heavy
        out -= np.minimum(np.maximum(out, -change), change)
    return np.fmin(np.fmax(out, -LARGEST_RATE), LARGEST_RATE)
