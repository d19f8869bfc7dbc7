"""Mass, mass centre and inertia with honest bounds: geometry times density, and what may be hollow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from assetkit.materials import PhysicalMaterial
from geom.inertia import mass_properties, of_sheet
from geom.surface_distance import triangle_areas
from geom.weld import diagonal
from schemas.asset import Matrix3, Vec3
from schemas.evidence import Evidence, Source
from schemas.model import FloatArray
from schemas.physics import MassProperties, Solid

# Mass bounds further apart than this factor tell a randomiser nothing.
MAX_SPAN = 30.0
# Walls of hollow things: this share of the diagonal, within these limits.
WALL_PER_DIAGONAL, LEAST_WALL_M, MOST_WALL_M = 0.005, 0.3e-3, 3e-3
# The wall of a sheet is a guess; a hull holds at most its own volume and often a third of it.
SHEET_WALL_FACTORS = (0.4, 2.5)
HULL_FILL = 0.3
COM_SLACK_SHARE = 0.05
UNIFORMITY = 0.7  # how much to trust that the density is the same everywhere


@dataclass(frozen=True)
class MassEvidence:
    """The mass properties to use, and what is known about each of them."""

    properties: MassProperties
    density_kgm3: Evidence[float]
    mass_kg: Evidence[float]
    centre_of_mass_m: Evidence[Vec3]
    inertia_kgm2: Evidence[Matrix3]


def mass_evidence(solid: Solid, material: PhysicalMaterial, found: Evidence[str]) -> MassEvidence:
    """Mass properties of `solid` filled with `material`; `found` says how the material is known.

    An unknown material leaves mass and inertia `default` with confidence 0; their bounds still hold. The value is never
    clamped: a feather weighs what it weighs.
    """
    density = material.density_kgm3
    body, method, confidence = mass_properties(solid, density)
    low, high = mass_bounds(solid, body.mass_kg / density, material)
    method = f"{method} times density of {material.name}"
    trust = confidence * found.confidence
    ratio = np.array([low, high]) / body.mass_kg
    inertia_bounds = np.sort(body.inertia_kgm2[None] * ratio[:, None, None], axis=0)
    geometric: Source = "measured" if solid.kind == "closed" else "inferred"
    return MassEvidence(
        properties=body,
        density_kgm3=Evidence(
            value=density,
            source=found.source,
            method=f"material class {material.name}",
            confidence=found.confidence,
            bounds=material.density_bounds_kgm3,
            inputs=found.inputs,
        ),
        mass_kg=Evidence(
            value=body.mass_kg,
            source=found.source,
            method=method,
            confidence=trust,
            bounds=(low, high),
            inputs=found.inputs,
        ),
        centre_of_mass_m=Evidence(
            value=_vec3(body.centre_of_mass_m),
            source=geometric,
            method=f"{method}, uniform density",
            confidence=confidence * UNIFORMITY,
            bounds=_centre_bounds(solid, body),
        ),
        inertia_kgm2=Evidence(
            value=_matrix3(body.inertia_kgm2),
            source=found.source,
            method=f"{method}, uniform density",
            confidence=trust * UNIFORMITY,
            bounds=(_matrix3(inertia_bounds[0]), _matrix3(inertia_bounds[1])),
        ),
    )


def mass_bounds(solid: Solid, volume_m3: float, material: PhysicalMaterial) -> tuple[float, float]:
    """Least and greatest plausible mass (kg), at most a factor of 30 apart and around the value.

    Closed: full of the densest kind, or of the lightest; when things of this class are often hollow, as light as a wall
    of 0.5 % of the diagonal. Shell: wall thickness 0.4 to 2.5 times the assumed one. Hull: filled to a third or fully.
    """
    value = volume_m3 * material.density_kgm3
    low, high = (volume_m3 * d for d in material.density_bounds_kgm3)
    if solid.kind == "shell":
        low, high = low * SHEET_WALL_FACTORS[0], high * SHEET_WALL_FACTORS[1]
    elif solid.kind == "hull":
        low *= HULL_FILL
    elif material.may_be_hollow:
        area = float(triangle_areas(solid.points[solid.triangles]).sum())
        wall = min(max(WALL_PER_DIAGONAL * diagonal(solid.points), LEAST_WALL_M), MOST_WALL_M)
        low = min(low, area * wall * material.density_bounds_kgm3[0])
    span = high / low
    if span > MAX_SPAN:
        shrink = math.log(MAX_SPAN) / math.log(span)
        low, high = value * (low / value) ** shrink, value * (high / value) ** shrink
    return low, high


def _centre_bounds(solid: Solid, body: MassProperties) -> tuple[Vec3, Vec3]:
    """From the centre of the filled body to that of its surface, and 5 % of the extent around."""
    surface = of_sheet(solid.points, solid.triangles, 1.0, 1.0).centre_of_mass_m
    centres = np.stack([body.centre_of_mass_m, surface])
    slack = COM_SLACK_SHARE * np.ptp(solid.points, axis=0)
    return _vec3(centres.min(axis=0) - slack), _vec3(centres.max(axis=0) + slack)


def _vec3(values: FloatArray) -> Vec3:
    x, y, z = (float(v) for v in values)
    return x, y, z


def _matrix3(values: FloatArray) -> Matrix3:
    a, b, c = (_vec3(row) for row in values)
    return a, b, c
