"""Whole trials with free starts: the noise of a start and steps of finite length are no error, a cause stays one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from schemas.arrays import FloatArray
from schemas.measurement import MeasurementSpec
from sim.dynamics.hooks import JointTorque
from sim.dynamics.mechanism import Law, rollout
from sim.effects.library import effect
from simgap.inference.intervals import threshold_excess
from simgap.kinds.mechanism.apply_model import apply_terms
from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.kinds.mechanism.windows import cut, windows_of
from simgap.problem import Model, Term
from simgap.recording.read import Measurement
from simgap.recording.recording import Trial
from simgap.whole_trials.fit_model import fit_model
from simgap.whole_trials.ladder import starts_on
from simgap.whole_trials.policy import POLICY

ROW_S, ROWS, NOISE = 5e-3, 300, 4e-4
STOP = {"lower_rad": -0.5, "upper_rad": 100.0, "stiffness_Nm_per_rad": 15.0, "loss_s_per_rad": 0.1}
HARD_STOP = effect("joint.hard_stop").hook
assert isinstance(HARD_STOP, JointTorque)


def _swing(
    damping: float, noise: float, largest_step_s: float = 2e-4, stop: dict[str, float] | None = None
) -> MechanismProblem:
    """A pendulum let go from six heights, with `damping` or a `stop` that its owner does not know of."""
    spec = MeasurementSpec.model_validate(
        {
            "schema_version": 1,
            "name": "swing",
            "kind": "mechanism",
            "columns": {"t": "t", "q_axis": "q_axis"},
            "subject": {
                "joints": [
                    {
                        "name": "axis",
                        "type": "revolute",
                        "inertia_kgm2": 0.02,
                        "gravity_load": {"mass_kg": 0.8, "com_distance_m": 0.1},
                    }
                ]
            },
            "actuation": {"type": "none"},
        }
    )
    t_s = np.arange(ROWS, dtype=np.float64) * ROW_S
    absent: dict[str, Any] = {
        n: np.full((ROWS, k), np.nan) for n, k in (("p", 3), ("quat_wxyz", 4), ("v_W", 3), ("w_B", 3))
    }
    absent |= {"command_p": absent["p"], "command_quat_wxyz": absent["quat_wxyz"]}
    absent |= {n: np.full((ROWS, 1), np.nan) for n in ("qd", "effort", "command")}
    starts = np.linspace(0.4, 1.4, 6)[:, None]
    trials = tuple(
        Trial(id=f"t{k}", t_s=t_s, q=np.tile(q0, (ROWS, 1)), aux={}, **absent) for k, q0 in enumerate(starts)
    )
    still = MechanismProblem(Measurement(spec, trials, Path("."), "swing", ("axis",)))
    model = replace(still.declared, damping=np.array([damping]))
    windows = windows_of([(still.logs.by_trial[t.id].series, cut(ROWS, None)) for t in trials], apply_terms(model, ()))
    laws = [Law(HARD_STOP, stop, 0)] if stop else []
    q, _ = rollout(model, windows, laws, largest_step_s=largest_step_s)
    rng = np.random.default_rng(1)
    read = [replace(t, q=q[k] + rng.normal(0.0, noise, q[k].shape)) for k, t in enumerate(trials)]
    return MechanismProblem(Measurement(spec, tuple(read), Path("."), "swing", ("axis",)))


def _whole(problem: MechanismProblem, model: Model = (), step_s: float | None = None) -> FloatArray:
    """(t,) mean square errors of whole trials in noise levels, starts free; `step_s` by default the problem's."""
    trials = problem.whole_trials(problem.trial_ids)
    trials = replace(trials, step_s=step_s or trials.step_s)
    fit = starts_on(trials, model, POLICY)
    fit = starts_on(trials.with_noise_from(model, fit.starts), model, POLICY)
    return fit.deviance / fit.rows


def _short(problem: MechanismProblem) -> float:
    """Root mean square of the declared model's errors over short roll-outs from smoothed readings, in noise levels."""
    errors = np.concatenate(problem.residuals((), problem.trial_ids, "short_horizon"))
    return float(np.sqrt((errors**2).mean()) / problem.noise_floor(problem.trial_ids, "short_horizon")[0])


def test_the_true_model_leaves_the_noise_of_the_readings_only():
    """Over 1.5 s, from starts that no reading gives; the step of 5 ms is 25 times that of the truth."""
    assert _whole(_swing(0.0, NOISE)) == pytest.approx(np.ones(6), abs=0.25)


def test_an_effect_stays_and_is_seen_far_below_the_noise_of_a_start():
    quiet, hidden = (_swing(damping, NOISE) for damping in (0.0, 1e-4))
    assert _whole(hidden).mean() > 2.0 * _whole(quiet).mean()
    assert _short(hidden) == pytest.approx(_short(quiet), rel=0.05)


def test_a_blow_from_an_uncertain_start_is_put_right_by_beginning_elsewhere():
    """Before and after a stop nothing is linear in a start: fits climb from short pieces to whole trials."""
    problem = _swing(0.0, NOISE, stop=STOP)
    assert (_whole(problem) > 25.0).sum() >= 3
    seeing = _whole(problem, (_stop_of(problem),), step_s=5e-4)
    assert np.median(seeing) < 1.3
    assert (seeing < 2.0).all()


def test_steps_as_long_as_rows_cost_a_stop_a_twentieth_of_its_stiffness():
    problem = _swing(0.0, NOISE, stop=STOP)
    trials, model = replace(problem.whole_trials(problem.trial_ids), step_s=ROW_S), (_stop_of(problem),)
    fit = fit_model(trials, model, starts_on(trials, model, POLICY).starts, POLICY)
    assert (fit.deviance / fit.rows < 3.0).all()
    values = fit.model[0].values
    assert values["stiffness_Nm_per_rad"] == pytest.approx(STOP["stiffness_Nm_per_rad"], rel=0.05)
    assert values["lower_rad"] == pytest.approx(STOP["lower_rad"], abs=2e-3)


def _stop_of(problem: MechanismProblem) -> Term:
    candidate = next(c for c in problem.candidates() if c.effect.name == "joint.hard_stop")
    assert candidate.bounds["stiffness_Nm_per_rad"][1] > 2.0 * STOP["stiffness_Nm_per_rad"]
    return Term(candidate, STOP)


def test_where_a_stop_begins_is_known_to_half_the_depth_at_best():
    problem = _swing(0.0, NOISE, stop=STOP)
    candidate = next(c for c in problem.candidates() if c.effect.name == "joint.hard_stop")
    deepest = min(float(np.nanmin(t.q)) for t in problem.measurement.trials)
    half = threshold_excess(Term(candidate, {**STOP, "upper_rad": candidate.null["upper_rad"]}))
    assert set(half) == {"lower_rad"}
    assert half["lower_rad"] == pytest.approx(0.5 * (STOP["lower_rad"] - deepest), abs=5e-3)
