"""Sensor bias: a joint reading with a constant error (rad, m)."""

from __future__ import annotations

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import Params, SensorMap, Series
from sim.effects.candidacy import Bounds, MechanismCandidacy, TossCandidacy
from sim.effects.common.series import with_columns
from sim.effects.effect import Confusable, Effect, Parameter
from sim.effects.ranges import TossRanges

_BIAS_SHARE, _LINKED_SHARE = 0.3, 0.2  # of the range that was reached; of the travel of a linkage


def _report(series: Series, params: Params, where: Place) -> Series:
    return with_columns(series, ("q", "reading"), lambda true: true + params["offset_rad"])


def _recover(series: Series, params: Params, where: Place) -> Series:
    return with_columns(series, ("q", "reading"), lambda read: read - params["offset_rad"])


def _linked_bounds(r: TossRanges) -> Bounds:
    most = _LINKED_SHARE * r.joint.half_travel if r.joint else 0.0
    return {"offset_rad": (-most, most)}


EFFECT = Effect(
    name="sensor.bias",
    kinds=("mechanism", "free_body", "tracking"),
    formula="reading = truth + offset_rad",
    source="encoder zero",
    reveals="gravity or the controller acts as if at another position",
    parameters=(Parameter("offset_rad", "rad (m)", -1.0, 1.0, 0.0),),
    confusables=(
        Confusable("joint.axis_tilt", "measure the place of rest with a level"),
        Confusable("actuator.bias", "switch the drive off"),
    ),
    hook=SensorMap(_report, _recover),
    mechanism=MechanismCandidacy(bounds=lambda r: {"offset_rad": (-_BIAS_SHARE * r.span, _BIAS_SHARE * r.span)}),
    free_body=TossCandidacy(observable=lambda r: r.joint is not None, bounds=_linked_bounds, acts_on="joint"),
)
