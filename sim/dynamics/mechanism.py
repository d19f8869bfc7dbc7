"""Roll-outs of jointed mechanisms from measured states, all windows of all trials in one call.

One step of length h (kick, drift, kick: second order, and energy keeps its mean without friction): half a drift, one
velocity update at the middle, half a drift. In the update smooth forces are explicit (what links do to one another by
their rates, at rates carried on to the middle), viscous damping is implicit, and dry friction is the impulse within
its limit that comes nearest to stopping the joint (projected Gauss-Seidel, as engines do for contacts), so that a
joint can stick.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Literal

import numpy as np

from schemas.arrays import FloatArray, IntArray
from sim.dynamics.hooks import (
    EffortMap,
    Hook,
    JointFriction,
    JointState,
    JointTorque,
    Params,
    StepHook,
    fresh_memory,
    step_value,
)
from sim.dynamics.joint_dynamics import JointDynamics, joint_dynamics
from sim.dynamics.tree import Tree

_JITTER = 0.1  # steps by which an interval may be longer: else half the rows of a jittery clock would take one more.
SUPPLY = "supply_V"  # the side channel that laws read
LARGEST_RATE = 1e4  # rad/s or m/s: beyond, a roll-out has diverged and is held there.


@dataclass(frozen=True)
class Drive:
    """The drive, which converts commands or logged efforts to joint effort; all (j,)."""

    type: Literal["none", "effort", "position_pd"] = "none"
    kp: FloatArray = field(default_factory=lambda: np.zeros(1))
    kd: FloatArray = field(default_factory=lambda: np.zeros(1))
    effort_limit: float | None = None
    effort_per_unit: float = 1.0


@dataclass(frozen=True)
class MechanismModel:
    """Parameters of a mechanism: the tree, gravity in the world, dry friction and damping per joint (j,), drive."""

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
    """Initial states and inputs of roll-outs: t_s (w, k), q0, qd0 (w, j), inputs (w, k, j) held from row to row."""

    t_s: FloatArray
    q0: FloatArray
    qd0: FloatArray
    command: FloatArray | None = None
    effort: FloatArray | None = None
    aux: Mapping[str, FloatArray] = field(default_factory=dict)  # (w, k) each


def windows_from_starts(windows: Windows, q0: FloatArray, qd0: FloatArray) -> Windows:
    """The windows repeated for each of m initial states (m, w, j): m * w windows, cheaper to step in one call."""

    def tiled(values: FloatArray) -> FloatArray:
        return np.tile(values, (len(q0), *[1] * (values.ndim - 1)))

    return Windows(
        t_s=tiled(windows.t_s),
        q0=q0.reshape(-1, q0.shape[2]),
        qd0=qd0.reshape(-1, qd0.shape[2]),
        command=None if windows.command is None else tiled(windows.command),
        effort=None if windows.effort is None else tiled(windows.effort),
        aux={name: tiled(values) for name, values in windows.aux.items()},
    )


def rollout(
    model: MechanismModel, windows: Windows, laws: Sequence[Law] = (), *, largest_step_s: float = 5e-3, finer: int = 1
) -> tuple[FloatArray, FloatArray]:
    """Joint positions and rates (w, k, j) at the stamps of `windows`; row 0 is the start.

    Each interval between stamps is divided into equal steps of about `largest_step_s` at most (by its median over
    windows), each of these into `finer`.
    """
    typical_s = _medians(np.diff(windows.t_s, axis=1))
    steps = np.maximum(1, np.ceil(typical_s / largest_step_s - _JITTER)).astype(int) * finer
    compiled = _compiled_rollout()
    if compiled is not None:
        return compiled.rollout(model, windows, laws, steps, typical_s, SUPPLY)
    return rollout_in_numpy(model, windows, laws, steps, typical_s)


@cache
def _compiled_rollout() -> Any:
    """The compiled form, where Numba is installed and `MANA_COMPILED` is not 0."""
    if os.environ.get("MANA_COMPILED") == "0":
        return None
    try:
        from sim.dynamics.compiled import rollout as compiled
    except ImportError:
        return None
    return compiled


def rollout_in_numpy(
    model: MechanismModel, windows: Windows, laws: Sequence[Law], steps: IntArray, typical_s: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The reference, all worlds at once: `steps` (k - 1,) in each interval, which typically last `typical_s`."""
    worlds, stamps = windows.t_s.shape
    q, qd = windows.q0.astype(float).copy(), windows.qd0.astype(float).copy()
    Q, QD = (np.empty((worlds, stamps, q.shape[1])) for _ in range(2))
    Q[:, 0], QD[:, 0] = q, qd
    forces = _Forces.of(model, laws, worlds)
    spans = np.diff(windows.t_s, axis=1)
    last_change, before = np.zeros_like(qd), np.zeros((worlds, 1))
    for k in range(stamps - 1):
        h = spans[:, k, None] / steps[k]
        dt_s = float(typical_s[k]) / int(steps[k])
        aux = {name: values[:, k, None] for name, values in windows.aux.items()}
        half = 0.5 * h
        if k and len(model.tree) > 1:
            last_change = last_change * np.divide(h, before, out=np.zeros_like(h), where=before > 0.0)
        before = h
        for s in range(steps[k]):
            q = q + half * qd
            commanded = commanded_effort(model.drive, windows, k, q, qd)
            t = windows.t_s[:, k, None] + (s + 0.5) * h if laws else half
            if model.drive.type == "position_pd":
                # The rate at the middle of the step, not at its start: half a step's delay would look like inertia.
                ahead = forces.with_own_memory().kick(q, qd, last_change, commanded, t, h, dt_s, aux)
                commanded = commanded_effort(model.drive, windows, k, q, 0.5 * (qd + ahead))
            after = forces.kick(q, qd, last_change, commanded, t, h, dt_s, aux)
            qd, last_change = after, after - qd
            q = q + half * qd
        Q[:, k + 1], QD[:, k + 1] = q, qd
    return Q, QD


