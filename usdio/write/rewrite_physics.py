"""Replaces mass properties and contact materials of a package on disk; all other files keep their bytes."""

from __future__ import annotations

from pathlib import Path

from pxr import Sdf, Usd

from schemas.physics import Contact, MassProperties
from usdio.write.physics import CONTACT_MATERIALS, author_body, author_contact_values

_METADATA = "SimReady_Metadata"


def rewrite_physics(
    main_file: Path, mass: MassProperties, contact: Contact | None, density_factor: float
) -> tuple[Path, Path]:
    """Author the body and the contact materials of a package that `write_package` wrote; returns the changed files.

    The density of every material is multiplied by `density_factor`; all get `contact`, None keeps theirs. Raises
    OSError when writing fails.
    """
    layer = Sdf.Layer.OpenAsAnonymous(str(main_file))
    stage = Usd.Stage.Open(layer, Usd.Stage.LoadNone)
    author_body(stage.GetDefaultPrim(), mass)
    layer.customLayerData = {
        **layer.customLayerData,
        _METADATA: {**layer.customLayerData[_METADATA], "mass": float(mass.mass_kg)},
    }
    root = stage.GetDefaultPrim().GetPath()
    physics_file = main_file.parent / "payloads" / f"{main_file.stem}_physics.usda"
    physics = Sdf.Layer.OpenAsAnonymous(str(physics_file))
    payload = Usd.Stage.Open(physics)
    for material in payload.GetPrimAtPath(root.AppendChild(CONTACT_MATERIALS)).GetChildren():
        author_contact_values(material, contact, density_factor)
    for changed, path in ((layer, main_file), (physics, physics_file)):
        if not changed.Export(str(path)):
            raise OSError(f"USD could not write {path.name}")
    return main_file, physics_file
