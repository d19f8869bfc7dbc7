"""A few hidden-effect cases end to end; the whole suite is `python -m tests.gap_suite.run`."""

from __future__ import annotations

import pytest

from schemas.gap import EFFECT_NAMES
from simgap.mechanism.problem import MechanismProblem
from simgap.search import select
from simgap.splits import split_trials
from tests.gap_suite.mechanism_cases import EFFECTS, mechanism_case
from tests.gap_suite.run import run_case


def test_a_large_drag_is_named():
    result = run_case(7)
    assert "drag large" in result.case.name
    assert result.outcome == "named"
    assert result.cpu_s < 15.0


def test_inertia_and_weight_of_a_free_swing_cannot_be_told_apart():
    result = run_case(3)
    assert "swing inertia" in result.case.name
    assert result.outcome == "group"


@pytest.mark.parametrize("number", [5, 8])
def test_controls_stay_without_a_name(number):
    result = run_case(number)
    assert not result.case.truth
    assert result.outcome == "silent"


def test_the_same_measurement_gives_the_same_selection():
    case = mechanism_case(11)
    gains = []
    for _ in range(2):
        problem = MechanismProblem(case.measurement)
        selection = select(problem, split_trials(case.measurement.spec, problem.trial_ids), "short_horizon")
        gains.append([(t.candidate.key, t.comparison.gain) for t in selection.rounds[0].tried])
    assert gains[0] == gains[1]


def test_a_sensor_scale_cannot_shrink_the_error_away():
    """Half the scale halves every error in truth; as read nothing is gained."""
    case = mechanism_case(5)
    problem = MechanismProblem(case.measurement)
    scale = next(c for c in problem.candidates() if c.effect.name == "sensor.scale")
    estimate = problem.direct(scale, (), problem.trial_ids)
    assert estimate is None or estimate.p_value > 1e-3 or abs(estimate.values["factor"] - 1.0) < 0.05


def test_every_effect_of_the_suite_is_in_the_library():
    assert {n for e in EFFECTS for n in e.names} <= set(EFFECT_NAMES)
