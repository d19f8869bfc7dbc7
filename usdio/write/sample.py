"""One sample of a plan as a layer over a compiled scene: what differs, and nothing else."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade

from schemas.physics import Contact
from schemas.scene.compiled import Point3, Quat_wxyz
from schemas.scene.program import PairedMaterial
from schemas.scene.samples import SampledLighting
from usdio.names import identifier
from usdio.write.materials import label_material
from usdio.write.package import USD_FOLDER
from usdio.write.physics import author_contact_values
from usdio.write.scene import author_scaled_mass

_ROOT = Sdf.Path("/World")


@dataclass(frozen=True)
class SampleEdit:
    """One object of a sample: its pose in W (None: as compiled), which package it is, and what a material makes of it.

    `contact` and `denser` belong to `material`: the contact as it then is, and by how much mass and inertia grow.
    """

    name: str
    position_m: Point3 | None = None
    quat_wxyz: Quat_wxyz | None = None
    package: str | None = None
    material: PairedMaterial | None = None
    contact: Contact | None = None
    denser: float = 1.0


def write_sample(
    scene: Path, edits: Sequence[SampleEdit], lighting: SampledLighting | None, packages: Path, file: Path
) -> Path:
    """Write `file`, a layer with `scene` below it: it opens alone, and serves as session layer of the scene.

    Raises KeyError for an object that the scene does not have, OSError when writing fails.
    """
    layer = Sdf.Layer.CreateNew(str(file)) if not file.exists() else Sdf.Layer.FindOrOpen(str(file))
    layer.Clear()
    layer.subLayerPaths = [os.path.relpath(scene, file.parent)]
    stage = Usd.Stage.Open(layer)
    stage.SetMetadata("metersPerUnit", 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    world = stage.GetPrimAtPath(_ROOT)
    stage.SetDefaultPrim(world)
    prims = [*world.GetChildren(), *world.GetChild("Objects").GetChildren()]
    found = {prim.GetCustomDataByKey("mana:id"): prim for prim in prims}
    for edit in edits:
        _edit(stage, found[edit.name], edit, packages, file.parent)
    if lighting is not None:
        light(stage, lighting)
    if not layer.Save():
        raise OSError(f"USD could not write {file.name}")
    return file


def _edit(stage: Usd.Stage, prim: Usd.Prim, edit: SampleEdit, packages: Path, folder: Path) -> None:
    if edit.package is not None:
        main = min((packages / edit.package / USD_FOLDER).glob("*.usda"))
        wanted = Path(os.path.relpath(main, folder)).as_posix()
        if not any(ref.assetPath.endswith(f"{edit.package}/{USD_FOLDER}/{main.name}") for ref in _references(prim)):
            prim.GetReferences().SetReferences([Sdf.Reference(f"./{wanted}")])
            scale = prim.GetAttribute("xformOp:scale")
            if scale:  # The scene below states mass and inertia of the asset it was compiled with.
                author_scaled_mass(prim, main, float(scale.Get()[0]))
    if edit.position_m is not None and edit.quat_wxyz is not None:
        prim.GetAttribute("xformOp:translate").Set(Gf.Vec3d(*edit.position_m))
        prim.GetAttribute("xformOp:orient").Set(Gf.Quatd(*edit.quat_wxyz))
    if edit.material is not None:
        wear(stage, prim, edit.material, edit)


def _references(prim: Usd.Prim) -> list[Sdf.Reference]:
    return [ref for spec in prim.GetPrimStack() for ref in spec.referenceList.GetAddedOrExplicitItems()]


def wear(stage: Usd.Stage, prim: Usd.Prim, source: PairedMaterial, edit: SampleEdit) -> None:
    """Bind the material over all that the prim has below it; mass and inertia change with it."""
    scope = UsdGeom.Scope.Define(stage, _ROOT.AppendChild("SampledMaterials")).GetPath()
    name = identifier(f"{source.id}_{edit.name}", "material")
    material = UsdShade.Material.Define(stage, scope.AppendChild(name))
    label_material(material, source.id)
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    over = UsdShade.Tokens.strongerThanDescendants
    if (source.base_color, source.roughness, source.metallic) != (None, None, None):
        _surface(stage, material, source)
        binding.Bind(material, over)
    if edit.contact is not None:
        api = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
        if source.density_kgm3 is not None:
            api.CreateDensityAttr(source.density_kgm3)
        author_contact_values(material.GetPrim(), edit.contact)
        binding.Bind(material, over, "physics")
        mass = UsdPhysics.MassAPI(prim)
        if edit.denser != 1.0 and mass.GetMassAttr().HasAuthoredValue():
            mass.GetMassAttr().Set(edit.denser * mass.GetMassAttr().Get())
            mass.GetDiagonalInertiaAttr().Set(edit.denser * mass.GetDiagonalInertiaAttr().Get())


def _surface(stage: Usd.Stage, material: UsdShade.Material, source: PairedMaterial) -> None:
    shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("surface"))
    shader.CreateIdAttr("UsdPreviewSurface")
    if source.base_color is not None:
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*source.base_color))
    for name, value in (("roughness", source.roughness), ("metallic", source.metallic)):
        if value is not None:
            shader.CreateInput(name, Sdf.ValueTypeNames.Float).Set(value)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")


def light(stage: Usd.Stage, drawn: SampledLighting) -> None:
    """The channels on both lights of the scene; `intensity` is the lamp's, the dome keeps its share of it."""
    lights = _ROOT.AppendChild("Lights")
    lamp, dome = (stage.GetPrimAtPath(lights.AppendChild(name)) for name in ("Lamp", "Dome"))
    share = UsdLux.LightAPI(dome).GetIntensityAttr().Get() / UsdLux.LightAPI(lamp).GetIntensityAttr().Get()
    for prim, part in ((lamp, 1.0), (dome, share)):
        light = UsdLux.LightAPI(prim)
        if drawn.intensity is not None:
            light.CreateIntensityAttr(part * drawn.intensity)
        if drawn.exposure is not None:
            light.CreateExposureAttr(drawn.exposure)
        if drawn.temperature_K is not None:
            light.CreateEnableColorTemperatureAttr(True)
            light.CreateColorTemperatureAttr(drawn.temperature_K)
    if drawn.rotation is not None:
        form = UsdGeom.Xformable(dome)
        form.ClearXformOpOrder()
        form.AddRotateZOp().Set(math.degrees(drawn.rotation))
