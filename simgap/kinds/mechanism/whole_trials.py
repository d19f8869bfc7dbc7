"""Whole trials of a mechanism as a `TrialSystem`: roll-outs from free starts against readings, in noise levels.

Predictions are compared as readings: sensors map what is simulated, never what was read.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import MechanismModel, Windows, rollout, windows_from_starts
from simgap.kinds.mechanism.apply_model import Applied, apply_terms
from simgap.kinds.mechanism.logs import Log
from simgap.kinds.mechanism.windows import Cut, windows_of
from simgap.problem import Model

_DIVERGED = 1e6  # noise levels
_MOST_CACHED = 64  # maps of inputs and readings whose windows are kept


class MechanismTrials:
    """Trials of one mechanism; starts are positions and rates (t, 2 j) off the smoothed readings, in their noise."""

    def __init__(self, declared: MechanismModel, logs: dict[str, Log], trials: Sequence[str], largest_step_s: float):
        """`logs` by trial id; roll-outs take steps of at most `largest_step_s`."""
        self._declared, self._step_s = declared, largest_step_s
        self._ids, self._logs = tuple(trials), [logs[t] for t in trials]
        self._lengths = [len(log.series.t_s) for log in self._logs]
        joints = len(declared.tree)
        self._readings = np.full((len(trials), max(self._lengths), joints), np.nan)
        for i, (log, n) in enumerate(zip(self._logs, self._lengths, strict=True)):
            self._readings[i, :n] = log.series.columns["reading"]
        self._noise = np.sqrt(np.mean([log.smooth.q_noise**2 for log in self._logs], axis=0))
        rates = np.array([log.smooth.qd_noise for log in self._logs])
        self._start_steps = np.concatenate([np.tile(self._noise, (len(trials), 1)), rates], axis=1)
        self._windows: dict[tuple[object, ...], tuple[Windows, list[FloatArray]]] = {}

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """See `TrialSystem`."""
        return self._ids

    @property
    def start_steps(self) -> FloatArray:
        """See `TrialSystem`."""
        return self._start_steps

    def errors(self, model: Model, starts: FloatArray) -> FloatArray:
        """See `TrialSystem`; n runs over rows and joints."""
        applied = apply_terms(self._declared, model)
        windows, stamps = self._windows_of(applied)
        joints = self._readings.shape[2]
        offsets = starts * self._start_steps
        many = windows_from_starts(windows, windows.q0 + offsets[..., :joints], windows.qd0 + offsets[..., joints:])
        q, _ = rollout(applied.mechanism, many, applied.laws, largest_step_s=self._step_s)
        q = q.reshape(len(starts), *self._readings.shape)
        if applied.sensors:
            for t, (n, stamp) in enumerate(zip(self._lengths, stamps, strict=True)):
                for m in range(len(starts)):
                    q[m, t, :n] = applied.reported(Series(stamp, {"q": q[m, t, :n]})).columns["q"]
        errors = np.nan_to_num((q - np.nan_to_num(self._readings)) / self._noise, nan=_DIVERGED)
        return np.where(np.isnan(self._readings), np.nan, errors).reshape(len(starts), len(self._ids), -1)

    def _windows_of(self, applied: Applied) -> tuple[Windows, list[FloatArray]]:
        """One window per trial, and its true stamps; kept for models that map readings and inputs in the same way."""
        if applied.maps not in self._windows:
            if len(self._windows) >= _MOST_CACHED:
                self._windows.clear()
            pieces = [
                (applied.recovered(log.series), Cut(np.arange(n)[None], np.arange(n)))
                for log, n in zip(self._logs, self._lengths, strict=True)
            ]
            self._windows[applied.maps] = windows_of(pieces, applied), [series.t_s for series, _ in pieces]
        return self._windows[applied.maps]
