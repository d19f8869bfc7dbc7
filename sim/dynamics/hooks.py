"""Hooks of effects: functions that act in a simulation step, by the place in the step where they act.

The class of a hook gives the place:

    command -> CommandMap -> controller -> EffortMap -> joint torque
        + JointTorque (smooth) + JointFriction (opposes motion) + BodyWrench -> dynamics -> SensorMap -> readings
    ModelChange changes parameters of the model before the first step.

Arrays are vectorised over windows (w) and joints (j), so that one call steps every window of every trial; an engine
that steps one world calls with w = 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place

Params = Mapping[str, float]


class JointState(NamedTuple):
    """One joint in mid step; floats in compiled roll-outs, arrays (w, 1) over worlds elsewhere.

    load       magnitude of the force (N) that the bearing transmits, for friction laws `by_load`; NaN for others.
    friction   the dry friction of the laws before this one, and the `direction` of motion (-1 or 1), for friction laws
               alone; NaN for others.
    supply_V   the logged supply voltage; NaN without a log of it.
    """

    t_s: Any
    q: Any
    qd: Any
    effort: Any
    dt_s: Any
    load: Any = np.nan
    friction: Any = np.nan
    direction: Any = np.nan
    supply_V: Any = np.nan


# Value of a law in a state, from its parameters in the order of the hook's `names`, and what it keeps between steps:
# (m,) or (m, w, 1), NaN before the first step, written in place. Every operation is elementwise (NumPy functions, and
# `sim.dynamics.elementwise.where`), so that one definition is compiled for one world and runs on arrays of worlds.
StepLaw = Callable[[JointState, FloatArray, FloatArray], Any]


@dataclass(frozen=True)
class BodyState:
    """A free body in mid step, world axes: p (w, 3) of the mass centre, quat_wxyz (w, 4), v, w_W (w, 3)."""

    t_s: FloatArray
    p: FloatArray
    quat_wxyz: FloatArray
    v: FloatArray
    w_W: FloatArray


@dataclass(frozen=True)
class Series:
    """A whole trial as recorded or simulated: t_s (n,) and named columns (n, k); the input of maps of logs."""

    t_s: FloatArray
    columns: Mapping[str, FloatArray]


@dataclass(frozen=True)
class ModelChange:
    """Changes parameters of a model before simulation."""

    change: Callable[[Any, Params, Place], Any]


@dataclass(frozen=True)
class CommandMap:
    """Command that reaches the controller or motor, from the command that was sent; maps a whole trial."""

    map: Callable[[Series, Params, Place], Series]


@dataclass(frozen=True)
class EffortMap:
    """Effort of the motor for the commanded effort; keeps `memory` numbers between steps."""

    law: StepLaw
    names: tuple[str, ...]
    memory: int = 0


@dataclass(frozen=True)
class JointTorque:
    """A smooth force or torque on the joint; keeps `memory` numbers between steps."""

    law: StepLaw
    names: tuple[str, ...]
    memory: int = 0


@dataclass(frozen=True)
class JointFriction:
    """Largest friction, at least 0, for motion along the state's `direction`; it never drives the joint.

    `by_load` laws need the load of the bearing.
    """

    law: StepLaw
    names: tuple[str, ...]
    by_load: bool = False
    memory: int = 0


StepHook = EffortMap | JointTorque | JointFriction


def fresh_memory(hook: StepHook, shape: tuple[int, ...] = ()) -> FloatArray:
    """What a law keeps before its first step (m, *shape): NaN."""
    return np.full((hook.memory, *shape), np.nan)


def step_value(hook: StepHook, state: JointState, params: Params, memory: FloatArray) -> FloatArray:
    """The value of a step's law for parameters by name."""
    return hook.law(state, np.array([params[name] for name in hook.names], dtype=float), memory)


@dataclass(frozen=True)
class BodyWrench:
    """Force (w, 3) at the mass centre and torque (w, 3) on a free body, world axes."""

    wrench: Callable[[BodyState, Params], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True)
class SensorMap:
    """Reading of the sensor for a true motion (`report`), and the estimate of the true motion from it (`recover`).

    Both work on the whole trial: a roll-out starts from the output of `recover` and is compared after `report`. A map
    that `spares_joints` changes poses alone where a log holds poses and joints.

    A sensor with memory can `follow`: readings (w, k, j) of positions in windows with rows at t_s (w, k), from the
    readings (w, j) at the first rows, or None where it has settled there. Roll-outs are then compared with what it
    reads, since what is recovered from readings has more noise than they have.
    """

    report: Callable[[Series, Params, Place], Series]
    recover: Callable[[Series, Params, Place], Series]
    spares_joints: bool = False
    follow: Callable[[FloatArray, FloatArray, FloatArray | None, Params], FloatArray] | None = None


Hook = ModelChange | CommandMap | EffortMap | JointTorque | JointFriction | BodyWrench | SensorMap
