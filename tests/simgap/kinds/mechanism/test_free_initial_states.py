"""Roll-outs with free starts: the noise of a start and steps of finite length are no error, a cause stays one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from schemas.measurement import MeasurementSpec
from sim.dynamics.hooks import JointTorque
from sim.dynamics.mechanism import Law, rollout
from sim.effects.library import effect
from simgap.inference.direct_comparison import is_better
from simgap.inference.intervals import threshold_excess
from simgap.kinds.mechanism.apply_model import apply_terms
from simgap.kinds.mechanism.free_initial_states import linearised_initial_states
from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.kinds.mechanism.windows import cut, windows_of
from simgap.problem import DirectEstimate, Problem, Term
from simgap.recording.read import Measurement
from simgap.recording.recording import Trial

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


def _rms(problem: MechanismProblem, view: str) -> float:
    """Of the declared model's errors, in noise levels."""
    errors = np.concatenate(problem.residuals((), problem.trial_ids, view))  # pyright: ignore[reportArgumentType]
    return float(np.sqrt((errors**2).mean()) / problem.noise_floor(problem.trial_ids, "long_horizon")[0])


def test_the_true_model_leaves_the_noise_of_the_readings_only():
    """Two of the sixteen means of a window go into its start; the step of 5 ms is 25 times that of the truth."""
    assert _rms(_swing(0.0, NOISE), "long_horizon") == pytest.approx(np.sqrt(14.0 / 16.0), rel=0.07)
    assert _rms(_swing(0.0, NOISE), "full_rollout") > 5.0


def test_an_effect_stays_and_is_seen_far_below_the_noise_of_a_start():
    quiet, hidden = (_rms(_swing(damping, NOISE), "long_horizon") for damping in (0.0, 1e-4))
    assert hidden > 1.5 * quiet
    near, far = (_rms(_swing(damping, NOISE), "short_horizon") for damping in (0.0, 1e-4))
    assert far == pytest.approx(near, rel=0.05)


def test_the_step_is_taken_out_where_it_was_looked_at():
    coarse = _swing(0.0, 1e-9)
    assert _rms(coarse, "long_horizon") * coarse.noise_floor(coarse.trial_ids, "long_horizon")[0] < 2e-6


def test_what_starts_do_is_taken_at_the_model_that_is_asked_for():
    problem = _swing(0.02, 1e-6)
    candidate = next(c for c in problem.candidates() if c.effect.name == "joint.viscous_friction")
    true = (Term(candidate, {"damping_Nms_per_rad": 0.02}),)
    far, near = (
        max(np.abs(r).max() for r in p.residuals(true, p.trial_ids, "long_horizon"))
        for p in (problem, problem.with_initial_states_at(true))
    )
    assert near < 0.08 * far  # the step of the truth is not without error either


def test_a_blow_from_an_uncertain_start_is_put_right_by_beginning_elsewhere():
    """Before and after a stop nothing is linear in a start: windows begin where the stop's own model says they do."""
    problem = _swing(0.0, NOISE, stop=STOP)
    candidate = next(c for c in problem.candidates() if c.effect.name == "joint.hard_stop")
    assert candidate.bounds["stiffness_Nm_per_rad"][1] > 2.0 * STOP["stiffness_Nm_per_rad"]
    true = (Term(candidate, STOP),)
    level = problem.noise_floor(problem.trial_ids, "long_horizon")

    def rms(seen: Problem) -> np.ndarray:
        residuals = seen.residuals(true, problem.trial_ids, "long_horizon")
        return np.array([np.sqrt(((r / level) ** 2).mean()) for r in residuals])

    blind, seeing = rms(problem.with_initial_states_at(())), rms(problem.with_initial_states_at(true))
    assert (blind > 5.0).sum() >= 3
    assert np.median(seeing) < 1.3
    assert (seeing < 2.0).all()


def test_where_a_stop_begins_is_known_to_half_the_depth_at_best():
    problem = _swing(0.0, NOISE, stop=STOP)
    candidate = next(c for c in problem.candidates() if c.effect.name == "joint.hard_stop")
    deepest = min(float(np.nanmin(t.q)) for t in problem.measurement.trials)
    half = threshold_excess(Term(candidate, {**STOP, "upper_rad": candidate.null["upper_rad"]}))
    assert set(half) == {"lower_rad"}
    assert half["lower_rad"] == pytest.approx(0.5 * (STOP["lower_rad"] - deepest), abs=5e-3)


def test_no_error_of_a_start_is_left_and_any_other_is():
    rng = np.random.default_rng(0)
    changes = rng.normal(0.0, 1.0, (3, 8, 2, 4))
    starts = linearised_initial_states(changes, np.full((3, 2), 1e-6), np.zeros((3, 8, 2)))
    wrong = changes @ np.array([0.3, -2.0, 1.0, 0.5])
    assert np.abs(starts.without(wrong)).max() < 1e-9
    other = rng.normal(0.0, 1.0, (3, 8, 2))
    left = starts.without(other)
    assert 0.3 < (left**2).mean() / (other**2).mean() < 1.0
    assert starts.without(left) == pytest.approx(left, abs=1e-9)


def test_means_of_readings_are_those_of_their_rows():
    piece = cut(100, 41, every=20, means=8)
    values = np.arange(100.0)[piece.rows]
    assert piece.of(values).shape == (len(piece.rows), 8)
    assert piece.of(values)[0] == pytest.approx(
        [values[0, a:b].mean() for a, b in ((1, 6), (6, 11))] + list(piece.of(values)[0, 2:])
    )
    assert piece.of(values).mean() == pytest.approx(values[:, 1:].mean())


def test_a_route_leads_by_what_it_leaves_or_does_not():
    """A truth value of its own kind would be neither: what the direct route preferred went unheard by that once."""
    estimate = DirectEstimate({}, {}, 0.0, 4, np.array([1.0, 2.0, 3.0, 2.5]))
    better = replace(estimate, held_out=np.array([0.5, 1.1, 1.4, 1.2]))
    led, trailed = is_better(better, estimate), is_better(estimate, better)
    assert led is not None
    assert trailed is not None
    assert (led.kept, trailed.kept) == (True, False)
    assert is_better(better, replace(estimate, held_out=None)) is None
