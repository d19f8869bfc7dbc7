"""Parameter values that make a model agree with trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from schemas.model import FloatArray
from simgap.problem import Candidate, Model, Problem, Term, View
from simgap.score import KNEE, trial_losses

_SCAN = (0.02, 0.1, 0.3, 0.6, 1.0)  # shares of the way from null to a bound, tried before the local search


@dataclass(frozen=True)
class Fit:
    """A fitted model, its losses per training trial, and 95 % half widths of its free parameters by key and name."""

    model: Model
    losses: FloatArray
    half_widths: dict[str, dict[str, float]]
    evaluations: int


def fit(
    problem: Problem, fixed: Model, free: Sequence[Candidate], trials: Sequence[str], view: View, scale: FloatArray
) -> Fit:
    """`fixed` and `free` together, the free ones fitted on `trials`; deterministic.

    Starts from each candidate's own start, and, for a single candidate, from a coarse scan of its range as well.
    """
    if not free:
        losses = trial_losses(problem.residuals(fixed, trials, view), scale)
        return Fit(fixed, losses, {}, 1)
    search = _Search(problem, fixed, tuple(free), tuple(trials), view, scale)
    x = search.best_start()
    solved = least_squares(
        search.vector,
        x,
        bounds=(np.zeros(len(x)), np.ones(len(x))),
        loss="cauchy",
        f_scale=KNEE,
        diff_step=3e-3,
        x_scale=0.1,
        max_nfev=20,
        xtol=1e-5,
        ftol=1e-6,
    )
    model = search.model(solved.x)
    losses = trial_losses(problem.residuals(model, trials, view), scale)
    return Fit(model, losses, search.half_widths(solved.x, solved.jac, solved.fun), search.evaluations)


class _Search:
    """Free parameters on [0, 1], mapped to their bounds."""

    def __init__(
        self,
        problem: Problem,
        fixed: Model,
        free: tuple[Candidate, ...],
        trials: tuple[str, ...],
        view: View,
        scale: FloatArray,
    ) -> None:
        self.problem, self.fixed, self.free = problem, fixed, free
        self.trials, self.scale = trials, scale
        self.view: View = view
        self.parameters = [(c, p.name) for c in free for p in c.effect.parameters]
        self.low = np.array([c.bounds[name][0] for c, name in self.parameters])
        self.high = np.array([c.bounds[name][1] for c, name in self.parameters])
        self.evaluations = 0

    def model(self, x: FloatArray) -> Model:
        values: dict[str, dict[str, float]] = {c.key: {} for c in self.free}
        for (c, name), value in zip(self.parameters, self.low + x * (self.high - self.low), strict=True):
            values[c.key][name] = float(value)
        return (*self.fixed, *(Term(c, values[c.key]) for c in self.free))

    def vector(self, x: FloatArray) -> FloatArray:
        """All residuals in one vector, each trial with equal weight, missing ones 0."""
        self.evaluations += 1
        parts = []
        for r in self.problem.residuals(self.model(x), self.trials, self.view):
            scaled = np.nan_to_num(r / self.scale)
            parts.append(np.clip(scaled, -1e4, 1e4).ravel())
        return np.concatenate(parts)

    def cost(self, x: FloatArray) -> float:
        return float(np.log1p((self.vector(x) / KNEE) ** 2).sum())

    def best_start(self) -> FloatArray:
        start = self._shares([c.start[name] for c, name in self.parameters])
        starts = [start]
        if len(self.free) == 1:
            null = self._shares([c.null[name] for c, name in self.parameters])
            starts.append(null)
            for k in range(len(null)):
                for end in (0.0, 1.0):
                    for share in _SCAN:
                        tried = start.copy()
                        tried[k] = null[k] + share * (end - null[k])
                        if abs(tried[k] - null[k]) > 1e-9:
                            starts.append(tried)
        inside = [np.clip(s, 1e-4, 1.0 - 1e-4) for s in starts]
        return min(inside, key=self.cost) if len(inside) > 1 else inside[0]

    def half_widths(self, x: FloatArray, jac: FloatArray, residuals: FloatArray) -> dict[str, dict[str, float]]:
        """1.96 standard errors with trials as clusters (sandwich estimator), in SI."""
        sizes = [r.size for r in self.problem.residuals(self.model(x), self.trials, self.view)]
        weight = 1.0 / (1.0 + (residuals / KNEE) ** 2)
        scores = np.split(weight[:, None] * jac * residuals[:, None], np.cumsum(sizes)[:-1])
        G = np.stack([s.sum(axis=0) for s in scores])
        bread = np.linalg.pinv((weight[:, None] * jac).T @ jac)
        clusters = len(self.trials)
        meat = G.T @ G * (clusters / max(clusters - 1, 1))
        errors = np.sqrt(np.maximum(np.diag(bread @ meat @ bread), 0.0))
        widths: dict[str, dict[str, float]] = {c.key: {} for c in self.free}
        for (c, name), width in zip(self.parameters, 1.96 * errors * (self.high - self.low), strict=True):
            widths[c.key][name] = float(width)
        return widths

    def _shares(self, values: Sequence[float]) -> FloatArray:
        return (np.array(values) - self.low) / (self.high - self.low)
