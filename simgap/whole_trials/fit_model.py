"""Fits of whole models: parameters shared by all trials and a free start of each, by Gauss and Newton.

From terms with start values to values, starts, loss per trial and information. Steps are damped (Levenberg, Marquardt)
and minimise the loss of `losses`. Slopes, the dear part, serve for further steps as long as these take off what the
slopes promise (chord method; Ortega and Rheinboldt, 1970).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from simgap.problem import Model, Term, TrialSystem
from simgap.whole_trials.linearisation import FIXED, Linearisation, errors_at, inverse_of, linearise
from simgap.whole_trials.losses import deviances, losses, rows_of, weights
from simgap.whole_trials.parameter_space import Space, vector_of, with_vector
from simgap.whole_trials.policy import Policy

_DAMPING, _MOST_DAMPING = 1e-3, 1e6
_KEPT_PROMISE = 0.7  # share of the promised fall of the loss above which slopes serve for a further step
_MOST_CORRELATION = 0.98


@dataclass(frozen=True)
class ModelFit:
    """A fitted model.

    starts      (t, s) in the system's start steps.
    deviance    (t,) sum of squared errors in noise levels.
    rows        (t,) errors that were compared, less the start values that they determine.
    gradients   (t, p) of half the loss in shares of the parameters' ranges, starts eliminated, and
                `trial_information` (t, p, p); p is 0 where only the starts were fitted.
    correlation of an error with the next one of its trial: more than none where errors are not noise.
    """

    model: Model
    starts: FloatArray
    deviance: FloatArray
    rows: FloatArray
    trial_information: FloatArray
    gradients: FloatArray
    correlation: float

    @property
    def losses(self) -> FloatArray:
        """(t,) see `losses`."""
        return losses(self.deviance, self.rows)

    @property
    def dispersion(self) -> float:
        """Variance of a change of the loss over what it would be if errors were noise, one independent of the next."""
        weighted = (weights(self.deviance, self.rows) * self.deviance).sum() / self.rows.sum()
        correlation = min(max(self.correlation, 0.0), _MOST_CORRELATION)
        return max(1.0, float(weighted)) * (1.0 + correlation) / (1.0 - correlation)

    @property
    def effects(self) -> tuple[Term, ...]:
        """Terms that are no nuisances."""
        return tuple(t for t in self.model if not t.candidate.nuisance)

    @property
    def keys(self) -> frozenset[str]:
        """Of its effects."""
        return frozenset(t.candidate.key for t in self.effects)

    @property
    def excess(self) -> float:
        """Mean square error in noise levels, less that of noise alone."""
        return float(self.deviance.sum() / self.rows.sum() - 1.0)


@dataclass(frozen=True)
class _Point:
    """Values (p,) and starts (t, s) of a fit with their errors (t, n) and cost."""

    vector: FloatArray
    starts: FloatArray
    errors: FloatArray
    cost: float


def fit_model(
    system: TrialSystem,
    model: Model,
    starts: FloatArray,
    policy: Policy,
    *,
    iterations: int | None = None,
    fixed: bool = False,
) -> ModelFit:
    """The model fitted from its values and these starts (t, s); `fixed` fits the starts alone.

    Values stay within the candidates' bounds. `iterations` counts how often slopes are computed.
    """
    space = Space.of(model)
    point = _point_at(system, model, space, vector_of(model), starts)
    linear = linearise(system, model, starts, fixed, point.errors)
    fresh, damping, left = True, _DAMPING, (iterations or policy.iterations) - 1
    while True:
        stepped, worth = None, 0.0
        while damping <= _MOST_DAMPING and stepped is None:
            stepped = _try_step(system, model, linear, space, point, damping, worth, fixed)
            worth = policy.least_step  # The first step is for free, and ends nearer to the best values.
            if stepped is None and not fresh:
                break
            damping = damping * 10.0 if stepped is None else max(damping / 10.0, 1e-7)
        if stepped is None and fresh:
            break
        if stepped is not None:
            (after, promised), fall = stepped, point.cost - stepped[0].cost
            point, damping = after, min(damping, 1.0)
            linear = linear.at(after.errors)
            if fresh and fall < policy.least_step:
                break
            if fall >= max(_KEPT_PROMISE * promised, policy.least_step):
                fresh = False
                continue
        if not left:
            break
        linear = linearise(system, with_vector(model, point.vector), point.starts, fixed, point.errors)
        fresh, left = True, left - 1
    return _fit_of(system, with_vector(model, point.vector), point, linear)


def _point_at(system: TrialSystem, model: Model, space: Space, vector: FloatArray, starts: FloatArray) -> _Point:
    errors = errors_at(system, with_vector(model, vector), starts)
    return _Point(vector, starts, errors, _loss_of(errors, starts.shape[1]) + space.penalty(vector))


def _try_step(
    system: TrialSystem,
    model: Model,
    linear: Linearisation,
    space: Space,
    point: _Point,
    damping: float,
    least: float,
    fixed: bool,
) -> tuple[_Point, float] | None:
    """The point after a damped step and the fall that it promised; None where it promises less than `least`, or where
    the cost does not fall.
    """
    moved, equations = point.vector, linear.reduced_equations(damping)
    if not fixed and len(moved):
        prior = space.prior_precision * space.span**2
        pull = space.prior_precision * space.span * (point.vector - space.prior_mean)
        moved = np.clip(point.vector + equations.step(damping, prior, pull) * space.span, space.low, space.high)
    shares = (moved - point.vector) / space.span if not fixed else np.zeros(0)
    change = equations.starts_after(shares)
    promised = linear.promised(shares, change) + space.penalty(point.vector) - space.penalty(moved)
    if promised < least:
        return None
    after = _point_at(system, model, space, moved, point.starts + change)
    return (after, promised) if after.cost < point.cost else None


def loss_at(system: TrialSystem, model: Model, starts: FloatArray) -> float:
    """Sum of the losses of a model at given values and starts."""
    return _loss_of(errors_at(system, model, starts), starts.shape[1])


def _loss_of(errors: FloatArray, starts: int) -> float:
    return float(losses(deviances(errors), rows_of(errors, starts)).sum())


def fit_at(system: TrialSystem, model: Model, starts: FloatArray) -> ModelFit:
    """The record of a model at given values and starts."""
    errors = errors_at(system, model, starts)
    point = _Point(vector_of(model), starts, errors, 0.0)
    return _fit_of(system, model, point, linearise(system, model, starts, errors=errors))


def _fit_of(system: TrialSystem, model: Model, point: _Point, linear: Linearisation) -> ModelFit:
    equations = linear.reduced_equations()
    rows = rows_of(point.errors, point.starts.shape[1])
    correlation = _correlation(system, linear)
    deviance = deviances(point.errors)
    return ModelFit(model, point.starts, deviance, rows, equations.information, equations.gradient, correlation)


def _correlation(system: TrialSystem, linear: Linearisation) -> float:
    """Of weighted errors with those of the same channel a row later; those not measured are zero."""
    by_row = linear.errors.reshape(len(linear.errors), -1, system.channel_count)
    square = float((by_row[:, :-1] ** 2).sum())
    return float((by_row[:, :-1] * by_row[:, 1:]).sum()) / max(square, 1e-12)


def half_widths(fit: ModelFit, quantile: float) -> dict[str, dict[str, float]]:
    """Half widths of intervals by key and parameter: clustered by trial, or of the noise where that is more.

    The sandwich over trials (Huber; White, Econometrica 50, 1982) covers errors that repeat within a trial; with few
    trials it is uncertain itself, and the information alone gives the least.
    """
    space = Space.of(fit.model)
    if not len(space.low):
        return {}
    information = fit.trial_information.sum(axis=0) + np.diag(space.prior_precision * space.span**2)
    information = information + np.diag(np.where(space.span < FIXED, 1.0, 0.0))
    inverse = inverse_of(information)
    trials = len(fit.gradients)
    spread = fit.gradients - fit.gradients.mean(axis=0)
    clustered = inverse @ (spread.T @ spread) @ inverse * trials / max(trials - 1, 1)
    noise = inverse * fit.dispersion
    error = np.sqrt(np.maximum(np.maximum(np.diag(clustered), np.diag(noise)), 0.0)) * space.span
    widths = iter(np.where(space.span < FIXED, 0.0, quantile * error))
    return {t.candidate.key: {n: float(next(widths)) for n in t.values} for t in fit.model}
