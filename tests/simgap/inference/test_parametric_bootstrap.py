"""Bias of the method on readings simulated without an effect."""

from __future__ import annotations

import numpy as np
import pytest

from simgap.inference.parametric_bootstrap import estimate_method_bias, prediction_half_widths
from simgap.kinds.free_body.problem import FreeBodyProblem
from simgap.problem import Model, Term
from tests.suites.gap.free_body_cases import free_body_case


@pytest.fixture(scope="module")
def toss() -> FreeBodyProblem:
    """Tossed boxes; only starts and stamps of their readings are used."""
    problem = free_body_case(4).problem()
    assert isinstance(problem, FreeBodyProblem)
    return problem


def weak_gravity(problem: FreeBodyProblem) -> Model:
    candidate = next(c for c in problem.candidates() if c.effect.name == "world.gravity_magnitude")
    return (Term(candidate, {"gravity_mps2": 7.5}),)


def test_a_model_explains_the_readings_that_it_gave_down_to_their_noise(toss):
    model = weak_gravity(toss)
    again = toss.bootstrap_sample(model, 0)
    floor = toss.noise_floor(toss.trial_ids, "short_horizon")[2]
    own, declared = (
        np.sqrt(np.mean((np.concatenate(again.residuals(m, again.trial_ids, "short_horizon"))[:, 2] / floor) ** 2))
        for m in (model, ())
    )
    assert own < 1.5
    assert declared > 3.0 * own


def test_the_same_seed_gives_the_same_readings_and_another_one_other_noise(toss):
    first, same, other = (toss.bootstrap_sample((), seed).measurement.trials[0].p for seed in (3, 3, 4))
    assert (first == same).all()
    assert 0.0 < np.abs(first - other).max() < 0.01


def test_what_is_found_without_an_effect_is_far_below_its_range(toss):
    model = weak_gravity(toss)
    low, high = model[0].candidate.bounds["gravity_mps2"]
    method_bias = estimate_method_bias(toss, toss.trial_ids[:6], (), model)
    for reach in (method_bias.fitted["gravity_mps2"], method_bias.direct["gravity_mps2"]):
        assert 0.0 <= reach < 0.1 * (high - low)


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
