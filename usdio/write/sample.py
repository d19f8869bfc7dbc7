"""Writes one sample of a plan as a USD layer over a compiled scene: only the opinions that differ."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade

from schemas.identifiers import identifier
from schemas.physics import Contact
from schemas.scene.compiled import Point3, Quat_wxyz
from schemas.scene.program import PairedMaterial
from schemas.scene.samples import SampledLighting
from usdio.write.materials.author import label_material
from usdio.write.package import USD_FOLDER
from usdio.write.physics import author_contact_values
from usdio.write.scene import author_scaled_mass

_ROOT = Sdf.Path("/World")


@dataclass(frozen=True)
class SampleEdit:
    """The edit of one object: its pose in W (None: as compiled), its package, and its sampled material.

    `contact` is the resulting contact with `material`; `density_factor` multiplies mass and inertia. One that
    `is_absent` is taken out of the stage.
    """

    name: str
    position_m: Point3 | None = None
    quat_wxyz: Quat_wxyz | None = None
    package: str | None = None
    material: PairedMaterial | None = None
    contact: Contact | None = None
    density_factor: float = 1.0
    is_absent: bool = False


def write_sample(
    scene: Path, edits: Sequence[SampleEdit], lighting: SampledLighting | None, packages: Path, file: Path
) -> Path:
    """Write `file`, a layer with `scene` below it: it opens alone, and serves as session layer of the scene.

    All edits are written or none: after an error `file` is as before, or absent. Raises KeyError for an object that
    the scene does not have, OSError when writing fails.
    """
    existed = file.exists()
    layer = Sdf.Layer.FindOrOpen(str(file)) if existed else Sdf.Layer.CreateNew(str(file))
    try:
        _author(layer, scene, edits, lighting, packages, file)
    except BaseException:
        if existed:
            layer.Reload(True)  # USD shares the edited layer with whoever opens the file in this process.
        else:
            file.unlink(missing_ok=True)
        raise
    return file


def _author(
    layer: Sdf.Layer,
    scene: Path,
    edits: Sequence[SampleEdit],
    lighting: SampledLighting | None,
    packages: Path,
    file: Path,
) -> None:
    layer.Clear()
    layer.subLayerPaths = [os.path.relpath(scene, file.parent)]
    stage = Usd.Stage.Open(layer)
    stage.SetMetadata("metersPerUnit", 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    world = stage.GetPrimAtPath(_ROOT)
    stage.SetDefaultPrim(world)
    prims = [*world.GetChildren(), *world.GetChild("Objects").GetChildren()]
    prim_of = {prim.GetCustomDataByKey("mana:id"): prim for prim in prims}
    for edit in edits:
        _edit(stage, prim_of[edit.name], edit, packages, file.parent)
    if lighting is not None:
        author_sampled_lighting(stage, lighting)
    if not layer.Save():
        raise OSError(f"USD could not write {file.name}")


def _edit(stage: Usd.Stage, prim: Usd.Prim, edit: SampleEdit, packages: Path, folder: Path) -> None:
    if edit.is_absent:  # a distractor that was not drawn
        prim.SetActive(False)
        return
    if edit.package is not None:
        main = min((packages / edit.package / USD_FOLDER).glob("*.usda"))
        main_path = Path(os.path.relpath(main, folder)).as_posix()
        if not any(ref.assetPath.endswith(f"{edit.package}/{USD_FOLDER}/{main.name}") for ref in _references(prim)):
            prim.GetReferences().SetReferences([Sdf.Reference(f"./{main_path}")])
            scale = prim.GetAttribute("xformOp:scale")
            if scale:  # The compiled scene states mass and inertia of the asset it was compiled with.
                author_scaled_mass(prim, main, float(scale.Get()[0]))
    if edit.position_m is not None and edit.quat_wxyz is not None:
        prim.GetAttribute("xformOp:translate").Set(Gf.Vec3d(*edit.position_m))
        prim.GetAttribute("xformOp:orient").Set(Gf.Quatd(*edit.quat_wxyz))
    if edit.material is not None:
        bind_sampled_material(stage, prim, edit.material, edit)


def _references(prim: Usd.Prim) -> list[Sdf.Reference]:
    return [ref for spec in prim.GetPrimStack() for ref in spec.referenceList.GetAddedOrExplicitItems()]


def bind_sampled_material(stage: Usd.Stage, prim: Usd.Prim, source: PairedMaterial, edit: SampleEdit) -> None:
    """Bind the material stronger than the bindings below `prim`; mass and inertia are scaled by its density."""
    scope = UsdGeom.Scope.Define(stage, _ROOT.AppendChild("SampledMaterials")).GetPath()
    name = identifier(f"{source.id}_{edit.name}", "material")
    material = UsdShade.Material.Define(stage, scope.AppendChild(name))
    label_material(material, source.id)
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    stronger = UsdShade.Tokens.strongerThanDescendants
    if (source.base_color, source.roughness, source.metallic) != (None, None, None):
        _surface(stage, material, source)
        binding.Bind(material, stronger)
    if edit.contact is not None:
        api = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
        if source.density_kgm3 is not None:
            api.CreateDensityAttr(source.density_kgm3)
        author_contact_values(material.GetPrim(), edit.contact)
        binding.Bind(material, stronger, "physics")
        mass = UsdPhysics.MassAPI(prim)
        if edit.density_factor != 1.0 and mass.GetMassAttr().HasAuthoredValue():
            mass.GetMassAttr().Set(edit.density_factor * mass.GetMassAttr().Get())
            mass.GetDiagonalInertiaAttr().Set(edit.density_factor * mass.GetDiagonalInertiaAttr().Get())


def _surface(stage: Usd.Stage, material: UsdShade.Material, source: PairedMaterial) -> None:
    shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("surface"))
    shader.CreateIdAttr("UsdPreviewSurface")
    if source.base_color is not None:
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*source.base_color))
    for name, value in (("roughness", source.roughness), ("metallic", source.metallic)):
        if value is not None:
            shader.CreateInput(name, Sdf.ValueTypeNames.Float).Set(value)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")


def author_sampled_lighting(stage: Usd.Stage, lighting: SampledLighting) -> None:
    """Author the sampled intensity, exposure, temperature and rotation on lamp and dome.

    `intensity` is that of the lamp; the dome keeps its ratio to it.
    """
    lights = _ROOT.AppendChild("Lights")
    lamp, dome = (stage.GetPrimAtPath(lights.AppendChild(name)) for name in ("Lamp", "Dome"))
    dome_share = UsdLux.LightAPI(dome).GetIntensityAttr().Get() / UsdLux.LightAPI(lamp).GetIntensityAttr().Get()
    for prim, share in ((lamp, 1.0), (dome, dome_share)):
        light = UsdLux.LightAPI(prim)
        if lighting.intensity is not None:
            light.CreateIntensityAttr(share * lighting.intensity)
        if lighting.exposure is not None:
            light.CreateExposureAttr(lighting.exposure)
        if lighting.temperature_K is not None:
            light.CreateEnableColorTemperatureAttr(True)
            light.CreateColorTemperatureAttr(lighting.temperature_K)
    if lighting.rotation is not None:
        form = UsdGeom.Xformable(dome)
        form.ClearXformOpOrder()
        form.AddRotateZOp().Set(math.degrees(lighting.rotation))
