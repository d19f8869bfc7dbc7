"""Picture of what the best model leaves: unexplained joint effort against position, speed and time in the trial."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from render.figure import figure, png, style_axes
from schemas.arrays import FloatArray
from sim.dynamics.mechanism import MechanismModel
from simgap.kinds.mechanism.equation_error import effort_balance
from simgap.kinds.mechanism.logs import log_of
from simgap.kinds.mechanism.time_scale import time_scale
from simgap.problem import Model
from simgap.recording.read import Measurement
from simgap.report.pictures.binned import binned_medians, block_means
from simgap.report.pictures.colours import EXTENDED, MEASURED

_MOST_POINTS = 4000


def left_over(declared: MechanismModel, measurement: Measurement, model: Model, trials: Sequence[str]) -> bytes | None:
    """PNG of the joint of which most is left; None where the blocks of the recording cannot be distinguished."""
    canvas = left_over_figure(declared, measurement, model, trials)
    return None if canvas is None else png(canvas)


def left_over_figure(
    declared: MechanismModel, measurement: Measurement, model: Model, trials: Sequence[str]
) -> Figure | None:
    """The picture before it is drawn: efforts in N m (N of a sliding joint), states in SI."""
    scale = time_scale(measurement.trials)
    logs = [log_of(t, scale) for t in measurement.trials if t.id in set(trials)]
    left = np.concatenate(effort_balance(declared, logs)(model))
    joint = int(np.argmax(left.std(axis=0)))
    link, effort = declared.tree[joint], left[:, joint]
    states = {
        f"position ({'m' if link.prismatic else 'rad'})": [log.series.columns["q"][:, joint] for log in logs],
        f"speed ({'m/s' if link.prismatic else 'rad/s'})": [log.series.columns["qd"][:, joint] for log in logs],
        "time in the trial (s)": [log.series.t_s - log.series.t_s[0] for log in logs],
    }
    canvas = figure(9.6, 3.6)
    panels = canvas.subplots(1, len(states), sharey=True)
    low, high = np.quantile(effort, [0.005, 0.995])
    room = 0.25 * max(high - low, 1e-12)
    for axes, (words, columns) in zip(panels, states.items(), strict=True):
        state = np.concatenate([block_means(log, values) for log, values in zip(logs, columns, strict=True)])
        if len(state) != len(effort):
            return None
        thin = np.s_[:: max(1, len(state) // _MOST_POINTS)]
        axes.plot(state[thin], effort[thin], ".", color=MEASURED, markersize=2.0, alpha=0.3)
        x, y = binned_medians(state, effort)
        axes.plot(x, y, color=EXTENDED, linewidth=2.0)
        axes.axhline(0.0, color=MEASURED, linewidth=0.8)
        share = share_by_state(state, effort)
        first = axes is panels[0]
        unit = "N" if link.prismatic else "N m"
        style_axes(axes, words, f"left of {link.name} ({unit})" if first else "", f"explains {share:.0%} of its square")
    panels[0].set_ylim(low - room, high + room)
    return canvas


def share_by_state(state: FloatArray, effort: FloatArray) -> float:
    """Share of the mean square of `effort` that its medians in bins of `state` take off; at least none."""
    x, y = binned_medians(state, effort)
    if len(x) < 2:
        return 0.0
    rest = effort - np.interp(state, x, y)
    return max(0.0, 1.0 - float((rest**2).mean() / max((effort**2).mean(), 1e-300)))
