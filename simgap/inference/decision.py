"""Decisions on candidates: from values beside their bounds to one closed reason, kept for the report.

A test yields its criteria one after another, each with the reason that applies where it does not hold. The first that
fails decides. A decision has no truth value: readers name the field they mean.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from schemas.sim_gap.decisions import Criterion, Reason, Relation, Step
from simgap.problem import Candidate


@dataclass(frozen=True)
class Decision:
    """Whether a candidate passed a test, why, and the values behind it.

    criteria   all hold if `kept`; else the last one does not, and is what `reason` refers to.
    beside     `name@place` of the other candidate in the reason; empty where there is none.
    """

    kept: bool
    reason: Reason
    criteria: tuple[Criterion, ...] = ()
    beside: str = ""

    def __post_init__(self) -> None:
        if self.kept != all(c.holds for c in self.criteria):
            raise ValueError(f"criteria contradict the decision '{self.reason}'")

    def __bool__(self) -> bool:
        raise TypeError("a decision has no truth value: read `kept`")


_OPPOSITE: dict[Relation, Relation] = {"<": ">=", "<=": ">", ">": "<=", ">=": "<"}
Test = tuple[Reason, Criterion]
Decided = tuple[Candidate, Decision]


@dataclass(frozen=True)
class SearchDecision:
    """A decision on a candidate with its place in the search: number of the round, from 0, and step."""

    round_number: int
    step: Step
    candidate: Candidate
    decision: Decision


def decide(tests: Iterable[Test], passed: Reason = Reason.PASSED, beside: str = "") -> Decision:
    """Kept for the reason `passed` if every criterion holds; else refused by the first that does not.

    Later criteria are not computed then.
    """
    criteria: list[Criterion] = []
    for reason, criterion in tests:
        criteria.append(criterion)
        if not criterion.holds:
            return Decision(False, reason, tuple(criteria), beside)
    return Decision(True, passed, tuple(criteria), beside)


def criterion(quantity: str, value: float, relation: Relation, bound: float) -> Criterion:
    """A value beside its bound; NaN where there is no value, which holds nowhere."""
    return Criterion(quantity=quantity, value=float(value), relation=relation, bound=float(bound))


def either(*alternatives: Criterion) -> Criterion:
    """The first of several sufficient criteria that holds; the first of all where none does."""
    return next((c for c in alternatives if c.holds), alternatives[0])


def negation(of: Criterion) -> Criterion:
    """The criterion that holds where the given one does not."""
    return of.model_copy(update={"relation": _OPPOSITE[of.relation]})


def all_of(decisions: Iterable[Decision]) -> Decision:
    """Kept if every decision is; else refused by the first that is not, and later ones are not computed."""
    criteria: list[Criterion] = []
    for decision in decisions:
        criteria += decision.criteria
        if not decision.kept:
            return replace(decision, criteria=tuple(criteria))
    return Decision(True, Reason.PASSED, tuple(criteria))


def place_name(candidate: Candidate) -> str:
    """`name@place`."""
    return f"{candidate.effect.name}@{candidate.where}"
