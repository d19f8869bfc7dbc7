"""Robust least squares on the unit box, with leave-one-out losses and cluster-robust intervals from the solution.

Residual functions map shares x (p,) of the parameters' ranges to residuals in noise levels, one array per trial.
Large residuals count by Cauchy's loss, solved by reweighting (Holland and Welsch, Comm. Stat. A6, 1977).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from schemas.arrays import BoolArray, FloatArray

CAUCHY_SCALE = 5.0  # noise levels at which a residual stops counting by its square
_DIFFERENCE_STEP = 2e-3
_ENOUGH = 1e-4  # relative decrease of the cost below which the search ends
_HESSIAN_RIDGE = 1e-9
_WALL = 1e-6
# Share of a step and its damping, one after another. What is hardly seen where a search stands, as the rest of a spring
# that is still weak, must not drag all others along (Levenberg, Quart. Appl. Math. 2, 1944).
_TRIES = ((1.0, 0.0), (0.3, 0.0), (0.09, 0.0), (1.0, 1e-3), (1.0, 1e-1))
_NORMAL = 1.96
Residuals = Callable[[FloatArray], Sequence[FloatArray]]


@dataclass(frozen=True)
class Prior:
    """Gaussian prior on the parameters: shares `centre` (p,), each with `precision` (p,) = 1 / deviation^2.

    Without it, parameters that the trials cannot separate would drift to their bounds together.
    """

    centre: FloatArray
    precision: FloatArray

    def normal(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Normal matrix and gradient of what is known, as of residuals."""
        return np.diag(self.precision), self.precision * (x - self.centre)

    def cost(self, x: FloatArray) -> float:
        """In the unit of the residuals' cost."""
        return float((self.precision * (x - self.centre) ** 2).sum() / CAUCHY_SCALE**2)


def flat_prior(count: int) -> Prior:
    """An uninformative prior of `count` parameters."""
    return Prior(np.zeros(count), np.zeros(count))


@dataclass(frozen=True)
class Solution:
    """Shares x (p,), residuals per trial, their Jacobian (n, p) over all trials, calls that took, and the prior."""

    x: FloatArray
    residuals: tuple[FloatArray, ...]
    jac: FloatArray
    evaluations: int
    prior: Prior

    @property
    def losses(self) -> FloatArray:
        """(t,) mean loss per trial."""
        return np.array([mean_loss(r) for r in self.residuals])


def mean_loss(residual: FloatArray) -> float:
    """Mean Cauchy loss of residuals in noise levels; those that are not finite are left out."""
    r = residual[np.isfinite(residual)]
    return float(CAUCHY_SCALE**2 * np.log1p((r / CAUCHY_SCALE) ** 2).mean()) if r.size else 0.0


def minimise(
    residuals: Residuals,
    x: FloatArray,
    known: FloatArray | None = None,
    at: Sequence[FloatArray] | None = None,
    most: int = 8,
    starting: int = 0,
    steps: FloatArray | float = _DIFFERENCE_STEP,
    prior: Prior | None = None,
) -> Solution:
    """The nearest minimum from x, by Gauss-Newton steps that never raise the cost.

    known   Jacobian columns of the first parameters, taken as good enough everywhere: no calls are spent on them.
    at      residuals at x where the caller has them already.
    steps   (p,) changes over which slopes are read.
    """
    steps = np.broadcast_to(steps, np.shape(x))
    prior = prior or flat_prior(len(steps))
    fixed = 0 if known is None else known.shape[1]
    x = np.clip(np.asarray(x, dtype=float), 0.0, 1.0)
    here = tuple(residuals(x) if at is None else at)
    calls = starting + (at is None)
    r = np.concatenate(here)
    jac, more = _jacobian(residuals, x, r, known, fixed, steps)
    calls += more
    for _ in range(most):
        H, g = _sum([_normal(jac, r), prior.normal(x)])
        step = _bounded_step(H, g, x)
        cost, moved = _cost(r) + prior.cost(x), None
        for share, damping in _TRIES:
            if damping:
                step = _bounded_step(H + damping * np.diag(H).max(initial=0.0) * np.eye(len(x)), g, x)
            tried = np.clip(x + share * step, 0.0, 1.0)
            there = tuple(residuals(tried))
            calls += 1
            if _cost(np.concatenate(there)) + prior.cost(tried) < cost:
                moved = tried, there
                break
        if moved is None:
            break
        x, here = moved
        r = np.concatenate(here)
        done = cost - _cost(r) - prior.cost(x) < _ENOUGH * cost
        jac, more = _jacobian(residuals, x, r, known, fixed, steps)
        calls += more
        if done:
            break
    return Solution(x, here, jac, calls, prior)


