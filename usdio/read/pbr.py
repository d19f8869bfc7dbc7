"""Converts the inputs of a surface shader into the metallic-roughness `Material` of `schemas.model`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from schemas.appearance.conversions import metallic_from_specular
from schemas.appearance.material import (
    Anisotropy,
    Channel,
    Iridescence,
    Material,
    Origin,
    Sheen,
    Specular,
    TextureUse,
)
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.evidence import BY_STANDARD
from usdio.read.shader_graph import EARLIEST, ImageSource, InputSource, to_json

Color = tuple[float, float, float]
# The quantities of `shader_dialects` from which each field of `Material` is made.
_QUANTITIES: Final[dict[str, tuple[str, ...]]] = {
    "base_color": ("base_color", "base_tint", "base_weight"),
    "metallic": ("metallic", "specular_workflow", "specular_color"),
    "roughness": ("roughness",),
    "normal_texture": ("normal",),
    "normal_scale": ("normal", "normal_scale"),
    "occlusion_texture": ("occlusion",),
    "emissive": ("emissive", "emissive_weight", "emissive_luminance", "emissive_switch", "emissive_strength"),
    "opacity": ("opacity", "opacity_switch"),
    "alpha_mode": ("opacity", "cutoff", "opacity_switch"),
    "alpha_cutoff": ("cutoff",),
    "ior": ("ior",),
    "clearcoat": ("clearcoat", "clearcoat_switch"),
    "clearcoat_roughness": ("clearcoat_roughness",),
    "transmission": ("transmission",),
    "dispersion": ("dispersion", "dispersion_abbe"),
    "specular.weight": ("specular_weight",),
    "specular.color": ("specular_tint",),
    "sheen.color": ("sheen_color", "sheen_weight"),
    "sheen.roughness": ("sheen_roughness",),
    "anisotropy.strength": ("anisotropy",),
    "anisotropy.rotation_rad": ("anisotropy_rad", "anisotropy_turns"),
    "iridescence.factor": ("film_weight",),
    "iridescence.ior": ("film_ior",),
    "iridescence.thickness_nm": ("film_thickness_um",),
}
_NITS_OF_WHITE: Final = 1000.0  # OpenPBR emission is in nits; this much is shown as full white.


class MaterialConversion:
    """Conversion of one material from its `sources` (by the quantities of `shader_dialects`) to `Material`.

    `authored` is the input of each quantity that the file states, `dialect` the name of the shader. `texture` returns
    the name of the texture an image reads, or None when there is none. `uv_names` (the primvars of the UV sets, in the
    order of `TextureUse.uv_set`) and `diagnostics` are complete once `material` has returned.
    """

    def __init__(
        self,
        sources: dict[str, InputSource],
        authored: Mapping[str, str],
        dialect: str,
        texture: Callable[[ImageSource], str | None],
        where: Location,
    ) -> None:
        self._sources, self._texture, self._where = sources, texture, where
        self._authored, self._dialect = authored, dialect
        self.uv_names: list[str] = []
        self.diagnostics: list[Diagnostic] = []
        self._unmapped_inputs: dict[str, Any] = {}

    def material(self, name: str, double_sided: bool, unmapped: dict[str, Any]) -> Material:
        """The material called `name`; values outside their range are clamped with a warning."""
        sources = self._sources
        base, base_map = self._color("base_color", (0.8, 0.8, 0.8))
        base = _times(base, self._constant("base_tint", (1.0, 1.0, 1.0)), self._number("base_weight", 1.0))
        metallic, metallic_map = self._scalar("metallic", 0.0)
        roughness, roughness_map = self._scalar("roughness", 0.5)
        if sources.get("specular_workflow") in (1.0, True):
            base, metallic = self._from_specular(base)
            metallic_map = None
        emissive, emissive_map = self._color("emissive", (0.0, 0.0, 0.0))
        emissive = _times(emissive, (1.0, 1.0, 1.0), self._emission())
        shows = bool(sources.get("opacity_switch", True))
        opacity, opacity_map = self._scalar("opacity", 1.0) if shows else (1.0, None)
        cutoff = self._number("cutoff", 0.0)
        see_through = opacity_map is not None or opacity < 1.0
        normal_map, normal_scale = self._normal()
        transmission, transmission_map = self._scalar("transmission", 0.0)
        coat, coat_map, coat_roughness, coat_roughness_map = self._coat()
        converted = Material(
            name,
            base_color=_unit(base),
            base_color_texture=base_map,
            metallic=self._clamped("metallic", metallic),
            metallic_texture=metallic_map,
            roughness=self._clamped("roughness", roughness),
            roughness_texture=roughness_map,
            normal_texture=normal_map,
            normal_scale=normal_scale,
            occlusion_texture=self._scalar("occlusion", 1.0)[1],
            emissive=_bright(emissive),
            emissive_texture=emissive_map if any(emissive) else None,
            opacity=self._clamped("opacity", opacity),
            opacity_texture=opacity_map,
            alpha_mode="opaque" if not see_through else "mask" if cutoff > 0 else "blend",
            alpha_cutoff=self._clamped("cutoff", cutoff) if cutoff > 0 else 0.5,
            double_sided=double_sided,
            ior=self._number("ior", 1.5),
            clearcoat=self._clamped("clearcoat", coat),
            clearcoat_texture=coat_map,
            clearcoat_roughness=self._clamped("clearcoat_roughness", coat_roughness),
            clearcoat_roughness_texture=coat_roughness_map,
            transmission=self._clamped("transmission", transmission),
            transmission_texture=transmission_map,
            dispersion=self._dispersion(),
            specular=self._specular_layer(),
            sheen=self._sheen(),
            anisotropy=self._anisotropy(),
            iridescence=self._iridescence(),
            unmapped={**unmapped, **self._unmapped_inputs},
            lost_textures=("base_color_texture",) if base_map is None and self._image("base_color") else (),
        )
        return replace(converted, origins=self._origins(converted))

    def _emission(self) -> float:
        """The factor 0..1 on the emissive colour: switch, weight, and luminance in nits."""
        if not self._sources.get("emissive_switch", True):
            return 0.0
        nits = self._number("emissive_luminance", _NITS_OF_WHITE)
        strength = self._number("emissive_strength", 1.0)
        return strength * self._number("emissive_weight", 1.0) * nits / _NITS_OF_WHITE

    def _coat(self) -> tuple[float, TextureUse | None, float, TextureUse | None]:
        """Weight and roughness of the clear coat with their textures; none where a switch turns it off."""
        if not self._sources.get("clearcoat_switch", True):
            return 0.0, None, 0.0, None
        return *self._scalar("clearcoat", 0.0), *self._scalar("clearcoat_roughness", 0.0)

    def _dispersion(self) -> float:
        """20 / Abbe number, as KHR_materials_dispersion has it; standard_surface states the Abbe number."""
        abbe = self._number("dispersion_abbe", 0.0)
        return 20.0 / abbe if abbe > 0.0 else max(self._number("dispersion", 0.0), 0.0)

    def _specular_layer(self) -> Specular | None:
        if not self._authored.keys() & {"specular_weight", "specular_tint"}:
            return None
        weight, weight_map = self._scalar("specular_weight", 1.0)
        tint, tint_map = self._color("specular_tint", (1.0, 1.0, 1.0))
        return Specular(self._clamped("specular_weight", weight), weight_map, _bright(tint), tint_map)

    def _sheen(self) -> Sheen | None:
        """The layer of fibres: its weight scales its colour, as glTF has one only."""
        if not self._authored.keys() & {"sheen_weight", "sheen_color"}:
            return None
        color, color_map = self._color("sheen_color", (0.0, 0.0, 0.0))
        roughness, roughness_map = self._scalar("sheen_roughness", 0.0)
        color = _unit(_times(color, (1.0, 1.0, 1.0), self._number("sheen_weight", 1.0)))
        return Sheen(color, color_map, self._clamped("sheen_roughness", roughness), roughness_map)

    def _anisotropy(self) -> Anisotropy | None:
        if "anisotropy" not in self._authored:
            return None
        turn_rad = self._number("anisotropy_rad", 0.0) + math.tau * self._number("anisotropy_turns", 0.0)
        return Anisotropy(self._clamped("anisotropy", self._number("anisotropy", 0.0)), turn_rad)

    def _iridescence(self) -> Iridescence | None:
        """A thin film of one thickness."""
        if "film_weight" not in self._authored:
            return None
        factor, factor_map = self._scalar("film_weight", 0.0)
        thickness_nm = 1000.0 * max(self._number("film_thickness_um", 0.5), 0.0)
        ior = max(self._number("film_ior", 1.4), 1.0)
        return Iridescence(self._clamped("film_weight", factor), factor_map, ior, (thickness_nm, thickness_nm))

    def _origins(self, converted: Material) -> dict[str, Origin]:
        """The input that each value comes from, or that the shader's definition fills in."""
        origins: dict[str, Origin] = {}
        for field, quantities in _QUANTITIES.items():
            layer, _, name = field.rpartition(".")
            holder = getattr(converted, layer) if layer else converted
            if holder is None:
                continue
            inputs = [self._authored[quantity] for quantity in quantities if quantity in self._authored]
            method = f"{self._dialect}: {', '.join(inputs)}"
            if not inputs and any(quantity in self._sources for quantity in quantities):
                origins[field] = Origin("declared", f"{self._dialect}: default of the shader", BY_STANDARD)
            elif inputs and field == "metallic" and self._sources.get("specular_workflow") in (1.0, True):
                origins[field] = Origin("inferred", f"{method}, reference conversion of specular to metalness", 0.8)
            elif inputs:
                origins[field] = Origin("declared", method)
            if field in origins and getattr(holder, f"{name}_texture", None) is not None:
                origins[f"{field}_texture"] = origins[field]
        return origins

    def _constant(self, quantity: str, default: Color) -> Color:
        value = self._sources.get(quantity)
        if isinstance(value, float):
            return (value, value, value)
        if isinstance(value, tuple) and len(value) >= 3 and all(map(math.isfinite, value)):
            return (value[0], value[1], value[2])
        return default

    def _number(self, quantity: str, default: float) -> float:
        """A scalar quantity; an image in its place, for which there is no field, is recorded as unmapped."""
        value = self._sources.get(quantity)
        if isinstance(value, ImageSource):
            self._unmapped_inputs[f"{quantity}_texture"] = to_json(value.file.Get(EARLIEST))
        if isinstance(value, tuple) and value:
            value = sum(value[:3]) / len(value[:3])
        if isinstance(value, bool | float):
            if math.isfinite(value):
                return float(value)
            self._replaced(quantity, str(value), default)
        return default

    def _clamped(self, quantity: str, value: float) -> float:
        if 0.0 <= value <= 1.0:
            return value
        self._replaced(quantity, value, min(max(value, 0.0), 1.0))
        return min(max(value, 0.0), 1.0)

    def _replaced(self, quantity: str, value: float | str, used: float) -> None:
        headline = f"{quantity} {value} became {used}"
        self.diagnostics.append(
            finding("asset/invalid-material-value", headline, where=self._where, value=value, bound=used)
        )

    def _color(self, quantity: str, default: Color) -> tuple[Color, TextureUse | None]:
        """A colour and its texture. The texture's scale becomes the colour, since both multiply the texel."""
        image = self._image(quantity)
        if image is None:
            return self._constant(quantity, default), None
        bias = image.bias[0] if len(set(image.bias[:3])) == 1 else 0.0
        if any(image.bias[:3]) and bias == 0.0:
            self._unmapped_inputs[f"{quantity}_bias"] = list(image.bias)
        if bias:
            scale = sum(image.scale[:3]) / 3.0
            use = self._texture_use(image, image.channel, scale, bias)
            return (1.0, 1.0, 1.0) if use else self._fallback_color(image, default), use
        use = self._texture_use(image, image.channel)
        return (image.scale[0], image.scale[1], image.scale[2]) if use else self._fallback_color(image, default), use

    def _scalar(self, quantity: str, default: float) -> tuple[float, TextureUse | None]:
        image = self._image(quantity)
        if image is None:
            return self._number(quantity, default), None
        channel: Channel = "r" if image.channel == "rgb" else image.channel
        at = "rgba".index(channel)
        if image.bias[at]:
            use = self._texture_use(image, channel, image.scale[at], image.bias[at])
            return 1.0 if use else default, use
        use = self._texture_use(image, channel)
        if use is None and image.fallback:
            return image.fallback[at], None
        return image.scale[at] if use else default, use

    def _fallback_color(self, image: ImageSource, default: Color) -> Color:
        """The colour that replaces an absent image."""
        return (image.fallback[0], image.fallback[1], image.fallback[2]) if image.fallback else default

    def _normal(self) -> tuple[TextureUse | None, float]:
        """The normal map, as plain texels, and its strength (UsdPreviewSurface: scale 2, bias -1)."""
        image = self._image("normal")
        if image is None:
            return None, 1.0
        if image.scale[1] < 0:
            self._unmapped_inputs["normal_scale"] = list(image.scale)
        use = self._texture_use(image, "rgb")
        strength = image.scale[0] / 2.0 if image.bias[0] else 1.0
        return use, strength * self._number("normal_scale", 1.0) if use else 1.0

    def _image(self, quantity: str) -> ImageSource | None:
        for key in (f"{quantity}_map", quantity):
            value = self._sources.get(key)
            if isinstance(value, ImageSource):
                return value
        return None

    def _texture_use(
        self, image: ImageSource, channel: Channel, scale: float = 1.0, bias: float = 0.0
    ) -> TextureUse | None:
        texture = self._texture(image)
        if texture is None:
            return None
        uv_name = image.primvar or "st"
        if uv_name not in self.uv_names:
            self.uv_names.append(uv_name)
        uv_scale, uv_offset, rotation = image.uv_scale, image.uv_offset, image.uv_rotation_rad
        shader_transform = (
            self._sources.get("uv_scale"),
            self._sources.get("uv_offset"),
            self._sources.get("uv_rotation_deg"),
        )
        if isinstance(shader_transform[0], tuple):
            uv_scale = (shader_transform[0][0], shader_transform[0][1])
        if isinstance(shader_transform[1], tuple):
            uv_offset = (shader_transform[1][0], shader_transform[1][1])
        if isinstance(shader_transform[2], float):
            rotation = math.radians(shader_transform[2])
        return TextureUse(
            texture=texture,
            channel=channel,
            uv_set=self.uv_names.index(uv_name),
            wrap_s=image.wrap_s,  # pyright: ignore[reportArgumentType]  # `shader_graph` writes these words only
            wrap_t=image.wrap_t,  # pyright: ignore[reportArgumentType]  # as above
            uv_scale=uv_scale,
            uv_rotation_rad=rotation,
            uv_offset=uv_offset,
            scale=scale,
            bias=bias,
        )

    def _from_specular(self, diffuse: Color) -> tuple[Color, float]:
        """Base colour and metalness of a specular-workflow surface.

        Solves the reflectance model of the metallic workflow for metalness, as in the Khronos note on converting
        KHR_materials_pbrSpecularGlossiness. A specular texture has no field and is recorded as unmapped.
        """
        specular = self._constant("specular_color", (0.0, 0.0, 0.0))
        image = self._image("specular_color")
        if image is not None:
            self._unmapped_inputs["specular_color_texture"] = to_json(image.file.Get(EARLIEST))
        base, metallic = metallic_from_specular(np.array(diffuse), np.array(specular))
        r, g, b = (float(channel) for channel in base)
        return (r, g, b), float(metallic)


