"""Competing hypotheses: candidates that fit no worse than an accepted effect, or make it vanish beside them.

Two candidates are compared by cross-validated losses of the training trials. A difference counts if it is significant
and larger than the errors of smoothing readings and inputs. Each comparison gives a decision with its reason.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

from schemas.sim_gap.decisions import Criterion, Reason
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
from simgap.inference.decision import Decision, Test, criterion, decide, either, negation, place_name
from simgap.inference.fit import Errors, Fit, extend, fit, is_twin
from simgap.inference.losses import compare, paired_p
from simgap.inference.search_state import SearchState
from simgap.problem import Candidate, Term

_RIVAL_SHARE = 0.5  # a rival explains at least this share of what the best explains
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


@dataclass(frozen=True)
class Refitted:
    """An accepted effect and its alternatives fitted in one place beside the other effects.

    without    the model without any of them.
    best       the fit that takes the place.
    fits       all fits there, best first.
    decision   whether the accepted effect keeps its place.
    """

    without: Fit
    best: CandidateFit
    fits: tuple[CandidateFit, ...]
    decision: Decision


def refit_beside_others(
    state: SearchState, accepted: CandidateFit, others: Sequence[CandidateFit], each: Map
) -> Refitted:
    """The accepted effect and others fitted again in its place.

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
    against_best = is_as_good(same, tried[0])
    leader = same if against_best.kept else tried[0]
    simpler = (t for t in tried if len(t.candidate.null) < len(leader.candidate.null) and is_as_good(t, leader).kept)
    best = next(simpler, leader)
    if best is same:
        return Refitted(without, best, tuple(tried), Decision(True, Reason.PASSED))
    fewest = criterion("parameters of candidates as good", len(same.candidate.null), "<=", len(best.candidate.null))
    criteria = (fewest,) if against_best.kept else against_best.criteria
    decision = Decision(False, Reason.REPLACED_BY, criteria, place_name(best.candidate))
    return Refitted(without, best, tuple(tried), decision)


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
    for place, replaced in enumerate(accepted):
        term = next(t for t in base.model if t.candidate.key == replaced.candidate.key)
        if best.fit.strength_exceeds({}).kept and not persists(term, best.fit).kept:
            return place, best
    return None


def adds_to(base: Fit, extended: Fit) -> Decision:
    """Kept if all effects of the base persist beside the new one: else it is a replacement, not an addition."""
    by_term = [persists(term, extended) for term in base.model]
    return next((d for d in by_term if not d.kept), Decision(True, Reason.PASSED))


def persists(term: Term, extended: Fit) -> Decision:
    """Kept if more than a little of some strength of a term is left in another fit; always for nuisances."""
    now = next((t for t in extended.model if t.candidate.key == term.candidate.key), None)
    if now is None or term.candidate.nuisance:
        return Decision(True, Reason.PASSED)
    null = term.candidate.null
    left = [
        criterion(
            f"distance of {n} of {place_name(term.candidate)} from no effect",
            abs(now.values[n] - null[n]),
            ">=",
            _REPLACED * abs(term.values[n] - null[n]),
        )
        for n in term.candidate.strengths
    ]
    return decide([(Reason.MAKES_VANISH, either(*left))], beside=place_name(term.candidate))


def possible_replacements(
    screening: Screening, base: Fit, accepted: CandidateFit, known: Sequence[CandidateFit]
) -> list[tuple[CandidateFit, Decision]]:
    """Significant candidates beside which an accepted effect vanishes: each may be the true cause instead."""
    term = next(t for t in base.model if t.candidate.key == accepted.candidate.key)
    taken = {t.candidate.key for t in known}
    out: list[tuple[CandidateFit, Decision]] = []
    for candidate_fit, p in zip(screening.fits, screening.p_adjusted, strict=True):
        significant = criterion("adjusted p-value", p, "<", ALPHA)
        if not significant.holds or candidate_fit.candidate.key in taken:
            continue
        persistence = persists(term, candidate_fit.fit)
        if not persistence.kept:
            criteria = significant, negation(persistence.criteria[-1])
            beside = place_name(accepted.candidate)
            out.append((candidate_fit, Decision(True, Reason.INSEPARABLE_FROM, criteria, beside)))
    return out


def as_good_with_confusable(
    errors: Errors,
    base: Fit,
    nuisances: Sequence[Candidate],
    accepted: CandidateFit,
    confusables: Sequence[CandidateFit],
    best: CandidateFit,
    others: Sequence[CandidateFit],
) -> list[tuple[CandidateFit, Decision]]:
    """Those of `others` that do as well in the place of `best` once a confusable effect replaces `accepted`.

    Two causes may mimic two others where neither does alone: friction by load and a weight mimic dry friction and a
    spring. Without the confusable effect the spring would be refuted.
    """
    remaining = warm_start_without(base, [accepted.candidate, best.candidate], nuisances)
    out: list[tuple[CandidateFit, Decision]] = []
    for confusable in confusables:
        others_remaining = [c for c in remaining if not is_twin(c, confusable.candidate)]
        near = fit(errors, [*others_remaining, replace(confusable.candidate, start=confusable.fit.model[-1].values)])
        for other in others:
            richer = len(other.candidate.null) > len(best.candidate.null) + _RICHER
            if richer or other.candidate.key in {confusable.candidate.key, *(t.candidate.key for t, _ in out)}:
                continue
            both = extend(errors, near, other.candidate, [other.fit.model[-1].values, other.candidate.start])
            decision = is_pair_as_good(both, base, other, best)
            if decision.kept:
                out.append((candidate_fit_on(near, both, other.direct), decision))
    return out


