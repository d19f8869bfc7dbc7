"""A `free_body` measurement as a `simgap.problem.Problem`: candidates, residuals, direct estimates, noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Series
from simgap.kinds.free_body.apply_model import AppliedBody
from simgap.kinds.free_body.bootstrap import bootstrap_sample, simulated_motion
from simgap.kinds.free_body.candidates import BOUNDS_ALPHA
from simgap.kinds.free_body.direct_estimates import agree_on_one_value, biases_of, estimate
from simgap.kinds.free_body.rates import body_rates, rows_of_slopes, slope_noise_per_s, velocities
from simgap.kinds.free_body.toss import Toss, fall_time_s
from simgap.kinds.free_body.tossed_body import BodySimulator, Columns
from simgap.problem import Candidate, DirectEstimate, Model, Problem, Term, View
from simgap.recording.read import Measurement
from simgap.recording.recording import Trial
from simgap.recording.train_test_split import split_trials

_HORIZON = 0.8  # of the time in which the body falls its own length: an impact and what follows
_BODY_ROWS_COMPARED = 4  # rows per short window that are compared
_IN_FLIGHT, _AT_REST, _IN_CONTACT = 3, 1, 6  # most windows per trial; without contact a few suffice
_STEP_CHECK_TRIALS, _FINER = 12, 4.0  # trials that show the error of a step; how much finer steps must be
_DIRECT_TOLERANCE_SHARE = 0.5  # of the fit, within which a direct estimate replaces it
_CLEAR_SHARE, _MOVED = 0.1, 0.01  # shares of the body's size: this far from the support all along, moved less than this


class FreeBodyProblem(Problem):
    """Engine roll-outs against poses; direct estimates from flight, impacts, sliding and rest."""

    def __init__(self, measurement: Measurement, simulator: BodySimulator, horizon_s: float | None = None) -> None:
        """`horizon_s` of short roll-outs follows from how fast the body falls, where it is left out."""
        self.measurement = measurement
        self.simulator = simulator
        step = float(np.median(np.concatenate([np.diff(t.t_s) for t in measurement.trials])))
        falls_s = [fall_time_s(simulator.size_m, simulator.gravity_W, t.t_s, t.p) for t in measurement.trials]
        fall_s = float(np.median(falls_s))
        self.horizon_s = _HORIZON * fall_s if horizon_s is None else horizon_s
        slope_rows = rows_of_slopes(fall_s, step)
        self._series = {t.id: _series(t, slope_rows) for t in measurement.trials}
        self._rows = max(4, round(self.horizon_s / step) + 1)
        self._slope_noise_per_s = slope_noise_per_s(slope_rows, step)
        self._read: tuple[object, list[Toss]] = (None, [])
        self._direct_models: dict[object, Model] = {}
        self._biases: dict[str, tuple[FloatArray, ...]] = {}
        self._numeric: dict[tuple[tuple[str, ...], View], FloatArray] = {}

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """All trials, in file order."""
        return tuple(self._series)

    @cached_property
    def _candidates(self) -> tuple[Candidate, ...]:
        taught = split_trials(self.measurement.spec, self.trial_ids).train
        return self.simulator.candidates([self._series[t] for t in taught], lambda c: self.direct(c, (), taught))

    def engine_time_s(self) -> float:
        """See `simgap.problem.Problem`."""
        return self.simulator.engine_time_s

    def channels(self) -> tuple[str, ...]:
        """Position and the rotation vector between simulated and measured, world axes; then joints."""
        return self.simulator.channels

    def channel_units(self) -> tuple[str, ...]:
        """See `simgap.problem.Problem`."""
        return self.simulator.channel_units

    def candidates(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return self._candidates

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return self.simulator.nuisances()

    def residuals(self, model: Model, trials: Sequence[str], view: View) -> list[FloatArray]:
        """See `simgap.problem.Problem`; m and rad."""
        return self._errors(model, trials, view, 1.0)

    def _errors(self, model: Model, trials: Sequence[str], view: View, finer: float) -> list[FloatArray]:
        applied = self.simulator.apply(model)
        series = [applied.recovered(self._series[trial]) for trial in trials]
        cuts = [self._cut(trial, view) for trial in trials]
        # Windows that are compared at the same rows are rolled out together, whatever trial they are of.
        kinds = [tuple(compared) for _, compared in cuts]
        out: list[FloatArray] = [np.zeros((0, len(self.simulator.channels)))] * len(series)
        for kind in dict.fromkeys(kinds):
            of = [n for n, k in enumerate(kinds) if k == kind]
            errors = self._rolled(applied, [series[n] for n in of], [cuts[n][0] for n in of], cuts[of[0]][1], finer)
            for n, found in zip(of, errors, strict=True):
                out[n] = found
        return out

    def _rolled(
        self,
        applied: AppliedBody,
        series: Sequence[Series],
        rows: Sequence[np.ndarray],
        compared: np.ndarray,
        finer: float,
    ) -> list[FloatArray]:
        """Errors (w * c, channels) per series from windows of equally many rows (w, k) each."""

        def picked(name: str, first_only: bool) -> FloatArray:
            parts = zip(series, rows, strict=True)
            return np.concatenate([s.columns[name][r[:, 0] if first_only else r] for s, r in parts])

        # Rows that are not compared need not be stopped at.
        rows, compared = [r[:, [0, *compared]] for r in rows], np.arange(1, len(compared) + 1)
        t_s = np.concatenate([s.t_s[r] for s, r in zip(series, rows, strict=True)])
        start = {name: picked(name, True) for name in self.simulator.state}
        motion = self.simulator.rollout(applied, t_s, start, finer)
        simulated = _reported(applied, t_s, {name: motion[name] for name in self.simulator.read})
        measured = _reported(applied, t_s, {name: picked(name, False) for name in self.simulator.read})
        errors = self.simulator.errors(*({n: v[:, compared] for n, v in c.items()} for c in (simulated, measured)))
        return np.split(errors, np.cumsum([len(r) * len(compared) for r in rows])[:-1])

    def features(self, trials: Sequence[str], view: View) -> list[FloatArray]:
        """Velocity, turning rate (world), height of the lowest point and joints at the start, and the time since."""
        out = []
        for trial in trials:
            series = self._series[trial]
            rows, compared = self._cut(trial, view)
            first = rows[:, 0]
            R = Rotation.from_quat(np.roll(series.columns["quat_wxyz"][first], -1, axis=1))
            gap = self.simulator.gaps(series)[first, None]
            joints = [series.columns[n][first] for n in ("q", "qd") if n in self.simulator.state]
            rates = [series.columns["v_W"][first], R.apply(series.columns["w_B"][first])]
            start = np.concatenate([*rates, gap, *joints], axis=1)
            since = series.t_s[rows[:, compared]] - series.t_s[first][:, None]
            out.append(np.concatenate([np.repeat(start, len(compared), axis=0), since.reshape(-1, 1)], axis=1))
        return out

    def direct(self, candidate: Candidate, model: Model, trials: Sequence[str]) -> DirectEstimate | None:
        """See `simgap.problem.Problem`."""
        return self._estimate_directly(candidate, self._with_direct_values(model, tuple(trials)), tuple(trials))

    def _estimate_directly(self, candidate: Candidate, model: Model, trials: tuple[str, ...]) -> DirectEstimate | None:
        """The direct estimate of a candidate, given the terms of `model`."""
        if candidate.key not in self._biases:
            self._biases[candidate.key] = biases_of(candidate, self._simulated, self.simulator.routes(candidate))
        read = self._tosses(model, trials)
        return estimate(candidate, read, self._biases[candidate.key], self.simulator.routes(candidate))

    def _with_direct_values(self, model: Model, trials: tuple[str, ...]) -> Model:
        """The model with the values that falls and rest determine precisely: fits to contacts stray from those.

        Beside a scale that is off by a hundredth, a body would look too small by as much. One after another, each
        beside all others, those before it as estimated: two of them must not undo the same error.
        """
        key = _cache_key(model, trials)
        if key not in self._direct_models:
            with_direct = model
            for k, term in enumerate(model):
                with_direct = (
                    *with_direct[:k],
                    self._with_direct_value(term, (*with_direct[:k], *with_direct[k + 1 :]), trials),
                    *with_direct[k + 1 :],
                )
            self._direct_models[key] = with_direct
        return self._direct_models[key]

    def _with_direct_value(self, term: Term, others: Model, trials: tuple[str, ...]) -> Term:
        candidate = term.candidate
        if candidate.nuisance or not candidate.effect.free_body.bounds_from_direct:
            return term
        direct = self._estimate_directly(candidate, others, trials)
        if direct is None or direct.p_value > BOUNDS_ALPHA or not agree_on_one_value(direct.separate_readings):
            return term
        far = (
            abs(direct.values[n] - v) > _DIRECT_TOLERANCE_SHARE * abs(v - candidate.null[n])
            for n, v in term.values.items()
        )
        return term if any(far) else replace(term, values=direct.values)

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """See `simgap.problem.Problem`: reading noise twice, the start's velocity noise carried along, and numerics.

        Numerics: what steps four times finer change. Nothing smaller than that is physics.
        """
        of_readings = self.simulator.reading_noise(self.measurement.noise, self._slope_noise_per_s, self.horizon_s)
        few = tuple(trials)[:_STEP_CHECK_TRIALS]
        if (few, view) not in self._numeric:
            usual, fine = (np.concatenate(self._errors((), few, view, finer)) for finer in (1.0, _FINER))
            self._numeric[few, view] = ((fine - usual) ** 2).mean(axis=0)
        return np.sqrt(of_readings + self._numeric[few, view])

    @cached_property
    def _simulated(self) -> list[list[Toss]]:
        """Full roll-outs of the declared model from the first rows of training trials, at two step sizes."""
        few = split_trials(self.measurement.spec, self.trial_ids).train[:_STEP_CHECK_TRIALS]
        declared = self.simulator.apply(())
        return [
            [
                self.simulator.toss(declared, simulated_motion(self.simulator, declared, self._series[t], finer))
                for t in few
            ]
            for finer in (1.0, _FINER)
        ]

    def bootstrap_sample(self, model: Model, seed: int) -> FreeBodyProblem:
        """See `simgap.problem.Problem`; in finer steps, so that their error shows."""
        here = self.measurement
        trials = bootstrap_sample(
            self.simulator,
            self.simulator.apply(model),
            here.trials,
            [self._series[t.id] for t in here.trials],
            here.noise,
            _FINER,
            seed,
        )
        return FreeBodyProblem(replace(here, trials=trials), self.simulator, self.horizon_s)

    def _tosses(self, model: Model, trials: tuple[str, ...]) -> list[Toss]:
        """Trials as they truly are under the model; those of the last call are kept."""
        key = _cache_key(model, trials)
        if self._read[0] != key:
            applied = self.simulator.apply(model)
            self._read = (key, [self.simulator.toss(applied, applied.recovered(self._series[t])) for t in trials])
        return self._read[1]

    def _cut(self, trial: str, view: View) -> tuple[np.ndarray, np.ndarray]:
        """Rows (w, k) of the windows of a trial, and the positions in a window that are compared."""
        length = len(self._series[trial].t_s)
        if view == "full_rollout" or self._rows >= length:
            return np.arange(length)[None], np.arange(1, length)
        k = self._rows
        compared = np.unique(np.linspace(1, k - 1, _BODY_ROWS_COMPARED).round().astype(int))
        return self._starts[trial][:, None] + np.arange(k), compared

    @cached_property
    def _starts(self) -> dict[str, np.ndarray]:
        """First rows of the short windows of each trial."""
        return {trial: self._windows(series) for trial, series in self._series.items()}

    def _windows(self, series: Series) -> np.ndarray:
        """First rows of windows side by side: a few in flight and at rest, most where something is met."""
        k, p = self._rows, series.columns["p"]
        starts = np.arange(0, len(p) - k + 1, k - 1)
        rows = starts[:, None] + np.arange(k)
        flying = np.ones(len(starts), dtype=bool)
        resting = np.ptp(p[rows], axis=1).max(axis=1) < _MOVED * self.simulator.size_m
        if self.simulator.has_support:
            flying = self.simulator.gaps(series)[rows].min(axis=1) > _CLEAR_SHARE * self.simulator.size_m
        kinds = ((flying, _IN_FLIGHT), (~flying & resting, _AT_REST), (~flying & ~resting, _IN_CONTACT))
        return np.sort(np.concatenate([_spread(starts[of], most) for of, most in kinds]))


def _cache_key(model: Model, trials: tuple[str, ...]) -> object:
    return tuple((t.candidate.key, tuple(t.values.items())) for t in model), trials


def _spread(items: np.ndarray, most: int) -> np.ndarray:
    """At most so many of the items, evenly."""
    return items[np.unique(np.linspace(0, len(items) - 1, min(most, len(items))).round().astype(int))]


def _reported(applied: AppliedBody, t_s: FloatArray, columns: Columns) -> Columns:
    """Columns (w, k, n) as the sensor reports them; what it does to poses it does row by row."""
    if not applied.sensors:
        return columns
    reported = applied.reported(Series(t_s.ravel(), {n: v.reshape(-1, v.shape[2]) for n, v in columns.items()})).columns
    return {n: reported[n].reshape(v.shape) for n, v in columns.items()}


def _series(trial: Trial, slope_rows: int) -> Series:
    """Pose and rates of a trial; rates that were not measured are slopes of the poses over so many rows."""
    quats = trial.quat_wxyz
    v = trial.v_W if trial.has("v_W") else velocities(trial.t_s, trial.p, slope_rows)
    w = trial.w_B if trial.has("w_B") else body_rates(trial.t_s, quats, slope_rows)
    columns = {"p": trial.p, "quat_wxyz": quats, "v_W": v, "w_B": w}
    if trial.has("q"):
        qd = trial.qd if trial.has("qd") else velocities(trial.t_s, trial.q, slope_rows)
        columns |= {"q": trial.q, "qd": qd}
    return Series(trial.t_s, columns)
