"""Competing hypotheses: candidates that fit no worse than an accepted effect, or make it vanish beside them.

Two candidates are compared by cross-validated losses of the training trials. A difference counts if it is significant
and larger than the errors of smoothing readings and inputs.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from simgap.inference.candidate_fit import (
    ALPHA,
    CandidateFit,
    Map,
    Screening,
    candidate_fit_on,
    combined_p_value,
    least_gain,
    warm_start_without,
)
from simgap.inference.fit import Errors, Fit, extend, fit, is_twin
from simgap.inference.losses import compare, paired_p
from simgap.inference.search_state import SearchState
from simgap.problem import Candidate, Term

RIVAL_SHARE = 0.5  # a rival explains at least this share of what the best explains
RIVAL_ALPHA = 0.05  # level at which the best beats another
AHEAD_GAIN = 0.05  # share of a rival's error by which the best must be ahead: less can be the smoothing
# The same share against a confusable effect: nuisances that are free beside one of the two only add to the difference.
_CONFUSABLE_AHEAD = 0.15
_SMOOTHED = 0.002  # share of what the best takes away by which it must be ahead
_NEARLY = 0.9  # share of the gain with which fewer parameters are preferred
_LITTLE_MORE = 2.0  # times what the best leaves: what leaves more was no match for it
_MOST_RIVALS = 5  # that are fitted again beside the other effects
_REPLACED = 0.25  # share of its strength at which an accepted effect counts as gone
_RICHER = 1  # parameters more that a rival of another kind may have: a spring has a rest beside its stiffness
# Pairs of causes have two laws that may be wrong: a smaller level refutes them; a pair with more parameters than
# the best is dropped at once where the best's loss is more than a fifth smaller.
_BEATEN_TOGETHER, _TOGETHER = 0.01, 0.8


def refit_beside_others(
    state: SearchState, accepted: CandidateFit, others: Sequence[CandidateFit], each: Map
) -> tuple[Fit, CandidateFit, list[CandidateFit]]:
    """The model without one accepted effect, the best effect in its place, and all fits there, best first.

    Another effect replaces the accepted one only if it is significantly better, or simpler and no worse.
    """
    without = fit(state.errors, warm_start_without(state.base, [accepted.candidate], state.problem.nuisances()))
    now = {t.candidate.key: t.values for t in state.base.model}
    before = {t.candidate.key: t.fit.model[-1].values for t in (accepted, *others)}

    def instead(candidate: Candidate) -> CandidateFit:
        values = before[candidate.key]
        starts = [now.get(candidate.key, values), values]
        direct = state.problem.direct(candidate, without.model, state.trials.train)
        return candidate_fit_on(without, extend(state.errors, without, candidate, starts), direct)

    tried = list(each(instead, [t.candidate for t in (accepted, *others)]))
    same = next(t for t in tried if t.candidate.key == accepted.candidate.key)
    tried.sort(key=lambda t: (-t.comparison.gain, t.candidate.key))
    best = tried[0] if is_beaten(same, tried[0]) else same
    simpler = (t for t in tried if len(t.candidate.null) < len(best.candidate.null) and not is_beaten(t, best))
    return without, next(simpler, best), tried


def alternatives(
    accepted: CandidateFit, screening: Screening, rivals: Collection[str], base: Fit
) -> list[CandidateFit]:
    """Candidates to fit in the place of an accepted effect: its rivals, confusable effects, and close runners-up.

    An effect that is confusable with one of two causes may mimic both, with a far smaller loss than either cause alone.
    """
    taken = {c.key for c in base.free}
    most = _LITTLE_MORE * float(accepted.fit.held_out.sum())
    free = [t for t in screening.fits if t.candidate.key not in taken]
    known = [t for t in free if t.candidate.key in rivals]
    judged = [t for t in free if t.comparison.gain > 0.0 and t.candidate.key not in rivals]
    confusables = [t for t in judged if are_confusable(t.candidate, accepted.candidate)]
    near = (
        t for t in judged if float(t.fit.held_out.sum()) < most and not are_confusable(t.candidate, accepted.candidate)
    )
    return [*known, *confusables, *near][:_MOST_RIVALS]


def are_confusable(one: Candidate, other: Candidate) -> bool:
    """Whether the library lists either effect as a look-alike of the other."""
    named = {c.effect for c in one.effect.confusables}
    return other.effect.name in named or one.effect.name in {c.effect for c in other.effect.confusables}


def replacement(screening: Screening, base: Fit, accepted: Sequence[CandidateFit]) -> tuple[int, CandidateFit] | None:
    """The best candidate of a screening if it makes an accepted effect vanish, with the index of that effect."""
    if not screening.fits:
        return None
    best = screening.fits[0]
    if screening.p_adjusted[0] >= ALPHA or best.comparison.gain <= least_gain(best.candidate):
        return None
    for place, found in enumerate(accepted):
        term = next(t for t in base.model if t.candidate.key == found.candidate.key)
        if best.fit.strength_exceeds({}) and vanishes(term, best.fit):
            return place, best
    return None


def replaces_an_effect(extended: Fit, base: Fit) -> bool:
    """Whether an effect of the base vanishes beside the new one: the new one is then a replacement, not an addition."""
    return any(vanishes(term, extended) for term in base.model)


def vanishes(term: Term, extended: Fit) -> bool:
    """Whether little of a term's strength is left in another fit."""
    now = next((t for t in extended.model if t.candidate.key == term.candidate.key), None)
    if now is None or term.candidate.nuisance:
        return False
    null = term.candidate.null
    return all(
        abs(now.values[n] - null[n]) < _REPLACED * abs(term.values[n] - null[n]) for n in term.candidate.strengths
    )


