"""Logs for roll-outs and direct estimates: smoothed motion beside inputs, at no more rows than roll-outs need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray, IntArray
from sim.dynamics.hooks import Series
from simgap.kinds.mechanism.smooth import Smooth, smooth
from simgap.kinds.mechanism.time_scale import TimeScale, time_scale
from simgap.recording.recording import Trial


@dataclass(frozen=True)
class Log:
    """One trial: inputs, side channels, the position as read, and smoothed q, qd, qdd as columns.

    smooth   of the full readings, for their noise; `block` rows span one local cubic; the first and last half of that
             are worth less.
    """

    series: Series
    smooth: Smooth
    block: int

    @property
    def margin(self) -> int:
        """Rows at either end whose derivatives are one-sided."""
        return self.block // 2 + 1


def log_of(trial: Trial, scale: TimeScale | None = None, known: Smooth | None = None) -> Log:
    """The trial smoothed, then thinned; inputs, which are held from row to row, are averaged over the rows left out.

    `scale` is that of the recording, by default of this trial alone; `known` is what smoothing gave before, of the
    same motion.
    """
    scale = scale or time_scale([trial])
    smoothed = known or smooth(trial.t_s, trial.q, scale.span_s)
    every = max(1, int(scale.largest_step_s / float(np.median(np.diff(trial.t_s))) + 1e-6))
    rows = np.arange(0, len(trial.t_s), every)
    columns = {"reading": trial.q[rows], "q": smoothed.q[rows], "qd": smoothed.qd[rows], "qdd": smoothed.qdd[rows]}
    for name in ("effort", "command"):
        if trial.has(name):
            columns[name] = _held(np.nan_to_num(getattr(trial, name)), rows)
    columns |= {f"aux:{n}": _held(np.asarray(v, dtype=float)[:, None], rows) for n, v in trial.aux.items()}
    return Log(Series(trial.t_s[rows], columns), smoothed, max(1, round(smoothed.rows / every)))


def _held(values: FloatArray, rows: IntArray) -> FloatArray:
    counts = np.diff(np.append(rows, len(values)))
    return np.add.reduceat(values, rows, axis=0) / counts[:, None]
