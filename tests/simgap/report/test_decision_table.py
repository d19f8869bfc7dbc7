"""The page's table: one last word on each candidate, or every reason to doubt an effect."""

from __future__ import annotations

from schemas.sim_gap.decisions import CandidateDecision, Criterion, Reason, Step
from schemas.sim_gap.extension import Place
from simgap.report.decision_table import DecisionRow, decision_rows, outcome_counts

AXIS = Place(joint="axis")


def _decision(
    name: str, step: Step, reason: Reason, *, passed: bool = False, beside: str = "", round_number: int = 0
) -> CandidateDecision:
    criterion = Criterion(quantity="p", value=0.01 if passed else 0.2, relation="<", bound=0.05)
    return CandidateDecision(
        round_number=round_number,
        step=step,
        name=name,
        where=AXIS,
        kept=passed,
        reason=reason,
        beside=beside,
        criteria=(criterion,),
    )


DECISIONS = (
    _decision("a", "screen", Reason.NOT_PROMISING),
    _decision("b", "confirm", Reason.PASSED, passed=True),
    _decision("c", "confirm", Reason.NOT_SIGNIFICANT),
    _decision("c", "compare", Reason.INSEPARABLE_FROM, passed=True, beside="b@axis"),
    _decision("d", "confirm", Reason.ACCEPTED_AFTER, beside="b@axis"),
    _decision("a", "confirm", Reason.TOO_SMALL, round_number=1),
    _decision("d", "confirm", Reason.PASSED, passed=True, round_number=1),
    _decision("c", "screen", Reason.OUTRANKED, round_number=1),
    _decision("b", "judge", Reason.MIMICKED_BY, beside="c@axis", round_number=1),
    _decision("b", "judge", Reason.DIRECT_DISAGREES, round_number=1),
    _decision("d", "judge", Reason.NAMED, passed=True, round_number=1),
)


def test_the_last_word_on_each_candidate_is_in_the_table() -> None:
    rows = decision_rows(DECISIONS)
    assert [(r.name, r.outcome, r.reason) for r in rows] == [
        ("d", "named", "named"),
        ("b", "in doubt", "mimicked by c@axis"),
        ("b", "in doubt", "direct estimate disagrees"),
        ("c", "competes", "inseparable from b@axis"),
        ("a", "refused", "too small"),
    ]
    assert rows[-1] == DecisionRow("a", "axis", "refused", "too small", "p 0.2, needed below 0.05")


def test_candidates_are_counted_once() -> None:
    assert outcome_counts(decision_rows(DECISIONS)) == "4 candidates: 1 named, 1 in doubt, 1 competes, 1 refused"


def test_an_effect_whose_work_later_ones_do_is_left_out() -> None:
    taken = _decision("a", "confirm", Reason.PASSED, passed=True)
    dropped = _decision("a", "judge", Reason.NO_LONGER_NEEDED, round_number=2)
    replaced = _decision("b", "compare", Reason.REPLACED_BY, beside="c@axis")
    assert [(r.name, r.outcome) for r in decision_rows([taken, dropped, replaced])] == [
        ("a", "left out"),
        ("b", "refused"),
    ]
    assert decision_rows([]) == ()
