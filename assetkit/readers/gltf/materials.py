"""Reads glTF materials as `schemas.appearance.material.Material` (glTF 2.0, 3.9; the KHR_materials_* extensions)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

from assetkit.readers.common.corners import Notes, repaired
from assetkit.readers.gltf.json import Json
from assetkit.readers.gltf.textures import Textures
from schemas.appearance.material import AlphaMode, Material, TextureUse
from schemas.diagnostics import finding

_ALPHA_MODES: Final[dict[str, AlphaMode]] = {"OPAQUE": "opaque", "MASK": "mask", "BLEND": "blend"}
_DIELECTRIC_SPECULAR: Final = 0.04


def read_material(material: Json, name: str, textures: Textures) -> tuple[Material, Notes]:
    """`material` as a metallic-roughness Material called `name`, and what was found.

    Extensions with a field are mapped; those without, or mapped in part, are kept verbatim in `unmapped` and
    announced by one `asset/material-extension-fallback`. Values out of range are clamped with a warning.
    Raises InvalidInput as `Textures.use` does.
    """
    reader = _Reader(textures)
    result = reader.core(material, Material(name=name))
    result = reader.extensions(material, result)
    names = ", ".join(key for key in result.unmapped if key != "extras")
    if names:
        headline = f"material '{name}': {names} kept in the record only or in part"
        reader.notes += Notes((finding("asset/material-extension-fallback", headline, where=material.where),))
    return result, reader.notes


class _Reader:
    """One material's reading: the texture table and the findings so far."""

    def __init__(self, textures: Textures) -> None:
        self._textures = textures
        self.notes = Notes()

    def core(self, material: Json, base: Material) -> Material:
        """The properties of glTF 2.0 itself."""
        alpha_mode = material.string("alphaMode", "OPAQUE")
        if alpha_mode not in _ALPHA_MODES:
            raise material.require("alphaMode").schema_error("expected OPAQUE, MASK or BLEND")
        normal, occlusion = material.get("normalTexture"), material.get("occlusionTexture")
        strength = 1.0 if occlusion is None else self._fraction(occlusion, "strength", 1.0)
        result = replace(
            base,
            normal_texture=self._use(normal),
            normal_scale=1.0 if normal is None else normal.number("scale", 1.0),
            # 3.9.3: occluded colour = lerp(colour, colour * texel, strength).
            occlusion_texture=self._use(occlusion, "r", scale=strength, bias=1.0 - strength),
            emissive=_rgb(self._fractions(material, "emissiveFactor", (0.0, 0.0, 0.0))),
            emissive_texture=self._use(material.get("emissiveTexture")),
            alpha_mode=_ALPHA_MODES[alpha_mode],
            alpha_cutoff=self._fraction(material, "alphaCutoff", 0.5),
            double_sided=material.boolean("doubleSided", False),
        )
        specular = material.extension("KHR_materials_pbrSpecularGlossiness")
        if specular is not None:  # It replaces the metallic-roughness block, which is there for older readers.
            return self._specular_glossiness(specular, result)
        lit = material.extension("KHR_materials_unlit") is None
        return self._metallic_roughness(material.object("pbrMetallicRoughness"), result, lit)

    def _metallic_roughness(self, pbr: Json, base: Material, lit: bool) -> Material:
        """`base` with the values of `pbr`; an unlit surface is matt, whatever they are."""
        *color, alpha = self._fractions(pbr, "baseColorFactor", (1.0, 1.0, 1.0, 1.0))
        surface = pbr.get("metallicRoughnessTexture") if lit else None
        result = replace(
            base,
            metallic=self._fraction(pbr, "metallicFactor", 1.0) if lit else 0.0,
            metallic_texture=self._use(surface, "b"),
            roughness=self._fraction(pbr, "roughnessFactor", 1.0) if lit else 1.0,
            roughness_texture=self._use(surface, "g"),
        )
        return self._with_base(result, _rgb(color), alpha, pbr.get("baseColorTexture"))

    def extensions(self, material: Json, base: Material) -> Material:
        """`base` changed by the material's extensions, with `unmapped` filled."""
        unmapped: dict[str, Any] = {}
        for extension in material.object("extensions").members():
            extension.members()
            base, complete = self._extension(extension, base)
            if not complete:
                unmapped[extension.key] = extension.value
        extras = material.get("extras")
        if extras is not None:
            unmapped["extras"] = extras.value
        return replace(base, unmapped=unmapped)

    def _extension(self, extension: Json, base: Material) -> tuple[Material, bool]:
        """`base` with the values of `extension`, and whether nothing of it is lost."""
        present = {member.key for member in extension.members()}
        match extension.key:
            case "KHR_materials_ior":
                ior = extension.number("ior", 1.5)
                return (replace(base, ior=ior), True) if ior >= 1.0 else (base, False)
            case "KHR_materials_emissive_strength":
                strength = max(extension.number("emissiveStrength", 1.0), 0.0)
                scaled = [strength * e for e in base.emissive]
                return replace(base, emissive=_rgb([min(e, 1.0) for e in scaled])), max(scaled) <= 1.0
            case "KHR_materials_clearcoat":
                factor = self._fraction(extension, "clearcoatFactor", 0.0)
                roughness = self._fraction(extension, "clearcoatRoughnessFactor", 0.0)
                complete = present <= {"clearcoatFactor", "clearcoatRoughnessFactor"}
                return replace(base, clearcoat=factor, clearcoat_roughness=roughness), complete
            case "KHR_materials_transmission":
                factor = self._fraction(extension, "transmissionFactor", 0.0)
                return replace(base, transmission=factor), factor == 0.0  # UsdPreviewSurface has no transmission.
            case _:  # Also those that `core` has read already: their values are only approximated.
                return base, False

    def _specular_glossiness(self, extension: Json, base: Material) -> Material:
        """Metallic-roughness values for KHR_materials_pbrSpecularGlossiness, by the conversion its appendix gives.

        A specular texture separates metal from paint per texel, which one factor cannot: the surface then counts as a
        dielectric of the diffuse colour.
        """
        *diffuse, alpha = self._fractions(extension, "diffuseFactor", (1.0, 1.0, 1.0, 1.0))
        specular = self._fractions(extension, "specularFactor", (1.0, 1.0, 1.0))
        glossiness = self._fraction(extension, "glossinessFactor", 1.0)
        texture = extension.get("specularGlossinessTexture")
        color, metallic = (_rgb(diffuse), 0.0) if texture is not None else metallic_from_specular(diffuse, specular)
        roughness_texture = self._use(texture, "a", scale=-glossiness, bias=1.0)
        result = replace(
            base,
            metallic=metallic,
            metallic_texture=None,
            roughness=1.0 if roughness_texture is not None else 1.0 - glossiness,
            roughness_texture=roughness_texture,
        )
        return self._with_base(result, color, alpha, extension.get("diffuseTexture"))

    def _with_base(
        self, material: Material, color: tuple[float, float, float], alpha: float, info: Json | None
    ) -> Material:
        """`material` with base colour and opacity; alpha counts only where the alpha mode uses it (3.9.4)."""
        used = self._textures.use(info)
        texture = None if used is None else used[0]
        opacity_texture = None
        if material.alpha_mode == "opaque":
            alpha = 1.0
        elif used is not None and used[1].extension == "png":  # JPEG has no alpha.
            opacity_texture = replace(used[0], channel="a")
        return replace(
            material,
            base_color=color,
            base_color_texture=texture,
            opacity=alpha,
            opacity_texture=opacity_texture,
        )

    def _use(
        self, info: Json | None, channel: Any = "rgb", *, scale: float = 1.0, bias: float = 0.0
    ) -> TextureUse | None:
        used = self._textures.use(info, channel, scale=scale, bias=bias)
        return None if used is None else used[0]

    def _fraction(self, json: Json, key: str, default: float) -> float:
        member = json.get(key)
        return default if member is None else self._clamped(member, member.as_number())

    def _fractions(self, json: Json, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
        values = json.vector(key, default)
        return tuple(self._clamped(json.require(key), v) if not 0.0 <= v <= 1.0 else v for v in values)

    def _clamped(self, json: Json, value: float) -> float:
        """`value` limited to 0..1, with a note when that changes it."""
        limited = min(max(value, 0.0), 1.0)
        if limited != value:
            diagnostic = finding(
                "asset/invalid-material-value",
                f"'{json.key}' is outside 0..1",
                where=json.where,
                value=value,
                bound=limited,
            )
            self.notes += repaired(diagnostic, "clamp_material_value", value=value)
        return limited


def metallic_from_specular(
    diffuse: list[float] | tuple[float, ...], specular: tuple[float, ...]
) -> tuple[tuple[float, float, float], float]:
    """Linear base colour and metallic for linear diffuse and specular colours.

    Source: KHR_materials_pbrSpecularGlossiness, the reference conversion: metallic m solves
    0.04 m^2 + (d k / 0.96 + s - 0.08) m + 0.04 - s = 0 for perceived brightnesses d, s and k = 1 - max(specular).
    """
    d, s, k = _brightness(diffuse), _brightness(specular), 1.0 - max(specular)
    a = _DIELECTRIC_SPECULAR
    metallic = 0.0
    if s > a + 1e-9:  # At the dielectric value itself black paint and black metal solve the equation alike: paint.
        b = d * k / (1.0 - a) + s - 2.0 * a
        metallic = min(max((-b + math.sqrt(max(b * b - 4.0 * a * (a - s), 0.0))) / (2.0 * a), 0.0), 1.0)
    blend = metallic * metallic
    color: list[float] = []
    for from_diffuse, from_specular in zip(diffuse, specular, strict=False):
        paint = from_diffuse * k / (1.0 - a) / max(1.0 - metallic, 1e-6)
        metal = (from_specular - a * (1.0 - metallic)) / max(metallic, 1e-6)
        color.append(min(max(paint * (1.0 - blend) + metal * blend, 0.0), 1.0))
    return _rgb(color), metallic


def _brightness(rgb: list[float] | tuple[float, ...]) -> float:
    return math.sqrt(0.299 * rgb[0] ** 2 + 0.587 * rgb[1] ** 2 + 0.114 * rgb[2] ** 2)


def _rgb(values: list[float] | tuple[float, ...]) -> tuple[float, float, float]:
    r, g, b = values
    return r, g, b