def leave_one_out_losses(solution: Solution) -> FloatArray:
    """(t,) loss of each trial under the parameters that the others alone would give, to first order.

    One Gauss-Newton step from the common solution with that trial's rows removed (Pregibon, Ann. Stat. 9, 1981): a
    leave-one-out cross-validation without a single further simulation.
    """
    if not solution.x.size:
        return solution.losses
    pieces = _normal_equations(solution)
    H, g = _sum([*pieces, solution.prior.normal(solution.x)])
    out, row = [], 0
    for r, (h, v) in zip(solution.residuals, pieces, strict=True):
        step = _bounded_step(H - h, g - v, solution.x)
        out.append(mean_loss(r + solution.jac[row : row + len(r)] @ step))
        row += len(r)
    return np.array(out)


def half_widths(solution: Solution) -> FloatArray:
    """(p,) half 95 % intervals of the shares, with trials as clusters (Liang and Zeger, Biometrika 73, 1986).

    Each trial's score is taken at the solution without it (a jackknife: few clusters do not look surer than they are).
    Parameters at a wall count as given there: the wall is what is known of them, and their own width is 0. What was
    known beforehand may be wrong by its deviation, which moves what cannot be distinguished from it.
    """
    pieces = _normal_equations(solution)
    n = len(pieces)
    if n < 2:
        return np.full(len(solution.x), np.inf)
    prior, at_rest = solution.prior.normal(solution.x)
    H, g = _sum([*pieces, (prior, at_rest)])
    free = (solution.x > _WALL) & (solution.x < 1.0 - _WALL)
    steps = np.stack([_newton_step(H - h, g - v, free) for h, v in pieces])
    spread = np.sqrt((n - 1) / n * ((steps - steps.mean(axis=0)) ** 2).sum(axis=0))
    moved = [_newton_step(H, column, free) for column in np.sqrt(prior) if column.any()]
    known = np.sqrt(np.sum(np.square(moved), axis=0)) if moved else 0.0
    return np.hypot(spread * float(stats.t.ppf(0.975, n - 1)), known * _NORMAL)


def _normal_equations(solution: Solution) -> list[tuple[FloatArray, FloatArray]]:
    """Normal matrix and gradient of each trial."""
    ends = np.cumsum([len(r) for r in solution.residuals])[:-1]
    return [_normal(j, r) for j, r in zip(np.split(solution.jac, ends), solution.residuals, strict=True)]


def _sum(parts: list[tuple[FloatArray, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    return np.sum([h for h, _ in parts], axis=0), np.sum([v for _, v in parts], axis=0)


def _normal(jac: FloatArray, r: FloatArray) -> tuple[FloatArray, FloatArray]:
    weighted = jac / (1.0 + (r / CAUCHY_SCALE) ** 2)[:, None]
    return weighted.T @ jac, weighted.T @ r


def _bounded_step(H: FloatArray, g: FloatArray, x: FloatArray) -> FloatArray:
    """Newton step that stays in the unit box: parameters that would leave it are held at the wall, one by one."""
    free = np.ones(len(x), dtype=bool)
    step = np.zeros(len(x))
    for _ in range(len(x)):
        held = np.where(free, 0.0, step)
        step = np.where(free, _newton_step(H, g + H @ held, free), held)
        beyond = free & ((x + step < 0.0) | (x + step > 1.0))
        if not beyond.any():
            return step
        worst = int(np.argmax(np.where(beyond, np.abs(x + step - 0.5), -1.0)))
        step[worst] = np.clip(x[worst] + step[worst], 0.0, 1.0) - x[worst]
        free[worst] = False
    return step


def _newton_step(H: FloatArray, g: FloatArray, free: BoolArray) -> FloatArray:
    """-H^-1 g over the free parameters, each scaled to its own curvature; blind directions stay put."""
    root = np.sqrt(np.maximum(np.diag(H), 0.0))
    seen = free & (root > 1e-12 * max(float(root.max()), 1e-300))
    out = np.zeros(len(g))
    if seen.any():
        s = root[seen]
        A = H[np.ix_(seen, seen)] / np.outer(s, s) + _HESSIAN_RIDGE * np.eye(len(s))
        out[seen] = -np.linalg.lstsq(A, g[seen] / s, rcond=1e-8)[0] / s
    return out


def _jacobian(
    residuals: Residuals, x: FloatArray, r: FloatArray, known: FloatArray | None, fixed: int, steps: FloatArray
) -> tuple[FloatArray, int]:
    """Forward differences, backward at the upper wall."""
    columns = [] if known is None else [known]
    for k in range(fixed, len(x)):
        step = steps[k] if x[k] + steps[k] <= 1.0 else -steps[k]
        moved = x.copy()
        moved[k] += step
        columns.append(((np.concatenate(residuals(moved)) - r) / step)[:, None])
    return (np.concatenate(columns, axis=1) if columns else np.zeros((len(r), 0))), len(x) - fixed


def _cost(r: FloatArray) -> float:
    return float(np.log1p((r / CAUCHY_SCALE) ** 2).sum())
