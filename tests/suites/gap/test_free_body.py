"""Tosses simulated in MuJoCo: direct estimates and whole searches against the hidden values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.bullet.body import BulletBodyRollout
from simgap.kinds.free_body.problem import FreeBodyProblem
from simgap.kinds.free_body.rigid import RigidBodySimulator
from simgap.problem import Term
from tests.suites.gap.free_body_cases import free_body_case
from tests.suites.gap.run import run_case


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


@pytest.mark.parametrize("declared", [0.998, 1.002])
def test_a_box_that_is_declared_a_hair_off_is_no_smaller_beside_a_scale(declared: float):
    """Errors of readings shrink with every toss, that of a file does not: falls and rest still agree."""
    exact = free_body_case(28).problem()
    assert isinstance(exact, FreeBodyProblem)
    assert isinstance(exact.simulator, RigidBodySimulator)
    body = exact.simulator.declared
    shapes = tuple(replace(s, size_m=tuple(declared * v for v in s.size_m)) for s in body.shapes)
    problem = FreeBodyProblem(exact.measurement, RigidBodySimulator(replace(body, shapes=shapes), BulletBodyRollout()))
    scale, size = (next(c for c in problem.candidates() if c.effect.name == n) for n in ("sensor.scale", "body.size"))
    beside = problem.direct(size, (Term(scale, {"factor": 0.94}),), problem.trial_ids)  # hidden: 0.95
    assert beside is not None
    assert beside.p_value > 0.05


def test_a_scale_on_which_falls_and_rest_differ_is_left_as_it_was_fitted():
    """What shows at rest beside a scale is no scale: replaced by the mean of both, it would vanish."""
    problem = free_body_case(28).problem()
    assert isinstance(problem, FreeBodyProblem)
    scale, size = (next(c for c in problem.candidates() if c.effect.name == n) for n in ("sensor.scale", "body.size"))
    # Not replaced yet when the scale is estimated: then rest shows another scale.
    shrunk = Term(size, {"factor": 0.95})
    alone, both = ((Term(scale, {"factor": 0.95}),), (Term(scale, {"factor": 0.95}), shrunk))
    with_direct = [problem._with_direct_values(model, problem.trial_ids) for model in (alone, both)]
    assert with_direct[0][0].values["factor"] == pytest.approx(0.95, abs=0.002)
    assert with_direct[0][0].values["factor"] != 0.95
    assert with_direct[1][0].values["factor"] == 0.95


def test_a_trial_as_long_as_a_window_leaves_the_others_as_they_are():
    problem = free_body_case(2).problem()
    assert isinstance(problem, FreeBodyProblem)
    trials, rows = problem.measurement.trials, problem._rows
    short = trials[0].rows(np.arange(rows))
    mixed = FreeBodyProblem(replace(problem.measurement, trials=(short, *trials[1:3])), problem.simulator)
    alone = mixed.residuals((), problem.trial_ids[1:3], "short_horizon")
    beside = mixed.residuals((), problem.trial_ids[:3], "short_horizon")
    assert len(beside[0]) == rows - 1
    for one, other in zip(alone, beside[1:], strict=True):
        assert np.array_equal(one, other)


# The last two: `make test` runs such searches in tests/simgap/kinds/free_body/test_guard_cases.py.
@pytest.mark.long
def test_another_engine_with_nothing_hidden_gives_no_name():
    record = run_case(free_body_case(2))
    assert record["family"] == "control"
    assert record["outcome"] in ("silent", "doubted")


@pytest.mark.long
def test_a_slippery_box_is_named_by_both_routes():
    record = run_case(free_body_case(0))
    assert record["outcome"] == "named"
    assert float(str(record["reduction"])) > 0.5
