"""Tosses simulated in MuJoCo: what the direct estimates read off them, and what the whole search says."""

from __future__ import annotations

import pytest

from simgap.problem import Term
from tests.gap_suite.free_body_cases import free_body_case
from tests.gap_suite.run import run_case


@pytest.mark.parametrize(
    ("number", "name", "parameter", "truth", "within"),
    [
        (0, "contact.friction", "mu", 0.12, 0.02),
        (3, "sensor.scale", "factor", 0.95, 0.005),
        (4, "world.gravity_magnitude", "gravity_mps2", 7.5, 0.02),
        (7, "world.gravity_tilt", "about_y_rad", -0.08, 0.005),
    ],
)
def test_what_another_engine_hides_is_read_off_its_motion(number, name, parameter, truth, within):
    problem = free_body_case(number).problem()
    candidate = next(c for c in problem.candidates() if c.effect.name == name)
    found = problem.direct(candidate, (), problem.trial_ids)
    assert found is not None
    assert abs(found.values[parameter]) == pytest.approx(abs(truth), abs=within)
    assert found.p_value < 1e-3


def test_beside_a_scale_that_contacts_fitted_badly_a_box_is_no_smaller():
    problem = free_body_case(28).problem()
    scale, size = (next(c for c in problem.candidates() if c.effect.name == n) for n in ("sensor.scale", "body.size"))
    beside = problem.direct(size, (Term(scale, {"factor": 0.965}),), problem.trial_ids)  # hidden: 0.95
    assert beside is not None
    assert beside.values["factor"] == pytest.approx(1.0, abs=0.003)


def test_another_engine_with_nothing_hidden_gives_no_name():
    record = run_case(free_body_case(2))
    assert record["family"] == "control"
    assert record["outcome"] in ("silent", "doubted")


def test_a_slippery_box_is_named_by_both_routes():
    record = run_case(free_body_case(0))
    assert record["outcome"] == "named"
    assert float(str(record["reduction"])) > 0.5
