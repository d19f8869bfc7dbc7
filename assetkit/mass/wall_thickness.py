"""Wall thickness (m) of an open surface: as the user states, as a render material hints, else a guess by size."""

from __future__ import annotations

from collections.abc import Sequence

from geom.solid.solidify import assumed_wall_m
from schemas.appearance.material import Material
from schemas.evidence import Evidence, declared, default, inferred

# The true wall of a sheet is within these factors of the guess by size (`assumed_wall_m`).
SHEET_WALL_FACTORS = (0.4, 2.5)
# KHR_materials_volume gives the thickness that light passes through, for rendering; often that of the whole body.
HINT_FACTORS, HINT_CONFIDENCE = (0.5, 2.0), 0.4
LEAST_M, MOST_SHARE = 1e-4, 0.05  # A hint outside these is no wall: metres, share of the diagonal.


def wall_evidence(
    size: float, *, stated_m: float | None, materials: Sequence[Material], meters_per_unit: float
) -> Evidence[float]:
    """The wall thickness (m) of the sheets of an asset with the diagonal `size` (m), and where it comes from.

    As the user states, else as a render material hints, else the one assumed in `geom.solid.solidify`.
    """
    if stated_m is not None:
        return declared(stated_m, "--shell-thickness")
    hint_m = _hinted(materials, meters_per_unit)
    if LEAST_M <= hint_m <= MOST_SHARE * size:
        bounds = (HINT_FACTORS[0] * hint_m, HINT_FACTORS[1] * hint_m)
        return inferred(hint_m, "KHR_materials_volume thicknessFactor", HINT_CONFIDENCE, bounds=bounds)
    guess = assumed_wall_m(size)
    bounds = (SHEET_WALL_FACTORS[0] * guess, SHEET_WALL_FACTORS[1] * guess)
    return default(guess, "1 % of the diagonal, within 0.5 and 5 mm", bounds=bounds)


def _hinted(materials: Sequence[Material], meters_per_unit: float) -> float:
    """The largest thickness that a material states (m), 0 when none does."""
    thicknesses = [material.volume.thickness for material in materials if material.volume is not None]
    return max(thicknesses, default=0.0) * meters_per_unit
