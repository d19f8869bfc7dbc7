"""Which effects the held-out trials ask for, one after another (forward selection), and which they cannot tell apart.

The null is the declared model with its nuisances refitted, never the default. A candidate is judged on trials that it
was not fitted on, paired by trial, with Holm's correction over all candidates of a round.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.model import FloatArray
from simgap.fit import Fit, fit
from simgap.problem import Candidate, DirectEstimate, Model, Problem, View
from simgap.score import Comparison, adjusted, compare, trial_losses
from simgap.splits import Trials

LEVEL = 0.01  # chance of one false name per round
LEAST_GAIN = 0.01  # a share of the error below which an effect is not worth a name
MOST_EFFECTS = 4
RIVAL_SHARE = 0.5  # a rival explains at least this share of what the best explains
Map = Callable[[Callable[[Candidate], "Trial"], Iterable[Candidate]], Iterable["Trial"]]


@dataclass(frozen=True)
class Trial:
    """One candidate tried on top of a base model: its fit, and how it does on the trials that judge."""

    candidate: Candidate
    fit: Fit
    comparison: Comparison
    losses: FloatArray
    direct: DirectEstimate | None
    delta_bic: float


@dataclass(frozen=True)
class Round:
    """All candidates tried on one base, best first; `p_adjusted` beside them."""

    tried: tuple[Trial, ...]
    p_adjusted: tuple[float, ...]


@dataclass(frozen=True)
class Selection:
    """The null, the rounds, the accepted trials in order, and per accepted one its inseparable rivals."""

    null: Fit
    null_losses: FloatArray
    rounds: tuple[Round, ...]
    accepted: tuple[Trial, ...]
    rivals: tuple[tuple[Trial, ...], ...]
    final: Fit
    final_losses: FloatArray
    scale: FloatArray


def select(problem: Problem, trials: Trials, view: View, each: Map | None = None) -> Selection:
    """Null refit, then the best candidate of each round as long as it gains beyond chance and beyond the noise."""
    each = each or (lambda work, items: map(work, items))
    scale = np.maximum(problem.noise_floor(trials.train, view), 1e-12)
    nuisances = problem.nuisances()
    null = fit(problem, (), nuisances, trials.train, view, scale)
    null_losses = _judged(problem, null.model, trials.test, view, scale)
    base, losses = null, null_losses
    rounds: list[Round] = []
    accepted: list[Trial] = []
    rivals: list[tuple[Trial, ...]] = []
    while len(accepted) < MOST_EFFECTS:
        taken = {t.candidate.key for t in base.model}
        free = [c for c in problem.candidates() if c.key not in taken]
        work = _work(problem, base, losses, trials, view, scale)
        tried = sorted(each(work, free), key=lambda t: (-t.comparison.gain, t.candidate.key))
        p = adjusted([t.comparison.p_value for t in tried])
        rounds.append(Round(tuple(tried), tuple(float(v) for v in p)))
        passing = [t for t, value in zip(tried, p, strict=True) if value < LEVEL and t.comparison.gain > LEAST_GAIN]
        if not passing:
            break
        best = passing[0]
        rivals.append(_inseparable(problem, base, best, tried, trials, view, scale))
        accepted.append(best)
        base = fit(problem, (), _warm(best.fit.model), trials.train, view, scale)
        losses = _judged(problem, base.model, trials.test, view, scale)
    return Selection(null, null_losses, tuple(rounds), tuple(accepted), tuple(rivals), base, losses, scale)


def _judged(problem: Problem, model: Model, trials: Sequence[str], view: View, scale: FloatArray) -> FloatArray:
    return trial_losses(problem.residuals(model, trials, view), scale)


def _work(
    problem: Problem, base: Fit, base_losses: FloatArray, trials: Trials, view: View, scale: FloatArray
) -> Callable[[Candidate], Trial]:
    """The trial of one candidate on `base`."""

    def tried(candidate: Candidate) -> Trial:
        direct = problem.direct(candidate, base.model, trials.train)
        fitted = fit(problem, base.model, [_informed(candidate, direct)], trials.train, view, scale)
        losses = _judged(problem, fitted.model, trials.test, view, scale)
        return Trial(candidate, fitted, compare(base_losses, losses), losses, direct, _delta_bic(base, fitted))

    return tried


def _informed(candidate: Candidate, direct: DirectEstimate | None) -> Candidate:
    """The candidate with its search started where the direct estimate points."""
    if direct is None:
        return candidate
    start = {
        name: float(np.clip(direct.values.get(name, value), *candidate.bounds[name]))
        for name, value in candidate.start.items()
    }
    return replace(candidate, start=start)


def _delta_bic(base: Fit, fitted: Fit) -> float:
    """BIC of the base minus BIC with the effect; trials are the samples."""
    n = len(base.losses)
    extra = len(fitted.model[-1].values)
    return float(n * np.log(max(base.losses.mean(), 1e-12) / max(fitted.losses.mean(), 1e-12)) - extra * np.log(n))


def _inseparable(
    problem: Problem, base: Fit, best: Trial, tried: Sequence[Trial], trials: Trials, view: View, scale: FloatArray
) -> tuple[Trial, ...]:
    """Rivals that explain the judging trials as well as the best, and on top of which the best adds nothing."""
    found = []
    for rival in tried:
        if rival is best or rival.comparison.gain < RIVAL_SHARE * best.comparison.gain:
            continue
        both = fit(problem, rival.fit.model, [_informed(best.candidate, best.direct)], trials.train, view, scale)
        losses = _judged(problem, both.model, trials.test, view, scale)
        over_rival = compare(rival.losses, losses)
        if over_rival.p_value < LEVEL and over_rival.gain > LEAST_GAIN:
            continue
        found.append(rival)
    return tuple(found)


def _warm(model: Model) -> list[Candidate]:
    """Terms as candidates that start at their present values."""
    return [replace(t.candidate, start=t.values) for t in model]
