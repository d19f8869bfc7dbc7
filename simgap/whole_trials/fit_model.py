"""Fits of whole models: parameters shared by all trials and a free start of each, by Gauss and Newton.

From terms with start values to values, starts, loss per trial and information. The starts of each trial are
eliminated from the normal equations (Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973), so that their number does not
matter; steps are damped (Levenberg, Marquardt).

The deviance of a trial is its sum of squared errors in noise levels. Its loss is 2 n log((1 + deviance / n) / 2) for n
rows: near the noise it changes as the deviance does, and a trial that no model follows, such as one that goes over the
top the other way, does not outvote the others. Steps minimise it by weights 2 / (1 + deviance / n).

Slopes cost a roll-out each. They are differenced in the plain steps of the system (`TrialSystem.plain`), and serve for
further steps as long as these take off what the slopes promise (chord method; Ortega and Rheinboldt, 1970).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from schemas.arrays import BoolArray, FloatArray
from simgap.problem import Model, Term, TrialSystem
from simgap.whole_trials.policy import Policy

_DIFFERENCE = 1e-6  # of a parameter's range: larger ones separate what scales together
_LARGEST_ERROR = 1e8  # noise levels beyond which an error counts no more: what is further off has diverged
_START_PRIOR = 1e-3  # precision that holds a start in place, in its steps: a start may be of no effect
_DAMPING, _MOST_DAMPING = 1e-3, 1e6
_KEPT_PROMISE = 0.7  # share of the promised fall of the loss above which slopes serve for a further step
_SINGULAR = 1e-12
_AT_BOUND = 1e-3  # of a range
_FIXED = 1e-5  # range of a value that bounds fix
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
        """(t,) see the head of the module."""
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
class Space:
    """The parameters of a model as one vector (p,): bounds, ranges, and the prior of nuisances."""

    low: FloatArray
    high: FloatArray
    prior_mean: FloatArray
    prior_precision: FloatArray

    @property
    def span(self) -> FloatArray:
        """(p,) ranges; one where there is none."""
        return np.where(self.high > self.low, self.high - self.low, 1.0)

    @staticmethod
    def of(model: Model) -> Space:
        """Nuisances are believed to lie about their declared value, half their range away (1 sigma)."""
        names = [(t.candidate, n) for t in model for n in t.values]
        low, high = (np.array([c.bounds[n][end] for c, n in names]) for end in (0, 1))
        nuisance = np.array([c.nuisance for c, _ in names], dtype=bool)
        half = np.where(high > low, 0.5 * (high - low), 1.0)
        mean = np.array([c.null[n] for c, n in names])
        return Space(low, high, np.where(nuisance, mean, 0.0), np.where(nuisance, 1.0 / half**2, 0.0))

    def inside(self, vector: FloatArray) -> BoolArray:
        """(p,) values so far from their bounds that they move with others."""
        edge = _AT_BOUND * self.span
        return (vector > self.low + edge) & (vector < self.high - edge)

    def penalty(self, vector: FloatArray) -> float:
        """What the prior adds to the deviance."""
        return float((self.prior_precision * (vector - self.prior_mean) ** 2).sum())


def vector_of(model: Model) -> FloatArray:
    """(p,) values of all terms in their order."""
    return np.array([v for t in model for v in t.values.values()], dtype=float)


def with_vector(model: Model, vector: FloatArray) -> Model:
    """The model with these values."""
    values = iter(vector)
    return tuple(Term(t.candidate, {n: float(next(values)) for n in t.values}) for t in model)


@dataclass(frozen=True)
class Linearisation:
    """Errors (t, n) of a model and their slopes: (t, n, p) in shares of the parameters' ranges, (t, n, s) in starts.

    All are multiplied by the root of the trial's weight (t,). What was not measured is zero.
    """

    errors: FloatArray
    parameter_slopes: FloatArray
    start_slopes: FloatArray
    weight: FloatArray

    def with_parameters(self, slopes: FloatArray) -> Linearisation:
        """With further columns (t, n, q), without weights."""
        weighted = slopes * np.sqrt(self.weight)[:, None, None]
        return replace(self, parameter_slopes=np.concatenate([self.parameter_slopes, weighted], axis=2))

    def only(self, chosen: BoolArray) -> Linearisation:
        """With the chosen parameters alone."""
        return replace(self, parameter_slopes=self.parameter_slopes[..., chosen])

    def with_errors(self, errors: FloatArray) -> Linearisation:
        """With other errors (t, n), without weights; NaN where nothing was measured."""
        plain = np.where(np.isfinite(errors), errors, 0.0)
        return replace(self, errors=plain * np.sqrt(self.weight)[:, None])

    def at(self, errors: FloatArray) -> Linearisation:
        """With errors (t, n), without weights, of other values and starts and the weights that belong to them."""
        weight = weights(deviances(errors), rows_of(errors, self.start_slopes.shape[2]))
        root = np.sqrt(weight / self.weight)[:, None, None]
        moved = Linearisation(self.errors, self.parameter_slopes * root, self.start_slopes * root, weight)
        return moved.with_errors(errors)

    def promised(self, parameters: FloatArray, starts: FloatArray) -> float:
        """Fall of the weighted squares by changes of parameters (p,), in shares of their ranges, and starts (t, s)."""
        change = self.parameter_slopes @ parameters + np.einsum("tns,ts->tn", self.start_slopes, starts)
        return -float((change * (2.0 * self.errors + change)).sum())

    def least_loss(self, prior: FloatArray) -> float:
        """Weighted squares that are left after a linear step of parameters, of this prior precision, and starts."""
        equations = self.reduced_equations()
        gradient = equations.gradient.sum(axis=0)
        step = solve_safely(equations.information.sum(axis=0) + np.diag(prior), gradient)
        by_starts = np.einsum("ts,tsr,tr->", equations.start_gradient, equations.inverse, equations.start_gradient)
        return float((self.errors**2).sum()) - float(by_starts) - float(gradient @ step)

    def reduced_equations(self, damping: float = 0.0) -> ReducedEquations:
        """Of each trial, its starts damped by a share of their own information."""
        A, B, e = self.parameter_slopes, self.start_slopes, self.errors
        At, Bt = np.swapaxes(A, 1, 2), np.swapaxes(B, 1, 2)
        starts, unit = Bt @ B, np.eye(B.shape[2])
        inverse = np.asarray(np.linalg.inv(starts * (1.0 + damping * unit) + _START_PRIOR * unit), dtype=float)
        mixed, start_gradient = At @ B, _product(Bt, e)
        through = mixed @ inverse
        return ReducedEquations(
            information=At @ A - through @ np.swapaxes(mixed, 1, 2),
            gradient=_product(At, e) - np.einsum("tps,ts->tp", through, start_gradient),
            mixed=mixed,
            inverse=inverse,
            start_gradient=start_gradient,
        )


@dataclass(frozen=True)
class ReducedEquations:
    """Normal equations of half the loss of each trial, its starts eliminated.

    information, gradient   (t, p, p) and (t, p) of the parameters, in shares of their ranges.
    mixed, inverse, start_gradient   (t, p, s) parameters beside starts, (t, s, s) the inverse of the starts' own
                            information, (t, s).
    """

    information: FloatArray
    gradient: FloatArray
    mixed: FloatArray
    inverse: FloatArray
    start_gradient: FloatArray

    def step(self, damping: float, prior: FloatArray, prior_gradient: FloatArray) -> FloatArray:
        """(p,) a damped step of the parameters, in shares of their ranges."""
        information = self.information.sum(axis=0) + np.diag(prior)
        gradient = self.gradient.sum(axis=0) + prior_gradient
        return -solve_safely(information + damping * np.diag(np.diag(information)), gradient)

    def starts_after(self, step: FloatArray) -> FloatArray:
        """(t, s) changes of the starts for a step (p,) of the parameters."""
        pull = self.start_gradient + np.einsum("tps,p->ts", self.mixed, step)
        return -np.einsum("tsr,tr->ts", self.inverse, pull)


def _product(transposed: FloatArray, errors: FloatArray) -> FloatArray:
    return (transposed @ errors[:, :, None])[:, :, 0]


def solve_safely(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """The solution (p,) of a symmetric system that may be nearly singular; each unknown is scaled by its own term."""
    if not len(right):
        return right
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    eased = matrix / np.outer(scale, scale) + _SINGULAR * np.eye(len(right))
    return np.asarray(np.linalg.solve(eased, right / scale), dtype=float) / scale


def inverse_of(matrix: FloatArray) -> FloatArray:
    """The inverse (p, p) of a symmetric matrix that may be nearly singular, scaled in the same way."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    eased = matrix / np.outer(scale, scale) + _SINGULAR * np.eye(len(scale))
    return np.asarray(np.linalg.inv(eased), dtype=float) / np.outer(scale, scale)


