"""The declared body with terms applied: changed numbers, wrenches for the steps, maps of readings."""

from __future__ import annotations

from dataclasses import dataclass

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import BodyWrench, ModelChange, Params, SensorMap, Series
from simgap.problem import Model


@dataclass(frozen=True)
class AppliedBody:
    """A model as inputs of a roll-out: the changed body, external wrenches, maps of readings."""

    body: BodyModel
    wrenches: tuple[tuple[BodyWrench, Params], ...]
    sensors: tuple[tuple[SensorMap, Params, Place], ...]

    def recovered(self, series: Series) -> Series:
        """True motion from readings: the sensor maps inverted."""
        for hook, params, where in reversed(self.sensors):
            series = hook.recover(series, params, where)
        return series

    def reported(self, series: Series) -> Series:
        """Truth as it would be read."""
        for hook, params, where in self.sensors:
            series = hook.report(series, params, where)
        return series


def apply_terms(declared: BodyModel, model: Model) -> AppliedBody:
    """`declared` with the terms of `model` in their order; a later term of the same number replaces an earlier one."""
    body, wrenches, sensors = declared, [], []
    for term in model:
        hook, where = term.candidate.effect.hook, term.candidate.where
        if isinstance(hook, ModelChange):
            body = hook.change(body, term.values, where)
        elif isinstance(hook, BodyWrench):
            wrenches.append((hook, term.values))
        elif isinstance(hook, SensorMap):
            sensors.append((hook, term.values, where))
        else:
            raise ValueError(f"{term.candidate.effect.name} does not act on free bodies")
    return AppliedBody(body, tuple(wrenches), tuple(sensors))
