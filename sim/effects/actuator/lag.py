"""Actuator lag: the drive follows commands as a first-order low-pass with a time constant (s)."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import solve_banded

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.dynamics.elementwise import where
from sim.dynamics.hooks import CommandMap, EffortMap, JointState, Params, Series
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.common.series import with_columns
from sim.effects.effect import IN_LOOP, Confusable, Effect, Parameter

_NO_TIME_S = 1e-12  # no division by none


def _map(series: Series, params: Params, where: Place) -> Series:
    return with_columns(series, ("command", "effort"), lambda sent: _followed(series.t_s, sent, params["lag_s"]))


def _followed(t_s: FloatArray, sent: FloatArray, lag_s: float) -> FloatArray:
    """First-order answer to inputs (n, k) that are held from row to row: its mean from each stamp to the next."""
    if lag_s <= 0.0:
        return sent
    keep = np.exp(-np.diff(t_s) / lag_s)
    # answer[i + 1] - keep[i] answer[i] = (1 - keep[i]) sent[i], all rows at once.
    rows = np.concatenate([sent[:1], (1.0 - keep)[:, None] * sent[:-1]])
    bands = np.stack([np.ones(len(t_s)), np.append(-keep, 0.0)])
    at_stamps = np.asarray(solve_banded((1, 0), bands, rows))
    # Inputs are held until the next stamp, so what counts is the mean of the answer until then.
    span = np.append(np.diff(t_s), np.median(np.diff(t_s)))[:, None] / lag_s
    return sent + (at_stamps - sent) * -np.expm1(-span) / span


def _low_passed(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    """First-order answer to efforts that are held for a step: its mean over the step."""
    steps = np.maximum(state.dt_s, _NO_TIME_S) / np.maximum(values[0], _NO_TIME_S)
    before = where(np.isnan(memory[0]), state.effort, memory[0])
    memory[0] = state.effort + (before - state.effort) * np.exp(-steps)
    return state.effort - (before - state.effort) * np.expm1(-steps) / steps


EFFECT = Effect(
    name="actuator.lag",
    kinds=("mechanism", "tracking"),
    formula="lag_s * d(command)/dt = sent - command; in the loop (in_loop = 1), lag_s * d(effort)/dt = asked - effort",
    source="first-order motor electrics or low-pass of the drive",
    reveals="steps are rounded; fast commands are weakened and late",
    parameters=(Parameter("lag_s", "s", 0.0, 0.5, 0.0), IN_LOOP),
    confusables=(
        Confusable("actuator.delay", "command steps: a lag rounds the corner"),
        Confusable("joint.armature", "accelerate at several frequencies"),
    ),
    hook=CommandMap(_map),
    in_loop=EffortMap(_low_passed, ("lag_s",), memory=1),
    mechanism=MechanismCandidacy(observable=lambda r: r.driven),
)
