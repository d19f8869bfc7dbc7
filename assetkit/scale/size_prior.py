"""Prior of the scale of an object (metres per source unit), from the proportions of its box and its category.

The logarithm has a mixture of normal distributions: things of known size in the category, most those of like form
(`size_anchors.csv`), and the category's usual range; for a category that may be wrong, household things in general.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from assetkit.mass.normal_mixture import NormalMixture
from assetkit.scale.unit_posterior import LOG_SPREAD, TYPICAL_SIZE_M
from assetkit.taxonomy.tables import Category, size_anchors
from schemas.arrays import FloatArray

# Things of one form differ in size by about this much (standard deviation of the logarithm); forms this far apart (sum
# over edges of the squared logarithms) have half the weight for each other.
SAME_FORM_SPREAD, FORM_SPREAD = 0.22, 0.35
# Largest total weight of things of known size against the range of the category.
MOST_ANCHORED = 0.75
# A range of the table spans this many standard deviations.
RANGE_DEVIATIONS = 4.0
# Precision of the categories that names decided in `benchmarks.assets.semantics`: 95 in 100 were right.
CATEGORY_PRECISION = 0.95


class SizePrior(NamedTuple):
    """Distribution of the logarithm of metres per unit; `anchors` names the things of known size with most weight."""

    log_scale: NormalMixture
    anchors: tuple[str, ...] = ()

    def density(self, scale: float) -> float:
        """Density at the logarithm of `scale`, metres per unit."""
        return self.log_scale.density(math.log(scale))

    def quantiles(self, shares: Sequence[float]) -> tuple[float, ...]:
        """Metres per unit at the quantiles `shares`."""
        return tuple(math.exp(self.log_scale.quantile(share)) for share in shares)


def size_prior(
    edges: Sequence[float], category: Category | None, category_probability: float, excluded_anchor: str = ""
) -> SizePrior:
    """The prior of the scale of a thing with sorted box `edges` (in its unit), of a `category` that is right with this
    probability; `excluded_anchor` names an anchor to leave out.
    """
    logs = np.log(np.maximum(np.asarray(edges, dtype=np.float64), 1e-12 * max(edges)))
    anywhere = (1.0, math.log(TYPICAL_SIZE_M) - float(logs.max()), LOG_SPREAD)
    if category is None:
        return _size_prior([anywhere])
    near = sorted(_near(logs, category.id, excluded_anchor), reverse=True)
    total = sum(closeness for closeness, *_ in near)
    anchored = MOST_ANCHORED * total / (total + 1.0)
    rows = [
        (category_probability * anchored * closeness / total, mean, SAME_FORM_SPREAD)
        for closeness, _, mean in near
        if total
    ]
    rows += [
        (category_probability * (1.0 - anchored), *_usual(logs, category)),
        (1.0 - category_probability, *anywhere[1:]),
    ]
    return _size_prior(rows, tuple(name for closeness, name, _ in near[:3] if closeness > 0.1))


def _size_prior(rows: Sequence[tuple[float, float, float]], anchors: tuple[str, ...] = ()) -> SizePrior:
    """The prior from rows of weight, mean and standard deviation."""
    weights, means, deviations = np.array(rows).T
    return SizePrior(NormalMixture(means, deviations, weights), anchors)


def _near(logs: FloatArray, category: str, excluded_anchor: str) -> Iterator[tuple[float, str, float]]:
    """For each thing of known size: likeness in form (0 to 1), its name, and the logarithm of the scale it implies."""
    for anchor in size_anchors():
        if anchor.category == category and anchor.name != excluded_anchor:
            apart = np.log(np.array(anchor.edges_mm) / 1000.0) - logs
            yield math.exp(-0.5 * float(np.var(apart)) * 3.0 / FORM_SPREAD**2), anchor.name, float(apart.mean())


def _usual(logs: FloatArray, category: Category) -> tuple[float, float]:
    """Mean and standard deviation of the log scale by the category's ranges; edges are correlated."""
    ranges = np.log(np.array(category.extents_m))
    deviations = np.ptp(ranges, axis=1) / RANGE_DEVIATIONS
    weights = deviations**-2 / (deviations**-2).sum()
    return float(weights @ (ranges.mean(axis=1) - logs)), float((deviations**-2).mean() ** -0.5)
