"""Step 1, screen: every candidate fitted alone on top of a base in a few steps, the promising ones until convergence.

Into a `Screening`: the fits, ranked, with adjusted p-values, and the reason why each candidate was fitted to the end
or not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from schemas.gap import Reason
from simgap.inference.candidate_fit import (
    CandidateFit,
    Map,
    Screening,
    candidate_fit_on,
    direct_held_out_loss,
    ranked_screening,
    warm_start,
)
from simgap.inference.competing_hypotheses import RIVAL_SHARE
from simgap.inference.decision import Decision, criterion, decide, either
from simgap.inference.fit import Errors, Fit, extend, fit, promising_starts, robust_scale, rollout_errors
from simgap.inference.losses import Comparison
from simgap.inference.search_state import SearchState
from simgap.problem import Candidate

_FINALISTS = 6
_DIRECT_FINALISTS = 3  # finalists by direct estimates
_PROMISING_P = 0.3  # p-value below which a candidate is fitted to the end
_SCREEN_STEPS = 2
_REFITS = 2  # of a threshold, each with initial states taken at its last fit
_NOT_JUDGED = Comparison(0.0, (0.0, 0.0), 1.0)


def screen(state: SearchState, free: Iterable[Candidate], each: Map) -> Screening:
    """All of `free` on top of the base, best first; `each` maps trials, over processes or not.

    Where effects are judged on long horizons, short ones are enough to see which are worth those.
    """
    on_long_horizon = state.view != "short_horizon"
    errors, base = _base_on_short_horizons(state) if on_long_horizon else (state.errors, state.base)
    return _fit_finalists(state, list(each(_quick_fit(state, errors, base), free)), on_long_horizon, each)


def _base_on_short_horizons(state: SearchState) -> tuple[Errors, Fit]:
    """The base on short horizons."""
    problem, train = state.problem, state.trials.train
    scale = robust_scale(problem, state.base.model, train, "short_horizon")
    errors = rollout_errors(problem, train, "short_horizon", scale)
    return errors, fit(errors, warm_start(state.base))


def _quick_fit(state: SearchState, errors: Errors, base: Fit) -> Callable[[Candidate], CandidateFit]:
    """The quick fit of one candidate: a step or two from the direct estimate."""

    def tried(candidate: Candidate) -> CandidateFit:
        direct = state.problem.direct(candidate, base.model, state.trials.train)
        if direct is None and state.problem.search_view == "long_horizon":
            starts = [dict(candidate.start)]  # Its direct route scans the whole range and found no trace.
        elif direct is None:
            starts = promising_starts(errors, base, candidate)
        else:
            none = {n: candidate.null[n] for n in candidate.strengths}
            starts = [direct.values, {**direct.values, **none}]
        return candidate_fit_on(base, extend(errors, base, candidate, starts, _SCREEN_STEPS), direct)

    return tried


def _fit_finalists(state: SearchState, screened: list[CandidateFit], on_long_horizon: bool, each: Map) -> Screening:
    """The most promising ones, by their quick fit or by their direct estimate, fitted to the end; best first.

    A candidate with neither a significant quick fit nor a significant direct estimate is no finalist. On long horizons
    (`on_long_horizon`) the others count as no gain, because they were screened on short ones only.
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
    unjudged = [replace(t, comparison=_NOT_JUDGED, delta_bic=0.0) if on_long_horizon else t for t in others]
    screening = ranked_screening([*(_finalists_refitted(state, fits) if on_long_horizon else fits), *unjudged])
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
    """Where a fit to the end begins: the quick fit and the direct estimate, of a threshold also halfway to none.

    No descent leads far along a threshold, and a law that is nearly right needs a smaller value on longer roll-outs.
    """
    quick, none = candidate_fit.fit.model[-1].values, candidate_fit.candidate.null
    starts = (
        [quick]
        if candidate_fit.direct is None or candidate_fit.direct.values == quick
        else [quick, candidate_fit.direct.values]
    )
    if candidate_fit.candidate.extra_starts:
        starts.append({**quick, **{n: 0.5 * (none[n] + quick[n]) for n in candidate_fit.candidate.strengths}})
    return starts


def _finalists_refitted(state: SearchState, finalists: list[CandidateFit]) -> list[CandidateFit]:
    """Finalists, with thresholds and all that gain nearly as much refitted with initial states of their own models.

    An impact changes how an initial state acts on what follows: initial states taken without it would count their own
    noise against the threshold. Its competitors get the same treatment.
    """
    near = [_refitted_from_own_starts(state, t) if t.candidate.extra_starts else t for t in finalists]
    best = max((t.comparison.gain for t in near if t.candidate.extra_starts), default=1.0)
    rivals = [not t.candidate.extra_starts and t.comparison.gain > RIVAL_SHARE * best for t in near]
    return [_refitted_from_own_starts(state, t) if rival else t for t, rival in zip(near, rivals, strict=True)]


def _refitted_from_own_starts(state: SearchState, candidate_fit: CandidateFit) -> CandidateFit:
    """A candidate's fit continued with initial states taken at its own model."""
    fitted = candidate_fit.fit
    for _ in range(_REFITS):
        again = fit(state.errors_at(fitted.model), warm_start(fitted))
        if again.losses.sum() >= fitted.losses.sum():
            break
        fitted = again
    return candidate_fit if fitted is candidate_fit.fit else candidate_fit_on(state.base, fitted, candidate_fit.direct)
