"""Decisions carry a closed reason with the value that decided; a real run's reasons agree with its values."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace

import pytest

from schemas.gap import CandidateDecision, GapReport, Reason
from simgap.find_gap import find_effects
from simgap.inference.decision import Decision, all_of, criterion, decide, either, negation
from simgap.inference.verdict_text import NAMED
from simgap.recording.train_test_split import split_trials
from simgap.report.decision_table import decision_rows
from tests.suites.gap.mechanism_cases import mechanism_case

# What decides, by reason: the quantity of the last criterion, and on which side of its bound a refused value lies.
DECIDES = {
    Reason.NOT_PROMISING: ("smaller p-value", "<"),
    Reason.OUTRANKED: ("rank by (held-out gain|direct loss)", "<="),
    Reason.NOT_SINGLED_OUT: ("direct loss", "<"),
    Reason.NOT_SIGNIFICANT: ("(adjusted )?p-value|p of the direct losses", "<"),
    Reason.TOO_SMALL: ("share of the loss removed|gain of the direct losses", ">"),
    Reason.INTERVAL_INCLUDES_NONE: ("distance of .* from no effect", ">"),
    Reason.BOUND_REACHED: ("half width of .*", ">"),
    Reason.NOT_DETERMINED: ("half width of .*", ">"),
    Reason.MAKES_VANISH: ("distance of .* of .*@.* from no effect", ">="),
    Reason.TEST_TRIALS_WORSE: ("ratio of test losses, .*|test loss with it", "<"),
    Reason.METHOD_BIAS: ("distance of .* from no effect|held-out gain", ">"),
    Reason.ACCEPTED_AFTER: ("rank among significant candidates", "<="),
    Reason.FITS_WORSE_THAN: ("p of being no worse", ">=?"),
    Reason.EXPLAINS_LESS_THAN: ("held-out gain", ">=?"),
    Reason.MORE_PARAMETERS_THAN: ("share of its held-out gain|share of the pair's loss|parameters", "[<>]=?"),
    Reason.INCOMPLETE_WITHOUT: ("p of the other on top of it", ">="),
    Reason.REPLACED_BY: ("p of being no worse|parameters of candidates as good", "[<>]="),
    Reason.MIMICKED_BY: ("(direct p|p of the direct|gain of the direct) .*", "[<>]"),
    Reason.NO_DIRECT_ESTIMATE: ("direct estimates|direct losses to compare", ">"),
    Reason.DIRECT_NOT_SIGNIFICANT: ("direct p-value.*", "<"),
    Reason.DIRECT_DISAGREES: ("(product|distance) of both estimates of .*", "<=|>"),
    Reason.DIRECT_PREFERS: ("p of the direct losses", ">="),
    Reason.INPUTS_OF_OTHERS: ("failed checks of input pairing", "<="),
    Reason.SINGLE_TRIAL: ("gains without an interval", "<="),
    Reason.LESS_THAN_UNEXPLAINED: ("share of the loss that comes back without it", ">="),
    Reason.REMAINDER_OF: ("confusable effects in doubt at its place", "<="),
}
PASSES = {
    "screen": {Reason.PASSED},
    "confirm": {Reason.PASSED},
    "compare": {Reason.PASSED, Reason.INSEPARABLE_FROM},
    "judge": {Reason.NAMED},
}
NEEDS_ANOTHER = {r for r in Reason if re.search(r" (than|by|from|without|to|after|prefers|of)$", f" {r}")}


@pytest.fixture(scope="module", params=[5007, 5057, 5041], ids=["a group", "a name", "nothing"])
def report(request: pytest.FixtureRequest) -> GapReport:
    """What a real search reports, as its file holds it."""
    case = mechanism_case(request.param)
    problem = case.problem()
    trials = split_trials(case.spec, problem.trial_ids)
    result = find_effects(problem, trials, measurement=case.name, horizon_s=0.0, quick=True)
    keys = {(c.effect.name, str(c.where)) for c in problem.candidates()}
    assert {(d.name, str(d.where)) for d in result.report.decisions} == keys
    return GapReport.model_validate_json(result.report.model_dump_json())


def contradictions(report: GapReport) -> list[str]:
    """Each decision whose reason and values do not belong together, or that the rest of the report contradicts."""
    bad = [f"{d.name}: {d.reason}" for d in report.decisions if not _fits(d)]
    if Counter(d.reason for d in report.decisions) != report.reason_counts:
        bad.append("counts")
    judged = [d for d in report.decisions if d.step == "judge"]
    sure = [(e.name, e.where) for e in report.verdict.effects if e.confidence >= NAMED]
    if [(d.name, d.where) for d in judged if d.reason is Reason.NAMED] != sure:
        bad.append("named")
    grouped = {name for g in report.verdict.ambiguous_groups for name in g.effects}
    mimics = {d.beside.partition("@")[0] for d in judged if d.reason in (Reason.MIMICKED_BY, Reason.DIRECT_PREFERS)}
    if grouped != mimics | {d.name for d in judged if d.reason is not Reason.NAMED}:
        bad.append("groups")
    p_values = {(h.name, h.where): h.p_adjusted for h in report.hypotheses}
    first = [d for d in report.decisions if (d.step, d.round_number) == ("confirm", 0)]
    bad += [d.name for d in first if d.criteria and _p_adjusted(d) not in (None, p_values[d.name, d.where])]
    return bad


def _fits(decision: CandidateDecision) -> bool:
    passes = decision.reason in PASSES[decision.step]
    if decision.kept != all(c.holds for c in decision.criteria) or decision.kept != passes:
        return False
    if ("@" in decision.beside) != (decision.reason in NEEDS_ANOTHER):
        return False
    if decision.kept:
        return True
    quantity, relation = DECIDES[decision.reason]
    *before, last = decision.criteria
    refused = not last.holds and all(c.holds for c in before)
    return refused and bool(re.fullmatch(quantity, last.quantity)) and bool(re.fullmatch(relation, last.relation))


def _p_adjusted(decision: CandidateDecision) -> float | None:
    return next((c.value for c in decision.criteria if c.quantity == "adjusted p-value"), None)


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


def test_the_page_has_a_row_for_each_candidate(report: GapReport) -> None:
    rows = decision_rows(report.decisions)
    assert {(r.name, r.where) for r in rows} == {(d.name, str(d.where)) for d in report.decisions}
    assert [r.name for r in rows if r.outcome == "named"] == [
        e.name for e in report.verdict.effects if e.confidence >= NAMED
    ]
    assert all(r.value for r in rows if r.outcome == "refused")


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