def clipped(errors: FloatArray) -> FloatArray:
    """Errors with what diverged held at a large number; NaN, where nothing was measured, stays."""
    return np.clip(errors, -_LARGEST_ERROR, _LARGEST_ERROR)


def deviances(errors: FloatArray) -> FloatArray:
    """(t,) of errors (t, n)."""
    squares: FloatArray = np.where(np.isfinite(errors), errors, 0.0) ** 2
    return squares.sum(axis=1)


def losses(deviance: FloatArray, rows: FloatArray) -> FloatArray:
    """(t,) of deviances (t,) over so many rows (t,)."""
    return 2.0 * rows * np.log(0.5 * (1.0 + deviance / rows))


def weights(deviance: FloatArray, rows: FloatArray) -> FloatArray:
    """(t,) changes of the losses by deviance."""
    return 2.0 / (1.0 + deviance / rows)


def rows_of(errors: FloatArray, starts: int) -> FloatArray:
    """(t,) errors that were measured, less the start values that they determine."""
    return np.maximum(np.isfinite(errors).sum(axis=1) - starts, 1).astype(float)


def linearise(
    system: TrialSystem, model: Model, starts: FloatArray, fixed: bool = False, errors: FloatArray | None = None
) -> Linearisation:
    """Errors and slopes of a model at these starts; `fixed` leaves out the slopes in parameters.

    `errors` (t, n) are those of the model, where they are known.
    """
    if errors is None:
        errors = errors_at(system, model, starts)
    steps = starts.shape[1]
    moved = np.repeat(starts[None], steps + 1, axis=0)
    for s in range(steps):
        moved[s + 1, :, s] += 1.0
    base, *after = clipped(system.plain.errors(model, moved))
    measured = np.isfinite(errors)
    start_slopes = np.stack([a - base for a in after], axis=2) if after else np.zeros((*base.shape, 0))
    columns = [] if fixed else _parameter_slopes(system.plain, model, starts, base)
    slopes = np.stack(columns, axis=2) if columns else np.zeros((*base.shape, 0))
    weight = weights(deviances(errors), rows_of(errors, steps))
    root = np.sqrt(weight)[:, None]
    return Linearisation(
        np.where(measured, errors, 0.0) * root,
        np.where(measured[:, :, None], slopes, 0.0) * root[:, :, None],
        np.where(measured[:, :, None], start_slopes, 0.0) * root[:, :, None],
        weight,
    )


