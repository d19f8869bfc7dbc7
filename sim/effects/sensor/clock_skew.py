"""Clock skew: the clock of the log runs fast or slow by a factor."""

from __future__ import annotations

from dataclasses import replace

from schemas.gap import Place
from sim.dynamics.hooks import Confusable, Effect, Parameter, Params, SensorMap, Series


def _report(series: Series, params: Params, where: Place) -> Series:
    return replace(series, t_s=series.t_s * params["factor"])


def _recover(series: Series, params: Params, where: Place) -> Series:
    factor = params["factor"]
    power = {"qd": 1, "v_W": 1, "w_B": 1, "qdd": 2}
    rates = {n: series.columns[n] * factor**k for n, k in power.items() if n in series.columns}
    return replace(series, t_s=series.t_s / factor, columns={**series.columns, **rates})


EFFECT = Effect(
    name="sensor.clock_skew",
    kinds=("mechanism", "free_body", "tracking"),
    formula="stamp = factor * time; rates were computed with the stamps",
    source="oscillator tolerance, or a wrong nominal rate",
    reveals="everything happens at the right places but too fast or too slow",
    parameters=(Parameter("factor", "1", 0.5, 2.0, 1.0),),
    confusables=(
        Confusable("world.gravity_magnitude", "time the log with a second clock"),
        Confusable("joint.gravity_load", "time the log with a second clock"),
    ),
    hook=SensorMap(_report, _recover),
)
