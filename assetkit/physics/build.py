"""Builds the physics section of one rigid body from its solid: collision shapes, mass properties, contact materials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from assetkit.colliders.choose import choose_colliders
from assetkit.mass.estimate import MassEvidence, mass_evidence
from assetkit.mass.parts import MassEvidenceInputs
from assetkit.mass.source_inertials import CODE
from assetkit.physics.collider_materials import assign_contact_materials
from geom.convex.support_function import surface
from geom.features.cavities import Cavity
from geom.mass.inertia_bounds import rms_distance_and_bound
from schemas.asset import PhysicsSection
from schemas.diagnostics import Diagnostic, finding
from schemas.outcome import Repair
from schemas.physics import CollisionShape, Contact, MassProperties, Solid, SurfaceMaterial
from schemas.stated_physics import StatedContact

REACH_SLACK = 0.005  # of the diagonal of the colliders, half of what the gate grants


@dataclass(frozen=True)
class PhysicsResult:
    """The input of the simulator (`shapes`, `mass`, `contact` against any counterpart) and the section of the record.

    All in the asset frame, metres and kilograms. For `surfaces` and `shape_surfaces` see `PackageContent`.
    """

    shapes: tuple[CollisionShape, ...]
    mass: MassProperties
    contact: Contact
    section: PhysicsSection
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()
    surfaces: tuple[SurfaceMaterial, ...] = ()
    shape_surfaces: tuple[int, ...] = ()


def build_physics(
    solid: Solid,
    names: Sequence[str],
    *,
    work_dir: Path,
    exclude: frozenset[str] = frozenset(),
    mass_inputs: MassEvidenceInputs | None = None,
    contacts: Sequence[StatedContact] = (),
    cavities: tuple[Cavity, ...] | None = None,
) -> PhysicsResult:
    """Physics of one rigid body.

    `names` of the whole (file) may mention its material, `mass_inputs` hold the evidence on its mass, `contacts` the
    friction that the source states; `exclude` holds collision methods that must not be chosen again because
    acceptance rejected them; `cavities` are those of the solid where they are known. Deterministic, except that a
    decomposition that runs into its time limit falls back to the next method. Raises ValueError when all points of
    `solid` coincide.
    """
    mass_inputs = mass_inputs or MassEvidenceInputs()
    colliders = choose_colliders(solid, work_dir, exclude, cavities)
    mass_inputs = replace(mass_inputs, cavities=colliders.cavities)
    mass = mass_evidence(solid, names, mass_inputs)
    if (beyond := inertia_beyond(mass.properties, colliders.shapes)) is not None:
        mass = _without_stated_inertia(mass, beyond, solid, names, mass_inputs)
    contact_materials = assign_contact_materials(colliders.shapes, solid, mass, mass_inputs, contacts)
    section = PhysicsSection(
        material=contact_materials.material,
        density_kgm3=mass.density_kgm3,
        mass_kg=mass.mass_kg,
        centre_of_mass_m=mass.centre_of_mass_m,
        inertia_kgm2=mass.inertia_kgm2,
        mass_parts=contact_materials.parts,
        contacts=contact_materials.contacts,
        collision_method=colliders.method,
        candidates=colliders.candidates,
        collider_materials=contact_materials.colliders,
    )
    return PhysicsResult(
        shapes=colliders.shapes,
        mass=mass.properties,
        contact=contact_materials.contacts[0].value,
        section=section,
        diagnostics=(*colliders.diagnostics, *mass.diagnostics, *contact_materials.diagnostics),
        repairs=(*mass.repairs, *contact_materials.repairs),
        surfaces=contact_materials.surfaces,
        shape_surfaces=contact_materials.shape_surfaces,
    )


def inertia_beyond(mass: MassProperties, shapes: Sequence[CollisionShape]) -> tuple[float, float] | None:
    """RMS distance (m) of the mass along the axis nearest to its bound, and the bound, where mass would have to lie
    outside the collision shapes (`rms_distance_and_bound`); None where it fits.

    The bound is narrower than that of `gate.rules.body.inertia_reach`, so that what fits here passes there.
    """
    points = np.concatenate([np.zeros((0, 3)), *(surface(shape)[0] for shape in shapes)])
    if not len(points) or not mass.mass_kg > 0.0:
        return None
    slack = REACH_SLACK * float(np.linalg.norm(np.ptp(points, axis=0)))
    reach, bound = rms_distance_and_bound(mass.inertia_kgm2 / mass.mass_kg, points - mass.centre_of_mass_m, slack)
    return (reach, bound) if reach > bound > 0.0 else None


def _without_stated_inertia(
    mass: MassEvidence,
    beyond: tuple[float, float],
    solid: Solid,
    names: Sequence[str],
    mass_inputs: MassEvidenceInputs,
) -> MassEvidence:
    """The evidence without the tensors that the source states, if there are any, with a finding and a repair.

    Statements are checked against the visible surface, of which colliders may leave out far ends.
    """
    stated = [s for s in mass_inputs.masses if s.inertia is not None]
    if not stated:
        return mass
    plain = tuple(replace(s, inertia=None) for s in mass_inputs.masses)
    again = mass_evidence(solid, names, replace(mass_inputs, masses=plain))
    reach, bound = beyond
    headline = "the stated inertia needs mass outside the collision shapes"
    figures = {"value": reach, "bound": bound, "unit": "m"}
    repair = Repair(
        name="implausible_inertia",
        code=CODE,
        stage="physics",
        before={"quantity": "inertia", "value": reach, "bound": bound},
        after={"quantity": "inertia", "value": "computed from the solid", "bound": bound},
    )
    return replace(
        again,
        diagnostics=(*again.diagnostics, finding(CODE, headline, where=stated[0].where, **figures)),
        repairs=(*again.repairs, repair),
    )
