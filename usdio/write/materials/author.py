"""Authors the materials of a package in every render context that shows them, and lists the textures they read."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from pxr import Sdf, Usd, UsdGeom, UsdSemantics, UsdShade

from schemas.appearance.optics import effective
from schemas.identifiers import unique_identifiers
from schemas.model import Model
from usdio.write.materials.mesh_materials import MeshMaterial
from usdio.write.materials.modules import module_sources
from usdio.write.materials.network import Network, TextureFiles
from usdio.write.materials.outputs import outputs_of

# Names of images in glTF and COLLADA often end as the file did from which they were made.
_EXTENSION = re.compile(r"\.(png|jpe?g|webp|bmp|tga|tiff?|gif|dds)$", re.IGNORECASE)


def texture_files(model: Model, mesh_materials: Sequence[MeshMaterial]) -> dict[str, str]:
    """Texture.name -> file name below `textures/` of every texture that a mesh material uses, in model order."""
    used = {
        use.texture
        for mesh_material in mesh_materials
        for use in effective(mesh_material.material).texture_uses.values()
    }
    textures = [texture for texture in model.textures if texture.name in used]
    names = unique_identifiers((_EXTENSION.sub("", texture.name) for texture in textures), "texture")
    return {texture.name: f"{file}.{texture.extension}" for file, texture in zip(names, textures, strict=True)}


def author_materials(
    stage: Usd.Stage,
    root: Sdf.Path,
    mesh_materials: Sequence[MeshMaterial],
    files: TextureFiles,
    label: str,
) -> dict[str, str]:
    """Define `<root>/Materials/<name>` for every distinct mesh material, with the shaders of `outputs_of`.

    `label` is the material type for SL.MAT.001. What the effective material lacks, such as a sheen of no colour, is not
    written. Returns the MDL modules that the shaders need, as source texts by file name.
    """
    names: set[str] = set()
    scope = UsdGeom.Scope.Define(stage, root.AppendChild("Materials")).GetPath()
    for name, mesh_material in sorted(
        {mesh_material.prim_name: mesh_material for mesh_material in mesh_materials}.items()
    ):
        material = UsdShade.Material.Define(stage, scope.AppendChild(name))
        label_material(material, label)
        material.GetPrim().SetCustomDataByKey("mana:sourceName", mesh_material.material.name)
        seen = replace(mesh_material, material=effective(mesh_material.material))
        for output in outputs_of(mesh_material, files.images):
            prefix = f"{output.context}_" if output.context else ""
            output.author(Network(stage, material, files, prefix), seen)
            names.add(output.name)
    return module_sources(names)


def label_material(material: UsdShade.Material, label: str) -> None:
    """The `material` semantic label every Material prim must carry, physics ones too (SL.MAT.001)."""
    UsdSemantics.LabelsAPI.Apply(material.GetPrim(), "material").CreateLabelsAttr([label])
