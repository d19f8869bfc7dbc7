"""Builds the physics section of one rigid body from its solid: collision shapes, mass properties, contact materials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from assetkit.colliders.choose import choose_colliders
from assetkit.mass.estimate import mass_evidence
from assetkit.mass.parts import MassEvidenceInputs
from assetkit.physics.collider_materials import assign_contact_materials
from geom.features.cavities import Cavity
from schemas.asset import PhysicsSection
from schemas.diagnostics import Diagnostic
from schemas.outcome import Repair
from schemas.physics import CollisionShape, Contact, MassProperties, Solid, SurfaceMaterial
from schemas.stated_physics import StatedContact


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
    mass = mass_evidence(solid, names, replace(mass_inputs, cavities=colliders.cavities))
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
