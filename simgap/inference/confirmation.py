"""Step 2, confirm: the first candidate of a screening that is significant, helps the test trials and is no bias.

From a `Screening` into at most one `Accepted` effect with its rivals, and the reason what became of each candidate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.decisions import Reason
from simgap.inference.candidate_fit import CandidateFit, Screening
from simgap.inference.competing_hypotheses import RIVAL_ALPHA, inseparable, is_simpler_and_as_good
from simgap.inference.decision import Decided, Decision, all_of, criterion, decide, place_name
from simgap.inference.fit import Errors, extend
from simgap.inference.hypothesis import Accepted, Evidence, is_beyond_method_bias, is_confirmed, is_significant
from simgap.inference.losses import paired_p
from simgap.inference.parametric_bootstrap import estimate_method_bias
from simgap.inference.search_state import SearchState

_AHEAD = 3  # candidates that are tried in pairs


@dataclass(frozen=True)
class Confirmation:
    """The effect that is accepted, if any, with what was decided on each candidate and on each rival of it."""

    accepted: Accepted | None
    decisions: tuple[Decided, ...]
    rivals: tuple[Decided, ...] = ()


def confirm(state: SearchState, screening: Screening) -> Confirmation:
    """The first significant candidate that the test trials confirm and that exceeds the method's bias."""
    evidence = {
        t.candidate.key: Evidence(state.base, t, p) for t, p in zip(screening.fits, screening.p_adjusted, strict=True)
    }
    decisions = {key: is_significant(e) for key, e in evidence.items()}
    ordered = _best_pair_first(state.errors, _significant_first(screening, decisions))
    losses_before = state.test_losses(state.base) if ordered else np.zeros(0)
    accepted, rivals = None, []
    for rank, candidate_fit in enumerate(ordered, 1):
        key = candidate_fit.candidate.key
        tested, decisions[key] = _tested(state, evidence[key], losses_before)
        if tested.method_bias is not None and decisions[key].kept:
            rivals = inseparable(state.errors, candidate_fit, screening.fits)
            fits = tuple(r for r, decision in rivals if decision.kept)
            accepted = Accepted(candidate_fit, screening, tested.p_adjusted, fits, tested.method_bias)
            decisions |= {
                t.candidate.key: _after(candidate_fit, rank, n) for n, t in enumerate(ordered[rank:], rank + 1)
            }
            break
    decided = tuple((t.candidate, decisions[t.candidate.key]) for t in screening.fits)
    return Confirmation(accepted, decided, tuple((r.candidate, decision) for r, decision in rivals))


def _after(accepted: CandidateFit, rank: int, rank_of_other: int) -> Decision:
    """Another candidate was accepted first: a significant one is not tested further before the next round."""
    later = criterion("rank among significant candidates", rank_of_other, "<=", rank)
    return decide([(Reason.ACCEPTED_AFTER, later)], beside=place_name(accepted.candidate))


def _tested(state: SearchState, evidence: Evidence, losses_before: FloatArray) -> tuple[Evidence, Decision]:
    """Evidence and decision after the test trials and, where these confirm, after the bootstrap."""
    fitted = evidence.candidate_fit.fit
    evidence = replace(evidence, test_losses=(losses_before, state.test_losses(fitted)))
    confirmed = is_confirmed(evidence)
    if not confirmed.kept:
        return evidence, confirmed
    bias = estimate_method_bias(state.problem, state.trials.train, state.base.model, fitted.model)
    evidence = replace(evidence, method_bias=bias)
    return evidence, all_of([confirmed, is_beyond_method_bias(evidence)])


def _significant_first(screening: Screening, decisions: Mapping[str, Decision]) -> list[CandidateFit]:
    """Significant candidates by gain; before each of them any that has fewer parameters and is not beaten by it.

    The simpler one need not pass the correction itself: what it competes with has passed.
    """
    ordered: list[CandidateFit] = []
    for candidate_fit in screening.fits:
        if not decisions[candidate_fit.candidate.key].kept:
            continue
        simpler = [
            t
            for t in screening.fits
            if len(t.candidate.null) < len(candidate_fit.candidate.null)
            and is_simpler_and_as_good(t, candidate_fit).kept
        ]
        ordered += [t for t in (*simpler, candidate_fit) if all(t is not other for other in ordered)]
    return ordered


def _best_pair_first(errors: Errors, significant: list[CandidateFit]) -> list[CandidateFit]:
    """The same candidates, but one law that does the work of two comes after the better of the two.

    Two causes together are often mimicked best by a third that is neither; with a second term the mimic falls behind.
    """
    few = sorted(significant, key=lambda t: -t.comparison.gain)[:_AHEAD]
    if len(few) < 3:
        return significant
    pairs = [
        (a, b, extend(errors, a.fit, b.candidate, [b.fit.model[-1].values, b.candidate.start], 3))
        for a, b in combinations(few, 2)
    ]
    best_of_all = min(pairs, key=lambda p: p[2].held_out.sum())
    with_first = min((p for p in pairs if significant[0] in p[:2]), key=lambda p: p[2].held_out.sum(), default=None)
    if with_first is None or paired_p(with_first[2].held_out, best_of_all[2].held_out) > RIVAL_ALPHA:
        return significant
    ahead = max(best_of_all[:2], key=lambda t: t.comparison.gain)
    return [ahead, *(t for t in significant if t is not ahead)]
