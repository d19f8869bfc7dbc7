"""Velocity age: reported rates belong to an earlier moment (s) than the positions beside them."""

from __future__ import annotations

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import Params, SensorMap, Series
from sim.effects.candidacy import MechanismCandidacy, TossCandidacy, never
from sim.effects.common.series import read_at, with_columns
from sim.effects.effect import Confusable, Effect, Parameter

_RATES = ("qd", "v_W", "w_B")
_YOUNGEST, _OLDEST = -0.5, 1.0  # of the time in which the body falls its own length


def _report(series: Series, params: Params, where: Place) -> Series:
    old = series.t_s - params["age_s"]
    return with_columns(series, _RATES, lambda true: read_at(series.t_s, true, old))


def _recover(series: Series, params: Params, where: Place) -> Series:
    later = series.t_s + params["age_s"]
    return with_columns(series, _RATES, lambda read: read_at(series.t_s, read, later))


EFFECT = Effect(
    name="sensor.velocity_age",
    kinds=("mechanism", "free_body", "tracking"),
    formula="reported rate(t) = true rate(t - age_s); a backward difference has half a frame",
    source="finite differences and filters have a group delay",
    reveals="integrated rates run behind the positions by a constant time",
    parameters=(Parameter("age_s", "s", -10.0, 10.0, 0.0),),
    confusables=(Confusable("world.gravity_magnitude", "compare rates with differences of the positions"),),
    hook=SensorMap(_report, _recover),
    # Rates of joints come from the positions here, so that their age is known.
    mechanism=MechanismCandidacy(observable=never),
    free_body=TossCandidacy(
        bounds=lambda r: {"age_s": (_YOUNGEST * r.fall_s, _OLDEST * r.fall_s)},
        direct=("rates_behind_path",),
        linked_direct=("rates_behind_common_path",),
        bounds_from_direct=True,
    ),
)
