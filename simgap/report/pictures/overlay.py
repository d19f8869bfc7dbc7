"""Picture of one channel over time: measured and simulated, with the errors below."""

from __future__ import annotations

import numpy as np

from render.figure import figure, png, style_axes
from simgap.report.pictures.colours import DECLARED, EXTENDED, MEASURED
from simgap.report.side_by_side import SideBySide


def overlay(declared: SideBySide, extended: SideBySide | None, channel: int, unit: str) -> bytes:
    """PNG of one channel of one trial; `extended` is None where nothing was added to the model."""
    canvas = figure(8.0, 5.0)
    top, bottom = canvas.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    t, truth = declared.t_s, declared.measured[:, channel]
    top.plot(t, truth, color=MEASURED, linewidth=2.6, label="measured")
    runs = [(declared, DECLARED, "simulated as declared", "--")]
    if extended is not None:
        runs.append((extended, EXTENDED, "simulated with the extension", "-"))
    for run, colour, words, dash in runs:
        top.plot(t, run.simulated[:, channel], color=colour, linewidth=1.4, linestyle=dash, label=words)
        bottom.plot(t, run.errors[:, channel], color=colour, linewidth=1.2, linestyle=dash)
    span = max(float(np.ptp(truth)), 1e-9)
    top.set_ylim(float(truth.min()) - 0.6 * span, float(truth.max()) + 0.6 * span)
    bottom.set_ylim(-0.8 * span, 0.8 * span) if np.abs(declared.errors[:, channel]).max() > 0.8 * span else None
    name = declared.columns[channel]
    style_axes(top, "", f"{name} ({unit})", f"Held-out trial {declared.trial}, one roll-out from its first row")
    style_axes(bottom, "time (s)", f"error ({unit})")
    top.legend(frameon=False, fontsize=9, loc="best")
    return png(canvas)
