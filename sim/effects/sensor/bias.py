"""Sensor bias: a joint reading with a constant error (rad, m)."""

from __future__ import annotations

from schemas.gap import Place
from sim.dynamics.hooks import Confusable, Effect, Parameter, Params, SensorMap, Series
from sim.effects.common.series import with_columns


def _report(series: Series, params: Params, where: Place) -> Series:
    return with_columns(series, ("q", "reading"), lambda true: true + params["offset_rad"])


def _recover(series: Series, params: Params, where: Place) -> Series:
    return with_columns(series, ("q", "reading"), lambda read: read - params["offset_rad"])


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
)
