"""Forward selection: which effects the trials need, one after another, and which cannot be distinguished.

The null is the declared model with its nuisances refitted, never the default. Every training trial is judged once by
parameters that the others taught; gains are paired by trial, with Holm's correction over all candidates of a round.
The test trials have the last word: they must do better, in sum or typically.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from schemas.arrays import FloatArray
from simgap.inference.candidate_fit import ALPHA, CandidateFit, Map, Screening, least_gain, warm_start_without
from simgap.inference.competing_hypotheses import (
    RIVAL_ALPHA,
    alternatives,
    as_good_with_confusable,
    inseparable,
    is_beaten,
    possible_replacements,
    refit_beside_others,
    replacement,
    replaces_an_effect,
    simpler_and_as_good,
)
from simgap.inference.direct_comparison import distinguishes
from simgap.inference.fit import Errors, Fit, extend, fit, robust_scale, rollout_errors
from simgap.inference.losses import LARGEST_LOG_CHANGE, LITTLE, log_loss_change, paired_p, trial_losses
from simgap.inference.parametric_bootstrap import MethodBias, estimate_method_bias
from simgap.inference.screening import screen
from simgap.inference.search_state import SearchState, refit_at
from simgap.problem import Problem, View, with_initial_states_at
from simgap.recording.train_test_split import Trials

MOST_EFFECTS = 4
_AHEAD = 3  # candidates that are tried in pairs
_TINY = 1e-12


@dataclass(frozen=True)
class Accepted:
    """An effect that was taken.

    p_adjusted   its p-value, adjusted over all candidates of its `screening`.
    rivals       candidates that the trials do not separate from it.
    method_bias  estimate of it on data simulated without it.
    removed      loss that comes back without it, as a share of what is left in the end.
    """

    candidate_fit: CandidateFit
    screening: Screening
    p_adjusted: float
    rivals: tuple[CandidateFit, ...]
    method_bias: MethodBias
    removed: float = np.inf

    @property
    def key(self) -> str:
        """Of its candidate."""
        return self.candidate_fit.candidate.key


@dataclass(frozen=True)
class Selection:
    """The null, the accepted effects in order, the last screening if it added none, and the final model.

    Losses are those of the test trials, in errors of `scale`.
    """

    null: Fit
    null_losses: FloatArray
    accepted: tuple[Accepted, ...]
    undecided: Screening | None
    final: Fit
    final_losses: FloatArray
    scale: FloatArray

    @property
    def screenings(self) -> tuple[Screening, ...]:
        """One per accepted effect, and the last if none was taken there."""
        return (*(a.screening for a in self.accepted), *([self.undecided] if self.undecided else []))


def select(
    problem: Problem, trials: Trials, view: View, each: Map | None = None, most: int = MOST_EFFECTS
) -> Selection:
    """Null refit, then the best candidate of each screening while its gain is significant and above the least gain.

    At most `most` effects are accepted: 0 gives the null alone.
    """
    each = each or (lambda work, items: map(work, items))
    level = robust_scale(problem, (), trials.train, view)
    state = refit_at(
        problem, trials, view, fit(rollout_errors(problem, trials.train, view, level), problem.nuisances())
    )
    null = state.base
    accepted: list[Accepted] = []
    undecided: Screening | None = None
    swaps = 0
    while True:
        for _ in accepted:  # What takes a place changes what the others stand beside.
            before = [a.key for a in accepted]
            for place in range(len(accepted)):
                state, accepted[place] = _tested_again(state, accepted[place], each)
            if before == [a.key for a in accepted]:
                break
        if len(accepted) == most:
            break
        taken = {c.key for c in state.base.free}
        screening = screen(state, [c for c in problem.candidates() if c.key not in taken], each)
        swapped = _swapped(state, screening, accepted, each) if swaps < most else None
        if swapped is not None:
            place, accepted[place] = swapped
            state, swaps = refit_at(problem, trials, view, accepted[place].candidate_fit.fit), swaps + 1
            continue
        accepted = [
            replace(a, rivals=(*a.rivals, *possible_replacements(screening, state.base, a.candidate_fit, a.rivals)))
            for a in accepted
        ]
        found = _next_accepted(state, screening)
        if found is None:
            undecided = screening
            break
        accepted.append(found)
        state = refit_at(problem, trials, view, found.candidate_fit.fit)
    accepted = [replace(a, removed=_removed(state, a)) for a in _with_rivals_beside_confusable(state, accepted)]
    last = with_initial_states_at(problem, state.base.model)
    scale = robust_scale(last, null.model, trials.train, view)
    null_losses, losses = (trial_losses(last.residuals(f.model, trials.test, view), scale) for f in (null, state.base))
    return Selection(null, null_losses, tuple(accepted), undecided, state.base, losses, scale)


def _tested_again(state: SearchState, accepted: Accepted, each: Map) -> tuple[SearchState, Accepted]:
    """What was chosen before the others were known, fitted again beside them; the base follows a better one.

    Effects accepted since are no rivals any more; rivals that are not fitted again stay.
    """
    taken = {c.key for c in state.base.free}
    accepted = replace(accepted, rivals=tuple(r for r in accepted.rivals if r.candidate.key not in taken))
    before = {r.candidate.key for r in accepted.rivals}
    others = alternatives(accepted.candidate_fit, accepted.screening, before, state.base)
    if not others:
        return state, accepted
    without, best, tried = refit_beside_others(state, accepted.candidate_fit, others, each)
    method_bias = accepted.method_bias
    if best.candidate.key != accepted.key:
        method_bias = estimate_method_bias(state.problem, state.trials.train, state.view, without.model, best.fit.model)
        if not _exceeds(best, method_bias):
            best = next(t for t in tried if t.candidate.key == accepted.key)
    tried_keys = {t.candidate.key for t in tried}
    untried = (r for r in accepted.rivals if r.candidate.key not in tried_keys)
    still = (t for t in tried if t.candidate.key in before and t is not best and not is_beaten(t, best))
    fresh = (t for t in inseparable(state.errors, best, tried) if t.candidate.key not in before)
    accepted = replace(accepted, rivals=(*untried, *still, *fresh))
    if best.candidate.key == accepted.key:
        return state, accepted
    return replace(state, base=best.fit), _in_place(accepted, best, method_bias)


def _swapped(
    state: SearchState, screening: Screening, accepted: Sequence[Accepted], each: Map
) -> tuple[int, Accepted] | None:
    """The replacement of an accepted effect by a candidate that makes it vanish; tried before an effect is added."""
    instead = replacement(screening, state.base, [a.candidate_fit for a in accepted])
    if instead is None:
        return None
    place, trial = instead
    replaced = accepted[place]
    without, best, _ = refit_beside_others(state, replaced.candidate_fit, [trial], each)
    method_bias = estimate_method_bias(state.problem, state.trials.train, state.view, without.model, best.fit.model)
    if best.candidate.key != trial.candidate.key or not _exceeds(best, method_bias):
        return None
    return place, _in_place(replaced, best, method_bias)


def _in_place(replaced: Accepted, best: CandidateFit, method_bias: MethodBias) -> Accepted:
    """Another effect in the place of an accepted one, and no longer among its rivals.

    Its p-value is that of its own screening: a replacement is no more certain than it was there.
    """
    key = best.candidate.key
    tried = tuple(best if t.candidate.key == key else t for t in replaced.screening.fits)
    rivals = tuple(r for r in replaced.rivals if r.candidate.key != key)
    return Accepted(best, replace(replaced.screening, fits=tried), replaced.screening.p_of(key), rivals, method_bias)


def _next_accepted(state: SearchState, screening: Screening) -> Accepted | None:
    """The first significant candidate that the test trials confirm and that exceeds the method's bias."""
    losses_before = state.test_losses(state.base)
    for trial in _best_pair_first(state.errors, _significant_candidates(screening, state.base)):
        if not _confirmed(state.base, trial, losses_before, state.test_losses_at_own_fit(trial.fit)):
            continue
        method_bias = estimate_method_bias(
            state.problem, state.trials.train, state.view, state.base.model, trial.fit.model
        )
        if _exceeds(trial, method_bias):
            errors = state.errors_at(trial.fit.model) if trial.candidate.extra_starts else state.errors
            p = screening.p_of(trial.candidate.key)
            return Accepted(trial, screening, p, inseparable(errors, trial, screening.fits), method_bias)
    return None


