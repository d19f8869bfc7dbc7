"""A `mechanism` measurement as a `simgap.problem.Problem`: candidates, residuals, direct estimates, noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from schemas.gap import ConventionCheck
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import MechanismModel, Windows, rollout
from sim.dynamics.tree import mass_matrix
from simgap.inference.fit import Errors, Fit
from simgap.inference.losses import paired_p, trial_losses
from simgap.kinds.mechanism.apply_model import Applied, apply_terms
from simgap.kinds.mechanism.bootstrap import bootstrap_sample
from simgap.kinds.mechanism.candidates import candidates_of, nuisances_of
from simgap.kinds.mechanism.declared_model import build_mechanism
from simgap.kinds.mechanism.equation_error import SPANS, balance, estimate, in_noise_levels, refitted
from simgap.kinds.mechanism.free_initial_states import FreeInitialStates, initial_states_of, mean_noise
from simgap.kinds.mechanism.input_timing import TIMINGS, InputTiming, possible_timings, stamp_jitter_s, with_timing
from simgap.kinds.mechanism.inputs import permuted_inputs
from simgap.kinds.mechanism.logs import log_of
from simgap.kinds.mechanism.smooth import Smooth
from simgap.kinds.mechanism.windows import Cut, cut, windows_of
from simgap.problem import Candidate, DirectEstimate, Model, View
from simgap.recording.read import Measurement

MECHANISM_HORIZON_S = 0.2  # jointed things move less per time than tossed ones: 80 ms would measure the encoder
_LONG = 5  # short horizons that a long one lasts
_MEANS = 16  # of a long horizon that are compared: 60 ms each
_LARGEST_ROLLOUT_ERROR = 1e6
_TIMING_ALPHA = 0.01  # chance below which another input timing than the stamps is accepted
_LARGEST_STEP_S = 5e-3
_STEP_SWING = 0.15  # of a radian of the fastest controlled swing per step; what that leaves is taken out (`starts`)
_BOOTSTRAP_STEP_RATIO = 0.25  # steps of repeats, of those of roll-outs
_MOST_WINDOWS = 240  # over all trials; each has at least `_LEAST_WINDOWS`
_LEAST_WINDOWS = 6

_TIMING: dict[InputTiming, str] = {
    "stamps": "inputs act when the stamps say, or these motions cannot tell",
    "even_inputs": "inputs act at that beat, readings were taken when the stamps say",
    "even": "inputs act and readings were taken at that beat",
}


class MechanismProblem:
    """Roll-outs of the joint model against readings; direct estimates from equation errors."""

    def __init__(
        self,
        measurement: Measurement,
        horizon_s: float = MECHANISM_HORIZON_S,
        known: Mapping[str, Smooth] | None = None,
        timing: InputTiming = "stamps",
    ) -> None:
        """`known` smoothed motions by trial id are taken as they are; `timing` is when inputs act and rows are read."""
        self.measurement = measurement
        self.declared: MechanismModel = build_mechanism(measurement.spec, measurement.root)
        self.horizon_s = horizon_s
        self.timing: InputTiming = timing
        self._logs = {t.id: log_of(with_timing(t, timing), (known or {}).get(t.id)) for t in measurement.trials}
        self._row_s = float(np.median(np.concatenate([np.diff(t.t_s) for t in measurement.trials])))
        step = float(np.median(np.concatenate([np.diff(g.series.t_s) for g in self._logs.values()])))
        self._rows = max(4, round(horizon_s / step) + 1)
        self._windows = max(_LEAST_WINDOWS, _MOST_WINDOWS // len(self._logs))
        self._step_s = _largest_step_s(self.declared)
        self._floors: dict[tuple[View, tuple[str, ...]], FloatArray] = {}
        self._kept: dict[tuple[View, tuple[str, ...]], tuple[tuple[object, ...], Windows]] = {}
        self._balances: dict[tuple[object, ...], tuple[Errors, Fit]] = {}
        self._by_timing_cache: dict[InputTiming, MechanismProblem] = {}
        left_open = [possible_timings(t) for t in measurement.trials] if timing == "stamps" else [()]
        self._open: list[InputTiming] = [b for b in TIMINGS[1:] if all(b in some for some in left_open)]
        self._settled = False
        self._around: Model = ()
        self._starts: Mapping[str, FreeInitialStates] = {}

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """All trials, in file order."""
        return tuple(self._logs)

    @property
    def search_view(self) -> View:
        """See `simgap.problem.LongHorizonProblem`."""
        return "long_horizon"

    def channels(self) -> tuple[str, ...]:
        """One position channel per joint."""
        return tuple(f"q_{link.name}" for link in self.declared.tree)

    def candidates(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return candidates_of(self.declared, [g.series for g in self._logs.values()])

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return nuisances_of(self.declared, self._row_s)

    def residuals(self, model: Model, trials: Sequence[str], view: View) -> list[FloatArray]:
        """See `simgap.problem.Problem`; rad or m, against smoothed readings."""
        applied = apply_terms(self.declared, model)
        pieces = [(applied.recovered(self._logs[t].series), self._cut(t, view)) for t in trials]
        windows = self._windows_of(trials, view, pieces, applied)
        if view == self.search_view:
            starts = [self._starts_of(trials)[t] for t in trials]
            by_q, by_qd = (np.concatenate([of(s) for s in starts]) for of in (lambda s: s.q0, lambda s: s.qd0))
            windows = replace(windows, q0=windows.q0 + by_q, qd0=windows.qd0 + by_qd)
        q, _ = rollout(applied.mechanism, windows, applied.laws, largest_step_s=self._step_s)
        out, at = [], 0
        for trial, (series, piece) in zip(trials, pieces, strict=True):
            count, k = piece.rows.shape
            error = piece.of(q[at : at + count, :k] - series.columns[piece.column][piece.rows])
            error = np.nan_to_num(error, nan=_LARGEST_ROLLOUT_ERROR)
            if view == self.search_view:
                error = self._starts_of(trials)[trial].without(
                    np.clip(error, -_LARGEST_ROLLOUT_ERROR, _LARGEST_ROLLOUT_ERROR)
                )
            # In units of the sensor: a scale that shrinks the truth must not shrink the error.
            if applied.sensors:
                error = error * _magnification(self._logs[trial].series, series)
            out.append(np.clip(error, -_LARGEST_ROLLOUT_ERROR, _LARGEST_ROLLOUT_ERROR).reshape(-1, q.shape[2]))
            at += count
        return out

    def features(self, trials: Sequence[str], view: View) -> list[FloatArray]:
        """Smoothed q and qd at the window's start, inputs there, and the time since, beside each residual row."""
        out = []
        for trial in trials:
            series, piece = self._logs[trial].series, self._cut(trial, view)
            first = piece.rows[:, 0]
            names = [n for n in ("q", "qd", "effort", "command") if n in series.columns]
            start = np.concatenate([series.columns[n][first] for n in names], axis=1)
            since = piece.of(series.t_s[piece.rows]) - series.t_s[first][:, None]
            k = len(piece.compared)
            out.append(np.concatenate([np.repeat(start, k, axis=0), since.reshape(-1, 1)], axis=1))
        return out

    def direct(self, candidate: Candidate, model: Model, trials: Sequence[str]) -> DirectEstimate | None:
        """See `simgap.problem.Problem`."""
        key = (tuple(trials), *((t.candidate.key, *t.values.items()) for t in model))
        if key not in self._balances:
            unexplained = balance(self.declared, [self._logs[t] for t in trials], SPANS)
            errors = in_noise_levels(unexplained, model)
            self._balances[key] = errors, refitted(errors, model)
        return estimate(*self._balances[key], candidate)

    def bootstrap_sample(self, model: Model, seed: int) -> MechanismProblem:
        """See `simgap.inference.parametric_bootstrap.Bootstrappable`."""
        trials = self.measurement.trials
        logs = [self._logs[t.id] for t in trials]
        again = bootstrap_sample(
            self.declared, trials, logs, model, self.timing, _BOOTSTRAP_STEP_RATIO * self._step_s, seed
        )
        return MechanismProblem(replace(self.measurement, trials=again), self.horizon_s).with_initial_states_at(model)

    def with_permuted_inputs(self, by: int = 1) -> MechanismProblem | None:
        """See `simgap.sanity.input_pairing.PermutableInputs`."""
        trials = permuted_inputs(self.measurement.trials, by)
        if trials is None:
            return None
        # Motions stay, and with them what their starts do.
        smoothed = {name: log.smooth for name, log in self._logs.items()}
        other = MechanismProblem(replace(self.measurement, trials=trials), self.horizon_s, smoothed, self.timing)
        other._starts = self._starts_of(self.trial_ids)
        return other

    def with_initial_states_at(self, model: Model) -> MechanismProblem:
        """See `simgap.problem.LongHorizonProblem`; with the input timing of the significantly smallest loss."""
        at_stamps = self._linearised_at(model)
        level = at_stamps.noise_floor(self.trial_ids, self.search_view)
        best, losses = at_stamps, at_stamps._losses(model, level)
        for timing in () if self._settled else self._open:
            other = self._by_timing(timing)._linearised_at(model)
            if at_stamps._cuts_alike(other):
                other._starts = at_stamps._starts  # to the order of a row's jitter the same
            theirs = other._losses(model, level)
            if paired_p(losses, theirs) < _TIMING_ALPHA and theirs.sum() < losses.sum():
                best, losses = other, theirs
        best._settled = True
        return best

    def timing_check(self) -> ConventionCheck | None:
        """See `simgap.problem.InputTimingProblem`."""
        blurred = [stamp_jitter_s(t) for t in self.measurement.trials]
        jitter_ms = 1e3 * float(np.sqrt(np.mean(np.square([b for b in blurred if b is not None] or [0.0]))))
        if self.timing == "stamps" and not self._open:
            return None
        return ConventionCheck(
            name="input_timing",
            status="ok" if self.timing == "stamps" else "fixed",
            evidence=f"stamps stray from an even beat by {jitter_ms:.2g} ms (rms); {_TIMING[self.timing]}",
        )

    def _by_timing(self, timing: InputTiming) -> MechanismProblem:
        """The same measurement with another input timing, built once."""
        if timing not in self._by_timing_cache:
            same = {name: log.smooth for name, log in self._logs.items()} if timing != "even" else None
            self._by_timing_cache[timing] = MechanismProblem(self.measurement, self.horizon_s, same, timing)
        return self._by_timing_cache[timing]

    def _linearised_at(self, model: Model) -> MechanismProblem:
        other = copy(self)
        other._around, other._starts = model, {}
        return other

    def _cuts_alike(self, other: MechanismProblem) -> bool:
        pairs = ((self._cut(t, self.search_view), other._cut(t, self.search_view)) for t in self.trial_ids)
        return all(a.rows.shape == b.rows.shape and np.array_equal(a.compared, b.compared) for a, b in pairs)

    def _losses(self, model: Model, level: FloatArray) -> FloatArray:
        """(t,) of all trials."""
        return trial_losses(self.residuals(model, self.trial_ids, self.search_view), level)

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """See `simgap.problem.Problem`: smoothed readings' noise, and the start's carried along by the model.

        In a straight line at most: a controller soon forgets a start, and without one it would grow with any horizon.
        Where starts are free, the noise of means of readings.
        """
        key = (view, tuple(trials))
        if key not in self._floors:
            smooth = [self._logs[t].smooth for t in trials]
            if view == self.search_view:
                noise = [mean_noise(self._logs[t].smooth, self._cut(t, view)) for t in trials]
                self._floors[key] = np.sqrt(np.mean(np.square(noise), axis=0))
                return self._floors[key]
            read = np.mean([(s.noise_gain * s.q_noise) ** 2 for s in smooth], axis=0)
            ahead = np.mean([(s.qd_noise * self.horizon_s) ** 2 / 3.0 for s in smooth], axis=0)
            self._floors[key] = np.sqrt(read + np.minimum(read + ahead, self._carried(trials, view)))
        return self._floors[key]

    def _carried(self, trials: Sequence[str], view: View) -> FloatArray:
        """(j,) mean square of what the declared model makes of the noise of its starts, where roll-outs are judged."""
        applied = apply_terms(self.declared, ())
        pieces = [(self._logs[t].series, self._cut(t, view)) for t in trials]
        windows = windows_of(pieces, applied)
        smooth = [(self._logs[t].smooth, len(piece.rows)) for t, (_, piece) in zip(trials, pieces, strict=True)]
        noise_q, noise_qd = (
            np.concatenate([np.tile(of(s), (count, 1)) for s, count in smooth])
            for of in (lambda s: s.noise_gain * s.q_noise, lambda s: s.qd_noise)
        )

        def judged(start: Windows) -> FloatArray:
            q, _ = rollout(applied.mechanism, start, applied.laws, largest_step_s=self._step_s)
            rows = np.split(q, np.cumsum([count for _, count in smooth])[:-1])
            return np.concatenate([p.of(r).reshape(-1, q.shape[2]) for r, (_, p) in zip(rows, pieces, strict=True)])

        plain = judged(windows)
        moved = (replace(windows, q0=windows.q0 + noise_q), replace(windows, qd0=windows.qd0 + noise_qd))
        return np.sum([np.nanmean((judged(start) - plain) ** 2, axis=0) for start in moved], axis=0)

    def _starts_of(self, trials: Sequence[str]) -> Mapping[str, FreeInitialStates]:
        """Free initial states of the long horizons of these trials, linearised at this problem's model."""
        new = [t for t in trials if t not in self._starts]
        if new:
            declared, model = (apply_terms(self.declared, m) for m in ((), self._around))
            logs = [self._logs[t] for t in new]
            cuts = [self._cut(t, self.search_view) for t in new]
            found = initial_states_of(
                declared, model, [g.series for g in logs], cuts, [g.smooth for g in logs], self._step_s
            )
            self._starts = {**self._starts, **dict(zip(new, found, strict=True))}
        return self._starts

    def _windows_of(
        self, trials: Sequence[str], view: View, pieces: Sequence[tuple[Series, Cut]], applied: Applied
    ) -> Windows:
        """Kept for models that map readings and inputs in the same way."""
        key = (view, tuple(trials))
        cached = self._kept.get(key)
        if cached is None or cached[0] != applied.maps:
            self._kept[key] = cached = applied.maps, windows_of(pieces, applied)
        return cached[1]

    def _cut(self, trial: str, view: View) -> Cut:
        log = self._logs[trial]
        length = len(log.series.t_s)
        if view == "full_rollout":
            return cut(length, None, log.margin)
        if view == "short_horizon":
            return cut(length, self._rows, log.margin, self._windows)
        long = _LONG * (self._rows - 1) + 1
        return cut(length, long, log.margin, self._windows, every=self._rows - 1, means=_MEANS)


def _largest_step_s(declared: MechanismModel) -> float:
    """Steps that follow the controller's own swing: a step's error must stay below what effects do."""
    if declared.drive.type != "position_pd":
        return _LARGEST_STEP_S
    joints = len(declared.tree)
    inertia = np.diag(mass_matrix(declared.tree, np.zeros((1, joints)))[0])
    stiffness = np.abs(declared.drive.kp * declared.drive.effort_per_unit)
    fastest = float(np.sqrt((stiffness / inertia).max()))
    return float(np.clip(_STEP_SWING / max(fastest, 1e-9), 1e-3, _LARGEST_STEP_S))


def _magnification(read: Series, truth: Series) -> FloatArray:
    """(j,) how much larger motion is in the readings than in truth."""
    return _extent(read) / _extent(truth)


def _extent(series: Series) -> FloatArray:
    return series.columns["q"].std(axis=0) + 1e-12
