"""Actuator delay: a command or effort takes effect some time (s) after it was sent."""

from __future__ import annotations

from schemas.gap import Place
from sim.dynamics.hooks import CommandMap, Confusable, Effect, Parameter, Params, Series
from sim.effects.common.series import held_at, with_columns


def _map(series: Series, params: Params, where: Place) -> Series:
    late = series.t_s - params["delay_s"]
    return with_columns(series, ("command", "effort"), lambda sent: held_at(series.t_s, sent, late))


EFFECT = Effect(
    name="actuator.delay",
    kinds=("mechanism", "tracking"),
    formula="command(t) becomes command(t - delay_s)",
    source="transport delay",
    reveals="the response to every change starts late by the same time",
    parameters=(Parameter("delay_s", "s", 0.0, 0.3, 0.0),),
    confusables=(
        Confusable("sensor.latency", "time the joint with a second clock, or watch it move with the drive off"),
        Confusable("actuator.lag", "command steps: a delay keeps the corner sharp"),
        Confusable("joint.backlash", "reverse at several speeds"),
    ),
    hook=CommandMap(_map),
)
