"""The table of a report's page that says what became of each candidate: from all decisions to the last word on each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from schemas.sim_gap.decisions import CandidateDecision, Criterion, Reason


@dataclass(frozen=True)
class DecisionRow:
    """The last word on one candidate, or one of several reasons to doubt an effect, as words for the page.

    outcome    `named`, `in doubt`, `left out` (later effects do its work), `competes` or `refused`.
    value      the value that decided beside its bound; empty where the reason needs none.
    """

    name: str
    where: str
    outcome: str
    reason: str
    value: str


def decision_rows(decisions: Sequence[CandidateDecision]) -> tuple[DecisionRow, ...]:
    """Rows by candidate, in the order in which these were first decided on; sure names and doubts before the rest."""
    by_candidate: dict[tuple[str, str], list[CandidateDecision]] = {}
    for decision in decisions:
        by_candidate.setdefault((decision.name, str(decision.where)), []).append(decision)
    rows = [_row(decision) for own_decisions in by_candidate.values() for decision in last_words(own_decisions)]
    order = ("named", "in doubt", "left out", "competes", "refused")
    return tuple(sorted(rows, key=lambda row: order.index(row.outcome)))


def last_words(decisions: Sequence[CandidateDecision]) -> tuple[CandidateDecision, ...]:
    """Of the decisions on one candidate those that settle it: of the verdict, else as a competitor, else the last."""
    judged = tuple(d for d in decisions if d.step == "judge")
    if judged:
        return judged
    competing = [d for d in decisions if d.reason is Reason.INSEPARABLE_FROM]
    refused = [d for d in decisions if not d.kept and (d.step != "compare" or d.reason is Reason.REPLACED_BY)]
    return tuple((competing or refused or list(decisions))[-1:])


def outcome_counts(rows: Sequence[DecisionRow]) -> str:
    """How many candidates came to which end, as words."""
    ends = {(row.name, row.where): row.outcome for row in rows}
    counts = Counter(ends.values())
    return f"{len(ends)} candidates: " + ", ".join(f"{n} {outcome}" for outcome, n in counts.items())


def _row(decision: CandidateDecision) -> DecisionRow:
    reason = f"{decision.reason} {decision.beside}".strip()
    value = _words(decision.criteria[-1]) if decision.criteria else ""
    return DecisionRow(decision.name, str(decision.where), _outcome(decision), reason, value)


def _outcome(decision: CandidateDecision) -> str:
    if decision.reason is Reason.NAMED:
        return "named"
    if decision.reason is Reason.NO_LONGER_NEEDED:
        return "left out"
    if decision.step == "judge":
        return "in doubt"
    return "competes" if decision.reason is Reason.INSEPARABLE_FROM else "refused"


def _words(criterion: Criterion) -> str:
    limit = {"<": "below", "<=": "at most", ">": "above", ">=": "at least"}[criterion.relation]
    return f"{criterion.quantity} {criterion.value:.3g}, needed {limit} {criterion.bound:.3g}"
