"""Score tests: how much loss each candidate would take off a fitted model, from one roll-out per probe.

A probe is the candidate at a small strength (or at a threshold); the change of the errors, with starts and the fitted
parameters free beside it, gives the reduction of a linear step and the strength at which it is reached (Rao, 1948).
Harmonic laws are probed by sine and cosine at each count; laws of several strengths in all at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from sim.effects.effect import Scan
from simgap.problem import Candidate, Model, Term, TrialSystem
from simgap.whole_trials.fit_model import ModelFit
from simgap.whole_trials.linearisation import Linearisation, errors_at, solve_safely
from simgap.whole_trials.parameter_space import Space, vector_of

_SMALL_SHARE_OF_RANGE = 0.01  # of a strength's range
_DIGITS = 6  # of a loss
_HALVINGS, _NEAREST = 4, 2  # of the way to the nearest thresholds that were tried


@dataclass(frozen=True)
class Score:
    """A candidate with the loss that a linear step takes off, and values to begin fits from, best first.

    probed   the values, of one group, whose changes gave that loss.
    """

    candidate: Candidate
    reduction: float
    begins: tuple[dict[str, float], ...]
    probed: tuple[dict[str, float], ...]


def scores(
    system: TrialSystem, fit: ModelFit, linear: Linearisation, candidates: Sequence[Candidate]
) -> tuple[Score, ...]:
    """All candidates by their scores beside a fitted model, best first."""
    space, vector = Space.of(fit.model), vector_of(fit.model)
    inside = space.inside(vector)
    span = space.span[inside]
    prior = space.prior_precision[inside] * span**2
    pull = space.prior_precision[inside] * span * (vector - space.prior_mean)[inside]
    base = linear.only(inside)
    probed = ProbedModel.of(system, fit.model, fit.starts)
    ranked = [_score(probed, base, prior, pull, c) for c in candidates]
    return tuple(sorted(ranked, key=lambda s: (-s.reduction, s.candidate.key)))


@dataclass(frozen=True)
class ProbedModel:
    """A model on a system, in its plain steps, with the starts (t, s) and errors (t, n) there."""

    system: TrialSystem
    model: Model
    starts: FloatArray
    errors: FloatArray

    @staticmethod
    def of(system: TrialSystem, model: Model, starts: FloatArray) -> ProbedModel:
        """A model of given values and starts."""
        return ProbedModel(system.plain, model, starts, errors_at(system.plain, model, starts))

    def change(self, term: Term) -> FloatArray:
        """(t, n) change of the errors by a further term; zero where nothing was measured."""
        errors = errors_at(self.system, (*self.model, term), self.starts)
        return np.where(np.isfinite(errors), errors - self.errors, 0.0)


def _score(
    probed: ProbedModel, base: Linearisation, prior: FloatArray, pull: FloatArray, candidate: Candidate
) -> Score:
    if candidate.extra_starts:
        return _threshold_score(probed, base, prior, candidate)
    best: Score | None = None
    for group in _probe_groups(candidate):
        changes = [probed.change(Term(candidate, values)) for values in group]
        equations = base.with_parameters(np.stack(changes, axis=2)).reduced_equations()
        count = len(group)
        total = equations.information.sum(axis=0) + np.diag(np.concatenate([prior, np.zeros(count)]))
        gradient = equations.gradient.sum(axis=0) + np.concatenate([pull, np.zeros(count)])
        move = -solve_safely(total, gradient)
        reduction = float(-gradient @ move)
        without = -solve_safely(total[:-count, :-count], gradient[:-count])
        reduction -= float(-gradient[:-count] @ without)
        if best is None or reduction > best.reduction:
            begins = (_moved(candidate, group, move[-count:]), group[0]) if reduction > 0.0 else ()
            best = Score(candidate, max(reduction, 0.0), begins, tuple(group))
    assert best is not None  # Every candidate is probed.
    return best


def _threshold_score(probed: ProbedModel, base: Linearisation, prior: FloatArray, candidate: Candidate) -> Score:
    """The best of several thresholds, taken as they are, and then of those halfway to its neighbours."""
    before = base.least_loss(prior)
    plain = base.errors / np.sqrt(base.weight)[:, None]

    def reduction(values: dict[str, float]) -> float:
        return before - base.with_errors(plain + probed.change(Term(candidate, values))).least_loss(prior)

    tried = [(_off_null(candidate, start)) for start in candidate.extra_starts]
    # Of thresholds that nothing reaches, all alike, the one nearest to what moves.
    gains = [(round(reduction(v), _DIGITS), _apart(candidate, v, candidate.null), n) for n, v in enumerate(tried)]
    least, _, number = max(gains)
    best = tried[number]
    for _ in range(_HALVINGS):
        nearby = sorted((v for v in tried if v != best), key=lambda v: _apart(candidate, v, best))[:_NEAREST]
        for other in nearby:
            middle = {n: 0.5 * (best[n] + other[n]) for n in best}
            tried.append(middle)
            if (gain := reduction(middle)) > least:
                least, best = gain, middle
    return Score(candidate, max(least, 0.0), (best,) if least > 0.0 else (), (best,))


def _apart(candidate: Candidate, a: dict[str, float], b: dict[str, float]) -> float:
    """Distance of two sets of values, in their ranges."""
    spans = {n: max(high - low, 1e-12) for n, (low, high) in candidate.bounds.items()}
    return sum(abs(a[n] - b[n]) / spans[n] for n in a)


def _moved(candidate: Candidate, group: Sequence[dict[str, float]], shares: FloatArray) -> dict[str, float]:
    """Values at which a linear step lands: probes of one group, each taken so many times."""
    values = dict(group[0])
    if phase := candidate.effect.phase:
        strength = candidate.strengths[0]
        size = float(np.hypot(*shares)) * group[0][strength]
        values |= {phase: float(np.arctan2(shares[1], shares[0])), strength: size}
    else:
        for share, probe in zip(shares, group, strict=True):
            for n in candidate.strengths:
                if probe[n] != candidate.start[n] or len(group) == 1:
                    values[n] = candidate.null[n] + share * (probe[n] - candidate.null[n])
    return {n: float(np.clip(v, *candidate.bounds[n])) for n, v in values.items()}


def _probe_groups(candidate: Candidate) -> list[list[dict[str, float]]]:
    """Values that are probed; those of one group together: the waves of one count, or the strengths of one law."""
    turns = [{candidate.effect.phase: turn} for turn in (0.0, 0.5 * np.pi)] if candidate.effect.phase else [{}]
    scanned = next((p for p in candidate.effect.parameters if p.scan is not None), None)
    if scanned is not None and scanned.scan is not None:
        values = _scanned(scanned.scan, *candidate.bounds[scanned.name])
        return [[_off_null(candidate, {scanned.name: float(v), **turn}) for turn in turns] for v in values]
    if len(candidate.strengths) > 1:
        return [[_off_null(candidate, {}, only=n) for n in candidate.strengths]]
    return [[_off_null(candidate, {})]]


def _scanned(scan: Scan, low: float, high: float) -> FloatArray:
    """(count,) values of a scan between bounds."""
    return (np.geomspace if scan.by_ratio else np.linspace)(scan.from_low * low, scan.to_high * high, scan.count)


def _off_null(candidate: Candidate, given: dict[str, float], only: str | None = None) -> dict[str, float]:
    """The candidate's start with some values, and strengths moved a little off none, into their bounds."""
    values = {**candidate.start, **given}
    for n in candidate.strengths if only is None else (only,):
        low, high = candidate.bounds[n]
        if n not in given and abs(values[n] - candidate.null[n]) <= 1e-12 * max(1.0, abs(candidate.null[n])):
            step = _SMALL_SHARE_OF_RANGE * (high - low)
            values[n] = values[n] + step if values[n] + step <= high else values[n] - step
    return {n: values[n] for n in candidate.null}
