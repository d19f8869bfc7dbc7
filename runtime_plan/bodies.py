"""Rigid bodies (kg, m, asset frame) of a plan for a simulator: packages reread from disk, or scaled primitives."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from geom.convex.scaling import scaled_body
from geom.pose import pose
from runtime_plan.package_files import changed_physics
from schemas.asset import RECORD, AssetRecord
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.physics import CollisionShape, MassProperties, RigidBody
from schemas.scene.program import BoxAsset, CylinderAsset, Inline
from schemas.scene.runtime_plan import PlanBody
from usdio.reread.body import reread_body, reread_linkage
from usdio.write.package import USD_FOLDER
from usdio.write.primitive import CONTACT, DENSITY_KGM3, primitive_mass


@dataclass(frozen=True)
class PhysicalBody:
    """A body at its scale with its mean density; None where the density is unknown."""

    body: RigidBody
    density_kgm3: float | None


def physical_body(body: PlanBody, packages: Path | None) -> PhysicalBody:
    """The rigid body of a plan's body at its scale, its joints held in the state of the plan.

    Raises FileNotFoundError for a body of a package without a folder of packages, InvalidInput for a package whose
    record is damaged or whose shape or physics changed after it was written (`plan/changed-package`), and as
    `reread_body` does.
    """
    if body.primitive is not None:
        return _primitive(body.asset_id, body.primitive, body.scale, body.mass_kg)
    if packages is None or body.package is None:
        raise FileNotFoundError(body.package or body.asset_id)
    folder = packages / body.package
    if not folder.resolve().is_relative_to(packages.resolve()):
        raise FileNotFoundError(f"{body.package} is not below the folder of packages")
    try:
        record = AssetRecord.model_validate_json((folder / RECORD).read_bytes())
    except ValueError:
        text = f"the {RECORD} of the package {body.package} is not the record of an asset"
        raise _changed(body.package, RECORD, text) from None
    changed = changed_physics(folder, record.hashes)
    if changed:
        text = f"'{changed[0]}' of the package {body.package} is not the file that its record was written of"
        raise _changed(body.package, changed[0], text)
    main_file = min((folder / USD_FOLDER).glob("*.usda"))
    whole = reread_linkage(main_file).held(dict(body.joints)) if record.physics.links else reread_body(main_file)
    scaled = scaled_body(whole, body.scale)
    mass, scale = scaled.mass, body.scale  # a scaled body keeps its density
    mass = MassProperties(mass.mass_kg * scale**3, mass.centre_of_mass_m, mass.inertia_kgm2 * scale**5)
    density = record.physics.density_kgm3
    return PhysicalBody(replace(scaled, mass=mass), density and density.value)


def _changed(package: str, file: str, text: str) -> InvalidInput:
    return InvalidInput(finding("plan/changed-package", text, where=Location(file=f"{package}/{file}")))


def _primitive(name: str, primitive: Inline, scale: float, mass_kg: float | None) -> PhysicalBody:
    mass = primitive_mass(primitive, scale, mass_kg)
    density = DENSITY_KGM3 * mass.mass_kg / primitive_mass(primitive, scale, None).mass_kg
    if isinstance(primitive, BoxAsset):
        kind, size_m, middle_m = "box", primitive.size_m, primitive.size_m[2] / 2.0
    elif isinstance(primitive, CylinderAsset):
        kind, size_m, middle_m = "cylinder", (primitive.radius_m, primitive.height_m), primitive.height_m / 2.0
    else:
        kind, size_m, middle_m = "sphere", (primitive.radius_m,), primitive.radius_m
    shape = CollisionShape(kind, tuple(scale * s for s in size_m), pose(None, np.array([0.0, 0.0, scale * middle_m])))
    return PhysicalBody(RigidBody(name, (shape,), mass, CONTACT), density)
