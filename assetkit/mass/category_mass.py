"""Mass (kg) of an object from its size and category: a mixture of log-normals over the kinds of the category."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.mass.bounds import MODELLED_WALL_SHARE, mean_thickness
from assetkit.mass.normal_mixture import NormalMixture
from assetkit.taxonomy.category_masses import Basis, CategoryMass, masses_of_kind
from assetkit.taxonomy.words import singulars, words_of
from geom.convex.hull import convex_hull, volume
from geom.convex.primitive_fits import fit_box
from geom.mesh.surface_distance import triangle_areas
from geom.mesh.weld import diagonal
from schemas.physics import Solid

# The bounds hold this share of the mixture at most; what is left is as likely below as above.
COVERAGE = 0.95
# Bounds further apart than this are of little use to a planner: they cover less of the mixture instead, and record it.
MAX_CATEGORY_SPAN = 10.0
# A range of the table holds 95 % of its kind, so that it is this many standard deviations wide.
RANGE_SIGMAS = 3.92
# Standard deviations in ln(mass): how well a size on a basis is known, scans being larger than the thing, and how much
# another thing of the same kind differs from a single measured one.
SIZE_SIGMA: dict[Basis, float] = {"hull": 0.1, "wall": 0.15, "length": 0.1}
SINGLE_SIGMA = 0.25
# A surface this much larger than its hull has an inside too; a vessel without has about this share of its hull's area.
TWO_SIDED, VESSEL_SHARE = 1.25, 0.75


@dataclass(frozen=True)
class CategoryMassEstimate:
    """Mass (kg) of objects of a category and size: median, bounds that contain the share `coverage`, rows used."""

    coverage: float
    low_kg: float
    value_kg: float
    high_kg: float
    category: str
    kinds: tuple[CategoryMass, ...]

    @property
    def text(self) -> str:
        """Category, share, bounds and sources in words."""
        states = sorted({kind.state for kind in self.kinds} - {"solid"})
        state = f", {' or '.join(states)}" if states else ""
        sources = dict.fromkeys(kind.source for kind in self.kinds)
        share = f"{100.0 * self.coverage:.0f} % of things of category {self.category} and this size{state}"
        return f"{share} weigh {self.low_kg:.3g} to {self.high_kg:.3g} kg: {'; '.join(sources)}"


def category_mass(solid: Solid, category: str, names: Sequence[str], without: str = "") -> CategoryMassEstimate | None:
    """Mass of an object of `category` with the surface of `solid`; None for a category outside the table.

    `names`, the most specific first, may identify the kind (`soup` can, `paper` cup). Each kind is log-normal in mass,
    its variance that of its range and of the size; the bounds are quantiles of the mixture of kinds. `without` leaves
    out the row written from that object.
    """
    kinds = masses_of_kind(category, [name_words(name) for name in names], without)
    mixed = mixture_of(solid, kinds)
    if mixed is None:
        return None
    coverage = mixed.coverage_within(math.log(MAX_CATEGORY_SPAN), COVERAGE)
    low, high = mixed.central_interval(coverage)
    return CategoryMassEstimate(coverage, math.exp(low), math.exp(mixed.quantile(0.5)), math.exp(high), category, kinds)


def mixture_of(solid: Solid, kinds: Sequence[CategoryMass]) -> NormalMixture | None:
    """Distribution of ln(mass / kg) for these kinds and the surface of `solid`; None without kinds or size."""
    bases: set[Basis] = {kind.basis for kind in kinds}
    try:
        sizes = {basis: reference_size(solid, basis) for basis in bases}
    except ValueError:  # Flat: it has no hull.
        return None
    if not sizes or min(sizes.values()) <= 0.0:
        return None
    ranges = np.log([kind.range for kind in kinds])
    means = ranges.mean(axis=1) + np.log([sizes[kind.basis] for kind in kinds])
    standard_deviations = np.array(
        [_sigma(kind, width) for kind, width in zip(kinds, np.ptp(ranges, axis=1), strict=True)]
    )
    return NormalMixture(means, standard_deviations, np.array([kind.weight for kind in kinds]))


def name_words(name: str) -> frozenset[str]:
    """The words of a name, and their singular forms."""
    words = words_of(name)
    return frozenset((*words, *(form for word in words for form in singulars(word))))


def reference_size(solid: Solid, basis: Basis) -> float:
    """Volume of the hull (m3), one-sided area of the walls (m2) or the cube of the length (m3)."""
    if basis == "length":
        box = fit_box(solid.points)
        return float(max(box.size_m if box is not None else np.ptp(solid.points, axis=0))) ** 3
    hull = convex_hull(solid.points)
    return volume(*hull) if basis == "hull" else _wall_area(solid, float(triangle_areas(hull[0][hull[1]]).sum()))


def _sigma(kind: CategoryMass, width: float) -> float:
    of_range = width / RANGE_SIGMAS if width > 0.0 else SINGLE_SIGMA
    return math.hypot(of_range, SIZE_SIGMA[kind.basis])


def _wall_area(solid: Solid, hull_m2: float) -> float:
    """Area of one side of the walls of a vessel (m2): of its sheets, or half of a surface that has an inside."""
    area = float(triangle_areas(solid.points[solid.triangles]).sum())
    if solid.kind == "shell":
        return area / 2.0 if area > TWO_SIDED * hull_m2 else area
    if solid.kind == "closed" and (
        area > TWO_SIDED * hull_m2 or mean_thickness(solid) <= MODELLED_WALL_SHARE * diagonal(solid.points)
    ):
        return area / 2.0
    return VESSEL_SHARE * hull_m2
