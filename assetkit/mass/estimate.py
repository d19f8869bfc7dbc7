"""Mass (kg), mass centre (m) and inertia (kg m2) with bounds: as the source states, else geometry times density."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.mass.bounds import MassBounds, bounds_around, elementwise, fill_factors, mass_bounds, wall_factors
from assetkit.mass.category_mass import CategoryMassEstimate, category_mass
from assetkit.mass.parts import MassEvidenceInputs, SubstanceBody, substance_bodies
from assetkit.mass.source_inertials import applicable_statements
from assetkit.mass.substances import STATED_CONFIDENCE, STATED_TOLERANCE
from assetkit.taxonomy.material_classes import UNKNOWN
from geom.mass.inertia import combine, combine_volumes, scaled, sheet_volume
from geom.solid.solid_volume import volume_properties
from schemas.arrays import FloatArray
from schemas.asset import MassPart, Matrix3, Vec3, matrix3, vec3
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, Source, declared, inferred
from schemas.outcome import Repair
from schemas.physics import MassProperties, Solid

COM_SLACK_SHARE, STATED_COM_SLACK_SHARE = 0.05, 0.01
CORE_TRUST = 0.5  # Inner shells are filled or empty: unknown.
REPORTED_SHARE = 0.02  # Overlaps of materials that change the mass by less are not reported.
CATEGORY_MASS_TRUST = 0.6  # The mass of a category is the median of a wide range, however sure the category.
CATEGORY_DENSITY_METHOD = "as dense as makes it weigh what such things weigh"
UNIFORMITY = 0.7  # confidence that the density is the same everywhere
# Confidence of area times wall thickness, by the source of the thickness.
WALL_TRUST: dict[Source, float] = {"declared": 0.9, "measured": 0.9, "inferred": 0.4, "default": 0.2}


@dataclass(frozen=True)
class MassEvidence:
    """The mass properties to use, the evidence for each of them, and findings and repairs on the source.

    `members` are the numbers of the meshes of each of `parts`.
    """

    properties: MassProperties
    material: Evidence[str]
    density_kgm3: Evidence[float]
    mass_kg: Evidence[float]
    centre_of_mass_m: Evidence[Vec3]
    inertia_kgm2: Evidence[Matrix3]
    parts: tuple[MassPart, ...]
    members: tuple[tuple[int, ...], ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()


def mass_evidence(solid: Solid, whole: Sequence[str], mass_inputs: MassEvidenceInputs) -> MassEvidence:
    """Mass properties of `solid`; `whole` are names of the object as such (file).

    Each substance (`substances_of`) has the mass that its source states, if plausible (`check_statement`), else its
    volume times its density; bodies of several substances are composed, overlaps counted once (`divide_volume`). An
    unknown material leaves mass and inertia `default` with confidence 0; their bounds still hold. The value is never
    clamped to usual masses. Raises ValueError when all points of `solid` coincide.
    """
    _, method, trust = volume_properties(solid)
    if solid.core is not None:
        method, trust = f"{method}, inner shells filled", trust * CORE_TRUST
    masses, notes = applicable_statements(mass_inputs.masses, mass_inputs.as_read)
    parts, exact, checked = substance_bodies(solid, whole, mass_inputs, masses)
    total = combine([part.body for part in parts if part.body.mass_kg > 0.0])
    filling = fill_factors(solid, mass_inputs.wall, mass_inputs.cavities)
    substances, volumes = [part.substance for part in parts], [part.volume.volume_m3 for part in parts]
    value = total.mass_kg
    bounds = mass_bounds(
        substances, volumes, [part.body.mass_kg for part in parts], filling, mass_inputs.unit, exact=exact
    )
    if all(part.alternative is not None for part in parts):
        alternative_kg = [part.alternative_body.mass_kg for part in parts]
        alternative_m3 = [(part.alternative or part.volume).volume_m3 for part in parts]
        bounds = bounds.union(
            mass_bounds(substances, alternative_m3, alternative_kg, filling, mass_inputs.unit, exact=exact),
            "what parts share may be of either",
            total.mass_kg,
        )
    of_category = _category_mass(solid, parts, mass_inputs)
    if of_category is not None:
        bounds = _category_bounds(bounds, of_category, parts, mass_inputs)
        value = min(max(of_category.value_kg, bounds.low), bounds.high)
    possible = bounds
    if mass_inputs.category_range_kg is not None and _source(parts) != "declared":
        bounds = bounds.clipped_to(mass_inputs.category_range_kg, _range_text(mass_inputs), value)
    if of_category is not None:
        parts = [_rescaled(part, value, total.mass_kg, bounds, of_category, mass_inputs) for part in parts]
        total = combine([part.body for part in parts if part.body.mass_kg > 0.0])
    wall_trust = WALL_TRUST["default" if mass_inputs.wall is None else mass_inputs.wall.source]
    if solid.kind == "shell":
        trust = wall_trust
    elif solid.walls is not None:
        share = solid.walls.volume_m3 / volume_properties(solid)[0].volume_m3
        method, trust = f"{method}, walls grown from sheets", (1.0 - share) * trust + share * wall_trust
    mass_trust = trust if of_category is None else 1.0  # It follows from the outer size alone.
    return MassEvidence(
        properties=total,
        material=parts[int(np.argmax(volumes))].substance.material,
        density_kgm3=_density(parts, total, bounds),
        mass_kg=_mass(parts, total, bounds, method, mass_trust * mass_inputs.unit.confidence),
        centre_of_mass_m=_centre(solid, parts, total, method, trust, mass_inputs),
        inertia_kgm2=_inertia(solid, parts, total, bounds, method, trust * mass_inputs.unit.confidence),
        parts=tuple(_recorded(part, sum(volumes), total.mass_kg) for part in parts),
        members=tuple(part.substance.meshes for part in parts),
        diagnostics=(
            *notes,
            *(d for c in checked for d in c.diagnostics),
            *_overlaps(parts, total),
            *_category_findings(possible, mass_inputs),
        ),
        repairs=tuple(r for c in checked for r in c.repairs),
    )


def _category_mass(
    solid: Solid, parts: Sequence[SubstanceBody], mass_inputs: MassEvidenceInputs
) -> CategoryMassEstimate | None:
    """The mass of the category at this size; None where the source states a mass, or the category excludes the size."""
    stated = any(p.substance.stated is not None or p.substance.density_kgm3.source == "declared" for p in parts)
    if stated or not mass_inputs.category:
        return None
    of_category = category_mass(solid, mass_inputs.category, mass_inputs.names, mass_inputs.excluded_row)
    least, most = mass_inputs.category_range_kg or (0.0, np.inf)
    return (
        of_category if of_category is not None and of_category.low_kg <= most and least <= of_category.high_kg else None
    )


def _category_bounds(
    geometric: MassBounds,
    of_category: CategoryMassEstimate,
    parts: Sequence[SubstanceBody],
    mass_inputs: MassEvidenceInputs,
) -> MassBounds:
    """Bounds of the category; where all materials are known, intersected with the bounds of volume times density."""
    around = bounds_around(
        of_category.value_kg, of_category.low_kg, of_category.high_kg, mass_inputs.unit, of_category.text
    )
    known = all(part.substance.material.value != UNKNOWN for part in parts)
    return around.intersected_with(geometric) if known else around


def _rescaled(
    part: SubstanceBody,
    mass_kg: float,
    from_kg: float,
    bounds: MassBounds,
    of_category: CategoryMassEstimate,
    mass_inputs: MassEvidenceInputs,
) -> SubstanceBody:
    """`part` with its density scaled so that the whole weighs `mass_kg` instead of `from_kg`."""
    density = part.substance.density_kgm3.value * mass_kg / from_kg
    evidence = inferred(
        density,
        f"{CATEGORY_DENSITY_METHOD}: {of_category.text}",
        CATEGORY_MASS_TRUST * mass_inputs.category_confidence,
        bounds=(density * bounds.low / mass_kg, density * bounds.high / mass_kg),
        inputs=(mass_inputs.category,),
    )
    substance = replace(part.substance, density_kgm3=evidence)
    return replace(part, substance=substance, body=scaled(part.body, mass_kg / from_kg))


def _range_text(mass_inputs: MassEvidenceInputs) -> str:
    low, high = mass_inputs.category_range_kg or (0.0, 0.0)
    return f"things of category {mass_inputs.category} weigh {low:g} to {high:g} kg"


def _category_findings(bounds: MassBounds, mass_inputs: MassEvidenceInputs) -> list[Diagnostic]:
    """A finding when the bounds and the range of the category do not overlap; the range is not used then."""
    if mass_inputs.category_range_kg is None or bounds.overlaps(mass_inputs.category_range_kg):
        return []
    headline = f"{_range_text(mass_inputs)}, this one {bounds.low:.3g} to {bounds.high:.3g} kg"
    return [finding("asset/category-contradicted", headline)]


def _overlaps(parts: Sequence[SubstanceBody], total: MassProperties) -> list[Diagnostic]:
    """A finding when parts share volume and its assignment changes the mass by 2 % or more."""
    alternative_kg = sum(part.alternative_body.mass_kg for part in parts)
    if abs(alternative_kg - total.mass_kg) < REPORTED_SHARE * total.mass_kg:
        return []
    densest = max(parts, key=lambda part: part.substance.density_kgm3.value).substance.material.value
    headline = f"parts of different materials overlap: {densest} keeps what they share ({parts[0].overlap_reason})"
    return [
        finding(
            "asset/overlapping-bodies",
            headline,
            value=total.mass_kg,
            bound=alternative_kg,
            unit="kg, if the others keep it",
        )
    ]


def _mass(
    parts: Sequence[SubstanceBody], total: MassProperties, bounds: MassBounds, method: str, trust: float
) -> Evidence[float]:
    return Evidence(
        value=total.mass_kg,
        source=_source(parts),
        method=f"{_method(parts, method)}; {bounds.text}",
        confidence=_confidence(parts, total, trust),
        bounds=(bounds.low, bounds.high),
        inputs=_inputs(parts),
    )


def _inertia(
    solid: Solid, parts: Sequence[SubstanceBody], total: MassProperties, bounds: MassBounds, method: str, trust: float
) -> Evidence[Matrix3]:
    stated = all(p.substance.stated is not None and p.substance.stated.inertia is not None for p in parts)
    ratios = (1.0 - STATED_TOLERANCE, 1.0 + STATED_TOLERANCE) if stated else bounds.ratios(total.mass_kg)
    if not stated and any(p.substance.density_kgm3.method.startswith(CATEGORY_DENSITY_METHOD) for p in parts):
        ratios = ratios[0], ratios[1] * _hollow_factor(solid)
    low, high = elementwise(total.inertia_kgm2, *ratios)
    spread = "spread evenly"
    if any(p.squeeze is not None for p in parts):  # Anything from half of it to the even filling.
        spread = "squeezed to fit about the stated mass centre"
        unsqueezed_kgm2 = combine([p.unsqueezed_body for p in parts if p.volume.volume_m3 > 0.0]).inertia_kgm2
        narrow, wide = elementwise(total.inertia_kgm2, 0.5, 1.0), elementwise(unsqueezed_kgm2, *ratios)
        low, high = np.minimum.reduce([low, *narrow, *wide]), np.maximum.reduce([high, *narrow, *wide])
    return Evidence(
        value=matrix3(total.inertia_kgm2),
        source="declared" if stated else "inferred" if _source(parts) == "declared" else _source(parts),
        method=_method(parts, method) if stated else f"{_method(parts, method)}, {spread}",
        confidence=STATED_CONFIDENCE if stated else _confidence(parts, total, trust) * UNIFORMITY,
        bounds=(matrix3(low), matrix3(high)),
        inputs=_inputs(parts),
    )


def _hollow_factor(solid: Solid) -> float:
    """Ratio of the inertia of the surface to that of the evenly filled body of the same mass; at least 1."""
    filled, sheet = volume_properties(solid)[0], sheet_volume(solid.points, solid.triangles, 1.0)
    per_volume = np.trace(sheet.second_moment_m5) / sheet.volume_m3
    return max(1.0, float(per_volume * filled.volume_m3 / np.trace(filled.second_moment_m5)))


def _centre(
    solid: Solid,
    parts: Sequence[SubstanceBody],
    total: MassProperties,
    method: str,
    trust: float,
    mass_inputs: MassEvidenceInputs,
) -> Evidence[Vec3]:
    """From the centre of the evenly filled body to that of its surface, 5 % of the extent around; 1 % if stated.

    Where inner shells may be cavities the centre of what is left then is within the bounds too; where walls were grown
    from sheets, the centres with the thinnest and the thickest.

    The asset's origin is its bottom centre, so an uncertain unit moves the centre in proportion.
    """
    stated = all(p.substance.stated is not None and p.substance.stated.centre is not None for p in parts)
    extent = np.ptp(solid.points, axis=0)
    if stated:
        slack = STATED_COM_SLACK_SHARE * extent
        bounds = (vec3(total.centre_of_mass_m - slack), vec3(total.centre_of_mass_m + slack))
        text = "; ".join(dict.fromkeys(p.substance.stated.method for p in parts if p.substance.stated))
        return Evidence(
            value=vec3(total.centre_of_mass_m),
            source="declared",
            method=text,
            confidence=STATED_CONFIDENCE,
            bounds=bounds,
            inputs=_inputs(parts),
        )
    surface = sheet_volume(solid.points, solid.triangles, 1.0).centre_m
    even = combine_volumes([p.volume for p in parts if p.volume.volume_m3 > 0.0]).centre_m
    alternative = combine([p.alternative_body for p in parts if p.alternative_body.mass_kg > 0.0]).centre_of_mass_m
    extremes = [_with_walls(solid, even, factor) for factor in wall_factors(mass_inputs.wall)]
    centres = np.stack(
        [
            total.centre_of_mass_m,
            even,
            surface,
            alternative,
            _without_core(solid, even),
            *extremes,
        ]
    )
    factors = np.array([1.0, *(bound / mass_inputs.unit.value for bound in mass_inputs.unit.bounds or ())])
    centres = (centres * factors[:, None, None]).reshape(-1, 3)
    slack = COM_SLACK_SHARE * extent
    alike = len(parts) == 1 and parts[0].substance.stated is None and solid.core is None and solid.walls is None
    geometric: Source = "measured" if solid.kind == "closed" and alike else "inferred"
    return Evidence(
        value=vec3(total.centre_of_mass_m),
        source=geometric,
        method=f"{method}, {'uniform density' if len(parts) == 1 else 'each substance evenly'}",
        confidence=trust * UNIFORMITY,
        bounds=(vec3(centres.min(axis=0) - slack), vec3(centres.max(axis=0) + slack)),
    )


def _without_core(solid: Solid, filled_centre_m: FloatArray) -> FloatArray:
    """The mass centre (3,) when what inner shells hold is empty."""
    if solid.core is None:
        return filled_centre_m
    whole, core = volume_properties(solid)[0], solid.core
    moment_m4 = whole.volume_m3 * whole.centre_m - core.volume_m3 * core.centre_m
    return moment_m4 / (whole.volume_m3 - core.volume_m3)


def _with_walls(solid: Solid, centre_m: FloatArray, factor: float) -> FloatArray:
    """The mass centre (3,) when the walls grown from sheets are thicker by a factor."""
    if solid.walls is None:
        return centre_m
    whole, walls = volume_properties(solid)[0], solid.walls
    more_m3 = (factor - 1.0) * walls.volume_m3
    moment_m4 = whole.volume_m3 * whole.centre_m + more_m3 * walls.centre_m
    return moment_m4 / (whole.volume_m3 + more_m3)


def _density(parts: Sequence[SubstanceBody], total: MassProperties, bounds: MassBounds) -> Evidence[float]:
    """That of the substance; with several, or a stated mass, total mass over total volume."""
    if len(parts) == 1 and parts[0].substance.stated is None:
        return parts[0].substance.density_kgm3
    volume = sum(p.volume.volume_m3 for p in parts)
    return Evidence(
        value=total.mass_kg / volume,
        source="inferred",
        method="effective: total mass over total volume",
        confidence=_confidence(parts, total, 1.0),
        bounds=(bounds.low / volume, bounds.high / volume),
        inputs=_inputs(parts),
    )


def _recorded(part: SubstanceBody, volume_m3: float, mass_kg: float) -> MassPart:
    density = part.substance.density_kgm3
    stated = part.substance.stated
    if stated is not None:
        effective = part.body.mass_kg / part.volume.volume_m3
        density = declared(effective, f"{stated.method} over volume", inputs=(str(stated.where),))
    return MassPart(
        meshes=part.substance.names,
        material=part.substance.material,
        density_kgm3=density,
        volume_share=part.volume.volume_m3 / volume_m3,
        mass_share=part.body.mass_kg / mass_kg,
    )


def _source(parts: Sequence[SubstanceBody]) -> Source:
    """`declared` when the source states every mass, `default` when nothing at all is known."""
    if all(p.substance.stated is not None for p in parts):
        return "declared"
    known = any(p.substance.stated is not None or p.substance.density_kgm3.source != "default" for p in parts)
    return "inferred" if known else "default"


def _method(parts: Sequence[SubstanceBody], geometric: str) -> str:
    """The methods of all masses in words."""
    stated = dict.fromkeys(p.substance.stated.method for p in parts if p.substance.stated is not None)
    densities = dict.fromkeys(p.substance.density_kgm3.method for p in parts if p.substance.stated is None)
    overlap = [parts[0].overlap_reason] if parts[0].overlap_reason else []
    return "; ".join([*stated, *(f"{geometric} times density: {method}" for method in densities), *overlap])


def _inputs(parts: Sequence[SubstanceBody]) -> tuple[str, ...]:
    places = [str(p.substance.stated.where) for p in parts if p.substance.stated is not None]
    names = [name for p in parts if p.substance.stated is None for name in p.substance.density_kgm3.inputs]
    return tuple(dict.fromkeys([*places, *names]))


def _confidence(parts: Sequence[SubstanceBody], total: MassProperties, trust: float) -> float:
    """By share of mass; `trust` in the geometry counts only where it gave the mass."""
    return sum(
        p.body.mass_kg / total.mass_kg * p.confidence * (1.0 if p.substance.stated is not None else trust)
        for p in parts
    )
