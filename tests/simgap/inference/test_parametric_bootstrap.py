"""Bias of the method on readings simulated without an effect."""

from __future__ import annotations

import numpy as np
import pytest

from simgap.inference.parametric_bootstrap import estimate_method_bias, prediction_half_widths
from simgap.kinds.free_body.problem import FreeBodyProblem
from simgap.problem import Candidate, Term
from tests.suites.gap.free_body_cases import free_body_case


@pytest.fixture(scope="module")
def toss() -> FreeBodyProblem:
    """Tossed boxes with nothing hidden."""
    problem = free_body_case(2).problem()
    assert isinstance(problem, FreeBodyProblem)
    return problem


def candidate(problem: FreeBodyProblem, name: str) -> Candidate:
    return next(c for c in problem.candidates() if c.effect.name == name)


def test_a_model_explains_the_readings_that_it_gave_down_to_their_noise(toss):
    model = (Term(candidate(toss, "world.gravity_magnitude"), {"gravity_mps2": 7.0}),)
    again = toss.bootstrap_sample(model, 0)
    floor = toss.noise_floor(toss.trial_ids, "short_horizon")
    own, declared = (
        np.median(np.abs(np.concatenate(again.residuals(m, again.trial_ids, "short_horizon")) / floor))
        for m in (model, ())
    )
    assert own < 1.5
    assert declared > 3.0 * own


def test_the_same_seed_gives_the_same_readings_and_another_one_other_noise(toss):
    first, same, other = (toss.bootstrap_sample((), seed).measurement.trials[0].p for seed in (3, 3, 4))
    assert (first == same).all()
    assert 0.0 < np.abs(first - other).max() < 0.01


def test_what_is_found_without_an_effect_is_far_below_a_fifth_of_its_range(toss):
    drag = candidate(toss, "world.linear_drag")
    name, (_, high) = next(iter(drag.bounds.items()))
    method_bias = estimate_method_bias(toss, toss.trial_ids[:6], (), (Term(drag, {name: 0.2 * high}),))
    for reach in (method_bias.fitted[name], method_bias.direct[name]):
        assert 0.0 <= reach < 0.1 * high


@pytest.mark.parametrize(
    ("found", "least", "most"),
    [
        ((2.0, 2.0, 2.0), 2.0, 2.001),  # a bias that all repeats share is as large as it is
        ((1.0, -1.0, 0.5), 2.0, 4.0),  # scatter reaches beyond what three draws show
        ((0.0, 0.0, 0.0), 0.0, 0.0),
    ],
)
def test_repeats_reach_as_far_as_their_bias_and_scatter(found: tuple[float, ...], least: float, most: float) -> None:
    reach = prediction_half_widths({"x": 0.3}, [{"x": 0.3 + v} for v in found])["x"]
    assert least - 1e-12 <= reach <= most + 1e-12
    assert reach == pytest.approx(prediction_half_widths({"x": 0.0}, [{"x": -v} for v in found])["x"])


def test_another_draw_lies_within_the_reach_as_often_as_it_should() -> None:
    rng = np.random.default_rng(5)
    for bias in (0.0, 3.0):
        draws = bias + rng.normal(0.0, 1.0, (4000, 4))
        inside = [abs(d[3]) <= prediction_half_widths({"x": 0.0}, [{"x": v} for v in d[:3]])["x"] for d in draws]
        assert np.mean(inside) > 0.9
