"""Sensor lag: readings of positions q and rates qd follow the truth as a first-order low-pass (time constant in s)."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import Params, SensorMap, Series
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.common.series import low_passed, read_at, with_columns
from sim.effects.effect import Confusable, Effect, Parameter

_READ = ("q", "qd")
_BESIDE = 0.25  # of the time constant, to either side of a row: the mean rate over half of it


def _report(series: Series, params: Params, where: Place) -> Series:
    return with_columns(
        series, _READ, lambda true: low_passed(series.t_s[None], true[None], params["time_constant_s"])[0]
    )


def _recover(series: Series, params: Params, where: Place) -> Series:
    """Truth = reading + time constant * its rate; the rate is a mean over half a time constant.

    Rates of single rows would make the noise of accelerations as much larger as the time constant is longer than rows;
    what a low-pass left of motion faster than itself is little.
    """
    tau_s, t_s = params["time_constant_s"], series.t_s
    if tau_s == 0.0:
        return series
    behind_s, ahead_s = (np.clip(t_s + shift * tau_s, t_s[0], t_s[-1]) for shift in (-_BESIDE, _BESIDE))
    spans = (ahead_s - behind_s)[:, None]

    def undone(read: FloatArray) -> FloatArray:
        return read + tau_s * (read_at(t_s, read, ahead_s) - read_at(t_s, read, behind_s)) / spans

    recovered = with_columns(series, ("q", "qd", "qdd"), undone)
    if not {"reading", "q"} <= series.columns.keys():
        return recovered
    shift = recovered.columns["q"] - series.columns["q"]
    return with_columns(recovered, ("reading",), lambda reading: reading + shift)


def _follow(t_s: FloatArray, q: FloatArray, start: FloatArray | None, params: Params) -> FloatArray:
    return low_passed(t_s, q, params["time_constant_s"], start)


EFFECT = Effect(
    name="sensor.lag",
    kinds=("mechanism", "tracking"),
    formula="time_constant_s * d(reading)/dt = truth - reading, of positions and rates",
    source="first-order low-pass of an encoder or its driver",
    reveals="turning points are rounded and come late; fast motion looks smaller than it is",
    parameters=(Parameter("time_constant_s", "s", 0.0, 0.2, 0.0),),
    confusables=(
        Confusable("actuator.lag", "watch with a second sensor, or let the joint swing with the drive off"),
        Confusable("sensor.latency", "move at several frequencies: a latency makes nothing smaller"),
        Confusable("actuator.delay", "move at several frequencies: a delay makes nothing smaller"),
        Confusable("joint.armature", "let the joint swing with the drive off"),
    ),
    hook=SensorMap(_report, _recover, follow=_follow),
    mechanism=MechanismCandidacy(observable=lambda r: r.driven),
)
