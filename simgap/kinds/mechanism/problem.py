"""A `mechanism` measurement as a `simgap.problem.Problem`: candidates, residuals, direct estimates, noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.report import ConventionCheck, RolloutEngine
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import MechanismModel, rollout
from simgap.kinds.mechanism.apply_model import apply_terms
from simgap.kinds.mechanism.candidates import candidates_of, nuisances_of
from simgap.kinds.mechanism.choose_timing import with_best_timing
from simgap.kinds.mechanism.equation_error import estimate
from simgap.kinds.mechanism.input_timing import InputTiming, stamp_jitter_s
from simgap.kinds.mechanism.inputs import permuted_inputs
from simgap.kinds.mechanism.leftover_forces import leftovers_of
from simgap.kinds.mechanism.whole_trials import MechanismTrials
from simgap.kinds.mechanism.windowed_logs import WindowedLogs
from simgap.problem import Candidate, DirectEstimate, JointMotion, Leftover, Model, Problem, View
from simgap.recording.read import Measurement

_LARGEST_ROLLOUT_ERROR = 1e6

_TIMING: dict[InputTiming, str] = {
    "stamps": "inputs act when the stamps say, or these motions cannot tell",
    "even_inputs": "inputs act at that beat, readings were taken when the stamps say",
    "even": "inputs act and readings were taken at that beat",
}


class MechanismProblem(Problem):
    """Roll-outs of the joint model against readings; direct estimates from equation errors.

    Effects are searched on `whole_trials`; roll-outs from smoothed readings localise the error and state the gain.
    """

    def __init__(self, measurement: Measurement, *, logs: WindowedLogs | None = None) -> None:
        """`logs` of the measurement may be given; by default those of the stamps."""
        self.measurement = measurement
        self.logs = logs or WindowedLogs(measurement)
        self.horizon_s = self.logs.scale.radian_s

    @property
    def declared(self) -> MechanismModel:
        """The model as its owner believes it."""
        return self.logs.declared

    @property
    def timing(self) -> InputTiming:
        """When inputs act and rows are read."""
        return self.logs.timing

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """All trials, in file order."""
        return tuple(self.logs.by_trial)

    def channels(self) -> tuple[str, ...]:
        """One position channel per joint."""
        return tuple(f"q_{link.name}" for link in self.declared.tree)

    def channel_units(self) -> tuple[str, ...]:
        """See `simgap.problem.Problem`."""
        return tuple("m" if link.prismatic else "rad" for link in self.declared.tree)

    def declared_mechanism(self) -> MechanismModel:
        """See `simgap.problem.Problem`."""
        return self.declared

    def own_rollout(self) -> RolloutEngine:
        """See `simgap.problem.Problem`."""
        method = "joint dynamics in second-order steps (kick, drift, kick) between the rows"
        return RolloutEngine(name="Mana", method=method, step_s=self.logs.step_s)

    def joint_motion(self, trial: str) -> JointMotion:
        """See `simgap.problem.Problem`."""
        series, piece = self.logs.by_trial[trial].series, self.logs.cut(trial, "full_rollout")
        rows = piece.rows[0, piece.compared]
        return JointMotion(series.t_s[rows], series.columns["q"][rows])

    def candidates(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return candidates_of(self.declared, [g.series for g in self.logs.by_trial.values()], self.logs.step_s)

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return nuisances_of(self.declared, self.logs.row_s)

    def residuals(self, model: Model, trials: Sequence[str], view: View) -> list[FloatArray]:
        """See `simgap.problem.Problem`; rad or m, against smoothed readings."""
        applied = apply_terms(self.declared, model)
        pieces = [(applied.recovered(self.logs.by_trial[t].series), self.logs.cut(t, view)) for t in trials]
        windows = self.logs.windows_of(trials, view, pieces, applied)
        q, _ = rollout(applied.mechanism, windows, applied.laws, largest_step_s=self.logs.step_s)
        out, at = [], 0
        for trial, (series, piece) in zip(trials, pieces, strict=True):
            count, k = piece.rows.shape
            read = applied.without_memory(self.logs.by_trial[trial].series) if applied.has_memory else series
            seen = applied.followed(
                windows.t_s[at : at + count, :k], q[at : at + count, :k], read.columns["q"][piece.rows[:, 0]]
            )
            error = piece.of(seen - read.columns["q"][piece.rows])
            error = np.nan_to_num(error, nan=_LARGEST_ROLLOUT_ERROR)
            # In units of the sensor: a scale that shrinks the truth must not shrink the error.
            if applied.sensors:
                error = error * _magnification(self.logs.by_trial[trial].series, read)
            out.append(np.clip(error, -_LARGEST_ROLLOUT_ERROR, _LARGEST_ROLLOUT_ERROR).reshape(-1, q.shape[2]))
            at += count
        return out

    def features(self, trials: Sequence[str], view: View) -> list[FloatArray]:
        """Smoothed q and qd at the window's start, inputs there, and the time since, beside each residual row."""
        out = []
        for trial in trials:
            series, piece = self.logs.by_trial[trial].series, self.logs.cut(trial, view)
            first = piece.rows[:, 0]
            names = [n for n in ("q", "qd", "effort", "command") if n in series.columns]
            start = np.concatenate([series.columns[n][first] for n in names], axis=1)
            since = piece.of(series.t_s[piece.rows]) - series.t_s[first][:, None]
            k = len(piece.compared)
            out.append(np.concatenate([np.repeat(start, k, axis=0), since.reshape(-1, 1)], axis=1))
        return out

    def direct(self, candidate: Candidate, model: Model, trials: Sequence[str]) -> DirectEstimate | None:
        """See `simgap.problem.Problem`."""
        return estimate(*self.logs.balance_beside(model, trials), candidate)

    def leftovers(self, model: Model, trials: Sequence[str]) -> tuple[Leftover, ...]:
        """See `simgap.problem.Problem`."""
        return leftovers_of(self.declared, [self.logs.by_trial[t] for t in trials], model)

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """See `simgap.problem.Problem`."""
        return self.logs.noise_floor(trials, view)

    def with_permuted_inputs(self, by: int = 1) -> MechanismProblem | None:
        """See `simgap.problem.Problem`."""
        trials = permuted_inputs(self.measurement.trials, by)
        if trials is None:
            return None
        measurement = replace(self.measurement, trials=trials)
        logs = WindowedLogs(measurement, self.logs.scale, self.logs.smooth(), self.timing)  # Motions stay.
        return MechanismProblem(measurement, logs=logs)

    def with_input_timing(self) -> MechanismProblem:
        """See `simgap.problem.Problem`; inputs act at the stamps where no other timing is significantly better."""
        logs = with_best_timing(self.logs, self.nuisances())
        return MechanismProblem(self.measurement, logs=logs)

    def whole_trials(self, trials: Sequence[str]) -> MechanismTrials:
        """See `simgap.problem.Problem`."""
        return MechanismTrials.of(self.declared, self.logs.by_trial, trials, self.logs.step_s)

    def timing_check(self) -> ConventionCheck | None:
        """See `simgap.problem.Problem`."""
        blurred = [stamp_jitter_s(t) for t in self.measurement.trials]
        jitter_ms = 1e3 * float(np.sqrt(np.mean(np.square([b for b in blurred if b is not None] or [0.0]))))
        if self.timing == "stamps" and not self.logs.open_timings:
            return None
        return ConventionCheck(
            name="input_timing",
            status="ok" if self.timing == "stamps" else "fixed",
            evidence=f"stamps stray from an even beat by {jitter_ms:.2g} ms (rms); {_TIMING[self.timing]}",
        )


def _magnification(read: Series, truth: Series) -> FloatArray:
    """(j,) how much larger motion is in the readings than in truth."""
    return _extent(read) / _extent(truth)


def _extent(series: Series) -> FloatArray:
    return series.columns["q"].std(axis=0) + 1e-12