def _medians(spans: FloatArray) -> FloatArray:
    """(k,) over windows; NaN values are left out, which takes far longer."""
    plain = np.median(spans, axis=0)
    return np.nanmedian(spans, axis=0) if np.isnan(plain).any() else plain


def commanded_effort(drive: Drive, windows: Windows, k: int, q: FloatArray, qd: FloatArray) -> FloatArray:
    """Effort commanded by the log or the controller (w, j), within the limit of the drive."""
    if drive.type == "effort" and windows.effort is not None:
        commanded = windows.effort[:, k] * drive.effort_per_unit
    elif drive.type == "position_pd" and windows.command is not None:
        commanded = (drive.kp * (windows.command[:, k] - q) - drive.kd * qd) * drive.effort_per_unit
    else:
        return np.zeros_like(q)
    limit = drive.effort_limit
    return commanded if limit is None else np.minimum(np.maximum(commanded, -limit), limit)


@dataclass(frozen=True)
class _Forces:
    """Forces on a mechanism in a step: its rigid-body forces, and laws by kind, in order, each with its memory."""

    model: MechanismModel
    dynamics: JointDynamics
    drives: tuple[tuple[Law, EffortMap, FloatArray], ...]
    torques: tuple[tuple[Law, JointTorque, FloatArray], ...]
    frictions: tuple[tuple[Law, JointFriction, FloatArray], ...]
    has_friction: bool
    no_load: FloatArray  # (w, j) NaN, in place of loads that no law needs

    @staticmethod
    def of(model: MechanismModel, laws: Sequence[Law], worlds: int) -> _Forces:
        def memory(law: Law) -> FloatArray:
            return fresh_memory(law.hook, (worlds, 1)) if isinstance(law.hook, StepHook) else np.empty(0)

        frictions = tuple((law, law.hook, memory(law)) for law in laws if isinstance(law.hook, JointFriction))
        return _Forces(
            model,
            joint_dynamics(model.tree, model.gravity_W),
            tuple((law, law.hook, memory(law)) for law in laws if isinstance(law.hook, EffortMap)),
            tuple((law, law.hook, memory(law)) for law in laws if isinstance(law.hook, JointTorque)),
            frictions,
            bool(frictions) or bool(model.friction.any()),
            np.full((worlds, len(model.tree)), np.nan),
        )

    def with_own_memory(self) -> _Forces:
        """A copy with separate memories, for a trial step."""
        if not any(hook.memory for _, hook, _ in (*self.drives, *self.torques, *self.frictions)):
            return self
        drives = tuple((law, hook, memory.copy()) for law, hook, memory in self.drives)
        torques = tuple((law, hook, memory.copy()) for law, hook, memory in self.torques)
        frictions = tuple((law, hook, memory.copy()) for law, hook, memory in self.frictions)
        return replace(self, drives=drives, torques=torques, frictions=frictions)

    def kick(
        self,
        q: FloatArray,
        qd: FloatArray,
        last_change: FloatArray,
        commanded: FloatArray,
        t_s: FloatArray,
        h: FloatArray,
        dt_s: float,
        aux: Mapping[str, FloatArray],
    ) -> FloatArray:
        """Joint rates after one step of length `h` (w, 1), typically `dt_s`.

        `last_change` is the change of the rates in the step before.
        """
        model, configuration = self.model, self.dynamics.at(q)
        effort = commanded.copy() if self.drives else commanded

        supply_V = aux.get(SUPPLY, np.nan)

        def state(j: int) -> JointState:
            column = np.s_[:, j : j + 1]
            return JointState(t_s, q[column], qd[column], effort[column], dt_s, supply_V=supply_V)

        for law, hook, memory in self.drives:
            effort[:, law.joint, None] = step_value(hook, state(law.joint), law.params, memory)
        # The velocity-product force between links depends on rates so strongly that half a step matters.
        net = effort - configuration.bias(qd + 0.5 * last_change if len(model.tree) > 1 else qd)
        for law, hook, memory in self.torques:
            net[:, law.joint, None] += step_value(hook, state(law.joint), law.params, memory)
        free = configuration.free_rates(qd, net, model.damping, h)
        if self.has_friction:
            largest: FloatArray = model.friction
            if self.frictions:
                # Bearing loads cost as much as all else: they are computed only for laws that need them.
                load = configuration.load(qd) if any(hook.by_load for _, hook, _ in self.frictions) else self.no_load
                direction = np.where(free < -1e-9, -1.0, 1.0)
                largest = model.friction + np.zeros(q.shape)
                for law, hook, memory in self.frictions:
                    column = np.s_[:, law.joint : law.joint + 1]
                    friction = largest[column].copy()
                    now = state(law.joint)._replace(load=load[column], friction=friction, direction=direction[column])
                    largest[column] += step_value(hook, now, law.params, memory)
            free = configuration.with_dry_friction(free, h * np.maximum(largest, 0.0), model.damping, h)
        # NaN counts as beyond the bound, too.
        return np.fmin(np.fmax(free, -LARGEST_RATE), LARGEST_RATE)
