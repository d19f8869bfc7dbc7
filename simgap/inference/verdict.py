"""The verdict from a selection: an effect is named only when its held-out gain and its direct estimate agree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from schemas.sim_gap.decisions import Reason
from schemas.sim_gap.report import AmbiguousGroup, Gain, NamedEffect, Verdict
from simgap.inference.agreement import direct_agreement, exceeds_method_bias
from simgap.inference.candidate_fit import ALPHA, CandidateFit
from simgap.inference.competing_hypotheses import are_confusable
from simgap.inference.decision import (
    Decided,
    Decision,
    all_of,
    criterion,
    decide,
    negation,
    place_name,
)
from simgap.inference.direct_comparison import distinguishes, is_better
from simgap.inference.forward_selection import Selection
from simgap.inference.hypothesis import Accepted
from simgap.inference.intervals import (
    Sides,
    differs_from_none,
    distance_to_alternatives,
    parameters,
    symmetric,
    wider,
)
from simgap.inference.losses import Comparison
from simgap.inference.verdict_text import NAMED, experiment, statement, status
from simgap.problem import Candidate, DirectEstimate, Model, Problem, Term

_DIRECT_RIVALS = 3  # further candidates that are compared by direct estimates
LEFTOVER = 0.1  # what a model without names may still explain before we say that something else is there


@dataclass(frozen=True)
class JudgedSelection:
    """A verdict with the decisions behind it: per accepted effect that it is named, or each reason for doubt."""

    verdict: Verdict
    decisions: tuple[Decided, ...]


def judge(
    problem: Problem,
    selection: Selection,
    trials: Sequence[str],
    gains: Sequence[Gain],
    leftover: Comparison,
) -> JudgedSelection:
    """The verdict over all accepted effects, with its `gains`, that of short horizons first.

    `leftover` is what a black box gains on top of them. Where a single trial judges, nothing is sure: a gain without an
    interval may be chance.
    """
    unexplained = leftover.p_value < ALPHA and leftover.gain > LEFTOVER
    single = math.isinf(gains[0].ci95[0])
    nameless = leftover.gain if unexplained else 0.0
    mimics = [_mimics(problem, selection, accepted, trials) for accepted in selection.accepted]
    named: list[NamedEffect] = []
    groups: list[AmbiguousGroup] = []
    in_doubt: list[Candidate] = []
    decisions: list[Decided] = []
    for number, accepted in enumerate(selection.accepted):
        candidate = accepted.candidate_fit.candidate
        remains = _remains(selection, accepted)
        if not remains.kept:
            decisions.append((candidate, remains))
            continue
        evidence = _final_evidence(problem, selection, number, mimics, trials)
        drowned = [
            _not_single(single),
            *_large_enough(accepted, nameless),
            differs_from_none(evidence.term, evidence.sides),
            *(_is_no_remainder(candidate, other) for other in in_doubt),
        ]
        every = [*(decision for _, decision in evidence.mimics), evidence.agreement, *drowned]
        doubts = [d for d in every if not d.kept]
        effect = NamedEffect(
            name=candidate.effect.name,
            where=candidate.where,
            confidence=_confidence(
                accepted.p_adjusted, evidence, bool(evidence.mimics) or not all(d.kept for d in drowned)
            ),
            routes={"heldout": True, "direct": evidence.agreement.kept},
            parameters=parameters(evidence.term, evidence.sides),
        )
        named.append(effect)
        if doubts:
            rivals = [r for r, _ in evidence.mimics]
            names = tuple(dict.fromkeys([effect.name, *(r.candidate.effect.name for r in rivals)]))
            groups.append(AmbiguousGroup(effects=names, experiment=experiment(accepted.candidate_fit, rivals, single)))
            in_doubt.append(candidate)
            decisions += [(candidate, doubt) for doubt in doubts]
        else:
            decisions.append((candidate, replace(all_of([remains, *every]), reason=Reason.NAMED)))
    certain = [e for e in named if e.confidence >= NAMED]
    verdict = Verdict(
        status=status(bool(certain), bool(groups), unexplained),
        effects=tuple(named),
        ambiguous_groups=tuple(groups),
        statement=statement(gains, named, groups, unexplained),
    )
    return JudgedSelection(verdict, tuple(decisions))


@dataclass(frozen=True)
class FinalEvidence:
    """What is known of an accepted effect in the final model.

    term        its values; `sides` are how far its reported intervals reach below and above them.
    mimics      other candidates that may be the cause instead, each with the refusal that it gives rise to.
    direct      its direct estimate beside the other effects, if any.
    agreement   whether that agrees with the fit and exceeds the bias of the direct method.
    """

    term: Term
    sides: Sides
    mimics: tuple[tuple[CandidateFit, Decision], ...]
    direct: DirectEstimate | None
    agreement: Decision


def _final_evidence(
    problem: Problem,
    selection: Selection,
    number: int,
    mimics: Sequence[Sequence[tuple[CandidateFit, Decision]]],
    trials: Sequence[str],
) -> FinalEvidence:
    """Of the accepted effect `number`; `mimics` are those of all accepted effects, by rivals of the search."""
    accepted = selection.accepted[number]
    candidate_fit = accepted.candidate_fit
    term, widths = _term_and_half_widths(selection, accepted)
    others = _without(selection.final.model, candidate_fit)
    known = [r for r, _ in mimics[number]]
    preferred = _preferred_by_direct(problem, candidate_fit, known, others, accepted.screening.fits, trials)
    direct, agreement = direct_agreement(problem, candidate_fit, term, widths, others, trials, alone=len(mimics) == 1)
    if direct is not None and agreement.kept:
        agreement = all_of([agreement, exceeds_method_bias(term, direct, accepted.method_bias)])
    sides = wider(
        symmetric(widths),
        distance_to_alternatives(term, widths, direct, [[r for r, _ in each] for each in mimics]),
    )
    return FinalEvidence(term, sides, (*mimics[number], *preferred), direct, agreement)


def _remains(selection: Selection, accepted: Accepted) -> Decision:
    """Refused where later effects do the work of an accepted one: then it differs from none no more."""
    term, widths = _term_and_half_widths(selection, accepted)
    decision = differs_from_none(term, symmetric(widths))
    return decision if decision.kept else replace(decision, reason=Reason.NO_LONGER_NEEDED)


def _not_single(single: bool) -> Decision:
    """Refused where a `single` trial judges: the gain has no interval."""
    return decide([(Reason.SINGLE_TRIAL, criterion("gains without an interval", int(single), "<=", 0))])


def _large_enough(accepted: Accepted, nameless: float) -> list[Decision]:
    """What took a place of another must have passed among all candidates, and must exceed what nothing explains.

    What is wrong with the model repeats from trial to trial like a cause, wherever trials move alike.
    """
    p_value = criterion("adjusted p-value", accepted.p_adjusted, "<", ALPHA)
    removed = criterion("share of the loss that comes back without it", accepted.removed, ">=", nameless)
    return [decide([(Reason.NOT_SIGNIFICANT, p_value)]), decide([(Reason.LESS_THAN_UNEXPLAINED, removed)])]


def _mimics(
    problem: Problem, selection: Selection, accepted: Accepted, trials: Sequence[str]
) -> list[tuple[CandidateFit, Decision]]:
    """The rivals that the direct estimate does not distinguish from an accepted effect; none where later ones do its
    work.
    """
    if not _remains(selection, accepted).kept:
        return []
    others = _without(selection.final.model, accepted.candidate_fit)
    against = [(r, distinguishes(problem, accepted.candidate_fit, r, others, trials)) for r in accepted.rivals]
    return [(rival, decision) for rival, decision in against if not decision.kept]


def _preferred_by_direct(
    problem: Problem,
    accepted: CandidateFit,
    known: Sequence[CandidateFit],
    others: Model,
    tried: Sequence[CandidateFit],
    trials: Sequence[str],
) -> list[tuple[CandidateFit, Decision]]:
    """Other candidates of the screening with a significantly better direct estimate: the two routes disagree.

    One law that does the work of two on roll-outs seldom balances the equations of motion as well.
    """
    if accepted.direct is None or accepted.direct.held_out is None:
        return []
    own_estimate = problem.direct(accepted.candidate, others, trials)
    if own_estimate is None:
        return []
    taken = {accepted.candidate.key, *(t.candidate.key for t in known), *(t.candidate.key for t in others)}
    left = [
        (float(t.direct.held_out.sum()), t.candidate.key, t)
        for t in tried
        if t.candidate.key not in taken and t.direct is not None and t.direct.held_out is not None
    ]
    out: list[tuple[CandidateFit, Decision]] = []
    for _, _, rival in sorted(left, key=lambda entry: entry[:2])[:_DIRECT_RIVALS]:
        rival_estimate = problem.direct(rival.candidate, others, trials)
        better = None if rival_estimate is None else is_better(rival_estimate, own_estimate)
        if better is not None and better.kept:
            lost = negation(better.criteria[0])
            out.append((rival, Decision(False, Reason.DIRECT_PREFERS, (lost,), place_name(rival.candidate))))
    return out


def _term_and_half_widths(selection: Selection, accepted: Accepted) -> tuple[Term, dict[str, float]]:
    """An accepted effect in the final model, and the half widths of its intervals, method bias included."""
    term = next(t for t in selection.final.model if t.candidate.key == accepted.key)
    least = accepted.method_bias.fitted
    return term, {n: max(w, least.get(n, 0.0)) for n, w in selection.final.half_widths.get(accepted.key, {}).items()}


def _without(model: Model, accepted: CandidateFit) -> Model:
    return tuple(t for t in model if t.candidate.key != accepted.candidate.key)


def _is_no_remainder(candidate: Candidate, earlier: Candidate) -> Decision:
    """Refused where an effect may be no more than what a law in doubt leaves: one that does nearly the same there."""
    alike = are_confusable(candidate, earlier) and candidate.where == earlier.where
    confusable = criterion("confusable effects in doubt at its place", int(alike), "<=", 0)
    return decide([(Reason.REMAINDER_OF, confusable)], beside=place_name(earlier))


def _confidence(p_adjusted: float, evidence: FinalEvidence, shared: bool) -> float:
    """At least `NAMED` with both routes and no rival; at most one half else."""
    agreed = evidence.agreement.kept
    if shared or not agreed or evidence.direct is None:
        return 0.5 * (1.0 - p_adjusted) / (2.0 if shared and not agreed else 1.0)
    p_direct = min(1.0, evidence.direct.p_value)
    return float(NAMED + (1.0 - NAMED) * (1.0 - min(1.0, p_adjusted / ALPHA)) * (1.0 - p_direct))
