"""Which effects the trials ask for, one after another (forward selection), and which they cannot tell apart.

The null is the declared model with its nuisances refitted, never the default. Every training trial is judged once by
parameters that the others taught; gains are paired by trial, with Holm's correction over all candidates of a round.
The test trials have the last word: an effect that makes them worse is not taken.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from schemas.model import FloatArray
from simgap.fit import Errors, Fit, extend, fit, promising, rollout_errors, spread
from simgap.numerics import Numerics, numerics
from simgap.problem import Candidate, Farsighted, Model, Problem, View, around
from simgap.rivals import (
    AS_GOOD,
    RIVAL_SHARE,
    as_good_together,
    beaten,
    beside_others,
    challengers,
    in_its_place,
    inseparable,
    replacement,
    simpler_and_as_good,
    takes_a_place,
)
from simgap.score import CLEAR, LITTLE, Comparison, change, paired_p, trial_losses
from simgap.splits import Trials
from simgap.told_apart import told_apart
from simgap.tried import LEAST_GAIN, LEVEL, Round, Trial, round_of, told_loss, tried_on, warm

MOST_EFFECTS = 4
_FINALISTS = 6
_TOLD = 3  # finalists by direct estimates
_SHOWS = 0.3  # chance below which a quick look is followed by a long one
_SCREEN_STEPS = 2
_AHEAD = 3  # candidates that are tried in pairs
_SETTLING = 2  # times that a threshold's fit is taken up again with starts seen from it
_TINY = 1e-12
_NOT_JUDGED = Comparison(0.0, (0.0, 0.0), 1.0)
Map = Callable[[Callable[[Candidate], Trial], Iterable[Candidate]], Iterable[Trial]]
Look = Callable[[Model], Errors]


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
        base = fit(errors, warm(base))
        null = null if accepted else base
        for place in range(len(accepted)):
            # What was chosen before the others were known is asked again beside them.
            before = {r.candidate.key for r in rivals[place]}
            others = challengers(accepted[place], rounds[place], before, base)
            if not others:
                continue
            kept, best, these = beside_others(here, trials, errors, base, accepted[place], others)
            still = tuple(t for t in these if t.candidate.key in before and t is not best and not beaten(t, best))
            fresh = (t for t in inseparable(errors, best, these) if t.candidate.key not in before)
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
        look = _seen_from(here, trials, view, level)
        this = _round(base, errors, look, list(each(_screening(here, *near, trials), free)), farther)
        instead = replacement(this, base, accepted) if swaps < most else None
        if instead is not None:
            # What does the work of an accepted effect, and more, is tried in its place before anything is added.
            place, trial = instead
            kept, best, _ = beside_others(here, trials, errors, base, accepted[place], [trial])
            made_up = numerics(here, trials.train, view, kept.model, best.fit.model)
            if best.candidate.key == trial.candidate.key and _exceeds(best, made_up):
                rivals[place] = tuple(r for r in rivals[place] if r.candidate.key != trial.candidate.key)
                rounds[place] = _with(rounds[place], best)
                accepted[place], beside[place], base, swaps = best, made_up, best.fit, swaps + 1
                continue
        rounds.append(this)
        for place, found in enumerate(accepted):
            rivals[place] = (*rivals[place], *in_its_place(this, base, found, rivals[place]))
        before = _judged(here, base, trials, view, level)
        worthy = _looking_ahead(errors, _worthy(this, base))
        confirmed = (t for t in worthy if _confirmed(base, t, before, _by_itself(here, t, trials, view, level)))
        asked = ((t, numerics(here, trials.train, view, base.model, t.fit.model)) for t in confirmed)
        best, made_up = next(((t, n) for t, n in asked if _exceeds(t, n)), (None, Numerics()))
        if best is None:
            break
        rivals.append(inseparable(look(best.fit.model) if best.candidate.probes else errors, best, this.tried))
        accepted.append(best)
        beside.append(made_up)
        base = best.fit
    rivals = _with_doubles(here, trials, errors, base, accepted, rounds, rivals)
    last = around(problem, base.model)
    scale = spread(last, null.model, trials.train, view)
    null_losses, losses = (_judged(last, f, trials, view, scale) for f in (null, base))
    return Selection(
        null, null_losses, tuple(rounds), tuple(accepted), tuple(rivals), tuple(beside), base, losses, scale
    )


def _with_doubles(
    problem: Problem,
    trials: Trials,
    errors: Errors,
    base: Fit,
    accepted: Sequence[Trial],
    rounds: Sequence[Round],
    rivals: Sequence[tuple[Trial, ...]],
) -> list[tuple[Trial, ...]]:
    """`rivals`, and those that become such beside a double of another accepted effect."""
    out = list(rivals)
    for place, found in enumerate(accepted):
        others = tuple(t for t in base.model if t.candidate.key != found.candidate.key)
        doubles = [r for r in rivals[place] if not told_apart(problem, found, r, others, trials.train)]
        for k, best in enumerate(accepted) if doubles else ():
            known = {t.candidate.key for t in (*out[k], *doubles, found)}
            fresh = [t for t in challengers(best, rounds[k], (), base) if t.candidate.key not in known]
            if k != place and fresh:
                out[k] = (*out[k], *as_good_together(errors, base, found, doubles, best, fresh))
    return out


def _judged(problem: Problem, found: Fit, trials: Trials, view: View, level: FloatArray) -> FloatArray:
    """(n,) losses of the test trials."""
    return trial_losses(problem.residuals(found.model, trials.test, view), level)


def _by_itself(problem: Problem, found: Trial, trials: Trials, view: View, level: FloatArray) -> FloatArray:
    """(n,) losses of the test trials, seen from the candidate's own model."""
    return _judged(around(problem, found.fit.model), found.fit, trials, view, level)


