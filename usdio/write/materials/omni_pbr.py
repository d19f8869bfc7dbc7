"""OmniPBR, the MDL material of Omniverse for opaque surfaces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from pxr import UsdShade

from schemas.appearance.material import Material, Texture, TextureUse
from schemas.appearance.optics import unlike_plain
from usdio.write.materials.mdl import (
    MONO_ALPHA,
    MONO_AVERAGE,
    author_picture,
    author_placement,
    is_plain,
    placement_of,
    single_number,
)
from usdio.write.materials.mesh_materials import MeshMaterial
from usdio.write.materials.network import Network, Types, set_input
from usdio.write.materials.open_pbr import NITS_OF_WHITE
from usdio.write.materials.output import VERTEX_COLORS, ShaderOutput

_ROUNDING = 1e-6  # of numbers that files hold in single precision
_REFLECTANCE_AT_ONE = 0.08  # OmniPBR: a specular level of 1 reflects 8 % at normal incidence, the usual 0.5 is 4 %
_SHOWN: Final = frozenset(
    {
        "base_color",
        "metallic",
        "roughness",
        "normal_scale",
        "emissive",
        "opacity",
        "alpha_mode",
        "alpha_cutoff",
        "double_sided",
        "ior",
    }
)


@dataclass(frozen=True)
class OmniMaps:
    """The textures of a material as OmniPBR can read them; a use that it cannot read is in none of the fields.

    `packed` is a picture of occlusion, roughness and metalness in its red, green and blue channel; `influence` are the
    weights of occlusion, roughness and metalness of a texture over the constants.
    """

    base: TextureUse | None
    normal: TextureUse | None
    emissive: TextureUse | None
    opacity: TextureUse | None
    packed: TextureUse | None
    single: Mapping[str, TextureUse]  # by field, pictures of one number

    @property
    def uses(self) -> tuple[TextureUse, ...]:
        """All of them."""
        direct = (self.base, self.normal, self.emissive, self.opacity, self.packed)
        return (*(use for use in direct if use is not None), *self.single.values())


def weight_and_constant(factor: float, use: TextureUse) -> tuple[float, float] | None:
    """(w, c) for which c + w (texel - c) is factor * (texel * scale + bias); None where w is not within 0..1."""
    weight, offset = factor * use.scale, factor * use.bias
    if not 0.0 <= weight <= 1.0:
        return None
    constant = 0.0 if offset == 0.0 else offset / (1.0 - weight) if weight < 1.0 else -1.0
    return (weight, min(constant, 1.0)) if 0.0 <= constant <= 1.0 + _ROUNDING else None


def maps_of(material: Material, images: Mapping[str, Texture]) -> OmniMaps:
    """Which textures OmniPBR can read, with one transform for all; those of the base colour decide which that is."""
    scalars = {
        "occlusion_texture": (1.0, material.occlusion_texture),
        "roughness_texture": (material.roughness, material.roughness_texture),
        "metallic_texture": (material.metallic, material.metallic_texture),
    }
    usable = {
        name: use
        for name, (factor, use) in scalars.items()
        if use is not None and _repeats(use) and _is_blend(name, factor, use)
    }
    channels = {"occlusion_texture": "r", "roughness_texture": "g", "metallic_texture": "b"}
    in_place = {name: use for name, use in usable.items() if use.channel == channels[name]}
    anchor = in_place.get("roughness_texture") or in_place.get("metallic_texture")
    grey = {name: use for name, use in usable.items() if single_number(use, images)}
    if anchor is not None and not {"roughness_texture", "metallic_texture"} & set(usable) <= set(grey):
        packed, single = anchor, {}
    else:
        packed, single = None, grey
    opacity = material.opacity_texture
    readable_opacity = opacity is not None and is_plain(opacity) and material.opacity == 1.0
    if readable_opacity and opacity is not None and opacity.channel != "a":
        readable_opacity = single_number(opacity, images)
    maps = OmniMaps(
        base=_plain(material.base_color_texture),
        normal=_plain(material.normal_texture),
        emissive=_plain(material.emissive_texture),
        opacity=opacity if readable_opacity else None,
        packed=packed,
        single=single,
    )
    return maps if not maps.uses or placement_of(maps.uses) is not None else _of_one_placement(maps)


def shown(material: Material, images: Mapping[str, Texture]) -> frozenset[str]:
    """The fields that the parameters of OmniPBR hold."""
    maps = maps_of(material, images)
    fields = set(_SHOWN)
    direct = {
        "base_color_texture": maps.base,
        "normal_texture": maps.normal,
        "emissive_texture": maps.emissive,
        "opacity_texture": maps.opacity,
    }
    fields |= {name for name, use in direct.items() if use is not None}
    fields |= set(maps.single)
    if maps.packed is not None:
        fields |= {name for name, use in _in_packed(material, maps.packed).items() if use is not None}
    return frozenset(fields)


def author_base(network: Network, shader: UsdShade.Shader, material: Material) -> None:
    """Author the parameters that OmniPBR and its variant with a clear coat share."""
    maps = maps_of(material, network.files.images)
    set_input(shader, "diffuse_color_constant", Types.Color3f, material.base_color)
    if maps.base is not None:
        set_input(shader, "diffuse_tint", Types.Color3f, material.base_color)
    author_picture(network, shader, "diffuse_texture", maps.base, "sRGB")
    _author_numbers(network, shader, material, maps)
    reflectance = ((material.ior - 1.0) / (material.ior + 1.0)) ** 2
    level = min(reflectance / _REFLECTANCE_AT_ONE, 1.0)
    set_input(shader, "specular_level", Types.Float, level)
    if maps.normal is not None:
        author_picture(network, shader, "normalmap_texture", maps.normal, "raw")
        set_input(shader, "bump_factor", Types.Float, material.normal_scale)
    strength = max(material.emissive)
    if strength > 0.0:
        r, g, b = (c / strength for c in material.emissive)
        set_input(shader, "enable_emission", Types.Bool, True)
        set_input(shader, "emissive_color", Types.Color3f, (r, g, b))
        set_input(shader, "emissive_intensity", Types.Float, NITS_OF_WHITE * strength)
        author_picture(network, shader, "emissive_color_texture", maps.emissive, "sRGB")
    if material.alpha_mode != "opaque":
        set_input(shader, "enable_opacity", Types.Bool, True)
        set_input(shader, "opacity_constant", Types.Float, material.opacity)
        threshold = material.alpha_cutoff if material.alpha_mode == "mask" else 0.0
        set_input(shader, "opacity_threshold", Types.Float, threshold)
        if maps.opacity is not None:
            set_input(shader, "enable_opacity_texture", Types.Bool, True)
            author_picture(network, shader, "opacity_texture", maps.opacity, "raw")
            mode = MONO_ALPHA if maps.opacity.channel == "a" else MONO_AVERAGE
            set_input(shader, "opacity_mode", Types.Int, mode)
    author_placement(shader, maps.uses)


def lost_beside(shown_fields: frozenset[str], mesh_material: MeshMaterial) -> frozenset[str]:
    """The fields of a mesh material that are not among the shown ones; no MDL material here reads vertex colours."""
    lost = unlike_plain(mesh_material.material) - shown_fields
    return lost | {VERTEX_COLORS} if mesh_material.vertex_colors else lost


def _author_numbers(network: Network, shader: UsdShade.Shader, material: Material, maps: OmniMaps) -> None:
    """Roughness, metalness and occlusion: constants, a packed picture, or pictures of one number each."""
    packed = {} if maps.packed is None else _in_packed(material, maps.packed)
    if maps.packed is not None:
        set_input(shader, "enable_ORM_texture", Types.Bool, True)
        author_picture(network, shader, "ORM_texture", maps.packed, "raw")
    names = {
        "roughness": ("reflection_roughness", "reflectionroughness_texture", material.roughness),
        "metallic": ("metallic", "metallic_texture", material.metallic),
    }
    for field, (stem, picture, factor) in names.items():
        use = packed.get(f"{field}_texture") or maps.single.get(f"{field}_texture")
        weight, constant = (0.0, factor) if use is None else weight_and_constant(factor, use) or (0.0, factor)
        set_input(shader, f"{stem}_constant", Types.Float, constant)
        set_input(shader, f"{stem}_texture_influence", Types.Float, weight)
        if maps.packed is None:
            author_picture(network, shader, picture, use, "raw")
    occlusion = packed.get("occlusion_texture") or maps.single.get("occlusion_texture")
    if occlusion is not None:
        set_input(shader, "ao_to_diffuse", Types.Float, occlusion.scale)
        if maps.packed is None:
            author_picture(network, shader, "ao_texture", occlusion, "raw")


def _in_packed(material: Material, packed: TextureUse) -> dict[str, TextureUse | None]:
    """The uses of the picture `packed` in its channels of occlusion, roughness and metalness, by field."""
    uses = {
        "occlusion_texture": ("r", 1.0, material.occlusion_texture),
        "roughness_texture": ("g", material.roughness, material.roughness_texture),
        "metallic_texture": ("b", material.metallic, material.metallic_texture),
    }
    return {
        name: use
        for name, (channel, factor, use) in uses.items()
        if use is not None
        and (use.texture, use.channel) == (packed.texture, channel)
        and _repeats(use)
        and placement_of((use, packed)) is not None
        and _is_blend(name, factor, use)
    }


def _is_blend(field: str, factor: float, use: TextureUse) -> bool:
    """Whether a weight over a constant holds the factor and the texture; for occlusion the constant is 1, no shade."""
    if field == "occlusion_texture":
        return 0.0 <= use.scale <= 1.0 and abs(use.scale + use.bias - 1.0) <= _ROUNDING
    return weight_and_constant(factor, use) is not None


def _of_one_placement(maps: OmniMaps) -> OmniMaps:
    """`maps` without the textures that are placed differently from the first one."""
    first = maps.uses[0]

    def alike(use: TextureUse | None) -> TextureUse | None:
        return use if use is not None and placement_of((first, use)) is not None else None

    return OmniMaps(
        base=alike(maps.base),
        normal=alike(maps.normal),
        emissive=alike(maps.emissive),
        opacity=alike(maps.opacity),
        packed=alike(maps.packed),
        single={name: use for name, use in maps.single.items() if alike(use) is not None},
    )


def _plain(use: TextureUse | None) -> TextureUse | None:
    return use if use is not None and is_plain(use) else None


def _repeats(use: TextureUse) -> bool:
    return use.wrap_s == use.wrap_t == "repeat"


def _lost(mesh_material: MeshMaterial, images: Mapping[str, Texture]) -> frozenset[str]:
    return lost_beside(shown(mesh_material.material, images), mesh_material)


def _author(network: Network, mesh_material: MeshMaterial) -> None:
    shader = network.module("OmniPBR")
    author_base(network, shader, mesh_material.material)
    network.connect_surface(shader, "out", "mdl")


OMNI_PBR: Final = ShaderOutput("OmniPBR", "mdl", _lost, _author)
