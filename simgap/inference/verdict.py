"""The verdict from a selection: an effect is named only when its held-out gain and its direct estimate agree."""

from __future__ import annotations

import math
from collections.abc import Sequence

from schemas.gap import AmbiguousGroup, Gain, NamedEffect, Verdict
from simgap.inference.agreement import direct_agreement, exceeds_method_bias
from simgap.inference.candidate_fit import ALPHA, CandidateFit
from simgap.inference.competing_hypotheses import are_confusable
from simgap.inference.direct_comparison import distinguishes, is_better
from simgap.inference.forward_selection import Accepted, Selection
from simgap.inference.intervals import (
    differs_from_none,
    distance_to_alternatives,
    parameters,
    symmetric,
    threshold_excess,
    wider,
)
from simgap.inference.losses import Comparison
from simgap.inference.verdict_text import NAMED, STRANGE, experiment, statement, status
from simgap.problem import Candidate, DirectEstimate, Model, Problem, Term

_DIRECT_RIVALS = 3  # further candidates that are compared by direct estimates
LEFTOVER = 0.1  # what a model without names may still explain before we say that something else is there


def judge(
    problem: Problem,
    selection: Selection,
    trials: Sequence[str],
    gains: Sequence[Gain],
    leftover: Comparison,
    tails: float = 0.0,
    strange: bool = False,
) -> Verdict:
    """The verdict over all accepted effects, with its `gains`, that of short horizons first.

    `leftover` is what a black box gains on top of them; `tails` is the share of its loss that lies in tails longer than
    noise has: what comes seldom, as play at reversals, no black box finds. Where the data are `strange`, nothing is
    sure: the inputs may be those of other motions. Where a single trial judges nothing is either: a gain without an
    interval may be chance.
    """
    unexplained = leftover.p_value < ALPHA and leftover.gain > LEFTOVER
    single = math.isinf(gains[0].ci95[0])
    nameless = max(leftover.gain if unexplained else 0.0, tails)
    doubted = [_doubted(problem, selection, accepted, trials) for accepted in selection.accepted]
    named: list[NamedEffect] = []
    groups: list[AmbiguousGroup] = []
    in_doubt: list[Candidate] = []
    for accepted, alike in zip(selection.accepted, doubted, strict=True):
        term, widths = _term_and_half_widths(selection, accepted)
        if not differs_from_none(term, symmetric(widths)):
            continue
        candidate_fit = accepted.candidate_fit
        others = _without(selection.final.model, candidate_fit)
        same = [*alike, *_preferred_by_direct(problem, candidate_fit, alike, others, accepted.screening.fits, trials)]
        direct_estimate, agreed = direct_agreement(
            problem, candidate_fit, term, widths, others, trials, alone=len(doubted) == 1
        )
        direct = (
            agreed and direct_estimate is not None and exceeds_method_bias(term, direct_estimate, accepted.method_bias)
        )
        wide = wider(
            wider(symmetric(widths), symmetric(threshold_excess(term))),
            distance_to_alternatives(term, widths, direct_estimate, doubted),
        )
        # What may be nothing, by the interval that is reported, has no sure name; nor has what took a place of another
        # and would not have passed among all candidates by itself.
        # Beside structure that nothing explains an effect must be the larger of the two: what is wrong with the model
        # repeats from trial to trial like a cause, wherever trials move alike.
        p = accepted.p_adjusted
        drowned = strange or single or p >= ALPHA or accepted.removed < nameless or not differs_from_none(term, wide)
        drowned = drowned or any(_may_be_remainder_of(candidate_fit.candidate, other) for other in in_doubt)
        effect = NamedEffect(
            name=candidate_fit.candidate.effect.name,
            where=candidate_fit.candidate.where,
            confidence=_confidence(p, direct_estimate, direct, bool(same) or drowned),
            routes={"heldout": True, "direct": direct},
            parameters=parameters(term, wide),
        )
        if same or drowned or not direct:
            in_doubt.append(candidate_fit.candidate)
            names = tuple(dict.fromkeys([effect.name, *(r.candidate.effect.name for r in same)]))
            groups.append(AmbiguousGroup(effects=names, experiment=experiment(candidate_fit, same, single)))
        named.append(effect)
    certain = [e for e in named if e.confidence >= NAMED]
    return Verdict(
        status=status(bool(certain), bool(groups), unexplained or strange),
        effects=tuple(named),
        ambiguous_groups=tuple(groups),
        statement=statement(gains, named, groups, unexplained) if not strange else STRANGE,
    )


def _doubted(problem: Problem, selection: Selection, accepted: Accepted, trials: Sequence[str]) -> list[CandidateFit]:
    """The rivals that the direct estimate does not distinguish from an accepted effect; none where later ones do its
    work.
    """
    term, widths = _term_and_half_widths(selection, accepted)
    if not differs_from_none(term, symmetric(widths)):
        return []
    others = _without(selection.final.model, accepted.candidate_fit)
    return [r for r in accepted.rivals if not distinguishes(problem, accepted.candidate_fit, r, others, trials)]


def _preferred_by_direct(
    problem: Problem,
    accepted: CandidateFit,
    known: Sequence[CandidateFit],
    others: Model,
    tried: Sequence[CandidateFit],
    trials: Sequence[str],
) -> list[CandidateFit]:
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
    out = []
    for _, _, rival in sorted(left, key=lambda entry: entry[:2])[:_DIRECT_RIVALS]:
        rival_estimate = problem.direct(rival.candidate, others, trials)
        if rival_estimate is not None and is_better(rival_estimate, own_estimate) is True:
            out.append(rival)
    return out


def _term_and_half_widths(selection: Selection, accepted: Accepted) -> tuple[Term, dict[str, float]]:
    """An accepted effect in the final model, and the half widths of its intervals, method bias included."""
    term = next(t for t in selection.final.model if t.candidate.key == accepted.key)
    least = accepted.method_bias.fitted
    return term, {n: max(w, least.get(n, 0.0)) for n, w in selection.final.half_widths.get(accepted.key, {}).items()}


def _without(model: Model, accepted: CandidateFit) -> Model:
    return tuple(t for t in model if t.candidate.key != accepted.candidate.key)


def _may_be_remainder_of(candidate: Candidate, earlier: Candidate) -> bool:
    """Whether an effect may be no more than what a law in doubt leaves: one that does nearly the same, at one place."""
    return are_confusable(candidate, earlier) and candidate.where == earlier.where


def _confidence(p_adjusted: float, direct: DirectEstimate | None, agreed: bool, shared: bool) -> float:
    """At least `NAMED` with both routes and no rival; at most one half else."""
    if shared or not agreed or direct is None:
        return 0.5 * (1.0 - p_adjusted) / (2.0 if shared and not agreed else 1.0)
    return float(NAMED + (1.0 - NAMED) * (1.0 - min(1.0, p_adjusted / ALPHA)) * (1.0 - min(1.0, direct.p_value)))