def is_pair_as_good(pair: Fit, base: Fit, other: CandidateFit, best: CandidateFit) -> Decision:
    """Kept unless the base leaves less than a pair with `other` in the place of `best`.

    Fewer parameters are preferred where they leave less besides.
    """

    def tests() -> Iterator[Test]:
        if len(other.candidate.null) > len(best.candidate.null):
            share = criterion("share of the pair's loss", _TOGETHER * pair.held_out.sum(), "<=", base.held_out.sum())
            yield Reason.MORE_PARAMETERS_THAN, share
        ahead = compare(pair.held_out, base.held_out)
        chance = criterion("p of being no worse", ahead.p_value, ">=", _BEATEN_TOGETHER)
        yield Reason.FITS_WORSE_THAN, either(chance, excess_loss(pair, base, best))

    return decide(tests(), Reason.INSEPARABLE_FROM, place_name(best.candidate))


def is_simpler_and_as_good(simpler: CandidateFit, best: CandidateFit) -> Decision:
    """Kept if a candidate has fewer parameters, gains nearly what the best does, and is not beaten by it."""

    def tests() -> Iterator[Test]:
        fewer = criterion("parameters", len(simpler.candidate.null), "<", len(best.candidate.null))
        yield Reason.MORE_PARAMETERS_THAN, fewer
        least = _NEARLY * best.comparison.gain
        yield Reason.EXPLAINS_LESS_THAN, criterion("held-out gain", simpler.comparison.gain, ">", least)
        yield Reason.NOT_SIGNIFICANT, criterion("p-value", simpler.comparison.p_value, "<", ALPHA)
        worse = paired_p(simpler.fit.held_out, best.fit.held_out)
        yield Reason.FITS_WORSE_THAN, criterion("p of being no worse", worse, ">", RIVAL_ALPHA)

    return decide(tests(), beside=place_name(best.candidate))


def is_as_good(rival: CandidateFit, best: CandidateFit) -> Decision:
    """Kept unless the best leaves less than the rival, beyond chance and by more than smoothing may do."""
    ahead = compare(rival.fit.held_out, best.fit.held_out)
    alternatives = [
        criterion("p of being no worse", ahead.p_value, ">=", RIVAL_ALPHA),
        excess_loss(rival.fit, best.fit, best),
    ]
    if are_confusable(rival.candidate, best.candidate):
        alternatives.append(criterion("gain of the other over it", ahead.gain, "<", _CONFUSABLE_AHEAD))
    return decide(
        [(Reason.FITS_WORSE_THAN, either(*alternatives))], Reason.INSEPARABLE_FROM, place_name(best.candidate)
    )


def excess_loss(rival: Fit, better: Fit, best: CandidateFit) -> Criterion:
    """What `rival` leaves beyond `better`, at most what smoothing may do of what is left and of what `best` takes.

    Readings and inputs are shifted and smoothed on the way to either: that errs with the size of what is hidden.
    """
    left, least = float(rival.held_out.mean()), float(better.held_out.mean())
    gain = min(best.comparison.gain, 0.999)
    taken = float(best.fit.held_out.mean()) * gain / (1.0 - gain)
    return criterion("loss beyond the other's", left - least, "<=", max(AHEAD_GAIN * left, _SMOOTHED * taken))


def inseparable(
    errors: Errors, best: CandidateFit, tried: Sequence[CandidateFit]
) -> list[tuple[CandidateFit, Decision]]:
    """Each rival of the best with the decision whether it does as well and the best adds nothing on top of it."""
    return [(rival, is_inseparable(errors, best, rival)) for rival in tried if rival is not best]


def is_inseparable(errors: Errors, best: CandidateFit, rival: CandidateFit) -> Decision:
    """Kept if a rival does as well as the best, and the best adds nothing on top of it.

    A richer law that does no better has had its chance, as has a much richer one of another kind; known doubles stay in
    doubt.
    """
    confusable = are_confusable(rival.candidate, best.candidate)

    def tests() -> Iterator[Test]:
        gain, least = rival.comparison.gain, _RIVAL_SHARE * best.comparison.gain
        yield Reason.EXPLAINS_LESS_THAN, criterion("held-out gain", gain, ">=", least)
        yield from ((Reason.FITS_WORSE_THAN, c) for c in is_as_good(rival, best).criteria)
        kin = rival.candidate.effect.family == best.candidate.effect.family
        richer = len(rival.candidate.null) > len(best.candidate.null) + (0 if kin else _RICHER)
        if richer and rival.candidate.effect.name not in {c.effect for c in best.candidate.effect.confusables}:
            more = criterion("share of its held-out gain", _NEARLY * gain, ">", best.comparison.gain)
            yield Reason.MORE_PARAMETERS_THAN, more
        both = extend(errors, rival.fit, best.candidate, [best.fit.model[-1].values, best.candidate.start])
        over_rival = compare(rival.fit.held_out, both.held_out)
        p_value = criterion("p of the other on top of it", combined_p_value(over_rival, both), ">=", ALPHA)
        alternatives = [p_value, excess_loss(rival.fit, both, best)]
        if confusable:
            alternatives.append(criterion("gain of the other on top of it", over_rival.gain, "<", _CONFUSABLE_AHEAD))
        yield Reason.INCOMPLETE_WITHOUT, either(*alternatives)

    return decide(tests(), Reason.INSEPARABLE_FROM, place_name(best.candidate))
