"""The declared mechanism with terms applied: changed numbers, laws for the steps, maps of inputs and readings."""

from __future__ import annotations

from dataclasses import dataclass

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import CommandMap, ModelChange, Params, SensorMap, Series
from sim.dynamics.mechanism import Law, MechanismModel
from sim.effects.common.joint_values import joint_index
from simgap.problem import Model

SensorTerm = tuple[SensorMap, Params, Place]


@dataclass(frozen=True)
class Applied:
    """A model as inputs of a roll-out: the changed mechanism, joint laws, maps of inputs and of readings."""

    mechanism: MechanismModel
    laws: tuple[Law, ...]
    inputs: tuple[tuple[CommandMap, Params, Place], ...]
    sensors: tuple[SensorTerm, ...]

    @property
    def maps(self) -> tuple[object, ...]:
        """Equal where inputs and readings are mapped in the same way."""
        return tuple((h, tuple(p.items()), w.joint) for h, p, w in (*self.inputs, *self.sensors))

    def sent(self, series: Series) -> Series:
        """Inputs as they reach the drive."""
        for hook, params, where in self.inputs:
            series = hook.map(series, params, where)
        return series

    def recovered(self, series: Series) -> Series:
        """True motion from readings: the sensor maps inverted."""
        for hook, params, where in reversed(self.sensors):
            series = hook.recover(series, params, where)
        return series

    @property
    def has_memory(self) -> bool:
        """Whether the reading of some sensor depends on earlier motion."""
        return any(hook.follow is not None for hook, _, _ in self.sensors)

    def without_memory(self, series: Series) -> Series:
        """What roll-outs are compared with: readings with those sensors inverted that have no memory."""
        for hook, params, where in reversed(self.sensors):
            series = series if hook.follow else hook.recover(series, params, where)
        return series

    def read_off(self, t_s: FloatArray, q: FloatArray, rows: FloatArray) -> FloatArray:
        """What all sensors make of true positions (w, k, j) at t_s (w, k), of which so many `rows` (w,) count."""
        for hook, params, where in self.sensors:
            if hook.follow:
                q = hook.follow(t_s, q, None, params)
                continue
            q = q.copy()
            for i, n in enumerate(rows):
                q[i, :n] = hook.report(Series(t_s[i, :n], {"q": q[i, :n]}), params, where).columns["q"]
        return q

    def followed(self, t_s: FloatArray, q: FloatArray, start: FloatArray) -> FloatArray:
        """What sensors with memory make of true positions (w, k, j) at t_s (w, k), from readings `start` (w, j)."""
        for hook, params, _ in self.sensors:
            q = hook.follow(t_s, q, start, params) if hook.follow else q
        return q


def apply_terms(declared: MechanismModel, model: Model) -> Applied:
    """`declared` with the terms of `model` in their order; a later term of the same number replaces an earlier one."""
    mechanism, laws, inputs, sensors = declared, [], [], []
    for term in model:
        hook, where = term.candidate.effect.hook_at(term.values), term.candidate.where
        if isinstance(hook, ModelChange):
            mechanism = hook.change(mechanism, term.values, where)
        elif isinstance(hook, CommandMap):
            inputs.append((hook, term.values, where))
        elif isinstance(hook, SensorMap):
            sensors.append((hook, term.values, where))
        else:
            laws.append(Law(hook, term.values, joint_index(declared, where)))
    return Applied(mechanism, tuple(laws), tuple(inputs), tuple(sensors))
