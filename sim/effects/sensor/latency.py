"""Sensor latency: readings are older than their stamps by a constant time (s)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import Params, SensorMap, Series
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.common.series import read_at, with_columns
from sim.effects.effect import Confusable, Effect, Parameter

_READ = ("q", "reading", "qd", "qdd", "p", "quat_wxyz", "v_W", "w_B")


def _report(series: Series, params: Params, where: Place) -> Series:
    old = series.t_s - params["latency_s"]
    return with_columns(series, _READ, lambda true: read_at(series.t_s, true, old))


def _recover(series: Series, params: Params, where: Place) -> Series:
    later = series.t_s + params["latency_s"]
    if {"q", "qd", "qdd"} <= series.columns.keys():
        return _extrapolated(series, later)
    return with_columns(series, _READ, lambda read: read_at(series.t_s, read, later))


def _extrapolated(series: Series, later: FloatArray) -> Series:
    """Joints at other times from the nearest row and its rates.

    A mean of two rows would have less noise than either, and a latency of half a row would look like a better model.
    """
    rows = np.clip(np.round(np.interp(later, series.t_s, np.arange(len(later)))).astype(int), 0, len(later) - 1)
    ahead = np.clip(later - series.t_s[rows], -np.inf, np.median(np.diff(series.t_s)))[:, None]
    q, qd, qdd = (series.columns[n][rows] for n in ("q", "qd", "qdd"))
    jerk = np.gradient(series.columns["qdd"], series.t_s, axis=0)[rows]
    extrapolated = {"q": q + ahead * qd + 0.5 * ahead**2 * qdd, "qd": qd + ahead * qdd, "qdd": qdd + ahead * jerk}
    if "reading" in series.columns:
        extrapolated["reading"] = series.columns["reading"][rows] + extrapolated["q"] - q
    return replace(series, columns={**series.columns, **extrapolated})


EFFECT = Effect(
    name="sensor.latency",
    kinds=("mechanism", "tracking"),
    formula="reading(t) = truth(t - latency_s)",
    source="transport delay",
    reveals="the whole motion comes late against commands; free motion looks right",
    parameters=(Parameter("latency_s", "s", 0.0, 0.3, 0.0),),
    confusables=(
        Confusable("actuator.delay", "read commands and motion with one clock, or log the true effort", True),
        Confusable("joint.backlash", "reverse at several speeds"),
        Confusable("actuator.lag", "step the command: a lag rounds the corner"),
    ),
    hook=SensorMap(_report, _recover),
    mechanism=MechanismCandidacy(observable=lambda r: r.driven),
)