def _parameter_slopes(system: TrialSystem, model: Model, starts: FloatArray, base: FloatArray) -> list[FloatArray]:
    space, vector = Space.of(model), vector_of(model)
    out = []
    for p, span in enumerate(space.span):
        if span < _FIXED:
            out.append(np.zeros_like(base))
            continue
        h = _DIFFERENCE * span
        if vector[p] + h > space.high[p]:
            h = -h
        moved = vector.copy()
        moved[p] += h
        out.append((errors_at(system, with_vector(model, moved), starts) - base) / h * span)
    return out


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


def errors_at(system: TrialSystem, model: Model, starts: FloatArray) -> FloatArray:
    """(t, n) of a model at given values and starts, clipped."""
    return clipped(system.errors(model, starts[None]))[0]


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
    information = information + np.diag(np.where(space.span < _FIXED, 1.0, 0.0))
    inverse = inverse_of(information)
    trials = len(fit.gradients)
    spread = fit.gradients - fit.gradients.mean(axis=0)
    clustered = inverse @ (spread.T @ spread) @ inverse * trials / max(trials - 1, 1)
    noise = inverse * fit.dispersion
    error = np.sqrt(np.maximum(np.maximum(np.diag(clustered), np.diag(noise)), 0.0)) * space.span
    widths = iter(np.where(space.span < _FIXED, 0.0, quantile * error))
    return {t.candidate.key: {n: float(next(widths)) for n in t.values} for t in fit.model}
