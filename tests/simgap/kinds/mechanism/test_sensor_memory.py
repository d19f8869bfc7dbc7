"""A low-pass before a linear joint or behind its reading: roll-outs of both explain the log equally well."""

from __future__ import annotations

import numpy as np
import pytest

from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.problem import Candidate, Term
from simgap.whole_trials.ladder import starts_on
from simgap.whole_trials.policy import POLICY
from tests.suites.gap.mechanism_cases import Stage

LAG_S = 0.03
PARAMETER = {"sensor.lag": "time_constant_s", "actuator.lag": "lag_s"}


def candidate(problem: MechanismProblem, name: str) -> Candidate:
    return next(c for c in problem.candidates() if c.effect.name == name)


def error(problem: MechanismProblem, model: tuple[Term, ...]) -> float:
    """Root mean square error of whole trials, starts free, in noise levels."""
    fit = starts_on(problem.whole_trials(problem.trial_ids), model, POLICY)
    return float(np.sqrt(fit.deviance.sum() / fit.rows.sum()))


@pytest.mark.parametrize("hidden", ["sensor_lag_s", "lag_s"])
def test_a_slide_does_not_show_on_which_side_of_it_a_low_pass_lies(hidden: str):
    problem = Stage(7003, "slide", 1.0).problem({hidden: LAG_S})
    left = {n: error(problem, (Term(candidate(problem, n), {p: LAG_S}),)) for n, p in PARAMETER.items()}
    quiet = error(Stage(7003, "slide", 1.0).problem({}), ())
    assert error(problem, ()) > 5.0 * quiet
    assert all(one < 1.1 * quiet for one in left.values())
    assert left["sensor.lag"] == pytest.approx(left["actuator.lag"], rel=0.1)


def test_a_lag_explains_nothing_where_none_is():
    problem = Stage(7003, "slide", 1.0).problem({})
    lag = candidate(problem, "sensor.lag")
    plain = error(problem, ())
    for time_constant_s in (1e-4, 3e-3, 0.03, 0.2):
        assert error(problem, (Term(lag, {"time_constant_s": time_constant_s}),)) > 0.97 * plain
