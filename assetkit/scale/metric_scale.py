"""Which scale does meaning give numbers whose unit nobody states? Bayes over units, with the size of its category.

Hypotheses are the common units with the habits of tools and formats (`unit_size`), numbers that were normalised (the
longest edge or the diagonal of the box is 1 or 2), and any other factor. The likelihood is how usual the size is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from assetkit.mass.normal_mixture import normal_density
from assetkit.options import METERS_PER_UNIT
from assetkit.scale.size_prior import Belief, size_belief
from assetkit.scale.unit_posterior import prior_of, roundness
from assetkit.taxonomy.tables import Category
from schemas.evidence import Evidence, inferred

# How likely numbers are normalised, or in no unit at all, before they are looked at.
NORMALISED, ANY_FACTOR = 0.05, 0.05
# A length is normalised when it is 1 or 2 to this share; a designed length is just that with a chance as if it were
# this many times as usual.
EXACT, DESIGNED = 1e-4, 20.0
FACTORS = math.log(10.0)  # Things in no unit are some ten times larger or smaller than 1 (standard deviation).
SURE = 0.8  # From this chance on a unit is taken; what has no unit takes the size of its category ...
WIDEST = 5.0  # ... unless its bounds are further apart than this.
LEAST = 0.04  # Units less likely than this are left out of the bounds.
WITHIN = (0.04, 0.5, 0.96)


class Scale(NamedTuple):
    """Metres per unit with its evidence, the reading in words, and whether a person must decide."""

    meters_per_unit: Evidence[float]
    reading: str
    review: bool


def scale_of(
    extent: tuple[float, float, float],
    edges: Sequence[float],
    category: Category | None,
    holds: float,
    *,
    format_: str,
    hints: Sequence[str] = (),
    implied: str | None = None,
    without: str = "",
) -> Scale:
    """The scale of a thing by what it is. `extent` is its bounding box and `edges` those of its smallest box, sorted,
    both in source units; `holds` is the chance of its `category`; `implied` the unit that the format's standard
    prescribes. `without` leaves out a thing of known size by its name.
    """
    belief = size_belief(edges, category, holds, without)
    chances = _chances(extent, belief, prior_of(format_, hints, implied))
    low, middle, high = belief.quantiles(WITHIN)
    unit = max(METERS_PER_UNIT, key=lambda u: chances[u])
    free = chances["normalised"] + chances["any factor"]
    spanned = [METERS_PER_UNIT[u] for u in METERS_PER_UNIT if chances[u] >= LEAST]
    if free >= LEAST:
        spanned += [low, high]
    what = category.id if category else "an unknown thing"
    clues = (*(f"{name}: {chance:.0%}" for name, chance in chances.items() if chance >= LEAST), *belief.anchors)
    if chances[unit] >= free:
        scale, chance = METERS_PER_UNIT[unit], chances[unit]
        reading = f"in {unit} it has the size of {what}"
    else:
        scale, chance = middle, free
        reading = f"the numbers are {'normalised' if chances['normalised'] > 0.5 * free else 'in no usual unit'}"
        reading += f", so it takes the size of {what}"
    bounds = (min(*spanned, scale), max(*spanned, scale))
    sure = chance >= SURE and category is not None and bounds[1] <= WIDEST * bounds[0]
    method = f"units and sizes of things like {what}: {reading}"
    confidence = round(chance * holds if chances[unit] >= free else 0.5 * chance * holds, 3)
    evidence = inferred(scale, method, confidence, bounds=bounds if bounds[0] < bounds[1] else None, inputs=clues)
    return Scale(evidence, reading, review=not sure)


def is_normalised(extent: Sequence[float]) -> bool:
    """Whether the longest edge or the diagonal of a box is 1 or 2, and the box no cube of that size."""
    telling = (max(extent), math.hypot(*extent))
    exact = any(math.isclose(length, whole, rel_tol=EXACT) for length in telling for whole in (1.0, 2.0))
    return exact and not all(math.isclose(e, max(extent), rel_tol=EXACT) for e in extent)


def _chances(extent: tuple[float, float, float], belief: Belief, prior: dict[str, float]) -> dict[str, float]:
    """Of each unit, of `normalised` and of `any factor`; sums to 1."""
    exact = is_normalised(extent)
    weights = {
        unit: (1.0 - NORMALISED - ANY_FACTOR)
        * prior[unit]
        * belief.density(METERS_PER_UNIT[unit])
        * roundness(extent, unit)
        * (DESIGNED if exact else 1.0)
        for unit in METERS_PER_UNIT
    }
    weights["normalised"] = NORMALISED / (2.0 * EXACT) / 2.0 if exact else 0.0
    weights["any factor"] = ANY_FACTOR * float(normal_density(math.log(max(extent)), 0.0, FACTORS))
    total = sum(weights.values())
    return {name: weight / total for name, weight in weights.items()}
