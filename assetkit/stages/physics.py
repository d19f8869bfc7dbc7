"""From the physical surface to collision shapes, mass properties and contact parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from assetkit.colliders import choose_colliders
from assetkit.mass import mass_evidence
from assetkit.materials import contacts_of, material_for, materials
from schemas.asset import PhysicsSection
from schemas.diagnostics import Diagnostic
from schemas.outcome import Repair
from schemas.physics import CollisionShape, Contact, MassProperties, Solid


@dataclass(frozen=True)
class PhysicsResult:
    """What the simulator gets (`shapes`, `mass`, `contact` against any counterpart) and what the record says about it.

    All in the asset frame, metres and kilograms.
    """

    shapes: tuple[CollisionShape, ...]
    mass: MassProperties
    contact: Contact
    section: PhysicsSection
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()


def build_physics(
    solid: Solid, names: Sequence[str], *, work_dir: Path, exclude: frozenset[str] = frozenset()
) -> PhysicsResult:
    """Physics of one rigid body made of one material throughout.

    `names` (file, render materials, meshes) may mention the material; `exclude` holds collision methods that must not
    be chosen again because acceptance rejected them. Deterministic, except that a decomposition that runs into its time
    limit falls to the next rung. Raises ValueError when all points of `solid` coincide.
    """
    found = material_for(names)
    material = materials()[found.value]
    colliders = choose_colliders(solid, work_dir, exclude)
    mass = mass_evidence(solid, material, found)
    contacts = contacts_of(found)
    section = PhysicsSection(
        material=found,
        density_kgm3=mass.density_kgm3,
        mass_kg=mass.mass_kg,
        centre_of_mass_m=mass.centre_of_mass_m,
        inertia_kgm2=mass.inertia_kgm2,
        contacts=contacts,
        collision_method=colliders.method,
        candidates=colliders.candidates,
    )
    return PhysicsResult(
        shapes=colliders.shapes,
        mass=mass.properties,
        contact=contacts[0].value,
        section=section,
        diagnostics=colliders.diagnostics,
    )
