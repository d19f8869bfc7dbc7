"""Mass, mass centre and inertia with honest bounds: what the source states, else geometry times density."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.mass.bounds import Bounds, bounds_around, elementwise, filling_of, mass_bounds, wall_factors
from assetkit.mass.category_mass import Usual, usual_mass
from assetkit.mass.parts import STATED_CONFIDENCE, Clues, Part, parts_of
from assetkit.mass.source_inertials import applicable
from assetkit.mass.substances import STATED_TOLERANCE
from assetkit.taxonomy.material_classes import UNKNOWN
from geom.mass.inertia import combine, mass_properties, of_sheet, scaled
from schemas.asset import MassPart, Matrix3, Vec3, matrix3, vec3
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, Source, declared, inferred
from schemas.model import FloatArray
from schemas.outcome import Repair
from schemas.physics import MassProperties, Solid

COM_SLACK_SHARE, STATED_COM_SLACK_SHARE = 0.05, 0.01
CORE_TRUST = 0.5  # Shells inside are filled or empty: nothing tells.
TOLD_SHARE = 0.02  # Overlaps of materials that change the mass by less are not told.
USUAL_TRUST = 0.6  # The usual mass is the middle of a wide range, however sure the category.
USUAL = "as dense as makes it weigh what such things weigh"
UNIFORMITY = 0.7  # how much to trust that the density is the same everywhere
# How much to trust area times wall thickness, by how the thickness is known.
WALL_TRUST: dict[Source, float] = {"declared": 0.9, "measured": 0.9, "inferred": 0.4, "default": 0.2}


@dataclass(frozen=True)
class MassEvidence:
    """The mass properties to use, what is known about each of them, and what was wrong in the source.

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


def mass_evidence(solid: Solid, whole: Sequence[str], clues: Clues) -> MassEvidence:
    """Mass properties of `solid`; `whole` are names of the object as such (file).

    Each substance (`substances_of`) has the mass its source states, if that can be true (`judge`), else its volume
    times its density; bodies of several substances are composed, overlaps counted once (`divide`). An unknown material
    leaves mass and inertia `default` with confidence 0; their bounds still hold. The value is never clamped: a feather
    weighs what it weighs. Raises ValueError when all points of `solid` coincide.
    """
    _, method, trust = mass_properties(solid, 1.0)
    if solid.core is not None:
        method, trust = f"{method}, inner shells filled", trust * CORE_TRUST
    masses, notes = applicable(clues.masses, clues.as_read)
    parts, exact, judged = parts_of(solid, whole, clues, masses)
    total = combine([part.body for part in parts if part.body.mass_kg > 0.0])
    filling = filling_of(solid, clues.wall, clues.cavities)
    substances, volumes = [part.substance for part in parts], [part.even.mass_kg for part in parts]
    value = total.mass_kg
    bounds = mass_bounds(substances, volumes, [part.body.mass_kg for part in parts], filling, clues.unit, exact=exact)
    if all(part.rival is not None for part in parts):
        others = [part.rival_body.mass_kg for part in parts]
        rivals = [(part.rival or part.even).mass_kg for part in parts]
        bounds = bounds.or_else(
            mass_bounds(substances, rivals, others, filling, clues.unit, exact=exact),
            "what parts share may be of either",
            total.mass_kg,
        )
    usual = _usual_mass(solid, parts, clues)
    if usual is not None:
        bounds = _as_usual(bounds, usual, parts, clues)
        value = min(max(usual.value_kg, bounds.low), bounds.high)
    possible = bounds
    if clues.usual_kg is not None and _source(parts) != "declared":
        bounds = bounds.within(clues.usual_kg, _range_text(clues), value)
    if usual is not None:
        parts = [_rescaled(part, value, total.mass_kg, bounds, usual, clues) for part in parts]
        total = combine([part.body for part in parts if part.body.mass_kg > 0.0])
    wall_trust = WALL_TRUST["default" if clues.wall is None else clues.wall.source]
    if solid.kind == "shell":
        trust = wall_trust
    elif solid.walls is not None:
        share = solid.walls.mass_kg / mass_properties(solid, 1.0)[0].mass_kg
        method, trust = f"{method}, walls grown from sheets", (1.0 - share) * trust + share * wall_trust
    mass_trust = trust if usual is None else 1.0  # The size of the outside is enough.
    return MassEvidence(
        properties=total,
        material=parts[int(np.argmax(volumes))].substance.material,
        density_kgm3=_density(parts, total, bounds),
        mass_kg=_mass(parts, total, bounds, method, mass_trust * clues.unit.confidence),
        centre_of_mass_m=_centre(solid, parts, total, method, trust, clues),
        inertia_kgm2=_inertia(solid, parts, total, bounds, method, trust * clues.unit.confidence),
        parts=tuple(_recorded(part, sum(volumes), total.mass_kg) for part in parts),
        members=tuple(part.substance.meshes for part in parts),
        diagnostics=(
            *notes,
            *(d for j in judged for d in j.diagnostics),
            *_shared(parts, total),
            *_unusual(possible, clues),
        ),
        repairs=tuple(r for j in judged for r in j.repairs),
    )


