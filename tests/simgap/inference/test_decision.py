"""Decisions carry a closed reason with the value that decided; a real run's reasons agree with its values."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest

from schemas.sim_gap.decisions import Reason
from schemas.sim_gap.report import GapReport
from simgap.find_gap import find_effects
from simgap.inference.decision import Decision, all_of, criterion, decide, either, negation
from simgap.recording.train_test_split import split_trials
from tests.suites.gap.mechanism_cases import mechanism_case
from tests.support.gap.decisions import DECIDES, PASSES, contradictions


@pytest.fixture(scope="module", params=[5007, 5003], ids=["a group", "nothing"])
def report(request: pytest.FixtureRequest) -> GapReport:
    """What a real search reports, as its file holds it."""
    case = mechanism_case(request.param)
    problem = case.problem()
    trials = split_trials(case.spec, problem.trial_ids)
    result = find_effects(problem, trials, measurement=case.name, horizon_s=0.0, quick=True)
    keys = {(c.effect.name, str(c.where)) for c in problem.candidates()}
    assert {(d.name, str(d.where)) for d in result.report.decisions} == keys
    return GapReport.model_validate_json(result.report.model_dump_json())


def test_reasons_of_a_real_run_agree_with_their_values(report: GapReport) -> None:
    assert report.decisions
    assert contradictions(report) == []


def test_a_swapped_reason_is_a_contradiction(report: GapReport) -> None:
    """The check above sees it whenever one decision bears the reason of another."""
    for number, decision in enumerate(report.decisions):
        for reason in {d.reason for d in report.decisions} - {decision.reason}:
            swapped = decision.model_copy(update={"reason": reason})
            decisions = (*report.decisions[:number], swapped, *report.decisions[number + 1 :])
            counts = dict(Counter(d.reason for d in decisions))
            changed = report.model_copy(update={"decisions": decisions, "reason_counts": counts})
            assert contradictions(changed), (decision, reason)


def test_every_reason_has_a_value_that_decides() -> None:
    assert set(DECIDES).union(*PASSES.values()) == set(Reason)


def test_the_first_criterion_that_fails_decides_and_later_ones_are_not_computed() -> None:
    def tests():
        yield Reason.NOT_SIGNIFICANT, criterion("p", 0.01, "<", 0.05)
        yield Reason.TOO_SMALL, criterion("gain", 0.0, ">", 0.04)
        raise AssertionError("computed")

    decision = decide(tests())
    assert (decision.kept, decision.reason) == (False, Reason.TOO_SMALL)
    assert [c.quantity for c in decision.criteria] == ["p", "gain"]
    assert all_of([decision, Decision(True, Reason.PASSED)]) == decision


def test_a_decision_that_its_values_contradict_cannot_be_made() -> None:
    fails = criterion("p", 0.5, "<", 0.05)
    for kept, criteria in ((True, (fails,)), (False, (negation(fails),))):
        with pytest.raises(ValueError, match="contradict"):
            Decision(kept, Reason.NOT_SIGNIFICANT, criteria)
    with pytest.raises(ValueError, match="contradict"):
        replace(Decision(False, Reason.TOO_SMALL, (fails,)), kept=True)


def test_a_decision_is_no_boolean() -> None:
    with pytest.raises(TypeError, match="kept"):
        bool(Decision(True, Reason.PASSED))


@pytest.mark.parametrize("value", [0.0, 1.0, 2.0])
def test_a_negation_holds_where_the_criterion_does_not(value: float) -> None:
    for relation in ("<", "<=", ">", ">="):
        one = criterion("x", value, relation, 1.0)
        assert negation(one).holds != one.holds
    assert either(criterion("x", 1.0, "<", 0.0), criterion("y", 1.0, ">", 0.0)).quantity == "y"
    assert not criterion("x", float("nan"), ">", 0.0).holds
