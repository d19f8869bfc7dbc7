"""Errors of a model with their slopes, and normal equations from which the starts of trials are eliminated.

Eliminated starts (Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973) cost nothing, however many trials there are. Slopes
cost a roll-out each, and are differenced in the plain steps of the system (`TrialSystem.plain`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from schemas.arrays import BoolArray, FloatArray
from simgap.problem import Model, TrialSystem
from simgap.whole_trials.losses import clipped, deviances, rows_of, weights
from simgap.whole_trials.parameter_space import Space, vector_of, with_vector

_DIFFERENCE = 1e-6  # of a parameter's range: larger ones separate what scales together
_START_PRIOR = 1e-3  # precision that holds a start in place, in its steps: a start may be of no effect
_NOTHING = 1e-200  # of a term of information
_SINGULAR = 1e-12
FIXED = 1e-5  # range of a value that bounds fix


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
    """The inverse (p, p) of a symmetric matrix that may be nearly singular, scaled in the same way.

    An unknown of which nothing is known (its term is zero, as that of a switch) has a row and a column of zeros.
    """
    known = np.diag(matrix) > _NOTHING
    scale = np.sqrt(np.where(known, np.diag(matrix), 1.0))
    eased = np.where(np.outer(known, known), matrix / np.outer(scale, scale), 0.0) + _SINGULAR * np.eye(len(scale))
    inverse = np.asarray(np.linalg.inv(eased), dtype=float) / np.outer(scale, scale)
    return np.where(np.outer(known, known), inverse, 0.0)


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
        if span < FIXED:
            out.append(np.zeros_like(base))
            continue
        h = _DIFFERENCE * span
        if vector[p] + h > space.high[p]:
            h = -h
        moved = vector.copy()
        moved[p] += h
        out.append((errors_at(system, with_vector(model, moved), starts) - base) / h * span)
    return out


def errors_at(system: TrialSystem, model: Model, starts: FloatArray) -> FloatArray:
    """(t, n) of a model at given values and starts, clipped."""
    return clipped(system.errors(model, starts[None]))[0]