def _usual_mass(solid: Solid, parts: Sequence[Part], clues: Clues) -> Usual | None:
    """What things of the category and size weigh; None where the source states a mass, or none has this size."""
    stated = any(p.substance.stated is not None or p.substance.density_kgm3.source == "declared" for p in parts)
    if stated or not clues.category:
        return None
    usual = usual_mass(solid, clues.category, clues.names, clues.without_row)
    least, most = clues.usual_kg or (0.0, np.inf)
    return usual if usual is not None and usual.low_kg <= most and least <= usual.high_kg else None


def _as_usual(geometric: Bounds, usual: Usual, parts: Sequence[Part], clues: Clues) -> Bounds:
    """Bounds of usual things; where all materials are known, what volume times density allows as well."""
    around = bounds_around(usual.value_kg, usual.low_kg, usual.high_kg, clues.unit, usual.text)
    known = all(part.substance.material.value != UNKNOWN for part in parts)
    return around.narrowed(geometric) if known else around


def _rescaled(part: Part, mass_kg: float, from_kg: float, bounds: Bounds, usual: Usual, clues: Clues) -> Part:
    """`part` as dense as makes the whole weigh `mass_kg` instead of `from_kg`: material, hollows and contents."""
    density = part.substance.density_kgm3.value * mass_kg / from_kg
    evidence = inferred(
        density,
        f"{USUAL}: {usual.text}",
        USUAL_TRUST * clues.category_confidence,
        bounds=(density * bounds.low / mass_kg, density * bounds.high / mass_kg),
        inputs=(clues.category,),
    )
    substance = replace(part.substance, density_kgm3=evidence)
    return replace(part, substance=substance, body=scaled(part.body, mass_kg / from_kg))


def _range_text(clues: Clues) -> str:
    low, high = clues.usual_kg or (0.0, 0.0)
    return f"things of category {clues.category} weigh {low:g} to {high:g} kg"


def _unusual(bounds: Bounds, clues: Clues) -> list[Diagnostic]:
    """What is told when no mass that geometry and statements allow is one of the category; these then stand alone."""
    if clues.usual_kg is None or bounds.meets(clues.usual_kg):
        return []
    headline = f"{_range_text(clues)}, this one {bounds.low:.3g} to {bounds.high:.3g} kg"
    return [finding("asset/category-contradicted", headline)]


def _shared(parts: Sequence[Part], total: MassProperties) -> list[Diagnostic]:
    """What is told when parts share volume and who keeps it changes the mass by 2 % or more."""
    other_kg = sum(part.rival_body.mass_kg for part in parts)
    if abs(other_kg - total.mass_kg) < TOLD_SHARE * total.mass_kg:
        return []
    densest = max(parts, key=lambda part: part.substance.density_kgm3.value).substance.material.value
    headline = f"parts of different materials overlap: {densest} keeps what they share ({parts[0].shared})"
    return [
        finding(
            "asset/overlapping-bodies", headline, value=total.mass_kg, bound=other_kg, unit="kg, if the others keep it"
        )
    ]


def _mass(parts: Sequence[Part], total: MassProperties, bounds: Bounds, method: str, trust: float) -> Evidence[float]:
    return Evidence(
        value=total.mass_kg,
        source=_source(parts),
        method=f"{_method(parts, method)}; {bounds.text}",
        confidence=_confidence(parts, total, trust),
        bounds=(bounds.low, bounds.high),
        inputs=_inputs(parts),
    )


def _inertia(
    solid: Solid, parts: Sequence[Part], total: MassProperties, bounds: Bounds, method: str, trust: float
) -> Evidence[Matrix3]:
    stated = all(p.substance.stated is not None and p.substance.stated.inertia is not None for p in parts)
    ratios = (1.0 - STATED_TOLERANCE, 1.0 + STATED_TOLERANCE) if stated else bounds.ratios(total.mass_kg)
    if not stated and any(p.substance.density_kgm3.method.startswith(USUAL) for p in parts):
        ratios = ratios[0], ratios[1] * _hollow_factor(solid)
    low, high = elementwise(total.inertia_kgm2, *ratios)
    spread = "spread evenly"
    if any(p.squeeze is not None for p in parts):  # Anything from half of it to the even filling.
        spread = "squeezed to fit about the stated mass centre"
        even = combine([p.unsqueezed_body for p in parts if p.even.mass_kg > 0.0]).inertia_kgm2
        narrow, wide = elementwise(total.inertia_kgm2, 0.5, 1.0), elementwise(even, *ratios)
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
    """How much more inertia a body has when its mass is all in its surface, as in hollow things; at least 1."""
    even, sheet = mass_properties(solid, 1.0)[0], of_sheet(solid.points, solid.triangles, 1.0, 1.0)
    return max(1.0, float(np.trace(sheet.inertia_kgm2) / sheet.mass_kg * even.mass_kg / np.trace(even.inertia_kgm2)))