def _seen_from(problem: Problem, trials: Trials, view: View, level: FloatArray) -> Look:
    """Errors of roll-outs whose starts are taken at a model."""
    return lambda model: rollout_errors(around(problem, model), trials.train, view, level)


def _with(this: Round, best: Trial) -> Round:
    return replace(this, tried=tuple(best if t.candidate.key == best.candidate.key else t for t in this.tried))


def _nearby(problem: Problem, trials: Trials, base: Fit) -> tuple[Errors, Fit]:
    """The base on short horizons: enough to see which candidates are worth long ones."""
    view = "short_horizon"
    errors = rollout_errors(problem, trials.train, view, spread(problem, base.model, trials.train, view))
    return errors, fit(errors, warm(base))


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
        return tried_on(base, extend(errors, base, candidate, starts, _SCREEN_STEPS), direct)

    return tried


def _strengths(candidate: Candidate) -> dict[str, float]:
    return {n: v for n, v in candidate.null.items() if n not in candidate.shapes}


def _settled(base: Fit, found: Trial, look: Look) -> Trial:
    """A candidate's fit taken up again, with starts as they are where its own model leads."""
    fitted = found.fit
    for _ in range(_SETTLING):
        again = fit(look(fitted.model), warm(fitted))
        if again.losses.sum() >= fitted.losses.sum():
            break
        fitted = again
    return found if fitted is found.fit else tried_on(base, fitted, found.direct)


def _seen_by_themselves(base: Fit, finalists: list[Trial], look: Look) -> list[Trial]:
    """Finalists, thresholds among them seen from their own models, and so are all that come near one of those.

    After a blow nothing of what a start does is as it was without one: starts that were taken where nothing was met
    would blame the threshold for what noise does. Where others compete, they are owed the same.
    """
    near = [_settled(base, t, look) if t.candidate.probes else t for t in finalists]
    best = max((t.comparison.gain for t in near if t.candidate.probes), default=1.0)
    rivals = [not t.candidate.probes and t.comparison.gain > RIVAL_SHARE * best for t in near]
    return [_settled(base, t, look) if rival else t for t, rival in zip(near, rivals, strict=True)]


def _round(base: Fit, errors: Errors, look: Look, screened: list[Trial], farther: bool) -> Round:
    """The most promising ones, by their quick trial or by their direct estimate, fitted to the end; best first.

    Where both say that chance does as well, no more is asked. What was screened on shorter horizons than it is judged
    on (`farther`) and is no finalist has not been judged: it counts as no gain.
    """
    order = sorted(screened, key=lambda t: (-t.comparison.gain, t.candidate.key))
    told = sorted(order, key=told_loss)
    finalists = {t.candidate.key for t in (*order[:_FINALISTS], *told[:_TOLD]) if _shows(t)}
    fits = [
        tried_on(base, extend(errors, base, t.candidate, _begun(t)), t.direct)
        for t in order
        if t.candidate.key in finalists
    ]
    others = [t for t in order if t.candidate.key not in finalists]
    unjudged = [replace(t, comparison=_NOT_JUDGED, delta_bic=0.0) if farther else t for t in others]
    return round_of([*(_seen_by_themselves(base, fits, look) if farther else fits), *unjudged])


def _shows(found: Trial) -> bool:
    direct = 1.0 if found.direct is None else found.direct.p_value
    return min(direct, found.comparison.p_value) < _SHOWS


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
        if p >= LEVEL or removed <= LEAST_GAIN or not trial.fit.stands_out({}) or takes_a_place(trial.fit, base):
            continue
        simpler = [
            t for t in this.tried if len(t.candidate.null) < len(trial.candidate.null) and simpler_and_as_good(t, trial)
        ]
        ordered += [t for t in (*simpler, trial) if t not in ordered]
    return ordered


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
    """Whether the test trials do better with it, in sum or typically: one cause of two may leave one trial worse.

    If all of them stay away from a threshold they have nothing to say.
    """
    largest = min(float(change(base.held_out, found.fit.held_out).max()), CLEAR)
    if found.candidate.probes and float(change(before, after).max()) < LITTLE * largest:
        return bool(after.sum() < (1.0 + LITTLE) * before.sum())
    typical = np.exp(np.mean(np.log((after + _TINY) / (before + _TINY))))
    return bool(min(typical, after.sum() / before.sum()) < 1.0 - 0.5 * LEAST_GAIN)
