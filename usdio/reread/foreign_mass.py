"""Mass properties of a body in USD that Mana did not write, by the rules of UsdPhysics where they are not stated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from pxr import Usd, UsdPhysics

from geom.mass.inertia import combine, enclosed_volume, moved, of_box, of_capsule, of_cylinder, of_sphere, scaled
from geom.mass.principal_axes import rotated_tensor
from geom.pose import apply
from schemas.arrays import FloatArray
from schemas.diagnostics import Location, finding
from schemas.physics import CollisionShape, MassProperties
from usdio.read.physics import authored_centre, authored_inertia, authored_number, contact_material
from usdio.reread.foreign_shapes import Note, unsupported

UNSTATED_DENSITY_KGM3: Final = 1000.0  # UsdPhysics: "the default density is 1000.0 kg/m3", that of water


@dataclass(frozen=True)
class Collider:
    """A collider prim with its shapes in the asset frame."""

    prim: Usd.Prim
    shapes: tuple[CollisionShape, ...]


@dataclass(frozen=True)
class StageUnits:
    """What one unit of a stage is, in metres and in kilograms."""

    metres: float
    kilograms: float


def foreign_mass(
    body: Usd.Prim, colliders: Sequence[Collider], X_AB: FloatArray, units: StageUnits, where: Location, note: Note
) -> MassProperties:
    """Mass, mass centre and inertia in axes of the asset frame; `X_AB` (4, 4) places the body prim, scale included.

    As UsdPhysics has it: the mass of the body counts before masses and densities of its colliders; of these the
    density nearest to the collider, then that of its contact material, then 1000 kg/m3. What is not stated follows
    from the colliders filled evenly, overlaps counted twice. A mass centre goes through the whole transform, inertia
    is only turned. Each value that is not stated on the body is noted. Raises InvalidInput
    (`asset/foreign-unsupported`) for a value that is not finite, or a negative mass.
    """
    states = body.HasAPI(UsdPhysics.MassAPI)
    mass = authored_number(body, "mass") if states else None
    centre = authored_centre(body) if states else None
    inertia = authored_inertia(body) if states else None
    stated = np.concatenate([np.ravel(v) for v in (mass, centre, inertia) if v is not None] or [np.zeros(0)])
    if not np.all(np.isfinite(stated)) or (mass is not None and mass < 0.0):
        raise unsupported("a body whose mass, mass centre or inertia is no number", where)
    filled, origin = _from_colliders(body, colliders, units, where)
    if mass is None:
        headline = f"the body states no mass: {filled.mass_kg:.3g} kg, from {origin} and the volume of its colliders"
        note(finding("asset/foreign-assumed", headline, where=where, value=filled.mass_kg, unit="kg"))
    else:
        filled = scaled(filled, mass * units.kilograms / filled.mass_kg)
    missing = [name for name, value in (("mass centre", centre), ("inertia", inertia)) if value is None]
    if missing:
        headline = f"the body states no {' and no '.join(missing)}: taken from its colliders, filled evenly"
        note(finding("asset/foreign-assumed", headline, where=where))
    rotation = X_AB[:3, :3] / np.linalg.norm(X_AB[:3, :3], axis=0)
    return MassProperties(
        filled.mass_kg,
        filled.centre_of_mass_m if centre is None else apply(X_AB, centre[None])[0],
        filled.inertia_kgm2
        if inertia is None
        else rotated_tensor(inertia, rotation) * units.kilograms * units.metres**2,
    )


def _from_colliders(
    body: Usd.Prim, colliders: Sequence[Collider], units: StageUnits, where: Location
) -> tuple[MassProperties, str]:
    """The colliders filled with their masses or densities, and in words where these come from."""
    parts: list[MassProperties] = []
    origins: dict[str, None] = {}
    for collider in colliders:
        density, origin = _density(body, collider.prim, units)
        part = combine([_filled(shape, density) for shape in collider.shapes])
        mass = authored_number(collider.prim, "mass") if collider.prim != body else None
        if mass is not None:
            part, origin = scaled(part, mass * units.kilograms / part.mass_kg), "masses of colliders"
        parts.append(part)
        origins[origin] = None
    whole = combine(parts)
    if not (np.isfinite(whole.mass_kg) and whole.mass_kg > 0.0):
        raise unsupported("colliders without a positive mass or volume", where)
    return whole, ", ".join(origins)


def _density(body: Usd.Prim, prim: Usd.Prim, units: StageUnits) -> tuple[float, str]:
    """In kg/m3, and where it comes from."""
    per_cubic = units.kilograms / units.metres**3
    at = prim
    while True:
        value = authored_number(at, "density") if at.HasAPI(UsdPhysics.MassAPI) else None
        if value is not None:
            return value * per_cubic, f"the density {value * per_cubic:.4g} kg/m3 of '{at.GetName()}'"
        if at == body:
            break
        at = at.GetParent()
    material = contact_material(prim)
    value = None if material is None else authored_number(material, "density")
    if material is not None and value is not None:
        return value * per_cubic, f"the density {value * per_cubic:.4g} kg/m3 of the material '{material.GetName()}'"
    return UNSTATED_DENSITY_KGM3, f"the {UNSTATED_DENSITY_KGM3:.0f} kg/m3 that UsdPhysics takes without any density"


def _filled(shape: CollisionShape, density_kgm3: float) -> MassProperties:
    if shape.points is not None and shape.triangles is not None:
        return moved(enclosed_volume(shape.points, shape.triangles).filled(density_kgm3), shape.X_AS)
    if shape.kind == "box":
        x, y, z = shape.size_m
        return moved(of_box((x, y, z), density_kgm3), shape.X_AS)
    if shape.kind == "sphere":
        return moved(of_sphere(shape.size_m[0], density_kgm3), shape.X_AS)
    fill = of_capsule if shape.kind == "capsule" else of_cylinder
    return moved(fill(shape.size_m[0], shape.size_m[1], density_kgm3), shape.X_AS)
