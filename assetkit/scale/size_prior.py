"""How large a thing of this form and category is: a belief about the logarithm of its scale.

A belief is a mixture of normal distributions: things of known size in the category, those of like form most
(`size_anchors.csv`), and the category's usual range; for a category that may be wrong, household things in general.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from assetkit.mass.normal_mixture import Mixture
from assetkit.scale.unit_posterior import LOG_SPREAD, TYPICAL_SIZE_M
from assetkit.taxonomy.tables import Category, size_anchors
from schemas.model import FloatArray

# Things of one form differ in size by about this much (standard deviation of the logarithm); forms this far apart (sum
# over edges of the squared logarithms) tell each other's size half as well.
SAME_FORM_SPREAD, FORM_SPREAD = 0.22, 0.35
# What things of known size weigh at most against the range of the category.
MOST_ANCHORED = 0.75
# A range of the table spans this many standard deviations.
RANGE_DEVIATIONS = 4.0
# Of all categories that names made stand in `benchmarks.assets.semantics`, 95 in 100 were right.
CATEGORY_HOLDS = 0.95


class Belief(NamedTuple):
    """The logarithm of metres per unit; `anchors` names the things of known size that weigh most."""

    logs: Mixture
    anchors: tuple[str, ...] = ()

    def density(self, scale: float) -> float:
        """Of the logarithm of `scale`, metres per unit."""
        return self.logs.density(math.log(scale))

    def quantiles(self, shares: Sequence[float]) -> tuple[float, ...]:
        """Metres per unit below which the scale lies with each of the chances `shares`."""
        return tuple(math.exp(self.logs.quantile(share)) for share in shares)


def size_belief(edges: Sequence[float], category: Category | None, holds: float, without: str = "") -> Belief:
    """What is believed of the scale of a thing with sorted box `edges` (in its unit) and a category that `holds` with
    this chance; `without` leaves out an anchor by its name.
    """
    logs = np.log(np.maximum(np.asarray(edges, dtype=np.float64), 1e-12 * max(edges)))
    anywhere = (1.0, math.log(TYPICAL_SIZE_M) - float(logs.max()), LOG_SPREAD)
    if category is None:
        return _belief([anywhere])
    near = sorted(_near(logs, category.id, without), reverse=True)
    total = sum(closeness for closeness, *_ in near)
    anchored = MOST_ANCHORED * total / (total + 1.0)
    rows = [(holds * anchored * closeness / total, mean, SAME_FORM_SPREAD) for closeness, _, mean in near if total]
    rows += [(holds * (1.0 - anchored), *_usual(logs, category)), (1.0 - holds, *anywhere[1:])]
    return _belief(rows, tuple(name for closeness, name, _ in near[:3] if closeness > 0.1))


def _belief(rows: Sequence[tuple[float, float, float]], anchors: tuple[str, ...] = ()) -> Belief:
    """Of rows of weight, mean and standard deviation."""
    weights, means, deviations = np.array(rows).T
    return Belief(Mixture(means, deviations, weights), anchors)


def _near(logs: FloatArray, category: str, without: str) -> Iterator[tuple[float, str, float]]:
    """How alike in form each thing of known size is (0 to 1), its name, and the logarithm of the scale it tells."""
    for anchor in size_anchors():
        if anchor.category == category and anchor.name != without:
            apart = np.log(np.array(anchor.edges_mm) / 1000.0) - logs
            yield math.exp(-0.5 * float(np.var(apart)) * 3.0 / FORM_SPREAD**2), anchor.name, float(apart.mean())


def _usual(logs: FloatArray, category: Category) -> tuple[float, float]:
    """Mean and deviation of the scale by the category's ranges; edges vary together, so three tell no more than one."""
    ranges = np.log(np.array(category.extents_m))
    deviations = np.ptp(ranges, axis=1) / RANGE_DEVIATIONS
    weights = deviations**-2 / (deviations**-2).sum()
    return float(weights @ (ranges.mean(axis=1) - logs)), float((deviations**-2).mean() ** -0.5)
