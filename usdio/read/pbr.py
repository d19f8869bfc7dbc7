"""Converts the inputs of a surface shader into the metallic-roughness `Material` of `schemas.model`."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from schemas.appearance.conversions import metallic_from_specular
from schemas.appearance.material import Channel, Material, TextureUse
from schemas.diagnostics import Diagnostic, Location, finding
from usdio.read.shader_graph import EARLIEST, ImageSource, InputSource, to_json

Color = tuple[float, float, float]
_NITS_OF_WHITE: Final = 1000.0  # OpenPBR emission is in nits; this much is shown as full white.


class MaterialConversion:
    """Conversion of one material from its `sources` (by the quantities of `shader_dialects`) to `Material`.

    `texture` returns the name of the texture an image reads, or None when there is none. `uv_names` (the primvars of
    the UV sets, in the order of `TextureUse.uv_set`) and `diagnostics` are complete once `material` has returned.
    """

    def __init__(
        self, sources: dict[str, InputSource], texture: Callable[[ImageSource], str | None], where: Location
    ) -> None:
        self._sources, self._texture, self._where = sources, texture, where
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
        return Material(
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
            emissive=_unit(emissive),
            emissive_texture=emissive_map if any(emissive) else None,
            opacity=self._clamped("opacity", opacity),
            opacity_texture=opacity_map,
            alpha_mode="opaque" if not see_through else "mask" if cutoff > 0 else "blend",
            alpha_cutoff=self._clamped("cutoff", cutoff) if cutoff > 0 else 0.5,
            double_sided=double_sided,
            ior=self._number("ior", 1.5),
            clearcoat=self._clamped("clearcoat", self._number("clearcoat", 0.0)),
            clearcoat_roughness=self._clamped("clearcoat_roughness", self._number("clearcoat_roughness", 0.0)),
            transmission=self._clamped("transmission", self._number("transmission", 0.0)),
            unmapped={**unmapped, **self._unmapped_inputs},
        )

    def _emission(self) -> float:
        """The factor 0..1 on the emissive colour: switch, weight, and luminance in nits."""
        if not self._sources.get("emissive_switch", True):
            return 0.0
        nits = self._number("emissive_luminance", _NITS_OF_WHITE)
        return self._number("emissive_weight", 1.0) * min(nits / _NITS_OF_WHITE, 1.0)

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


def _times(color: Color, tint: Color, weight: float) -> Color:
    return (color[0] * tint[0] * weight, color[1] * tint[1] * weight, color[2] * tint[2] * weight)


def _unit(color: Color) -> Color:
    r, g, b = (min(max(c, 0.0), 1.0) for c in color)
    return (r, g, b)
