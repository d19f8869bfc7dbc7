"""The parameters of a model as one vector: values, bounds, ranges, priors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from schemas.arrays import BoolArray, FloatArray
from simgap.problem import Model, Term

_AT_BOUND = 1e-3  # of a range


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
