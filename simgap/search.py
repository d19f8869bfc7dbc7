"""Which effects the trials ask for, one after another (forward selection), and which they cannot tell apart.

The null is the declared model with its nuisances refitted, never the default. Every training trial is judged once by
parameters that the others taught; gains are paired by trial, with Holm's correction over all candidates of a round.
The test trials have the last word: an effect that makes them worse is not taken.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from schemas.model import FloatArray
from simgap.fit import Errors, Fit, extend, fit, promising, rollout_errors, spread
from simgap.numerics import Numerics, numerics
from simgap.problem import Candidate, DirectEstimate, Farsighted, Problem, Term, View, around
from simgap.score import LITTLE, Comparison, adjusted, change, compare, met_p, paired_p, trial_losses
from simgap.splits import Trials

LEVEL = 0.05  # chance of one false name per round; the direct route and the test trials must agree besides
LEAST_GAIN = 0.04  # a share of the loss (half of it of the error), or of the noise, below which no effect has a name
MOST_EFFECTS = 4
RIVAL_SHARE = 0.5  # a rival explains at least this share of what the best explains
AS_GOOD = 0.05  # level at which the best beats another
_FINALISTS = 6
_LITTLE_MORE = 2.0  # times what the best leaves: what leaves more was no match for it
_TOLD = 3  # finalists by direct estimates
_SHOWS = 0.3  # chance below which a quick look is followed by a long one
_SCREEN_STEPS = 2
AHEAD_GAIN = 0.05  # share of a rival's error by which the best must be ahead: less can be the smoothing
_SMOOTHED = 0.002  # share of what the best takes away by which it must be ahead
_NEARLY = 0.9  # share of the gain with which fewer parameters are preferred
_REPLACED = 0.25  # share of its strength at which an accepted effect counts as gone
_RICHER = 1  # parameters more that a rival of another kind may have: a spring has a rest beside its stiffness
_AHEAD = 3  # candidates that are tried in pairs
_NOT_JUDGED = Comparison(0.0, (0.0, 0.0), 1.0)
Map = Callable[[Callable[[Candidate], "Trial"], Iterable[Candidate]], Iterable["Trial"]]


@dataclass(frozen=True)
class Trial:
    """One candidate tried on top of a base model: its fit, and how it does on training trials held out in turn."""

    candidate: Candidate
    fit: Fit
    comparison: Comparison
    direct: DirectEstimate | None
    delta_bic: float


@dataclass(frozen=True)
class Round:
    """All candidates tried on one base, best first; `p_adjusted` beside them."""

    tried: tuple[Trial, ...]
    p_adjusted: tuple[float, ...]


@dataclass(frozen=True)
class Selection:
    """The null, the rounds, the accepted trials in order, and per accepted one its inseparable rivals.

    Losses are those of the test trials; `numerics` what the method finds of each accepted effect where it is not.
    """

    null: Fit
    null_losses: FloatArray
    rounds: tuple[Round, ...]
    accepted: tuple[Trial, ...]
    rivals: tuple[tuple[Trial, ...], ...]
    numerics: tuple[Numerics, ...]
    final: Fit
    final_losses: FloatArray
    scale: FloatArray


def select(
    problem: Problem, trials: Trials, view: View, each: Map | None = None, most: int = MOST_EFFECTS
) -> Selection:
    """Null refit, then the best candidate of each round as long as it gains beyond chance and beyond the noise.

    At most so many effects are taken: 0 for the null alone.
    """
    each = each or (lambda work, items: map(work, items))
    first = spread(problem, (), trials.train, view)
    base = fit(rollout_errors(problem, trials.train, view, first), problem.nuisances())
    null = base
    rounds: list[Round] = []
    accepted: list[Trial] = []
    rivals: list[tuple[Trial, ...]] = []
    beside: list[Numerics] = []
    swaps = 0
    while True:
        here = around(problem, base.model)
        # What was an outlier to a poor model is evidence to a better one: the level follows the base.
        level = spread(here, base.model, trials.train, view)
        errors = rollout_errors(here, trials.train, view, level)
        base = fit(errors, _warm(base))
        null = null if accepted else base
        for place in range(len(accepted)):
            # What was chosen before the others were known is asked again beside them.
            before = {r.candidate.key for r in rivals[place]}
            others = _near(accepted[place], rounds[place], before, base)
            if not others:
                continue
            kept, best, these = _beside_others(here, trials, errors, base, accepted[place], others)
            still = tuple(t for t in these if t.candidate.key in before and t is not best and not _beaten(t, best))
            fresh = (t for t in _inseparable(errors, best, these) if t.candidate.key not in before)
            rivals[place] = (*still, *fresh)
            if best.candidate.key == accepted[place].candidate.key:
                continue
            made_up = numerics(here, trials.train, view, kept.model, best.fit.model)
            if _exceeds(best, made_up):
                accepted[place], beside[place], base = best, made_up, best.fit
                rounds[place] = _with(rounds[place], best)
        if len(accepted) == most:
            break
        taken = {c.key for c in base.free}
        free = [c for c in problem.candidates() if c.key not in taken]
        farther = view != "short_horizon"
        near = _nearby(here, trials, base) if farther else (errors, base)
        this = _round(base, errors, list(each(_screening(here, *near, trials), free)), farther)
        instead = _instead(this, base, accepted) if swaps < most else None
        if instead is not None:
            # What does the work of an accepted effect, and more, is tried in its place before anything is added.
            place, trial = instead
            kept, best, _ = _beside_others(here, trials, errors, base, accepted[place], [trial])
            made_up = numerics(here, trials.train, view, kept.model, best.fit.model)
            if best.candidate.key == trial.candidate.key and _exceeds(best, made_up):
                rivals[place] = tuple(r for r in rivals[place] if r.candidate.key != trial.candidate.key)
                rounds[place] = _with(rounds[place], best)
                accepted[place], beside[place], base, swaps = best, made_up, best.fit, swaps + 1
                continue
        rounds.append(this)
        for place, found in enumerate(accepted):
            rivals[place] = (*rivals[place], *_in_its_place(this, base, found, rivals[place]))
        before = _judged(here, base, trials, view, level)
        worthy = _looking_ahead(errors, _worthy(this, base))
        confirmed = (t for t in worthy if _confirmed(base, t, before, _judged(here, t.fit, trials, view, level)))
        asked = ((t, numerics(here, trials.train, view, base.model, t.fit.model)) for t in confirmed)
        best, made_up = next(((t, n) for t, n in asked if _exceeds(t, n)), (None, Numerics()))
        if best is None:
            break
        rivals.append(_inseparable(errors, best, this.tried))
        accepted.append(best)
        beside.append(made_up)
        base = best.fit
    last = around(problem, base.model)
    scale = spread(last, null.model, trials.train, view)
    null_losses, losses = (_judged(last, f, trials, view, scale) for f in (null, base))
    return Selection(
        null, null_losses, tuple(rounds), tuple(accepted), tuple(rivals), tuple(beside), base, losses, scale
    )


def _judged(problem: Problem, found: Fit, trials: Trials, view: View, level: FloatArray) -> FloatArray:
    """(n,) losses of the test trials."""
    return trial_losses(problem.residuals(found.model, trials.test, view), level)


def _beside_others(
    problem: Problem, trials: Trials, errors: Errors, base: Fit, found: Trial, others: Sequence[Trial]
) -> tuple[Fit, Trial, list[Trial]]:
    """The model without one accepted effect, the best in its place, and it and `others` tried there, best first.

    Another takes the place of what was found only if it is better beyond chance, or simpler and no worse.
    """
    kept = fit(errors, [c for c in _warm(base) if c.key != found.candidate.key])
    now = {t.candidate.key: t.values for t in base.model}
    tried = []
    for t in (found, *others):
        starts = [now.get(t.candidate.key, t.fit.model[-1].values), t.fit.model[-1].values]
        direct = problem.direct(t.candidate, kept.model, trials.train)
        tried.append(_trial(kept, extend(errors, kept, t.candidate, starts), direct))
    same = next(t for t in tried if t.candidate.key == found.candidate.key)
    tried.sort(key=lambda t: (-t.comparison.gain, t.candidate.key))
    best = tried[0] if _beaten(same, tried[0]) else same
    simpler = (t for t in tried if len(t.candidate.null) < len(best.candidate.null) and not _beaten(t, best))
    return kept, next(simpler, best), tried


def _near(found: Trial, this: Round, rivals: Collection[str], base: Fit) -> list[Trial]:
    """What may stand in the place of an accepted effect: its rivals, and all that left little more than it did."""
    taken = {c.key for c in base.free}
    most = _LITTLE_MORE * float(found.fit.held_out.sum())
    free = (t for t in this.tried if t.candidate.key not in taken)
    near = [
        t for t in free if t.candidate.key in rivals or (t.comparison.gain > 0.0 and float(t.fit.held_out.sum()) < most)
    ]
    return near[: _FINALISTS - 1]


def _with(this: Round, best: Trial) -> Round:
    return replace(this, tried=tuple(best if t.candidate.key == best.candidate.key else t for t in this.tried))


def _nearby(problem: Problem, trials: Trials, base: Fit) -> tuple[Errors, Fit]:
    """The base on short horizons: enough to see which candidates are worth long ones."""
    view = "short_horizon"
    errors = rollout_errors(problem, trials.train, view, spread(problem, base.model, trials.train, view))
    return errors, fit(errors, _warm(base))


def _screening(problem: Problem, errors: Errors, base: Fit, trials: Trials) -> Callable[[Candidate], Trial]:
    """A quick trial of one candidate: from where the direct estimate points, a step or two."""

    def tried(candidate: Candidate) -> Trial:
        direct = problem.direct(candidate, base.model, trials.train)
        if direct is None and isinstance(problem, Farsighted):
            starts = [dict(candidate.start)]  # Its direct route scans the whole range and found no trace.
        elif direct is None:
            starts = promising(errors, base, candidate)
        else:
            starts = [direct.values, {**direct.values, **_strengths(candidate)}]
        return _trial(base, extend(errors, base, candidate, starts, _SCREEN_STEPS), direct)

    return tried


def _strengths(candidate: Candidate) -> dict[str, float]:
    return {n: v for n, v in candidate.null.items() if n not in candidate.shapes}


def _trial(base: Fit, extended: Fit, direct: DirectEstimate | None) -> Trial:
    comparison = compare(base.held_out, extended.held_out)
    if extended.free[-1].probes:
        comparison = replace(comparison, p_value=met_p(base.held_out, extended.held_out))
    comparison = replace(comparison, p_value=_chance(comparison, extended))
    return Trial(extended.free[-1], extended, comparison, direct, _delta_bic(base, extended))


def _chance(comparison: Comparison, extended: Fit) -> float:
    """Chance of such evidence without the effect, by held-out losses or by the strength itself: two looks, so twice."""
    return min(1.0, 2.0 * min(comparison.p_value, extended.p_value))


def _round(base: Fit, errors: Errors, screened: list[Trial], farther: bool) -> Round:
    """The most promising ones, by their quick trial or by their direct estimate, fitted to the end; best first.

    Where both say that chance does as well, no more is asked. What was screened on shorter horizons than it is judged
    on (`farther`) and is no finalist has not been judged: it counts as no gain.
    """
    order = sorted(screened, key=lambda t: (-t.comparison.gain, t.candidate.key))
    told = sorted(order, key=_told)
    finalists = {t.candidate.key for t in (*order[:_FINALISTS], *told[:_TOLD]) if _shows(t)}
    tried = []
    for t in order:
        if t.candidate.key in finalists:
            tried.append(_trial(base, extend(errors, base, t.candidate, _begun(t)), t.direct))
        else:
            tried.append(replace(t, comparison=_NOT_JUDGED, delta_bic=0.0) if farther else t)
    tried.sort(key=lambda t: (-t.comparison.gain, t.candidate.key))
    p = adjusted([t.comparison.p_value for t in tried])
    return Round(tuple(tried), tuple(float(v) for v in p))


def _shows(found: Trial) -> bool:
    direct = 1.0 if found.direct is None else found.direct.p_value
    return min(direct, found.comparison.p_value) < _SHOWS


def _told(found: Trial) -> float:
    """What the direct estimate leaves of the loss."""
    direct = found.direct
    return np.inf if direct is None or direct.held_out is None else float(direct.held_out.sum())


def _begun(found: Trial) -> list[dict[str, float]]:
    """Where a fit to the end begins."""
    quick = found.fit.model[-1].values
    return [quick] if found.direct is None or found.direct.values == quick else [quick, found.direct.values]


def _worthy(this: Round, base: Fit) -> list[Trial]:
    """Significant candidates by gain whose values differ from none.

    Before each of them comes any that has fewer parameters and is not beaten by it.

    The simpler one need not pass the correction itself: what it competes with has passed.
    """
    ordered: list[Trial] = []
    for trial, p in zip(this.tried, this.p_adjusted, strict=True):
        removed = trial.comparison.gain * min(1.0, float(base.held_out.mean()))  # of what is left, or of the noise
        if p >= LEVEL or removed <= LEAST_GAIN or not trial.fit.stands_out({}) or _takes_a_place(trial.fit, base):
            continue
        simpler = [t for t in this.tried if len(t.candidate.null) < len(trial.candidate.null) and _rivals(t, trial)]
        ordered += [t for t in (*simpler, trial) if t not in ordered]
    return ordered


def _instead(this: Round, base: Fit, accepted: Sequence[Trial]) -> tuple[int, Trial] | None:
    """The best of a round where an accepted effect all but vanishes beside it, and the place of that effect."""
    if not this.tried or this.p_adjusted[0] >= LEVEL or this.tried[0].comparison.gain <= LEAST_GAIN:
        return None
    best = this.tried[0]
    for place, found in enumerate(accepted):
        term = next(t for t in base.model if t.candidate.key == found.candidate.key)
        if best.fit.stands_out({}) and _vanishes(term, best.fit):
            return place, best
    return None


def _takes_a_place(extended: Fit, base: Fit) -> bool:
    """Whether an effect accepted before all but vanishes beside the new one: that is another name, not one more."""
    return any(_vanishes(term, extended) for term in base.model)


def _vanishes(term: Term, extended: Fit) -> bool:
    now = next((t for t in extended.model if t.candidate.key == term.candidate.key), None)
    if now is None or term.candidate.nuisance:
        return False
    null = term.candidate.null
    names = [n for n in term.values if n not in term.candidate.shapes]
    return all(abs(now.values[n] - null[n]) < _REPLACED * abs(term.values[n] - null[n]) for n in names)


def _in_its_place(this: Round, base: Fit, found: Trial, known: Sequence[Trial]) -> list[Trial]:
    """Significant candidates beside which what was found before all but vanishes: they may be what it is."""
    term = next(t for t in base.model if t.candidate.key == found.candidate.key)
    taken = {t.candidate.key for t in known}
    return [
        trial
        for trial, p in zip(this.tried, this.p_adjusted, strict=True)
        if p < LEVEL and trial.candidate.key not in taken and _vanishes(term, trial.fit)
    ]


def _rivals(simpler: Trial, best: Trial) -> bool:
    near = simpler.comparison.gain > _NEARLY * best.comparison.gain
    return near and simpler.comparison.p_value < LEVEL and paired_p(simpler.fit.held_out, best.fit.held_out) > AS_GOOD


def _looking_ahead(errors: Errors, worthy: list[Trial]) -> list[Trial]:
    """The same candidates, but one law that does the work of two comes after the better of the two.

    Two causes together are often mimicked best by a third that is neither; with a second term the mimic falls behind.
    """
    few = sorted(worthy, key=lambda t: -t.comparison.gain)[:_AHEAD]
    if len(few) < 3:
        return worthy
    pairs = [
        (a, b, extend(errors, a.fit, b.candidate, [b.fit.model[-1].values, b.candidate.start], 3))
        for a, b in combinations(few, 2)
    ]
    best_of_all = min(pairs, key=lambda p: p[2].held_out.sum())
    with_first = min((p for p in pairs if worthy[0] in p[:2]), key=lambda p: p[2].held_out.sum(), default=None)
    if with_first is None or paired_p(with_first[2].held_out, best_of_all[2].held_out) > AS_GOOD:
        return worthy
    ahead = max(best_of_all[:2], key=lambda t: t.comparison.gain)
    return [ahead, *(t for t in worthy if t is not ahead)]


def _exceeds(found: Trial, made_up: Numerics) -> bool:
    return found.fit.stands_out(made_up.fitted) and found.comparison.gain > made_up.gain


def _confirmed(base: Fit, found: Trial, before: FloatArray, after: FloatArray) -> bool:
    """Whether the test trials do better with it; if all of them stay away from a threshold they have nothing to say."""
    largest = float(change(base.held_out, found.fit.held_out).max())
    if found.candidate.probes and float(change(before, after).max()) < LITTLE * largest:
        return True
    return bool(after.sum() < (1.0 - 0.5 * LEAST_GAIN) * before.sum())


def _delta_bic(base: Fit, fitted: Fit) -> float:
    """BIC of the base minus BIC with the effect; trials are the samples."""
    n = len(base.losses)
    extra = len(fitted.free[-1].null)
    return float(n * np.log(max(base.losses.mean(), 1e-12) / max(fitted.losses.mean(), 1e-12)) - extra * np.log(n))


def _beaten(rival: Trial, best: Trial) -> bool:
    """Whether the best leaves less than the rival, beyond chance and by more than smoothing may do."""
    ahead = compare(rival.fit.held_out, best.fit.held_out)
    return ahead.p_value < AS_GOOD and _ahead(rival.fit, best.fit, best)


def _ahead(rival: Fit, better: Fit, best: Trial) -> bool:
    """Whether `better` leaves less than `rival` by more than smoothing may do, of what is left and what `best` takes.

    Readings and inputs are shifted and smoothed on the way to either: that errs with the size of what is hidden.
    """
    left, least = float(rival.held_out.mean()), float(better.held_out.mean())
    gain = min(best.comparison.gain, 0.999)
    taken = float(best.fit.held_out.mean()) * gain / (1.0 - gain)
    return left - least > max(AHEAD_GAIN * left, _SMOOTHED * taken)


def _inseparable(errors: Errors, best: Trial, tried: Sequence[Trial]) -> tuple[Trial, ...]:
    """Rivals that do as well as the best, and on top of which the best adds nothing."""
    found = []
    for rival in tried:
        if rival is best or rival.comparison.gain < RIVAL_SHARE * best.comparison.gain:
            continue
        if _beaten(rival, best):
            continue
        # A richer law that does no better has had its chance, as has a much richer one of another kind; known doubles
        # stay in doubt.
        doubles = {c.effect for c in best.candidate.effect.confusables}
        kin = rival.candidate.effect.family == best.candidate.effect.family
        richer = len(rival.candidate.null) > len(best.candidate.null) + (0 if kin else _RICHER)
        does_better = _NEARLY * rival.comparison.gain > best.comparison.gain
        if richer and not does_better and rival.candidate.effect.name not in doubles:
            continue
        both = extend(errors, rival.fit, best.candidate, [best.fit.model[-1].values, best.candidate.start])
        over_rival = compare(rival.fit.held_out, both.held_out)
        if _chance(over_rival, both) < LEVEL and _ahead(rival.fit, both, best):
            continue
        found.append(rival)
    return tuple(found)


def _warm(found: Fit) -> list[Candidate]:
    """Terms as candidates that start at their present values."""
    return [replace(t.candidate, start=t.values) for t in found.model]
