"""Reads glTF materials as `schemas.appearance.material.Material` (glTF 2.0, 3.9; the KHR_materials_* extensions)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

from assetkit.readers.common.corners import Notes
from assetkit.readers.gltf.json import Json
from assetkit.readers.gltf.material_layers import LAYERS
from assetkit.readers.gltf.material_values import MaterialValues, rgb
from assetkit.readers.gltf.specular_glossiness import with_specular_glossiness
from assetkit.readers.gltf.textures import Textures
from schemas.appearance.material import AlphaMode, Material
from schemas.diagnostics import finding

_ALPHA_MODES: Final[dict[str, AlphaMode]] = {"OPAQUE": "opaque", "MASK": "mask", "BLEND": "blend"}
_SPECULAR_GLOSSINESS: Final = "KHR_materials_pbrSpecularGlossiness"


def read_material(material: Json, name: str, textures: Textures) -> tuple[Material, Notes]:
    """`material` as a metallic-roughness Material called `name`, with the origin of each value, and what was found.

    Extensions with a field are mapped; those without are kept verbatim in `unmapped` and announced by one
    `asset/material-extension-fallback`. Values out of range are clamped with a warning. Raises InvalidInput as
    `Textures.use` does.
    """
    values = MaterialValues(textures)
    result = _core(material, values, textures, Material(name=name))
    unmapped: dict[str, Any] = {}
    for extension in material.object("extensions").members():
        extension.members()
        complete = extension.key == _SPECULAR_GLOSSINESS
        if (layer := LAYERS.get(extension.key)) is not None:
            result, complete = layer(extension, values, result)
        if not complete:
            unmapped[extension.key] = extension.value
    if (extras := material.get("extras")) is not None:
        unmapped["extras"] = extras.value
    names = ", ".join(unmapped)
    notes = values.notes
    if names:
        headline = f"material '{name}': {names} kept in the record only"
        notes += Notes((finding("asset/material-extension-fallback", headline, where=material.where),))
    return replace(result, origins=values.origins, unmapped=unmapped, lost_textures=tuple(values.lost)), notes


def _core(material: Json, values: MaterialValues, textures: Textures, base: Material) -> Material:
    """The properties of glTF 2.0 itself; specular-glossiness replaces the block for metallic-roughness."""
    alpha_mode = material.string("alphaMode", "OPAQUE")
    if alpha_mode not in _ALPHA_MODES:
        raise material.require("alphaMode").schema_error("expected OPAQUE, MASK or BLEND")
    normal, occlusion = material.get("normalTexture"), material.get("occlusionTexture")
    strength = 1.0
    if occlusion is not None:
        strength = values.fraction(occlusion, "strength", 1.0, "occlusion_texture")
    values.state(material, "alphaMode", "alpha_mode")
    values.state(material, "doubleSided", "double_sided")
    result = replace(
        base,
        normal_texture=values.use(material, "normalTexture", "normal_texture"),
        normal_scale=1.0 if normal is None else values.number(normal, "scale", 1.0, "normal_scale"),
        # 3.9.3: occluded colour = lerp(colour, colour * texel, strength).
        occlusion_texture=values.use(
            material, "occlusionTexture", "occlusion_texture", "r", scale=strength, bias=1.0 - strength
        ),
        emissive=values.color(material, "emissiveFactor", (0.0, 0.0, 0.0), "emissive"),
        emissive_texture=values.use(material, "emissiveTexture", "emissive_texture"),
        alpha_mode=_ALPHA_MODES[alpha_mode],
        alpha_cutoff=values.fraction(material, "alphaCutoff", 0.5, "alpha_cutoff"),
        double_sided=material.boolean("doubleSided", False),
    )
    specular = material.extension(_SPECULAR_GLOSSINESS)
    if specular is not None:
        return with_specular_glossiness(specular, values, textures, result)
    lit = material.extension("KHR_materials_unlit") is None
    return _metallic_roughness(material.object("pbrMetallicRoughness"), values, textures, result, lit)


def _metallic_roughness(pbr: Json, values: MaterialValues, textures: Textures, base: Material, lit: bool) -> Material:
    """`base` with the values of `pbr`; an unlit surface is matt, whatever they are. Alpha counts only where the alpha
    mode uses it (3.9.4).
    """
    *color, alpha = values.fractions(pbr, "baseColorFactor", (1.0, 1.0, 1.0, 1.0), "base_color")
    opaque = base.alpha_mode == "opaque"
    base_color = textures.use(pbr.get("baseColorTexture"))
    opacity_texture = None
    if not opaque:
        values.declare("opacity", "alpha of pbrMetallicRoughness.baseColorFactor")
        if base_color is not None and base_color[1].extension == "png":  # JPEG has no alpha.
            opacity_texture = replace(base_color[0], channel="a")
            values.declare("opacity_texture", "alpha of pbrMetallicRoughness.baseColorTexture")
    result = replace(
        base,
        base_color=rgb(color),
        base_color_texture=values.use(pbr, "baseColorTexture", "base_color_texture"),
        opacity=1.0 if opaque else alpha,
        opacity_texture=opacity_texture,
        metallic=0.0,
        roughness=1.0,
    )
    if not lit:
        values.declare("metallic", "KHR_materials_unlit")
        values.declare("roughness", "KHR_materials_unlit")
        return result
    return replace(
        result,
        metallic=values.fraction(pbr, "metallicFactor", 1.0, "metallic"),
        metallic_texture=values.use(pbr, "metallicRoughnessTexture", "metallic_texture", "b"),
        roughness=values.fraction(pbr, "roughnessFactor", 1.0, "roughness"),
        roughness_texture=values.use(pbr, "metallicRoughnessTexture", "roughness_texture", "g"),
    )
