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
from dataclasses import dataclass, field
from typing import Any

from schemas.arrays import FloatArray
from schemas.gap import Place

Params = Mapping[str, float]


@dataclass(frozen=True)
class JointState:
    """Joints in mid step, all (w, j).

    load      magnitude of the force that the bearing transmits, for friction laws `by_load`; NaN for others.
    friction  the dry friction of the laws before this one, for friction laws alone.
    """

    t_s: FloatArray  # (w, 1)
    q: FloatArray
    qd: FloatArray
    effort: FloatArray
    load: FloatArray
    dt_s: float
    aux: Mapping[str, FloatArray] = field(default_factory=dict)  # (w, 1) each
    friction: FloatArray | None = None


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
    """Effort of the motor (w, j) for the commanded effort; `memory` starts empty and is kept between steps."""

    map: Callable[[JointState, Params, dict[str, FloatArray]], FloatArray]


@dataclass(frozen=True)
class JointTorque:
    """A smooth force or torque on the joint (w, j)."""

    torque: Callable[[JointState, Params, dict[str, FloatArray]], FloatArray]


@dataclass(frozen=True)
class JointFriction:
    """Largest friction (w, j), at least 0, for motion along `direction` (w, j; -1 or 1); it never drives the joint.

    `by_load` laws need the load of the bearing.
    """

    limit: Callable[[JointState, Params, FloatArray], FloatArray]
    by_load: bool = False


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
    readings (w, j) at the first rows. Roll-outs are then compared with what it reads, since what is recovered from
    readings has more noise than they have.
    """

    report: Callable[[Series, Params, Place], Series]
    recover: Callable[[Series, Params, Place], Series]
    spares_joints: bool = False
    follow: Callable[[FloatArray, FloatArray, FloatArray, Params], FloatArray] | None = None


Hook = ModelChange | CommandMap | EffortMap | JointTorque | JointFriction | BodyWrench | SensorMap
