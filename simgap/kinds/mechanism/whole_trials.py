"""Whole trials of a mechanism as a `TrialSystem`: roll-outs from free starts against readings, in noise levels.

Predictions are compared as readings: sensors map what is simulated, never what was read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from schemas.arrays import BoolArray, FloatArray, IntArray
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import MechanismModel, Windows, rollout, windows_from_starts
from simgap.kinds.mechanism.apply_model import Applied, apply_terms
from simgap.kinds.mechanism.logs import Log
from simgap.kinds.mechanism.windows import Cut, windows_of
from simgap.problem import Model

_DIVERGED = 1e6  # noise levels
_MOST_CACHED = 64  # maps of inputs and readings whose windows are kept
_FEWEST_ROWS = 16  # of a piece of a trial
_WILD = 6.0  # noise levels by which a single row leaves its neighbours
_NEIGHBOURS = 2  # rows to either side that a wild row leaves


@dataclass(frozen=True)
class MechanismTrials:
    """Trials of one mechanism; starts are positions and rates (t, 2 j) off the smoothed readings, in their noise.

    logs       of the trials, beside their `trial_ids`.
    step_s     largest step of roll-outs.
    noise      (j,) of readings, rad or m.
    missing    (t, n, j) readings that are not compared, padded to the longest trial.
    count      pieces into which each trial is cut.
    """

    declared: MechanismModel
    trial_ids: tuple[str, ...]
    logs: tuple[Log, ...]
    step_s: float
    noise: FloatArray
    missing: BoolArray
    count: int = 1
    _windows: dict[tuple[object, ...], tuple[Windows, list[FloatArray]]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @staticmethod
    def of(
        declared: MechanismModel, logs: dict[str, Log], trials: Sequence[str], largest_step_s: float
    ) -> MechanismTrials:
        """Whole trials with the noise of smoothed readings."""
        chosen = tuple(logs[t] for t in trials)
        longest = max(len(log.series.t_s) for log in chosen)
        noise = np.sqrt(np.mean([log.smooth.q_noise**2 for log in chosen], axis=0))
        missing = np.ones((len(chosen), longest, len(declared.tree)), dtype=bool)
        for i, log in enumerate(chosen):
            missing[i, : len(log.series.t_s)] = np.isnan(log.series.columns["reading"])
        return MechanismTrials(declared, tuple(trials), chosen, largest_step_s, noise, missing)

    @property
    def channel_count(self) -> int:
        """See `TrialSystem`."""
        return len(self.declared.tree)

    @cached_property
    def start_steps(self) -> FloatArray:
        """See `TrialSystem`."""
        scale = self.noise / np.sqrt(np.mean([log.smooth.q_noise**2 for log in self.logs], axis=0))
        rows = [np.concatenate([self.noise, log.smooth.qd_noise * scale]) for log in self.logs]
        return np.repeat(rows, self.count, axis=0)

    @cached_property
    def _rows(self) -> list[IntArray]:
        """Rows of each piece, trial after trial; neighbours share a row."""
        out: list[IntArray] = []
        for log in self.logs:
            last = len(log.series.t_s) - 1
            ends = [round(i * last / self.count) for i in range(self.count + 1)]
            out += [np.arange(a, b + 1) for a, b in zip(ends, ends[1:], strict=False)]
        return out

    @cached_property
    def _readings(self) -> FloatArray:
        """(pieces, n, j) NaN where nothing is compared."""
        longest = max(len(rows) for rows in self._rows)
        out = np.full((len(self._rows), longest, self.channel_count), np.nan)
        for i, rows in enumerate(self._rows):
            trial = i // self.count
            readings = self.logs[trial].series.columns["reading"][rows]
            out[i, : len(rows)] = np.where(self.missing[trial, rows], np.nan, readings)
        return out

    def errors(self, model: Model, starts: FloatArray) -> FloatArray:
        """See `TrialSystem`; n runs over rows and joints."""
        applied = apply_terms(self.declared, model)
        windows, stamps = self._windows_of(applied)
        joints = self.channel_count
        offsets = starts * self.start_steps
        many = windows_from_starts(windows, windows.q0 + offsets[..., :joints], windows.qd0 + offsets[..., joints:])
        q, _ = rollout(applied.mechanism, many, applied.laws, largest_step_s=self.step_s)
        q = q.reshape(len(starts), *self._readings.shape)
        if applied.sensors:
            for i, stamp in enumerate(stamps):
                for m in range(len(starts)):
                    seen = applied.reported(Series(stamp, {"q": q[m, i, : len(stamp)]}))
                    q[m, i, : len(stamp)] = seen.columns["q"]
        unread = np.isnan(self._readings)
        errors = np.nan_to_num((q - np.where(unread, 0.0, self._readings)) / self.noise, nan=_DIVERGED)
        return np.where(unread, np.nan, errors).reshape(len(starts), len(self._rows), -1)

    def pieces(self, count: int) -> MechanismTrials | None:
        """See `TrialSystem`."""
        shortest = min(len(log.series.t_s) for log in self.logs) / count
        return replace(self, count=count) if shortest >= _FEWEST_ROWS else None

    def with_noise_from(self, model: Model, starts: FloatArray) -> MechanismTrials:
        """See `TrialSystem`: the noise from second differences, which what moves smoothly hardly changes."""
        errors = self.errors(model, starts[None])[0].reshape(self._readings.shape) * self.noise
        second = np.abs(np.diff(errors, 2, axis=1))
        noise = 1.4826 * np.nanmedian(second, axis=(0, 1)) / np.sqrt(6.0)
        noise = np.maximum(noise, 1e-3 * self.noise)
        missing = self.missing.copy()
        for i, rows in enumerate(self._rows):
            around = np.stack([errors[i, k : len(rows) - 2 * _NEIGHBOURS + k] for k in range(2 * _NEIGHBOURS + 1)])
            middle = slice(_NEIGHBOURS, len(rows) - _NEIGHBOURS)
            wild = np.abs(errors[i, middle] - np.nanmedian(around, axis=0)) > _WILD * noise
            missing[i // self.count, rows[middle]] |= wild
        return replace(self, noise=noise, missing=missing)

    def _windows_of(self, applied: Applied) -> tuple[Windows, list[FloatArray]]:
        """One window per piece, and its true stamps; kept for models that map readings and inputs in the same way."""
        if applied.maps not in self._windows:
            if len(self._windows) >= _MOST_CACHED:
                self._windows.clear()
            cuts, stamps = [], []
            for i, log in enumerate(self.logs):
                series = applied.recovered(log.series)
                for rows in self._rows[i * self.count : (i + 1) * self.count]:
                    cuts.append((series, Cut(rows[None], np.arange(len(rows)))))
                    stamps.append(series.t_s[rows])
            self._windows[applied.maps] = windows_of(cuts, applied), stamps
        return self._windows[applied.maps]
