"""Metres per source unit where no unit is stated: the posterior over units, from the size prior of the category.

Hypotheses are the common units with the habits of tools and formats (`unit_posterior`), numbers that were normalised
(the longest edge or the diagonal of the box is 1 or 2), and any other factor. The likelihood is the size prior.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from assetkit.mass.normal_mixture import normal_density
from assetkit.options import METERS_PER_UNIT
from assetkit.scale.size_prior import SizePrior, size_prior
from assetkit.scale.unit_posterior import roundness, unit_prior
from assetkit.taxonomy.tables import Category
from schemas.evidence import Evidence, inferred

# Prior probabilities that numbers are normalised, or in no unit at all.
NORMALISED_PRIOR, ANY_FACTOR_PRIOR = 0.05, 0.05
# A length is normalised when it is 1 or 2 within this relative tolerance. A designed length is 1 or 2 as often as if
# it were this many times as usual.
EXACT, DESIGNED = 1e-4, 20.0
LOG_FACTOR_SPREAD = math.log(
    10.0
)  # Numbers in no unit are some ten times larger or smaller than 1 (standard deviation of the logarithm).
MIN_PROBABILITY = 0.8  # From this probability on a unit is used; numbers in no unit get the size of the category ...
MAX_BOUND_RATIO = 5.0  # ... unless its bounds are further apart than this.
MIN_LISTED = 0.04  # Units less likely than this are left out of the bounds.
QUANTILES = (0.04, 0.5, 0.96)


class ScaleEstimate(NamedTuple):
    """Metres per source unit with its evidence, the explanation, and whether a person must decide."""

    meters_per_unit: Evidence[float]
    reading: str
    review: bool


def estimate_scale(
    extent: tuple[float, float, float],
    edges: Sequence[float],
    category: Category | None,
    category_probability: float,
    *,
    format_: str,
    hints: Sequence[str] = (),
    implied: str | None = None,
    excluded_anchor: str = "",
) -> ScaleEstimate:
    """The scale of an object by its category. `extent` is its bounding box and `edges` the sorted ones of its smallest
    box, both in source units; `category_probability` is that of its `category`; `implied` the unit that the format
    prescribes. `excluded_anchor` names a thing of known size to leave out.
    """
    prior_size = size_prior(edges, category, category_probability, excluded_anchor)
    chances = _chances(extent, prior_size, unit_prior(format_, hints, implied))
    low, middle, high = prior_size.quantiles(QUANTILES)
    unit = max(METERS_PER_UNIT, key=lambda u: chances[u])
    free = chances["normalised"] + chances["any factor"]
    spanned = [METERS_PER_UNIT[u] for u in METERS_PER_UNIT if chances[u] >= MIN_LISTED]
    if free >= MIN_LISTED:
        spanned += [low, high]
    what = category.id if category else "an unknown thing"
    clues = (
        *(f"{name}: {chance:.0%}" for name, chance in chances.items() if chance >= MIN_LISTED),
        *prior_size.anchors,
    )
    if chances[unit] >= free:
        scale, chance = METERS_PER_UNIT[unit], chances[unit]
        reading = f"in {unit} it has the size of {what}"
    else:
        scale, chance = middle, free
        reading = f"the numbers are {'normalised' if chances['normalised'] > 0.5 * free else 'in no usual unit'}"
        reading += f", so it takes the size of {what}"
    bounds = (min(*spanned, scale), max(*spanned, scale))
    sure = chance >= MIN_PROBABILITY and category is not None and bounds[1] <= MAX_BOUND_RATIO * bounds[0]
    method = f"units and sizes of things like {what}: {reading}"
    confidence = round(
        chance * category_probability if chances[unit] >= free else 0.5 * chance * category_probability, 3
    )
    evidence = inferred(scale, method, confidence, bounds=bounds if bounds[0] < bounds[1] else None, inputs=clues)
    return ScaleEstimate(evidence, reading, review=not sure)


def is_normalised(extent: Sequence[float]) -> bool:
    """Whether the longest edge or the diagonal of a box is 1 or 2, and the box no cube of that size."""
    telling = (max(extent), math.hypot(*extent))
    exact = any(math.isclose(length, whole, rel_tol=EXACT) for length in telling for whole in (1.0, 2.0))
    return exact and not all(math.isclose(e, max(extent), rel_tol=EXACT) for e in extent)


def _chances(extent: tuple[float, float, float], prior_size: SizePrior, prior: dict[str, float]) -> dict[str, float]:
    """Posterior probability of each unit, of `normalised` and of `any factor`; sums to 1."""
    exact = is_normalised(extent)
    weights = {
        unit: (1.0 - NORMALISED_PRIOR - ANY_FACTOR_PRIOR)
        * prior[unit]
        * prior_size.density(METERS_PER_UNIT[unit])
        * roundness(extent, unit)
        * (DESIGNED if exact else 1.0)
        for unit in METERS_PER_UNIT
    }
    weights["normalised"] = NORMALISED_PRIOR / (2.0 * EXACT) / 2.0 if exact else 0.0
    weights["any factor"] = ANY_FACTOR_PRIOR * float(normal_density(math.log(max(extent)), 0.0, LOG_FACTOR_SPREAD))
    total = sum(weights.values())
    return {name: weight / total for name, weight in weights.items()}
