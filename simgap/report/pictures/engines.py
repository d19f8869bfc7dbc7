"""Picture of one joint of the declared model: measured, rolled out here, and in the user's engine at its step."""

from __future__ import annotations

import numpy as np

from render.figure import figure, png, style_axes
from simgap.engine_comparison.compare import TrialRollouts
from simgap.report.pictures.colours import DECLARED, ENGINE, MEASURED

_MOST_SHOWN = 3.0  # ranges of the readings up to which a roll-out that leaves them is drawn


def engines(trial: TrialRollouts, joint: int, channel: str, unit: str, engine: str, step_s: float) -> bytes:
    """PNG: positions above; below what the engine's roll-out differs by from ours, on a scale of its own."""
    canvas = figure(8.0, 5.0)
    top, bottom = canvas.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    t, measured = trial.t_s, trial.measured[:, joint]
    words = f"{engine}, steps of {1e3 * step_s:.3g} ms"
    top.plot(t, measured, color=MEASURED, linewidth=2.6, label="measured")
    top.plot(t, trial.ours[:, joint], color=DECLARED, linewidth=1.6, label="simulated here, as declared")
    top.plot(t, trial.engine[:, joint], color=ENGINE, linewidth=1.6, linestyle="--", label=f"{words}, as declared")
    top.set_ylim(*_shown(trial, joint))
    apart = trial.engine[:, joint] - trial.ours[:, joint]
    bottom.plot(t, apart, color=ENGINE, linewidth=1.4, linestyle="--", label=f"steps of {1e3 * step_s:.3g} ms")
    if trial.finer is not None:
        finer = trial.finer[:, joint] - trial.ours[:, joint]
        bottom.plot(t, finer, color=ENGINE, linewidth=1.4, alpha=0.5, label="a quarter of that")
    bottom.legend(frameon=False, fontsize=9, loc="best")
    style_axes(top, "", f"{channel} ({unit})", f"Whose error: held-out trial {trial.trial} of the declared model")
    style_axes(bottom, "time (s)", f"engine - ours ({unit})")
    top.legend(frameon=False, fontsize=9, loc="best")
    return png(canvas)


def _shown(trial: TrialRollouts, joint: int) -> tuple[float, float]:
    """Lowest and highest position: all readings, and roll-outs up to some of their ranges away."""
    measured = trial.measured[:, joint]
    span = max(float(np.ptp(measured)), 1e-9)
    low, high = float(measured.min()) - _MOST_SHOWN * span, float(measured.max()) + _MOST_SHOWN * span
    every = np.concatenate([measured, trial.ours[:, joint], trial.engine[:, joint]])
    inside = np.clip(every[np.isfinite(every)], low, high)
    room = 0.08 * float(np.ptp(inside)) + 1e-9
    return float(inside.min()) - room, float(inside.max()) + room
