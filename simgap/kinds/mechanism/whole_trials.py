"""Whole trials of a mechanism as a `TrialSystem`: roll-outs from free starts against readings, in noise levels.

Predictions are compared as readings: sensors map what is simulated, never what was read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from schemas.arrays import BoolArray, FloatArray, IntArray
from sim.dynamics.hooks import CommandMap, Series
from sim.dynamics.mechanism import MechanismModel, Windows, rollout, windows_from_starts
from simgap.kinds.mechanism.apply_model import Applied, apply_terms
from simgap.kinds.mechanism.imagined import imagined_recordings
from simgap.kinds.mechanism.logs import Log
from simgap.kinds.mechanism.windows import Cut, windows_of
from simgap.problem import ImaginedRecording, Model

_DIVERGED = 1e8  # noise levels
_MOST_CACHED = 64  # maps of inputs and readings whose windows are kept
_FINER_STEPS = 4.0  # than windows need: over whole trials at the plain step controls stay 8 % above the noise
_FINER = 4  # rows in the place of one where inputs act between rows
_FEWEST_ROWS = 16  # of a piece of a trial
_GAP = 1.5  # median intervals; a longer one lacks a row
_LEAST_NOISE = 0.3  # of the noise of smoothed readings
_PLAIN = 4.0  # typical second differences of errors; larger ones are no plain noise
_WILD = 6.0  # noise levels by which a single row leaves its neighbours
_ROWS_AROUND = 2  # rows to either side that a wild row leaves


@dataclass(frozen=True)
class MechanismTrials:
    """Trials of one mechanism; starts are positions and rates (t, 2 j) off the smoothed readings, in their noise.

    logs       of the trials, beside their `trial_ids`.
    step_s     largest step of roll-outs.
    noise      (j,) of readings, rad or m.
    missing    (t, n, j) readings that are not compared, padded to the longest trial.
    count      pieces into which each trial, or part without a gap, is cut; fewer where they would get too short.
    steps      as many in the place of each that windows need.
    """

    declared: MechanismModel
    trial_ids: tuple[str, ...]
    logs: tuple[Log, ...]
    step_s: float
    noise: FloatArray
    missing: BoolArray
    count: int = 1
    steps: float = 1.0
    _windows: dict[tuple[object, ...], tuple[Windows, FloatArray]] = field(
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

    @property
    def start_steps(self) -> FloatArray:
        """See `TrialSystem`."""
        return self._start_steps

    @cached_property
    def _start_steps(self) -> FloatArray:
        scale = self.noise / np.sqrt(np.mean([log.smooth.q_noise**2 for log in self.logs], axis=0))
        return np.array([np.concatenate([self.noise, self.logs[i].smooth.qd_noise * scale]) for i, _ in self._cuts])

    @cached_property
    def _cuts(self) -> list[tuple[int, IntArray]]:
        """Trial and rows of each piece, trial after trial; neighbours share a row."""
        out: list[tuple[int, IntArray]] = []
        for trial, log in enumerate(self.logs):
            for first, last in self._unbroken(log.series.t_s):
                count = self.count
                while count > 1 and (last - first) / count < _FEWEST_ROWS:
                    count //= 2
                ends = [first + round(i * (last - first) / count) for i in range(count + 1)]
                out += [(trial, np.arange(a, b + 1)) for a, b in pairwise(ends)]
        return out

    def _unbroken(self, t_s: FloatArray) -> list[tuple[int, int]]:
        """First and last rows of parts without a gap: what drove the joints at rows that were lost is unknown."""
        if self.declared.drive.type == "none":
            return [(0, len(t_s) - 1)]
        spans = np.diff(t_s)
        gaps: list[int] = np.flatnonzero(spans > _GAP * np.median(spans)).tolist()
        parts = pairwise([-1, *gaps, len(t_s) - 1])
        long_enough = [(a + 1, b) for a, b in parts if b - a >= _FEWEST_ROWS]
        return long_enough or [(0, len(t_s) - 1)]

    @property
    def piece_starts(self) -> tuple[tuple[int, int], ...]:
        """See `TrialSystem`."""
        return tuple((trial, int(rows[0])) for trial, rows in self._cuts)

    @cached_property
    def _readings(self) -> FloatArray:
        """(pieces, n, j) NaN where nothing is compared."""
        longest = max(len(rows) for _, rows in self._cuts)
        out = np.full((len(self._cuts), longest, self.channel_count), np.nan)
        for i, (trial, rows) in enumerate(self._cuts):
            readings = self.logs[trial].series.columns["reading"][rows]
            out[i, : len(rows)] = np.where(self.missing[trial, rows], np.nan, readings)
        return out

    def errors(self, model: Model, starts: FloatArray) -> FloatArray:
        """See `TrialSystem`; n runs over rows and joints."""
        applied = apply_terms(self.declared, model)
        finer = _FINER if _maps_inputs(model) else 1
        windows, t_s = self._windows_of(applied, finer)
        joints = self.channel_count
        offsets = starts * self.start_steps
        many = windows_from_starts(windows, windows.q0 + offsets[..., :joints], windows.qd0 + offsets[..., joints:])
        q, _ = rollout(applied.mechanism, many, applied.laws, largest_step_s=self.step_s / self.steps)
        q = q[:, ::finer]
        if applied.sensors:
            lengths = np.array([len(rows) for _, rows in self._cuts])
            q = applied.read_off(np.tile(t_s, (len(starts), 1)), q, np.tile(lengths, len(starts)))
        q = q.reshape(len(starts), *self._readings.shape)
        unread = np.isnan(self._readings)
        errors = np.nan_to_num((q - np.where(unread, 0.0, self._readings)) / self.noise, nan=_DIVERGED)
        return np.where(unread, np.nan, errors).reshape(len(starts), len(self._cuts), -1)

    def pieces(self, count: int) -> MechanismTrials | None:
        """See `TrialSystem`."""
        longest = max(len(log.series.t_s) for log in self.logs)
        return replace(self, count=count) if longest / count >= _FEWEST_ROWS else None

    def finer(self) -> MechanismTrials:
        """See `TrialSystem`."""
        return replace(self, steps=_FINER_STEPS)

    @property
    def plain(self) -> MechanismTrials:
        """See `TrialSystem`."""
        return self._plain if self.steps > 1.0 else self

    @cached_property
    def _plain(self) -> MechanismTrials:
        return replace(self, steps=1.0)

    def imagined(self, model: Model) -> tuple[ImaginedRecording, ...]:
        """See `TrialSystem`."""
        return imagined_recordings(self, model)

    def with_noise_from(self, model: Model, starts: FloatArray) -> MechanismTrials:
        """See `TrialSystem`: the noise from second differences, which what moves smoothly hardly changes."""
        errors = self.errors(model, starts[None])[0].reshape(self._readings.shape) * self.noise
        second = np.diff(errors, 2, axis=1)
        # Rounded readings of a joint that stands do not change: what smoothing leaves bounds the noise from below.
        least = _LEAST_NOISE * self.noise
        typical = np.maximum(1.4826 * np.nanmedian(np.abs(second), axis=(0, 1)), np.sqrt(6.0) * least)
        plain = np.where(np.abs(second) < _PLAIN * typical, second, np.nan)
        noise = np.maximum(np.sqrt(np.nanmean(plain**2, axis=(0, 1)) / 6.0), least)
        missing = self.missing.copy()
        for i, (trial, rows) in enumerate(self._cuts):
            if len(rows) <= 2 * _ROWS_AROUND:
                continue
            around = np.stack([errors[i, k : len(rows) - 2 * _ROWS_AROUND + k] for k in range(2 * _ROWS_AROUND + 1)])
            middle = slice(_ROWS_AROUND, len(rows) - _ROWS_AROUND)
            wild = np.abs(errors[i, middle] - np.nanmedian(around, axis=0)) > _WILD * noise
            missing[trial, rows[middle]] |= wild
        return replace(self, noise=noise, missing=missing)

    def _windows_of(self, applied: Applied, finer: int) -> tuple[Windows, FloatArray]:
        """One window per piece, and true stamps (w, k); kept for models that map inputs and readings alike."""
        key = (*applied.maps, finer)
        if key not in self._windows:
            if len(self._windows) >= _MOST_CACHED:
                self._windows.clear()
            recovered = [applied.recovered(log.series) for log in self.logs]
            held = [_between_rows(series, finer) for series in recovered]
            cuts = [
                (held[trial], Cut(np.arange(rows[0] * finer, rows[-1] * finer + 1)[None], np.arange(len(rows))))
                for trial, rows in self._cuts
            ]
            longest = self._readings.shape[1]
            stamps = [np.pad(recovered[i].t_s[rows], (0, longest - len(rows)), mode="edge") for i, rows in self._cuts]
            self._windows[key] = windows_of(cuts, applied), np.array(stamps)
        return self._windows[key]


def _maps_inputs(model: Model) -> bool:
    """Whether a term, other than a nuisance, changes when inputs act: that may be anywhere between two rows."""
    terms = (t for t in model if not t.candidate.nuisance)
    return any(isinstance(t.candidate.effect.hook_at(t.values), CommandMap) for t in terms)


def _between_rows(series: Series, finer: int) -> Series:
    """The series with so many rows in the place of each, what it holds held."""
    if finer == 1:
        return series
    places = np.arange((len(series.t_s) - 1) * finer + 1) / finer
    rows = np.floor(places).astype(int)
    t_s = np.interp(places, np.arange(len(series.t_s)), series.t_s)
    return Series(t_s, {name: values[rows] for name, values in series.columns.items()})
