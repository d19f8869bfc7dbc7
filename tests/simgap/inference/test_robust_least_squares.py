"""Robust least squares against closed forms, and leave-one-out against real refits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from simgap.inference.fit import extend, fit, promising_starts
from simgap.inference.robust_least_squares import Prior, half_widths, leave_one_out_losses, mean_loss, minimise
from tests.suites.gap.mechanism_cases import mechanism_case

TRIALS, ROWS = 8, 30


def _linear(seed: int, noise: float = 0.3, truth: tuple[float, ...] = (0.4, 0.6)):
    """Residuals of a straight-line model, one block of rows per trial."""
    rng = np.random.default_rng(seed)
    A = [rng.normal(size=(ROWS, len(truth))) for _ in range(TRIALS)]
    y = [a @ truth + noise * rng.normal(size=ROWS) for a in A]
    return A, y


def test_small_residuals_give_the_least_squares_solution():
    A, y = _linear(0)
    solved = minimise(lambda x: [a @ x - b for a, b in zip(A, y, strict=True)], np.array([0.1, 0.9]))
    exact = np.linalg.lstsq(np.concatenate(A), np.concatenate(y), rcond=None)[0]
    assert solved.x == pytest.approx(exact, abs=2e-3)


def test_a_known_jacobian_costs_no_calls():
    A, y = _linear(1)

    def residuals(x):
        return [a @ x - b for a, b in zip(A, y, strict=True)]

    plain = minimise(residuals, np.array([0.1, 0.9]))
    helped = minimise(residuals, np.array([0.1, 0.9]), known=np.concatenate(A)[:, :1])
    assert helped.evaluations < plain.evaluations
    assert helped.x == pytest.approx(plain.x, abs=2e-3)


def test_the_box_holds_and_the_other_parameter_makes_up():
    A, y = _linear(2, truth=(1.7, 0.5))
    solved = minimise(lambda x: [a @ x - b for a, b in zip(A, y, strict=True)], np.array([0.5, 0.5]))
    assert solved.x[0] == pytest.approx(1.0)
    weighted = np.concatenate(A)
    rest = np.concatenate(y) - weighted[:, 0]
    assert solved.x[1] == pytest.approx(weighted[:, 1] @ rest / (weighted[:, 1] @ weighted[:, 1]), abs=0.05)


def test_left_out_losses_are_those_of_refits_without_the_trial():
    A, y = _linear(3)
    predicted = leave_one_out_losses(
        minimise(lambda x: [a @ x - b for a, b in zip(A, y, strict=True)], np.array([0.5, 0.5]))
    )
    for k in range(TRIALS):
        others = [i for i in range(TRIALS) if i != k]
        refit = minimise(lambda x, o=others: [A[i] @ x - y[i] for i in o], np.array([0.5, 0.5]))
        assert predicted[k] == pytest.approx(mean_loss(A[k] @ refit.x - y[k]), rel=5e-3)


def test_a_parameter_without_effect_never_helps_a_trial_that_was_left_out():
    """Free parameters buy nothing on average where there is nothing to learn."""
    better = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        A = [rng.normal(size=(ROWS, 1)) for _ in range(TRIALS)]
        y = [rng.normal(size=ROWS) for _ in range(TRIALS)]
        found = minimise(lambda x, A=A, y=y: [a @ (x - 0.5) - b for a, b in zip(A, y, strict=True)], np.array([0.5]))
        better.append(sum(mean_loss(b) for b in y) - leave_one_out_losses(found).sum())
    assert np.mean(better) < 0.0


def test_intervals_hold_the_truth_about_as_often_as_they_say():
    held = 0
    for seed in range(200):
        A, y = _linear(seed)
        found = minimise(lambda x, A=A, y=y: [a @ x - b for a, b in zip(A, y, strict=True)], np.array([0.4, 0.6]))
        held += abs(found.x[0] - 0.4) <= half_widths(found)[0]
    assert 0.91 <= held / 200 <= 0.995


def test_blind_parameters_stay_where_they_were():
    A, y = _linear(4)
    found = minimise(lambda x: [a @ x[:2] - b for a, b in zip(A, y, strict=True)], np.array([0.5, 0.5, 0.3]))
    assert found.x[2] == 0.3


def test_of_two_numbers_that_nothing_tells_apart_the_known_one_stays_and_the_other_is_no_surer():
    """Only their sum is seen: what is known of one to 0.1 is all that is known of the other."""
    rng = np.random.default_rng(5)
    A = [rng.normal(size=(ROWS, 1)) for _ in range(TRIALS)]
    y = [1.1 * a[:, 0] + 0.01 * rng.normal(size=ROWS) for a in A]
    prior = Prior(np.array([0.5, 0.0]), np.array([100.0, 0.0]))
    found = minimise(
        lambda x: [a[:, 0] * x.sum() - b for a, b in zip(A, y, strict=True)], np.array([0.9, 0.2]), prior=prior
    )
    assert found.x == pytest.approx([0.5, 0.6], abs=0.01)
    assert half_widths(found) == pytest.approx([0.196, 0.196], rel=0.05)


@pytest.mark.parametrize("trials", [8, 16])
def test_students_test_over_trials_keeps_its_level_although_rows_of_a_trial_err_together(trials):
    rng = np.random.default_rng(trials)
    false = 0
    for _ in range(200):
        A = [rng.normal(size=(ROWS, 3)) + rng.normal(size=(1, 3)) for _ in range(trials)]
        y = [a @ np.full(3, 0.5) + 0.2 * rng.normal(size=ROWS) + 0.2 * rng.normal() for a in A]
        found = minimise(lambda x, A=A, y=y: [a @ x - b for a, b in zip(A, y, strict=True)], np.full(3, 0.5))
        false += abs(found.x[0] - 0.5) > half_widths(found)[0]
    assert stats.binom.sf(false - 1, 200, 0.05) > 1e-3


def test_a_wave_is_found_at_any_pitch_and_phase():
    problem = mechanism_case(0).problem()
    detent = next(c for c in problem.candidates() if c.effect.name == "joint.detent")
    reach = detent.bounds["count_per_rad"][1] / 300.0  # one over the range that was reached
    q = np.linspace(0.0, 1.0 / reach, 400)
    strength = 0.4 * detent.bounds["torque_Nm"][1]

    def errors(model):
        waves = [t.values for t in model]
        wave = sum(v["torque_Nm"] * np.sin(v["count_per_rad"] * q - v["phase_rad"]) for v in waves)
        hidden = strength * np.sin(211.0 * reach * q - 2.5)
        return [5.0 * (wave - hidden) / strength]

    base = fit(errors, ())
    best = promising_starts(errors, base, detent)[2]
    assert best["count_per_rad"] == pytest.approx(211.0 * reach, rel=0.02)
    found = extend(errors, base, detent, [best], 20).model[-1].values
    assert found["torque_Nm"] == pytest.approx(strength, rel=1e-3)
    assert np.cos(found["phase_rad"] - 2.5) == pytest.approx(1.0, abs=1e-3)
