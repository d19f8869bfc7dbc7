"""A `mechanism` measurement as a `simgap.problem.Problem`: candidates, residuals, direct estimates, noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from schemas.gap import ConventionCheck, RolloutEngine
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import MechanismModel, rollout
from simgap.inference.losses import paired_p, trial_losses
from simgap.kinds.mechanism.apply_model import Applied, apply_terms
from simgap.kinds.mechanism.bootstrap import bootstrap_sample
from simgap.kinds.mechanism.candidates import candidates_of, nuisances_of
from simgap.kinds.mechanism.equation_error import estimate
from simgap.kinds.mechanism.input_timing import InputTiming, stamp_jitter_s
from simgap.kinds.mechanism.inputs import permuted_inputs
from simgap.kinds.mechanism.whole_trials import MechanismTrials
from simgap.kinds.mechanism.windowed_logs import LONG_VIEW, InitialStates, WindowedLogs
from simgap.kinds.mechanism.windows import Cut
from simgap.problem import Candidate, DirectEstimate, JointMotion, Model, Problem, View
from simgap.recording.read import Measurement

MECHANISM_HORIZON_S = 0.2  # jointed things move less per time than tossed ones: 80 ms would measure the encoder
_LARGEST_ROLLOUT_ERROR = 1e6
_TIMING_ALPHA = 0.01  # chance below which another input timing than the stamps is accepted
_BOOTSTRAP_STEP_RATIO = 0.25  # steps of repeats, of those of roll-outs

_TIMING: dict[InputTiming, str] = {
    "stamps": "inputs act when the stamps say, or these motions cannot tell",
    "even_inputs": "inputs act at that beat, readings were taken when the stamps say",
    "even": "inputs act and readings were taken at that beat",
}


class MechanismProblem(Problem):
    """Roll-outs of the joint model against readings; direct estimates from equation errors.

    Without contacts, effects are chosen on long horizons, with initial states left free.
    """

    def __init__(
        self,
        measurement: Measurement,
        horizon_s: float = MECHANISM_HORIZON_S,
        *,
        logs: WindowedLogs | None = None,
        initial_states: InitialStates | None = None,
        timing_is_settled: bool = False,
    ) -> None:
        """`logs` of the measurement and `initial_states` for them may be given; by default those of the stamps.

        timing_is_settled   whether other input timings were tried.
        """
        self.measurement = measurement
        self.horizon_s = horizon_s
        self.logs = logs or WindowedLogs(measurement, horizon_s)
        self._initial_states = initial_states or InitialStates(self.logs, ())
        self._timing_is_settled = timing_is_settled

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

    @property
    def search_view(self) -> View:
        """See `simgap.problem.Problem`."""
        return LONG_VIEW

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
        return candidates_of(self.declared, [g.series for g in self.logs.by_trial.values()])

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return nuisances_of(self.declared, self.logs.row_s)

    def residuals(self, model: Model, trials: Sequence[str], view: View) -> list[FloatArray]:
        """See `simgap.problem.Problem`; rad or m, against smoothed readings."""
        applied = apply_terms(self.declared, model)
        pieces = [(applied.recovered(self.logs.by_trial[t].series), self.logs.cut(t, view)) for t in trials]
        windows = self.logs.windows_of(trials, view, pieces, applied)
        if view == self.search_view:
            starts = [self._initial_states.of(trials)[t] for t in trials]
            by_q, by_qd = (np.concatenate([of(s) for s in starts]) for of in (lambda s: s.q0, lambda s: s.qd0))
            windows = replace(windows, q0=windows.q0 + by_q, qd0=windows.qd0 + by_qd)
        q, _ = rollout(applied.mechanism, windows, applied.laws, largest_step_s=self.logs.step_s)
        out, at = [], 0
        for trial, (series, piece) in zip(trials, pieces, strict=True):
            count, k = piece.rows.shape
            read = applied.without_memory(self.logs.by_trial[trial].series) if applied.has_memory else series
            seen = applied.followed(
                windows.t_s[at : at + count, :k], q[at : at + count, :k], read.columns["q"][piece.rows[:, 0]]
            )
            error = piece.of(seen - read.columns[piece.column][piece.rows])
            error = np.nan_to_num(error, nan=_LARGEST_ROLLOUT_ERROR)
            if view == self.search_view:
                states = self._initial_states.of(trials)[trial]
                if applied.has_memory:
                    states = states.with_sensor_state(self._fading(applied, trial, piece, windows.t_s[at : at + count]))
                error = states.without(np.clip(error, -_LARGEST_ROLLOUT_ERROR, _LARGEST_ROLLOUT_ERROR))
            # In units of the sensor: a scale that shrinks the truth must not shrink the error.
            if applied.sensors:
                error = error * _magnification(self.logs.by_trial[trial].series, read)
            out.append(np.clip(error, -_LARGEST_ROLLOUT_ERROR, _LARGEST_ROLLOUT_ERROR).reshape(-1, q.shape[2]))
            at += count
        return out

    def _fading(self, applied: Applied, trial: str, piece: Cut, t_s: FloatArray) -> FloatArray:
        """(w, c, j) what is left of the noise of sensors' first readings, windows with rows at t_s (w, k)."""
        smooth = self.logs.by_trial[trial].smooth
        still = np.zeros((*piece.rows.shape, len(smooth.q_noise)))
        noise = np.broadcast_to(smooth.noise_gain * smooth.q_noise, still[:, 0].shape)
        return piece.of(applied.followed(t_s[:, : piece.rows.shape[1]], still, noise))

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

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """See `simgap.problem.Problem`."""
        return self.logs.noise_floor(trials, view)

    def bootstrap_sample(self, model: Model, seed: int) -> MechanismProblem:
        """See `simgap.problem.Problem`."""
        trials = self.measurement.trials
        logs = [self.logs.by_trial[t.id] for t in trials]
        again = bootstrap_sample(
            self.declared, trials, logs, model, self.timing, _BOOTSTRAP_STEP_RATIO * self.logs.step_s, seed
        )
        return MechanismProblem(replace(self.measurement, trials=again), self.horizon_s).with_initial_states_at(model)

    def with_permuted_inputs(self, by: int = 1) -> MechanismProblem | None:
        """See `simgap.problem.Problem`."""
        trials = permuted_inputs(self.measurement.trials, by)
        if trials is None:
            return None
        # Motions stay, and with them what their starts do.
        measurement = replace(self.measurement, trials=trials)
        logs = WindowedLogs(measurement, self.horizon_s, self.logs.smooth(), self.timing)
        states = InitialStates(logs, (), self._initial_states.of(self.trial_ids))
        return MechanismProblem(measurement, self.horizon_s, logs=logs, initial_states=states)

    def with_initial_states_at(self, model: Model) -> MechanismProblem:
        """See `simgap.problem.Problem`; with the input timing of the significantly smallest loss."""
        states = InitialStates(self.logs, model)
        best = at_stamps = self._with(states)
        level = at_stamps.noise_floor(self.trial_ids, self.search_view)
        losses = at_stamps._losses(model, level)
        for timing in () if self._timing_is_settled else self.logs.open_timings:
            logs = self.logs.at_timing(timing)
            # To the order of a row's jitter the starts are the same.
            known = states.of(self.trial_ids) if self.logs.cuts_alike(logs) else None
            other = self._with(InitialStates(logs, model, known))
            theirs = other._losses(model, level)
            if paired_p(losses, theirs) < _TIMING_ALPHA and theirs.sum() < losses.sum():
                best, losses = other, theirs
        return best

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

    def _with(self, states: InitialStates) -> MechanismProblem:
        """The problem at given initial states and their logs, with its timing settled."""
        return MechanismProblem(
            self.measurement, self.horizon_s, logs=states.logs, initial_states=states, timing_is_settled=True
        )

    def _losses(self, model: Model, level: FloatArray) -> FloatArray:
        """(t,) of all trials."""
        return trial_losses(self.residuals(model, self.trial_ids, self.search_view), level)


def _magnification(read: Series, truth: Series) -> FloatArray:
    """(j,) how much larger motion is in the readings than in truth."""
    return _extent(read) / _extent(truth)


def _extent(series: Series) -> FloatArray:
    return series.columns["q"].std(axis=0) + 1e-12
