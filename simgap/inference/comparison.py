"""Step 3, compare: accepted effects against competing hypotheses, fitted in their place beside the other effects.

From accepted effects and a `SearchState` into accepted effects with their rivals, some of them replaced, and the reason
for each comparison.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from simgap.inference.candidate_fit import CandidateFit, Map, Screening
from simgap.inference.competing_hypotheses import (
    alternatives,
    as_good_with_confusable,
    inseparable,
    is_as_good,
    possible_replacements,
    refit_beside_others,
    replacement,
)
from simgap.inference.decision import Decided, Decision
from simgap.inference.direct_comparison import distinguishes
from simgap.inference.fit import Fit
from simgap.inference.hypothesis import Accepted, Evidence, is_beyond_method_bias
from simgap.inference.parametric_bootstrap import MethodBias, estimate_method_bias
from simgap.inference.search_state import SearchState


@dataclass(frozen=True)
class Comparisons:
    """The search after comparisons: its state, the accepted effects in order, and what was decided."""

    state: SearchState
    accepted: tuple[Accepted, ...]
    decisions: tuple[Decided, ...] = ()


def compare_with_alternatives(state: SearchState, accepted: Sequence[Accepted], each: Map) -> Comparisons:
    """Every accepted effect compared with its alternatives beside the others, until none takes a place.

    What takes a place changes what the others are compared beside.
    """
    effects, decisions = list(accepted), list[Decided]()
    for _ in accepted:
        before = [a.key for a in effects]
        for place in range(len(effects)):
            state, effects[place], decided = refitted_with_alternatives(state, effects[place], each)
            decisions += decided
        if before == [a.key for a in effects]:
            break
    return Comparisons(state, tuple(effects), tuple(decisions))


def refitted_with_alternatives(
    state: SearchState, accepted: Accepted, each: Map
) -> tuple[SearchState, Accepted, list[Decided]]:
    """What was chosen before the others were known, fitted again beside them; the base follows a better one.

    Effects accepted since are no rivals any more; rivals that are not fitted again stay.
    """
    taken = {c.key for c in state.base.free}
    accepted = replace(accepted, rivals=tuple(r for r in accepted.rivals if r.candidate.key not in taken))
    before = {r.candidate.key for r in accepted.rivals}
    others = alternatives(accepted.candidate_fit, accepted.screening, before, state.base)
    if not others:
        return state, accepted, []
    refitted = refit_beside_others(state, accepted.candidate_fit, others, each)
    best, decisions = refitted.best, [(accepted.candidate_fit.candidate, refitted.decision)]
    method_bias = accepted.method_bias
    if best.candidate.key != accepted.key:
        method_bias, beyond = _bias_of(state, refitted.without, best, accepted)
        if not beyond.kept:
            decisions = [(best.candidate, beyond)]
            best = next(t for t in refitted.fits if t.candidate.key == accepted.key)
    tried_keys = {t.candidate.key for t in refitted.fits}
    untried = (r for r in accepted.rivals if r.candidate.key not in tried_keys)
    again = [(t, is_as_good(t, best)) for t in refitted.fits if t.candidate.key in before and t is not best]
    fresh = inseparable(state.errors, best, [t for t in refitted.fits if t.candidate.key not in before])
    still = (t for t, decision in (*again, *fresh) if decision.kept)
    decisions += [(t.candidate, decision) for t, decision in (*again, *fresh)]
    accepted = replace(accepted, rivals=(*untried, *still))
    if best.candidate.key == accepted.key:
        return state, accepted, decisions
    return replace(state, base=best.fit), _in_place(accepted, best, method_bias), decisions


def exchange_vanishing(
    state: SearchState, screening: Screening, accepted: Sequence[Accepted], each: Map
) -> tuple[tuple[int, Accepted] | None, tuple[Decided, ...]]:
    """The replacement of an accepted effect by a candidate that makes it vanish, with its index, and the decisions.

    It is tried before an effect is added; None where no candidate does, or where it does not do better in that place.
    """
    instead = replacement(screening, state.base, [a.candidate_fit for a in accepted])
    if instead is None:
        return None, ()
    place, challenger = instead
    replaced = accepted[place]
    refitted = refit_beside_others(state, replaced.candidate_fit, [challenger], each)
    decision = replaced.candidate_fit.candidate, refitted.decision
    if refitted.best.candidate.key != challenger.candidate.key:
        return None, (decision,)
    method_bias, beyond = _bias_of(state, refitted.without, refitted.best, replaced)
    if not beyond.kept:
        return None, ((challenger.candidate, beyond),)
    return (place, _in_place(replaced, refitted.best, method_bias)), (decision, (challenger.candidate, beyond))


def with_possible_replacements(
    state: SearchState, screening: Screening, accepted: Sequence[Accepted]
) -> tuple[tuple[Accepted, ...], tuple[Decided, ...]]:
    """Accepted effects with, as further rivals, the significant candidates beside which they vanish."""
    out, decisions = [], list[Decided]()
    for a in accepted:
        more = possible_replacements(screening, state.base, a.candidate_fit, a.rivals)
        out.append(replace(a, rivals=(*a.rivals, *(t for t, _ in more))))
        decisions += [(t.candidate, decision) for t, decision in more]
    return tuple(out), tuple(decisions)


def with_rivals_beside_confusable(
    state: SearchState, accepted: Sequence[Accepted]
) -> tuple[tuple[Accepted, ...], tuple[Decided, ...]]:
    """`accepted` with the further rivals that appear once a confusable effect replaces another accepted effect."""
    out, decisions = list(accepted), list[Decided]()
    nuisances = state.problem.nuisances()
    for doubted in accepted:
        others = tuple(t for t in state.base.model if t.candidate.key != doubted.key)
        confusables = [
            r
            for r in doubted.rivals
            if not distinguishes(state.problem, doubted.candidate_fit, r, others, state.trials.train).kept
        ]
        if not confusables:
            continue
        for k, best in enumerate(accepted):
            known = {doubted.key, *(t.candidate.key for t in (*out[k].rivals, *confusables))}
            fresh = [
                t
                for t in alternatives(best.candidate_fit, best.screening, (), state.base)
                if t.candidate.key not in known
            ]
            if best is doubted or not fresh:
                continue
            more = as_good_with_confusable(
                state.errors, state.base, nuisances, doubted.candidate_fit, confusables, best.candidate_fit, fresh
            )
            out[k] = replace(out[k], rivals=(*out[k].rivals, *(t for t, _ in more)))
            decisions += [(t.candidate, decision) for t, decision in more]
    return tuple(out), tuple(decisions)


def _bias_of(state: SearchState, without: Fit, best: CandidateFit, replaced: Accepted) -> tuple[MethodBias, Decision]:
    """The method's bias on a candidate in the place of an accepted effect, and whether the candidate exceeds it."""
    bias = estimate_method_bias(state.problem, state.trials.train, without.model, best.fit.model)
    p_adjusted = replaced.screening.p_of(best.candidate.key)
    return bias, is_beyond_method_bias(Evidence(without, best, p_adjusted, method_bias=bias))


def _in_place(replaced: Accepted, best: CandidateFit, method_bias: MethodBias) -> Accepted:
    """Another effect in the place of an accepted one, and no longer among its rivals.

    Its p-value is that of its own screening: a replacement is no more certain than it was there.
    """
    key = best.candidate.key
    fits = tuple(best if t.candidate.key == key else t for t in replaced.screening.fits)
    rivals = tuple(r for r in replaced.rivals if r.candidate.key != key)
    return Accepted(best, replace(replaced.screening, fits=fits), replaced.screening.p_of(key), rivals, method_bias)
