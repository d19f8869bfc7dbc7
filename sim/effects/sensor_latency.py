"""Readings that are old when they are stamped."""

from __future__ import annotations

from schemas.gap import Place
from sim.effects.effect import Confusable, Effect, Parameter, Params, SensorMap, Series
from sim.effects.series import read_at, with_columns

_READ = ("q", "qd", "qdd", "p", "quat_wxyz", "v_W", "w_B")


def _report(series: Series, params: Params, where: Place) -> Series:
    old = series.t_s - params["latency_s"]
    return with_columns(series, _READ, lambda true: read_at(series.t_s, true, old))


def _recover(series: Series, params: Params, where: Place) -> Series:
    later = series.t_s + params["latency_s"]
    return with_columns(series, _READ, lambda read: read_at(series.t_s, read, later))


EFFECT = Effect(
    name="sensor.latency",
    kinds=("mechanism", "tracking"),
    formula="reading(t) = truth(t - latency_s)",
    source="transport delay",
    reveals="the whole motion comes late against commands; free motion looks right",
    parameters=(Parameter("latency_s", "s", 0.0, 0.3, 0.0),),
    confusables=(
        Confusable("actuator.delay", "read commands and motion with one clock, or log the true effort"),
        Confusable("joint.backlash", "reverse at several speeds"),
    ),
    hook=SensorMap(_report, _recover),
)
