"""Step 1, screen: every candidate fitted alone on top of a base in a few steps, the promising ones until convergence.

Into a `Screening`: the fits, ranked, with adjusted p-values, and the reason why each candidate was fitted to the end
or not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from schemas.sim_gap.decisions import Reason
from simgap.inference.candidate_fit import (
    CandidateFit,
    Map,
    Screening,
    candidate_fit_on,
    direct_held_out_loss,
    ranked_screening,
)
from simgap.inference.decision import Decision, criterion, decide, either
from simgap.inference.fit import extend, promising_starts
from simgap.inference.search_state import SearchState
from simgap.problem import Candidate

_FINALISTS = 6
_DIRECT_FINALISTS = 3  # finalists by direct estimates
_PROMISING_P = 0.3  # p-value below which a candidate is fitted to the end
_SCREEN_STEPS = 2


def screen(state: SearchState, free: Iterable[Candidate], each: Map) -> Screening:
    """All of `free` on top of the base, best first; `each` maps trials, over processes or not."""
    return _fit_finalists(state, list(each(_quick_fit(state), free)), each)


def _quick_fit(state: SearchState) -> Callable[[Candidate], CandidateFit]:
    """The quick fit of one candidate: a step or two from the direct estimate."""
    base = state.base

    def tried(candidate: Candidate) -> CandidateFit:
        direct = state.problem.direct(candidate, base.model, state.trials.train)
        if direct is None:
            starts = promising_starts(state.errors, base, candidate)
        else:
            none = {n: candidate.null[n] for n in candidate.strengths}
            starts = [direct.values, {**direct.values, **none}]
        return candidate_fit_on(base, extend(state.errors, base, candidate, starts, _SCREEN_STEPS), direct)

    return tried


def _fit_finalists(state: SearchState, screened: list[CandidateFit], each: Map) -> Screening:
    """The most promising ones, by their quick fit or by their direct estimate, fitted to the end; best first.

    A candidate with neither a significant quick fit nor a significant direct estimate is no finalist.
    """
    order = sorted(screened, key=lambda t: (-t.comparison.gain, t.candidate.key))
    by_direct_loss = sorted(order, key=direct_held_out_loss)
    direct_ranks = {t.candidate.key: rank for rank, t in enumerate(by_direct_loss, 1)}
    decisions = {
        t.candidate.key: is_finalist(t, rank, direct_ranks[t.candidate.key]) for rank, t in enumerate(order, 1)
    }
    ranked = (*order[:_FINALISTS], *by_direct_loss[:_DIRECT_FINALISTS])
    finalists = {t.candidate.key: t for t in ranked if decisions[t.candidate.key].kept}

    def tried(candidate: Candidate) -> CandidateFit:
        quick = finalists[candidate.key]
        return candidate_fit_on(
            state.base, extend(state.errors, state.base, candidate, _final_starts(quick)), quick.direct
        )

    fits = list(each(tried, [t.candidate for t in order if t.candidate.key in finalists]))
    others = [t for t in order if t.candidate.key not in finalists]
    screening = ranked_screening([*fits, *others])
    return replace(screening, decisions=tuple((t.candidate, decisions[t.candidate.key]) for t in order))


def is_finalist(candidate_fit: CandidateFit, rank_by_gain: int, rank_by_direct_loss: int) -> Decision:
    """Kept if a candidate is among the first by gain or by direct loss, and either p-value is promising."""
    direct = 1.0 if candidate_fit.direct is None else candidate_fit.direct.p_value
    ranks = (
        criterion("rank by held-out gain", rank_by_gain, "<=", _FINALISTS),
        criterion("rank by direct loss", rank_by_direct_loss, "<=", _DIRECT_FINALISTS),
    )
    p_value = criterion("smaller p-value", min(direct, candidate_fit.comparison.p_value), "<", _PROMISING_P)
    return decide([(Reason.NOT_PROMISING, p_value), (Reason.OUTRANKED, either(*ranks))])


def _final_starts(candidate_fit: CandidateFit) -> list[dict[str, float]]:
    """Where a fit to the end begins: the quick fit and the direct estimate."""
    quick, direct = candidate_fit.fit.model[-1].values, candidate_fit.direct
    return [quick] if direct is None or direct.values == quick else [quick, direct.values]
