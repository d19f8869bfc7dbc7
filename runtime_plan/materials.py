"""Apply a paired material to a body: mass (kg), inertia (kg m2) and contact change together or not at all."""

from __future__ import annotations

from dataclasses import replace

from schemas.physics import MassProperties, RigidBody
from schemas.scene.program import PairedMaterial


def is_paired(material: PairedMaterial) -> bool:
    """Whether the material has physical values; if not it changes appearance alone, and bodies stay as they are."""
    physical = (material.density_kgm3, material.static_friction, material.dynamic_friction, material.restitution)
    return any(value is not None for value in physical)


def with_material(body: RigidBody, density_kgm3: float | None, material: PairedMaterial | None) -> RigidBody:
    """The body made of a material: mass and inertia scaled by the ratio of densities, contact values as stated.

    `density_kgm3` is the density of the given body; where it is unknown or the material has none, mass stays. Contact
    values that the material does not state stay; dynamic friction never exceeds static.
    """
    if material is None or not is_paired(material):
        return body
    factor = material.density_kgm3 / density_kgm3 if material.density_kgm3 and density_kgm3 else 1.0
    mass = MassProperties(body.mass.mass_kg * factor, body.mass.centre_of_mass_m, body.mass.inertia_kgm2 * factor)
    stated = {
        "static_friction": material.static_friction,
        "dynamic_friction": material.dynamic_friction,
        "restitution": material.restitution,
    }
    contact = body.contact.model_copy(update={name: value for name, value in stated.items() if value is not None})
    if contact.dynamic_friction > contact.static_friction:
        other = "static_friction" if material.static_friction is None else "dynamic_friction"
        value = contact.dynamic_friction if other == "static_friction" else contact.static_friction
        contact = contact.model_copy(update={other: value})
    return replace(body, mass=mass, contact=contact)