def _centre(
    solid: Solid, parts: Sequence[Part], total: MassProperties, method: str, trust: float, clues: Clues
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
    surface = of_sheet(solid.points, solid.triangles, 1.0, 1.0).centre_of_mass_m
    even = combine([p.even for p in parts if p.even.mass_kg > 0.0]).centre_of_mass_m
    rival = combine([p.rival_body for p in parts if p.rival_body.mass_kg > 0.0]).centre_of_mass_m
    extremes = [_with_walls(solid, even, factor) for factor in wall_factors(clues.wall)]
    centres = np.stack([total.centre_of_mass_m, even, surface, rival, _without_core(solid, even), *extremes])
    factors = np.array([1.0, *(bound / clues.unit.value for bound in clues.unit.bounds or ())])
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
    whole, core = mass_properties(solid, 1.0)[0], solid.core
    return (whole.mass_kg * whole.centre_of_mass_m - core.mass_kg * core.centre_of_mass_m) / (
        whole.mass_kg - core.mass_kg
    )


def _with_walls(solid: Solid, centre_m: FloatArray, factor: float) -> FloatArray:
    """The mass centre (3,) when the walls grown from sheets are thicker by a factor."""
    if solid.walls is None:
        return centre_m
    whole, walls = mass_properties(solid, 1.0)[0], solid.walls
    more_kg = (factor - 1.0) * walls.mass_kg
    moment = whole.mass_kg * whole.centre_of_mass_m + more_kg * walls.centre_of_mass_m
    return moment / (whole.mass_kg + more_kg)


def _density(parts: Sequence[Part], total: MassProperties, bounds: Bounds) -> Evidence[float]:
    """That of the substance; with several, or a stated mass, total mass over total volume."""
    if len(parts) == 1 and parts[0].substance.stated is None:
        return parts[0].substance.density_kgm3
    volume = sum(p.even.mass_kg for p in parts)
    return Evidence(
        value=total.mass_kg / volume,
        source="inferred",
        method="effective: total mass over total volume",
        confidence=_confidence(parts, total, 1.0),
        bounds=(bounds.low / volume, bounds.high / volume),
        inputs=_inputs(parts),
    )


def _recorded(part: Part, volume_m3: float, mass_kg: float) -> MassPart:
    density = part.substance.density_kgm3
    stated = part.substance.stated
    if stated is not None:
        effective = part.body.mass_kg / part.even.mass_kg
        density = declared(effective, f"{stated.method} over volume", inputs=(str(stated.where),))
    return MassPart(
        meshes=part.substance.names,
        material=part.substance.material,
        density_kgm3=density,
        volume_share=part.even.mass_kg / volume_m3,
        mass_share=part.body.mass_kg / mass_kg,
    )


def _source(parts: Sequence[Part]) -> Source:
    """`declared` when the source states every mass, `default` when nothing at all is known."""
    if all(p.substance.stated is not None for p in parts):
        return "declared"
    known = any(p.substance.stated is not None or p.substance.density_kgm3.source != "default" for p in parts)
    return "inferred" if known else "default"


def _method(parts: Sequence[Part], geometric: str) -> str:
    """How each substance got its mass, in few words."""
    stated = dict.fromkeys(p.substance.stated.method for p in parts if p.substance.stated is not None)
    dense = dict.fromkeys(p.substance.density_kgm3.method for p in parts if p.substance.stated is None)
    shared = [parts[0].shared] if parts[0].shared else []
    return "; ".join([*stated, *(f"{geometric} times density: {method}" for method in dense), *shared])


def _inputs(parts: Sequence[Part]) -> tuple[str, ...]:
    places = [str(p.substance.stated.where) for p in parts if p.substance.stated is not None]
    names = [name for p in parts if p.substance.stated is None for name in p.substance.density_kgm3.inputs]
    return tuple(dict.fromkeys([*places, *names]))


def _confidence(parts: Sequence[Part], total: MassProperties, trust: float) -> float:
    """By share of mass; `trust` in the geometry counts only where it gave the mass."""
    return sum(
        p.body.mass_kg / total.mass_kg * p.confidence * (1.0 if p.substance.stated is not None else trust)
        for p in parts
    )