def _removed(state: SearchState, accepted: Accepted) -> float:
    """Held-out loss that comes back in a refit without it, as a share of what is left with it."""
    without = fit(
        state.errors, warm_start_without(state.base, [accepted.candidate_fit.candidate], state.problem.nuisances())
    )
    return float(without.held_out.sum() / max(state.base.held_out.sum(), _TINY) - 1.0)


def _with_rivals_beside_confusable(state: SearchState, accepted: Sequence[Accepted]) -> list[Accepted]:
    """`accepted` with the further rivals that appear once a confusable effect replaces another accepted effect."""
    out = list(accepted)
    nuisances = state.problem.nuisances()
    for doubted in accepted:
        others = tuple(t for t in state.base.model if t.candidate.key != doubted.key)
        confusables = [
            r
            for r in doubted.rivals
            if not distinguishes(state.problem, doubted.candidate_fit, r, others, state.trials.train)
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
            if best is not doubted and fresh:
                more = as_good_with_confusable(
                    state.errors, state.base, nuisances, doubted.candidate_fit, confusables, best.candidate_fit, fresh
                )
                out[k] = replace(out[k], rivals=(*out[k].rivals, *more))
    return out


def _significant_candidates(screening: Screening, base: Fit) -> list[CandidateFit]:
    """Significant candidates by gain whose values differ from none.

    Before each of them comes any that has fewer parameters and is not beaten by it.

    The simpler one need not pass the correction itself: what it competes with has passed.
    """
    ordered: list[CandidateFit] = []
    for trial, p in zip(screening.fits, screening.p_adjusted, strict=True):
        removed = trial.comparison.gain * min(1.0, float(base.held_out.mean()))  # of what is left, or of the noise
        little = removed <= least_gain(trial.candidate)
        if p >= ALPHA or little or not trial.fit.strength_exceeds({}) or replaces_an_effect(trial.fit, base):
            continue
        simpler = [
            t
            for t in screening.fits
            if len(t.candidate.null) < len(trial.candidate.null) and simpler_and_as_good(t, trial)
        ]
        ordered += [t for t in (*simpler, trial) if t not in ordered]
    return ordered


def _best_pair_first(errors: Errors, worthy: list[CandidateFit]) -> list[CandidateFit]:
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
    if with_first is None or paired_p(with_first[2].held_out, best_of_all[2].held_out) > RIVAL_ALPHA:
        return worthy
    ahead = max(best_of_all[:2], key=lambda t: t.comparison.gain)
    return [ahead, *(t for t in worthy if t is not ahead)]


def _exceeds(candidate_fit: CandidateFit, method_bias: MethodBias) -> bool:
    return candidate_fit.fit.strength_exceeds(method_bias.fitted) and candidate_fit.comparison.gain > method_bias.gain


def _confirmed(base: Fit, candidate_fit: CandidateFit, before: FloatArray, after: FloatArray) -> bool:
    """Whether the test trials do better with it, in sum or typically: one cause of two may leave one trial worse.

    If no test trial reaches a threshold, none of them can contradict it.
    """
    largest = min(float(log_loss_change(base.held_out, candidate_fit.fit.held_out).max()), LARGEST_LOG_CHANGE)
    if candidate_fit.candidate.extra_starts and float(log_loss_change(before, after).max()) < LITTLE * largest:
        return bool(after.sum() < (1.0 + LITTLE) * before.sum())
    typical = np.exp(np.mean(np.log((after + _TINY) / (before + _TINY))))
    return bool(min(typical, after.sum() / before.sum()) < 1.0 - 0.5 * least_gain(candidate_fit.candidate))