def possible_replacements(
    screening: Screening, base: Fit, accepted: CandidateFit, known: Sequence[CandidateFit]
) -> list[CandidateFit]:
    """Significant candidates beside which an accepted effect vanishes: each may be the true cause instead."""
    term = next(t for t in base.model if t.candidate.key == accepted.candidate.key)
    taken = {t.candidate.key for t in known}
    return [
        trial
        for trial, p in zip(screening.fits, screening.p_adjusted, strict=True)
        if p < ALPHA and trial.candidate.key not in taken and vanishes(term, trial.fit)
    ]


def as_good_with_confusable(
    errors: Errors,
    base: Fit,
    nuisances: Sequence[Candidate],
    accepted: CandidateFit,
    confusables: Sequence[CandidateFit],
    best: CandidateFit,
    others: Sequence[CandidateFit],
) -> list[CandidateFit]:
    """Which of `others` do as well in the place of `best` once a confusable effect replaces `accepted`.

    Two causes may mimic two others where neither does alone: friction by load and a weight mimic dry friction and a
    spring. Without the confusable effect the spring would be refuted.
    """
    remaining = warm_start_without(base, [accepted.candidate, best.candidate], nuisances)
    out: list[CandidateFit] = []
    for confusable in confusables:
        others_remaining = [c for c in remaining if not is_twin(c, confusable.candidate)]
        near = fit(errors, [*others_remaining, replace(confusable.candidate, start=confusable.fit.model[-1].values)])
        for other in others:
            richer = len(other.candidate.null) > len(best.candidate.null) + _RICHER
            if richer or other.candidate.key in {confusable.candidate.key, *(t.candidate.key for t in out)}:
                continue
            both = extend(errors, near, other.candidate, [other.fit.model[-1].values, other.candidate.start])
            more = len(other.candidate.null) > len(best.candidate.null)
            if more and _TOGETHER * both.held_out.sum() > base.held_out.sum():
                continue  # Fewer parameters are preferred where they leave less besides.
            ahead = compare(both.held_out, base.held_out)
            if not (ahead.p_value < _BEATEN_TOGETHER and clearly_less(both, base, best)):
                out.append(candidate_fit_on(near, both, other.direct))
    return out


def simpler_and_as_good(simpler: CandidateFit, best: CandidateFit) -> bool:
    """Whether a candidate has fewer parameters, gains nearly what the best does, and is not beaten by it."""
    fewer = len(simpler.candidate.null) < len(best.candidate.null)
    near = simpler.comparison.gain > _NEARLY * best.comparison.gain
    significant = simpler.comparison.p_value < ALPHA
    return fewer and near and significant and paired_p(simpler.fit.held_out, best.fit.held_out) > RIVAL_ALPHA


def is_beaten(rival: CandidateFit, best: CandidateFit) -> bool:
    """Whether the best leaves less than the rival, beyond chance and by more than smoothing may do."""
    ahead = compare(rival.fit.held_out, best.fit.held_out)
    if are_confusable(rival.candidate, best.candidate) and ahead.gain < _CONFUSABLE_AHEAD:
        return False
    return ahead.p_value < RIVAL_ALPHA and clearly_less(rival.fit, best.fit, best)


def clearly_less(rival: Fit, better: Fit, best: CandidateFit) -> bool:
    """Whether `better` leaves less than `rival` by more than smoothing may do, of what is left and what `best` takes.

    Readings and inputs are shifted and smoothed on the way to either: that errs with the size of what is hidden.
    """
    left, least = float(rival.held_out.mean()), float(better.held_out.mean())
    gain = min(best.comparison.gain, 0.999)
    taken = float(best.fit.held_out.mean()) * gain / (1.0 - gain)
    return left - least > max(AHEAD_GAIN * left, _SMOOTHED * taken)


def inseparable(errors: Errors, best: CandidateFit, tried: Sequence[CandidateFit]) -> tuple[CandidateFit, ...]:
    """Rivals that do as well as the best, and on top of which the best adds nothing."""
    inseparable_rivals = []
    for rival in tried:
        if rival is best or rival.comparison.gain < RIVAL_SHARE * best.comparison.gain:
            continue
        if is_beaten(rival, best):
            continue
        # A richer law that does no better has had its chance, as has a much richer one of another kind; known doubles
        # stay in doubt.
        confusable_names = {c.effect for c in best.candidate.effect.confusables}
        kin = rival.candidate.effect.family == best.candidate.effect.family
        richer = len(rival.candidate.null) > len(best.candidate.null) + (0 if kin else _RICHER)
        does_better = _NEARLY * rival.comparison.gain > best.comparison.gain
        if richer and not does_better and rival.candidate.effect.name not in confusable_names:
            continue
        both = extend(errors, rival.fit, best.candidate, [best.fit.model[-1].values, best.candidate.start])
        over_rival = compare(rival.fit.held_out, both.held_out)
        little = are_confusable(rival.candidate, best.candidate) and over_rival.gain < _CONFUSABLE_AHEAD
        if not little and combined_p_value(over_rival, both) < ALPHA and clearly_less(rival.fit, both, best):
            continue
        inseparable_rivals.append(rival)
    return tuple(inseparable_rivals)
