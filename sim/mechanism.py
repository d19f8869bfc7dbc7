"""Roll-outs of jointed mechanisms from measured states, all windows of all trials in one call.

One step of length h (kick, drift, kick: second order, and energy keeps its mean without friction): half a drift, one
velocity update at the middle, half a drift. In the update smooth forces are explicit, viscous damping is implicit, and
dry friction is the impulse within its limit that comes nearest to stopping the joint (projected Gauss-Seidel, as
engines do for contacts), so that a joint can stick.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from schemas.model import FloatArray
from sim.effects.effect import EffortMap, Hook, JointFriction, JointState, JointTorque, Params
from sim.joint_dynamics import JointDynamics, joint_dynamics
from sim.tree import Tree

_LARGEST_RATE = 1e4  # rad/s or m/s: beyond, a roll-out has diverged and is held there.


@dataclass(frozen=True)
class Drive:
    """What turns commands or logged efforts into joint effort; all (j,)."""

    type: Literal["none", "effort", "position_pd"] = "none"
    kp: FloatArray = field(default_factory=lambda: np.zeros(1))
    kd: FloatArray = field(default_factory=lambda: np.zeros(1))
    effort_limit: float | None = None
    effort_per_unit: float = 1.0


@dataclass(frozen=True)
class MechanismModel:
    """Numbers of a mechanism: the tree, gravity in the world, dry friction and damping per joint (j,), drive."""

    tree: Tree
    gravity_W: FloatArray
    friction: FloatArray
    damping: FloatArray
    drive: Drive = Drive()
    limits: FloatArray | None = None  # (j, 2)


@dataclass(frozen=True)
class Law:
    """An effect's hook with values, on one joint."""

    hook: Hook
    params: Params
    joint: int


@dataclass(frozen=True)
class Windows:
    """Where roll-outs start and what drives them: t_s (w, k), q0, qd0 (w, j), inputs (w, k, j) held from row to row."""

    t_s: FloatArray
    q0: FloatArray
    qd0: FloatArray
    command: FloatArray | None = None
    effort: FloatArray | None = None
    aux: Mapping[str, FloatArray] = field(default_factory=dict)  # (w, k) each


def rollout(
    model: MechanismModel, windows: Windows, laws: Sequence[Law] = (), *, largest_step_s: float = 5e-3
) -> tuple[FloatArray, FloatArray]:
    """Joint positions and rates (w, k, j) at the stamps of `windows`; row 0 is the start.

    Each interval between stamps is divided into equal steps of at most `largest_step_s` (by its median over windows).
    """
    worlds, stamps = windows.t_s.shape
    q, qd = windows.q0.astype(float).copy(), windows.qd0.astype(float).copy()
    Q, QD = (np.empty((worlds, stamps, q.shape[1])) for _ in range(2))
    Q[:, 0], QD[:, 0] = q, qd
    memory: list[dict[str, FloatArray]] = [{} for _ in laws]
    dynamics = joint_dynamics(model.tree, model.gravity_W)
    spans = np.diff(windows.t_s, axis=1)
    typical = np.nanmedian(spans, axis=0) if stamps > 1 else np.zeros(0)
    for k in range(stamps - 1):
        steps = max(1, int(np.ceil(typical[k] / largest_step_s - 1e-9)))
        h = spans[:, k, None] / steps
        dt_s = float(typical[k]) / steps
        aux = {name: values[:, k, None] for name, values in windows.aux.items()}
        for s in range(steps):
            q = q + 0.5 * h * qd
            asked = asked_effort(model.drive, windows, k, q, qd)
            t = windows.t_s[:, k, None] + (s + 0.5) * h
            if model.drive.type == "position_pd":
                # The rate at the middle of the step, not at its start: half a step's delay would look like inertia.
                ahead = _kick(model, dynamics, laws, [dict(m) for m in memory], q, qd, asked, t, h, dt_s, aux)
                asked = asked_effort(model.drive, windows, k, q, 0.5 * (qd + ahead))
            qd = _kick(model, dynamics, laws, memory, q, qd, asked, t, h, dt_s, aux)
            q = q + 0.5 * h * qd
        Q[:, k + 1], QD[:, k + 1] = q, qd
    return Q, QD


def asked_effort(drive: Drive, windows: Windows, k: int, q: FloatArray, qd: FloatArray) -> FloatArray:
    """Effort that the log or the controller asks for (w, j)."""
    if drive.type == "effort" and windows.effort is not None:
        asked = windows.effort[:, k] * drive.effort_per_unit
    elif drive.type == "position_pd" and windows.command is not None:
        asked = (drive.kp * (windows.command[:, k] - q) - drive.kd * qd) * drive.effort_per_unit
    else:
        return np.zeros_like(q)
    limit = drive.effort_limit
    return asked if limit is None else np.clip(asked, -limit, limit)


def _kick(
    model: MechanismModel,
    dynamics: JointDynamics,
    laws: Sequence[Law],
    memory: Sequence[dict[str, FloatArray]],
    q: FloatArray,
    qd: FloatArray,
    asked: FloatArray,
    t_s: FloatArray,
    h: FloatArray,
    dt_s: float,
    aux: Mapping[str, FloatArray],
) -> FloatArray:
    """Joint rates after one step of length `h` (w, 1), typically `dt_s`."""
    bias, load = dynamics.bias(q, qd)
    effort, smooth = asked, np.zeros_like(q)
    if any(isinstance(law.hook, EffortMap) for law in laws):
        effort = asked.copy()

    def state(j: int) -> JointState:
        one = np.s_[:, j : j + 1]
        return JointState(t_s, q[one], qd[one], effort[one], load[one], dt_s, aux)

    for law, kept in zip(laws, memory, strict=True):
        if isinstance(law.hook, EffortMap):
            effort[:, law.joint, None] = law.hook.map(state(law.joint), law.params, kept)
    for law, kept in zip(laws, memory, strict=True):
        if isinstance(law.hook, JointTorque):
            smooth[:, law.joint, None] += law.hook.torque(state(law.joint), law.params, kept)
    free = dynamics.free_rates(q, qd, effort + smooth - bias, model.damping, h)
    rubbing = [(law, law.hook) for law in laws if isinstance(law.hook, JointFriction)]
    if rubbing or model.friction.any():
        direction = np.where(np.abs(free) > 1e-9, np.sign(free), 1.0)
        largest = np.broadcast_to(model.friction, q.shape).copy()
        for law, hook in rubbing:
            one = np.s_[:, law.joint : law.joint + 1]
            now = replace(state(law.joint), friction=largest[one])
            largest[one] += hook.limit(now, law.params, direction[one])
        free = dynamics.held(q, free, h * np.maximum(largest, 0.0), model.damping, h)
    if not np.isfinite(free).all():
        free = np.nan_to_num(free)
    return np.clip(free, -_LARGEST_RATE, _LARGEST_RATE)
