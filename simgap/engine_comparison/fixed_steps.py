"""Windows of a recording as a simulation of fixed steps sees them, and its motion back at the stamps; SI.

Users step an engine at a constant rate, whatever the rate of a recording: an input counts from the first step that
begins after its stamp, and motion between two steps lies on the straight line.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.mechanism import Windows

_SAME_S = 1e-9  # stamps closer than this are one


def on_fixed_steps(windows: Windows, step_s: float) -> Windows:
    """One window (1, k) with a row per step from its start to its end or just beyond, inputs held from their rows."""
    t_s = windows.t_s[0]
    steps = max(1, int(np.ceil((t_s[-1] - t_s[0] - _SAME_S) / step_s)))
    grid_s = t_s[0] + step_s * np.arange(steps + 1)
    rows = np.searchsorted(t_s, grid_s + _SAME_S, side="right") - 1
    return replace(
        windows,
        t_s=grid_s[None],
        command=None if windows.command is None else windows.command[:, rows],
        effort=None if windows.effort is None else windows.effort[:, rows],
        aux={name: values[:, rows] for name, values in windows.aux.items()},
    )


def at_stamps(steps: Windows, q: FloatArray, t_s: FloatArray) -> FloatArray:
    """(k, j) joint positions at stamps t_s (k,), from those after each step, q (1, n, j)."""
    return np.stack([np.interp(t_s, steps.t_s[0], column) for column in q[0].T], axis=1)
