"""OmniGlass, the MDL material of Omniverse for what light passes through."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from schemas.appearance.material import Material, Texture, TextureUse
from schemas.appearance.optics import inner_color, is_thin_walled
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
from usdio.write.materials.omni_pbr import lost_beside, weight_and_constant
from usdio.write.materials.output import ShaderOutput

_SHOWN: Final = frozenset(
    {
        "base_color",
        "roughness",
        "normal_scale",
        "opacity",
        "alpha_mode",
        "alpha_cutoff",
        "double_sided",
        "ior",
        "specular.color",
        "volume.thickness",
        "volume.attenuation_distance",
        "volume.attenuation_color",
    }
)


@dataclass(frozen=True)
class _Maps:
    """The textures that OmniGlass can read, all of one placement."""

    color: TextureUse | None = None
    roughness: TextureUse | None = None
    normal: TextureUse | None = None
    opacity: TextureUse | None = None

    @property
    def uses(self) -> tuple[TextureUse, ...]:
        return tuple(use for use in (self.color, self.roughness, self.normal, self.opacity) if use is not None)


def _lost(mesh_material: MeshMaterial, images: Mapping[str, Texture]) -> frozenset[str]:
    """Everything opaque, and partial transmission: OmniGlass lets all light through."""
    material = mesh_material.material
    maps = _maps_of(material, images)
    fields = set(_SHOWN)
    by_field = {
        "base_color_texture": maps.color,
        "roughness_texture": maps.roughness,
        "normal_texture": maps.normal,
        "opacity_texture": maps.opacity,
    }
    fields |= {name for name, use in by_field.items() if use is not None}
    if material.transmission == 1.0:
        fields.add("transmission")
    return lost_beside(frozenset(fields), mesh_material)


def _author(network: Network, mesh_material: MeshMaterial) -> None:
    material = mesh_material.material
    maps = _maps_of(material, network.files.images)
    shader = network.module("OmniGlass")
    color, depth = inner_color(material)
    set_input(shader, "glass_color", Types.Color3f, color)
    author_picture(network, shader, "glass_color_texture", maps.color, "sRGB")
    if depth > 0.0:
        set_input(shader, "depth", Types.Float, depth)
    set_input(shader, "glass_ior", Types.Float, material.ior)
    set_input(shader, "thin_walled", Types.Bool, is_thin_walled(material))
    rough = None if maps.roughness is None else weight_and_constant(material.roughness, maps.roughness)
    weight, constant = rough or (0.0, material.roughness)
    set_input(shader, "frosting_roughness", Types.Float, constant)
    set_input(shader, "roughness_texture_influence", Types.Float, weight)
    author_picture(network, shader, "roughness_texture", maps.roughness, "raw")
    if material.specular is not None:
        set_input(shader, "reflection_color", Types.Color3f, material.specular.color)
    if maps.normal is not None:
        author_picture(network, shader, "normal_map_texture", maps.normal, "raw")
        set_input(shader, "normal_map_strength", Types.Float, material.normal_scale)
    if material.alpha_mode != "opaque":
        set_input(shader, "enable_opacity", Types.Bool, True)
        set_input(shader, "cutout_opacity", Types.Float, material.opacity)
        threshold = material.alpha_cutoff if material.alpha_mode == "mask" else 0.0
        set_input(shader, "opacity_threshold", Types.Float, threshold)
        if maps.opacity is not None:
            author_picture(network, shader, "cutout_opacity_texture", maps.opacity, "raw")
            mode = MONO_ALPHA if maps.opacity.channel == "a" else MONO_AVERAGE
            set_input(shader, "cutout_opacity_mono_source", Types.Int, mode)
    author_placement(shader, maps.uses)
    network.connect_surface(shader, "out", "mdl")


def _maps_of(material: Material, images: Mapping[str, Texture]) -> _Maps:
    """The colour decides the placement; it has a map only where the base colour is white, as no tint multiplies it."""
    maps = _Maps()
    color = material.base_color_texture
    if color is not None and is_plain(color) and inner_color(material) == ((1.0, 1.0, 1.0), 0.0):
        maps = _Maps(color=color)
    others = {"normal": material.normal_texture}
    rough = material.roughness_texture
    if rough is not None and single_number(rough, images) and weight_and_constant(material.roughness, rough):
        others["roughness"] = rough
    opacity = material.opacity_texture
    if opacity is not None and material.opacity == 1.0 and (opacity.channel == "a" or single_number(opacity, images)):
        others["opacity"] = opacity
    for name, use in others.items():
        if use is not None and (name == "roughness" or is_plain(use)) and placement_of((*maps.uses, use)) is not None:
            maps = _Maps(**{**vars(maps), name: use})
    return maps


OMNI_GLASS: Final = ShaderOutput("OmniGlass", "mdl", _lost, _author)
