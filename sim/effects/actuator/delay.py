"""Actuator delay: a command or effort takes effect some time (s) after it was sent."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.dynamics.elementwise import where
from sim.dynamics.hooks import CommandMap, EffortMap, JointState, Params, Series
from sim.effects.candidacy import MechanismCandidacy, Nuisance, within
from sim.effects.common.series import held_at, with_columns
from sim.effects.effect import IN_LOOP, Confusable, Effect, Parameter
from sim.effects.ranges import DeclaredJoint

_STEPS = 64  # remembered
_NO_TIME_S = 1e-12
_MEETING = 0.1  # of a row: how well the time is known at which an input acts


def _map(series: Series, params: Params, where: Place) -> Series:
    late = series.t_s - params["delay_s"]
    return with_columns(series, ("command", "effort"), lambda sent: held_at(series.t_s, sent, late))


def _held_back(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    """Effort as it was one delay ago, between the steps on either side; before the first step, the first one."""
    for i in range(_STEPS - 1, 0, -1):
        memory[i] = memory[i - 1]
    memory[0] = state.effort
    ago = np.minimum(values[0] / np.maximum(state.dt_s, _NO_TIME_S), _STEPS - 1.001)
    n = int(ago)
    late, later = memory[n], memory[n + 1]
    late = where(np.isnan(late), state.effort, late)
    later = where(np.isnan(later), state.effort, later)
    return late + (ago - n) * (later - late)


def _input_timing(joint: DeclaredJoint) -> Nuisance | None:
    """Inputs meet readings within a share of a row: loops read before they write, engines act on whole steps."""
    return within("timing", "delay_s", 0.0, _MEETING * joint.row_s) if joint.driven and joint.joint == 0 else None


EFFECT = Effect(
    name="actuator.delay",
    kinds=("mechanism", "tracking"),
    formula="command(t) becomes command(t - delay_s); in the loop (in_loop = 1), effort(t) becomes effort(t - delay_s)",
    source="transport delay",
    reveals="the response to every change starts late by the same time",
    parameters=(Parameter("delay_s", "s", 0.0, 0.3, 0.0), IN_LOOP),
    confusables=(
        Confusable("sensor.latency", "time the joint with a second clock, or watch it move with the drive off", True),
        Confusable("actuator.lag", "command steps: a delay keeps the corner sharp"),
        Confusable("joint.backlash", "reverse at several speeds"),
    ),
    hook=CommandMap(_map),
    in_loop=EffortMap(_held_back, ("delay_s",), memory=_STEPS),
    mechanism=MechanismCandidacy(observable=lambda r: r.driven, nuisance=_input_timing),
)
