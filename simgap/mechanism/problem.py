"""A `mechanism` measurement as a problem for the statistics (`simgap.problem.Problem`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.model import FloatArray
from sim.effects.effect import Series
from sim.mechanism import MechanismModel, rollout
from simgap.measurement import Measurement
from simgap.mechanism.build import build_mechanism
from simgap.mechanism.equation_error import estimate
from simgap.mechanism.places import candidates_of, nuisances_of
from simgap.mechanism.smooth import Smooth, smooth
from simgap.mechanism.terms import Applied, apply_terms
from simgap.mechanism.windows import cut, windows_of
from simgap.problem import Candidate, DirectEstimate, Model, View
from simgap.trial import Trial

HORIZON_S = 0.2  # jointed things move less per time than tossed ones: 80 ms would measure the encoder
_LARGEST = 1e6


class MechanismProblem:
    """Roll-outs of the joint model against readings; direct estimates from equation errors."""

    def __init__(self, measurement: Measurement, horizon_s: float = HORIZON_S) -> None:
        self.measurement = measurement
        self.declared: MechanismModel = build_mechanism(measurement.spec)
        self.horizon_s = horizon_s
        self._series = {t.id: _series(t) for t in measurement.trials}
        self._smooth = {i: smooth(s.t_s, s.columns["q"]) for i, s in self._series.items()}
        step = float(np.median(np.concatenate([np.diff(s.t_s) for s in self._series.values()])))
        self._rows = max(4, round(horizon_s / step) + 1)

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """All trials, in file order."""
        return tuple(self._series)

    def channels(self) -> tuple[str, ...]:
        """One position channel per joint."""
        return tuple(f"q_{link.name}" for link in self.declared.tree)

    def candidates(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return candidates_of(self.declared, list(self._series.values()), list(self._smooth.values()))

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return nuisances_of(self.declared)

    def residuals(self, model: Model, trials: Sequence[str], view: View) -> list[FloatArray]:
        """See `simgap.problem.Problem`; rad or m."""
        applied = apply_terms(self.declared, model)
        pieces = []
        for trial in trials:
            series, smoothed = self._recovered(trial, applied)
            pieces.append((series, smoothed, cut(len(series.t_s), self._rows if view == "short_horizon" else None)))
        windows = windows_of(pieces, applied)
        q, _ = rollout(applied.mechanism, windows, applied.laws)
        out, at = [], 0
        for series, _, piece in pieces:
            count, k = piece.rows.shape
            out.append(
                _error(series, piece.rows, q[at : at + count, :k], applied)[:, piece.compared].reshape(-1, q.shape[2])
            )
            at += count
        return out

    def features(self, trials: Sequence[str], view: View) -> list[FloatArray]:
        """Smoothed q and qd at the window's start, inputs there, and the time since, beside each residual row."""
        out = []
        for trial in trials:
            series, smoothed = self._series[trial], self._smooth[trial]
            piece = cut(len(series.t_s), self._rows if view == "short_horizon" else None)
            first = piece.rows[:, 0]
            inputs = [series.columns[n] for n in ("effort", "command") if n in series.columns]
            start = np.concatenate([c[first] for c in (smoothed.q, smoothed.qd, *inputs)], axis=1)
            since = series.t_s[piece.rows[:, piece.compared]] - series.t_s[first][:, None]
            k = len(piece.compared)
            out.append(np.concatenate([np.repeat(start, k, axis=0), since.reshape(-1, 1)], axis=1))
        return out

    def direct(self, candidate: Candidate, model: Model, trials: Sequence[str]) -> DirectEstimate | None:
        """See `simgap.problem.Problem`."""

        def recovered(terms: Model) -> list[tuple[Series, Smooth]]:
            applied = apply_terms(self.declared, terms)
            return [self._recovered(t, applied) for t in trials]

        return estimate(self.declared, candidate, model, recovered)

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """See `simgap.problem.Problem`: reading noise, and the start's noise carried along in a straight line."""
        length = self.horizon_s
        squares = [s.q_noise**2 * 2.0 + (s.qd_noise * length) ** 2 / 3.0 for s in (self._smooth[t] for t in trials)]
        return np.sqrt(np.mean(squares, axis=0))

    def _recovered(self, trial: str, applied: Applied) -> tuple[Series, Smooth]:
        """What the readings of a trial say about the truth, and its smooth version."""
        if not applied.sensors:
            return self._series[trial], self._smooth[trial]
        series = applied.recovered(self._series[trial])
        return series, smooth(series.t_s, series.columns["q"])


def _error(series: Series, rows: FloatArray, q: FloatArray, applied: Applied) -> FloatArray:
    """Simulated minus measured (w, k, j), both as the sensor would report them."""
    measured = series.columns["q"][rows]
    if applied.sensors:
        seen = []
        for w in range(len(rows)):
            stamps = series.t_s[rows[w]]
            said = [applied.reported(Series(stamps, {"q": values})).columns["q"] for values in (q[w], measured[w])]
            seen.append(said[0] - said[1])
        return np.clip(np.stack(seen), -_LARGEST, _LARGEST)
    return np.clip(q - measured, -_LARGEST, _LARGEST)


def _series(trial: Trial) -> Series:
    columns = {"q": trial.q}
    for name in ("effort", "command"):
        if trial.has(name):
            columns[name] = np.nan_to_num(getattr(trial, name))
    columns |= {f"aux:{name}": np.asarray(values)[:, None] for name, values in trial.aux.items()}
    return Series(trial.t_s, columns)
