"""Clock skew: the clock of the log runs fast or slow by a factor."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import Params, SensorMap, Series
from sim.effects.candidacy import MechanismCandidacy, TossCandidacy
from sim.effects.effect import Confusable, Effect, Parameter

_CLOCK_FACTORS = (0.7, 1.4)


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
    mechanism=MechanismCandidacy(whole_log=True),
    free_body=TossCandidacy(
        bounds=lambda r: {"factor": _CLOCK_FACTORS},
        direct=("pace_of_falls",),
        linked_direct=("pace_of_falls",),
        bounds_from_direct=True,
    ),
)
