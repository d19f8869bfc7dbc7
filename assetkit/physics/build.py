"""From the physical surface to collision shapes, mass properties and contact parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from assetkit.colliders.choose import choose_colliders
from assetkit.mass.estimate import mass_evidence
from assetkit.mass.parts import Clues
from assetkit.physics.collider_materials import touches
from geom.features.cavities import Cavity
from schemas.asset import PhysicsSection
from schemas.diagnostics import Diagnostic
from schemas.outcome import Repair
from schemas.physics import CollisionShape, Contact, MassProperties, Solid, SurfaceMaterial
from schemas.stated_physics import StatedContact


@dataclass(frozen=True)
class PhysicsResult:
    """What the simulator gets (`shapes`, `mass`, `contact` against any counterpart) and what the record says about it.

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
    clues: Clues | None = None,
    contacts: Sequence[StatedContact] = (),
    cavities: tuple[Cavity, ...] | None = None,
) -> PhysicsResult:
    """Physics of one rigid body.

    `names` of the whole (file) may mention its material, `clues` hold what is known about its parts, `contacts` what
    the source states about friction; `exclude` holds collision methods that must not be chosen again because
    acceptance rejected them; `cavities` are those of the solid where they are known. Deterministic, except that a
    decomposition that runs into its time limit falls to the next rung. Raises ValueError when all points of `solid`
    coincide.
    """
    clues = clues or Clues()
    colliders = choose_colliders(solid, work_dir, exclude, cavities)
    mass = mass_evidence(solid, names, replace(clues, cavities=colliders.cavities))
    touched = touches(colliders.shapes, solid, mass, clues, contacts)
    section = PhysicsSection(
        material=touched.material,
        density_kgm3=mass.density_kgm3,
        mass_kg=mass.mass_kg,
        centre_of_mass_m=mass.centre_of_mass_m,
        inertia_kgm2=mass.inertia_kgm2,
        mass_parts=touched.parts,
        contacts=touched.contacts,
        collision_method=colliders.method,
        candidates=colliders.candidates,
        collider_materials=touched.colliders,
    )
    return PhysicsResult(
        shapes=colliders.shapes,
        mass=mass.properties,
        contact=touched.contacts[0].value,
        section=section,
        diagnostics=(*colliders.diagnostics, *mass.diagnostics, *touched.diagnostics),
        repairs=(*mass.repairs, *touched.repairs),
        surfaces=touched.surfaces,
        shape_surfaces=touched.shape_surfaces,
    )
