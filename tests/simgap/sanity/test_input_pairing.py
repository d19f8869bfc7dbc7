"""Inputs that belong to other motions are noticed, whatever else is wrong with the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from simgap.find_gap import find_effects
from simgap.kinds.mechanism.inputs import permuted_inputs
from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.recording.train_test_split import split_trials
from simgap.sanity.input_pairing import other_inputs_check, pairing_check
from tests.suites.gap.mechanism_cases import mechanism_case, single_case

DRIVEN, SHUFFLED, FREE = (560, 565), (358, 378), (572,)
HIDDEN = {565: ("actuator.deadband", "slide", "middle")}


def problem_of(number: int) -> MechanismProblem:
    hidden = HIDDEN.get(number)
    problem = (mechanism_case(number) if hidden is None else single_case(number, *hidden)).problem()
    assert isinstance(problem, MechanismProblem)
    return problem


@pytest.mark.parametrize(
    ("numbers", "status"), [(DRIVEN, "ok"), (SHUFFLED, "suspect")], ids=["driven", "with inputs of other trials"]
)
def test_a_model_does_better_with_its_own_inputs_if_they_are_its_own(numbers: tuple[int, ...], status: str) -> None:
    for number in numbers:
        problem = problem_of(number)
        trap = pairing_check(problem, (), problem.trial_ids)
        assert trap is not None
        assert trap.status == status


@pytest.mark.parametrize(
    ("numbers", "status"),
    [(DRIVEN, "ok"), ((*SHUFFLED, 1038), "suspect")],
    ids=["driven", "with inputs of other trials"],
)
def test_inputs_of_others_are_noticed_before_anything_is_searched(numbers: tuple[int, ...], status: str) -> None:
    for number in numbers:
        trap = other_inputs_check(problem_of(number))
        assert trap is not None
        assert trap.status == status


def test_nothing_is_searched_where_inputs_belong_to_others() -> None:
    case = mechanism_case(SHUFFLED[0])
    problem = case.problem()
    found = find_effects(
        problem, split_trials(case.spec, problem.trial_ids), measurement="made up", horizon_s=0.2, quick=True
    )
    assert found.report.verdict.status == "outside_model_class"
    assert not found.report.hypotheses
    assert "inputs do not belong" in found.report.verdict.statement


def test_nothing_is_said_where_nothing_drives() -> None:
    problem = problem_of(FREE[0])
    assert pairing_check(problem, (), problem.trial_ids) is None
    assert other_inputs_check(problem) is None


def test_trials_that_are_driven_alike_tell_nothing() -> None:
    trials = problem_of(DRIVEN[0]).measurement.trials
    name = "command" if trials[0].has("command") else "effort"
    wave = [replace(t, **{name: np.sin(6.0 * t.t_s)[:, None]}) for t in trials]
    assert permuted_inputs(wave) is None
    other = [replace(t, **{name: np.sin((6.0 + k) * t.t_s)[:, None]}) for k, t in enumerate(trials)]
    moved = permuted_inputs(other)
    assert moved is not None
    np.testing.assert_allclose(getattr(moved[0], name)[:, 0], np.sin(7.0 * trials[0].t_s), atol=0.1)
