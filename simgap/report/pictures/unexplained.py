"""Picture of the unexplained joint effort against the state that an effect depends on, with the fitted law."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from render.figure import figure, png, style_axes
from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.dynamics.mechanism import MechanismModel
from sim.effects.library import effect
from simgap.kinds.mechanism.equation_error import effort_balance
from simgap.kinds.mechanism.logs import Log, log_of
from simgap.kinds.mechanism.time_scale import time_scale
from simgap.problem import Model
from simgap.recording.read import Measurement
from simgap.report.pictures.binned import binned_medians, block_means
from simgap.report.pictures.colours import EXTENDED, MEASURED

_MOST_POINTS = 4000


def unexplained(
    declared: MechanismModel, measurement: Measurement, model: Model, name: str, where: Place, trials: Sequence[str]
) -> bytes | None:
    """PNG for the effect `name` of `model`; None where the blocks of the recording cannot be distinguished."""
    canvas = unexplained_figure(declared, measurement, model, name, where, trials)
    return None if canvas is None else png(canvas)


def unexplained_figure(
    declared: MechanismModel, measurement: Measurement, model: Model, name: str, where: Place, trials: Sequence[str]
) -> Figure | None:
    """The picture before it is drawn: efforts in N m (N of a sliding joint), states in SI."""
    scale = time_scale(measurement.trials)
    logs = [log_of(t, scale) for t in measurement.trials if t.id in set(trials)]
    effort = effort_balance(declared, logs)
    joint = next((j for j, link in enumerate(declared.tree) if link.name == where.joint), 0)
    without, with_law = (np.concatenate([e[:, joint] for e in effort(m)]) for m in ((), model))
    state, words = _feature(declared, logs, joint, name)
    if len(state) != len(without):
        return None
    link = declared.tree[joint]
    unit = "N" if link.prismatic else "N m"
    canvas = figure(8.0, 4.4)
    axes = canvas.subplots()
    thin = np.s_[:: max(1, len(state) // _MOST_POINTS)]
    axes.plot(state[thin], without[thin], ".", color=MEASURED, markersize=2.5, alpha=0.35, label="from the recording")
    x, y = binned_medians(state, without - with_law)
    axes.plot(x, y, color=EXTENDED, linewidth=2.2, label="the fitted effects")
    low, high = np.quantile(without, [0.005, 0.995])
    room = 0.25 * max(high - low, 1e-12)
    axes.set_ylim(low - room, high + room)
    axes.axhline(0.0, color=MEASURED, linewidth=0.8)
    style_axes(
        axes, words, f"unexplained effort ({unit})", f"What acts on {link.name} beyond the declared model: {name}"
    )
    axes.legend(frameon=False, fontsize=9)
    return canvas


def _feature(declared: MechanismModel, logs: Sequence[Log], joint: int, name: str) -> tuple[FloatArray, str]:
    """Block means of the state that the effect depends on, and its words."""
    slides = declared.tree[joint].prismatic
    given = next((c for c in ("effort", "command") if c in logs[0].series.columns), None)
    against = effect(name).plot_against
    if against == "position":
        pick, words = (lambda log: log.series.columns["q"][:, joint]), f"position ({'m' if slides else 'rad'})"
    elif against == "input" and given is not None:
        pick, words = (lambda log: log.series.columns[given][:, joint]), f"{given} as logged"
    else:
        pick, words = (lambda log: log.series.columns["qd"][:, joint]), f"speed ({'m/s' if slides else 'rad/s'})"
    return np.concatenate([block_means(log, pick(log)) for log in logs]), words