_CLEAR: Final = ("transmission", "transmission_texture", "opacity", "opacity_texture")
# What UsdPreviewSurface cannot state, and a surface of another render context can.
_BEYOND_PREVIEW: Final = (
    "dispersion",
    "specular",
    "volume",
    "sheen",
    "anisotropy",
    "iridescence",
    "diffuse_transmission",
)


def layer_sources(
    sources: Mapping[str, InputSource], authored: Mapping[str, str]
) -> tuple[dict[str, InputSource], dict[str, str]]:
    """The sources and authored inputs of layers that UsdPreviewSurface lacks; of opacity only beside transmission."""
    clear = {"transmission"} & sources.keys()
    fields = (*_BEYOND_PREVIEW, "ior", *(_CLEAR if clear else ()))
    quantities = {q for field, of_field in _QUANTITIES.items() if field.partition(".")[0] in fields for q in of_field}
    return (
        {name: source for name, source in sources.items() if name.removesuffix("_map") in quantities},
        {name: port for name, port in authored.items() if name in quantities},
    )


def with_layers_of(material: Material, other: Material) -> Material:
    """`material` with the layers that it lacks and `other`, a surface of the same material, has, and their origins.

    Transmitted light is taken together with opacity: a surface without transmission shows glass as opacity. The weight
    of specular light is taken with its index of refraction: a surface without weights puts both into one index.
    """
    changes: dict[str, Any] = {}
    for field in _BEYOND_PREVIEW:
        if not getattr(material, field) and getattr(other, field):
            changes[field] = getattr(other, field)
    if "specular" in changes:
        changes["ior"] = other.ior
    if material.transmission == 0.0 and other.transmission > 0.0:
        changes |= {field: getattr(other, field) for field in (*_CLEAR, "alpha_mode")}
    origins = {field: origin for field, origin in other.origins.items() if field.partition(".")[0] in changes}
    return replace(material, **changes, origins={**material.origins, **origins})


def _times(color: Color, tint: Color, weight: float) -> Color:
    return (color[0] * tint[0] * weight, color[1] * tint[1] * weight, color[2] * tint[2] * weight)


def _bright(color: Color) -> Color:
    r, g, b = (max(channel, 0.0) for channel in color)
    return (r, g, b)


def _unit(color: Color) -> Color:
    r, g, b = (min(max(c, 0.0), 1.0) for c in color)
    return (r, g, b)
