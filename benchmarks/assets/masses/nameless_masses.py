"""Compares methods to bound the mass of objects of unknown category, by the width of the bounds.

    python -m benchmarks.assets.masses.nameless_masses

Things of `named_masses.csv` and `everyday_masses.csv` as plain shapes, 216 in all. Six ways, each with the factor
between the bounds that holds nine things of ten (each thing judged by the others only), and how many the same way holds
within a factor of ten:

size law      density falls with the root of size, as `unknown_density` has it.
one density   one density of the convex hull for all.
regression    least squares of ln(mass) on hull volume, mean thickness, slenderness and fill.
squares       the same with the squares of hull volume, thickness and fill, and their products.
like things   median density of the hull of the ten things most like it in size and form.
categories    the mixture of all categories whose sizes and form fit, with their usual masses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.spatial.distance import cdist

from assetkit.annotate.shape_check import compare, misfit, shape_of
from assetkit.mass.bounds import mean_thickness
from assetkit.mass.category_mass import mixture_of
from assetkit.mass.normal_mixture import NormalMixture
from assetkit.mass.unknown_density import unknown_density
from assetkit.taxonomy.category_masses import masses_of_kind
from assetkit.taxonomy.tables import categories
from benchmarks.assets.masses import everyday, named_masses
from geom.convex.hull import convex_hull, volume
from schemas.arrays import FloatArray
from schemas.physics import Solid

HELD, SPAN = 0.9, 10.0
LIKE = 10


def main() -> None:
    table = [(t.solid, t.mass_kg) for t in (*named_masses.things(), *everyday.things())]
    solids, masses = [solid for solid, _ in table], np.log([mass for _, mass in table])
    hulls = np.log([volume(*convex_hull(solid.points)) for solid in solids])
    law = np.array([math.log(_law_kg(solid)) for solid in solids])
    report("size law", masses - law)
    report("one density", masses - hulls)
    features = np.column_stack([np.ones(len(solids)), hulls, [_features(solid) for solid in solids]])
    report("regression", masses - left_out_predictions(features, masses))
    hull, thick, solidity = features[:, 1], features[:, 2], features[:, 6]
    squares = np.column_stack([hull**2, thick**2, solidity**2, hull * thick, thick * solidity])
    report("squares", masses - left_out_predictions(np.column_stack([features, squares]), masses))
    report("like things", masses - hulls - of_like_things(features[:, 1:], masses - hulls))
    mixtures = [among_categories(solid) for solid in solids]
    known = [(mixture, mass) for mixture, mass in zip(mixtures, masses, strict=True) if mixture is not None]
    bounds = np.array([mixture.central_interval(HELD) for mixture, _ in known])
    inside = sum(low <= mass <= high for (low, high), (_, mass) in zip(bounds, known, strict=True))
    width = math.exp(float(np.ptp(bounds, axis=1).mean()))
    held = f"{inside} of {len(known)} inside the central {100 * HELD:.0f} %"
    print(f"categories: {held}, x{width:.1f} in the geometric mean")
    report("categories", np.array([mass - mixture.quantile(0.5) for mixture, mass in known]))


def report(title: str, errors: FloatArray) -> None:
    """The factor that holds nine of ten `errors` in ln(mass) about the middle of the others, and how many x10 holds."""
    shifted = np.array([error - np.median(np.delete(errors, i)) for i, error in enumerate(errors)])
    low, high = np.quantile(shifted, [0.5 - HELD / 2.0, 0.5 + HELD / 2.0])
    within = int((np.abs(shifted) <= 0.5 * math.log(SPAN)).sum())
    print(f"{title}: nine of ten within x{math.exp(high - low):.1f}; {within} of {len(errors)} within x{SPAN:g}")


def left_out_predictions(features: FloatArray, values: FloatArray) -> FloatArray:
    """(n,) of each value by least squares on all others (the leave-one-out identity of the hat matrix)."""
    hat = features @ np.linalg.pinv(features)
    share = np.diag(hat)
    return (hat @ values - share * values) / (1.0 - share)


def of_like_things(features: FloatArray, values: FloatArray) -> FloatArray:
    """(n,) median of the values of the ten others that are nearest in standardised features (n, k)."""
    apart = cdist(features, features, "seuclidean")
    np.fill_diagonal(apart, np.inf)
    return np.median(values[np.argsort(apart, axis=1, kind="stable")[:, :LIKE]], axis=1)


def among_categories(solid: Solid) -> NormalMixture | None:
    """The usual masses of all categories that the shape allows, one weight each; None when it allows none."""
    shape = shape_of(solid.points, solid)
    fitting = [
        category
        for category in categories().values()
        if misfit(category, shape.extents_m) <= 1.0 and all(f.remaining_chance >= 1.0 for f in compare(category, shape))
    ]
    kinds = [
        (kind, sum(k.weight for k in masses_of_kind(c.id, []))) for c in fitting for kind in masses_of_kind(c.id, [])
    ]
    return mixture_of(solid, [kind.model_copy(update={"weight": kind.weight / total}) for kind, total in kinds])


def _law_kg(solid: Solid) -> float:
    density = unknown_density(solid)
    return (density.value if density else 500.0) * volume(solid.points, solid.triangles)


def _features(solid: Solid) -> Sequence[float]:
    hull = volume(*convex_hull(solid.points))
    shape = shape_of(solid.points, solid)
    short, middle, long = shape.extents_m
    return (
        math.log(mean_thickness(solid)),
        math.log(short / middle),
        math.log(middle / long),
        shape.fill or 0.0,
        volume(solid.points, solid.triangles) / hull,
    )


if __name__ == "__main__":
    main()
