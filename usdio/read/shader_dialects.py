"""Input names of common surface shaders, by quantity of the metallic-roughness model.

Sources: UsdPreviewSurface specification 2.6; MaterialX 1.38 standard_surface, gltf_pbr and open_pbr_surface node
definitions (OpenPBR 1.1); NVIDIA OmniPBR.mdl and OmniSurface parameters.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Final


@dataclass(frozen=True)
class ShaderDialect:
    """The input names of one surface shader.

    identifiers  a shader uses the dialect when its id contains one of these.
    inputs       our quantity -> name of the input that holds its value or connection.
    maps         our quantity -> name of an input that holds an image file directly (MDL style).
    defaults     our quantity -> value when nothing is authored.
    """

    name: str
    identifiers: tuple[str, ...]
    inputs: dict[str, str]
    maps: dict[str, str] = field(default_factory=dict)
    defaults: dict[str, Any] = field(default_factory=dict)


PREVIEW: Final = ShaderDialect(
    "UsdPreviewSurface",
    ("UsdPreviewSurface",),
    {
        "base_color": "diffuseColor",
        "metallic": "metallic",
        "roughness": "roughness",
        "normal": "normal",
        "occlusion": "occlusion",
        "emissive": "emissiveColor",
        "opacity": "opacity",
        "cutoff": "opacityThreshold",
        "ior": "ior",
        "clearcoat": "clearcoat",
        "clearcoat_roughness": "clearcoatRoughness",
        "specular_workflow": "useSpecularWorkflow",
        "specular_color": "specularColor",
    },
    defaults={
        "base_color": (0.18, 0.18, 0.18),
        "roughness": 0.5,
        "ior": 1.5,
        "clearcoat_roughness": 0.01,
        "specular_color": (0.0, 0.0, 0.0),
    },
)
STANDARD_SURFACE: Final = ShaderDialect(
    "standard_surface",
    ("standard_surface", "StandardSurface"),
    {
        "base_weight": "base",
        "base_color": "base_color",
        "metallic": "metalness",
        "roughness": "specular_roughness",
        "normal": "normal",
        "emissive_weight": "emission",
        "emissive": "emission_color",
        "opacity": "opacity",
        "ior": "specular_IOR",
        "clearcoat": "coat",
        "clearcoat_roughness": "coat_roughness",
        "transmission": "transmission",
        "dispersion_abbe": "transmission_dispersion",
        "specular_weight": "specular",
        "specular_tint": "specular_color",
        "sheen_weight": "sheen",
        "sheen_color": "sheen_color",
        "sheen_roughness": "sheen_roughness",
        "anisotropy": "specular_anisotropy",
        "anisotropy_turns": "specular_rotation",
    },
    defaults={
        "base_weight": 1.0,
        "base_color": (0.8, 0.8, 0.8),
        "roughness": 0.2,
        "emissive_weight": 0.0,
        "emissive": (1.0, 1.0, 1.0),
        "ior": 1.5,
        "clearcoat_roughness": 0.1,
        "specular_weight": 1.0,
        "specular_tint": (1.0, 1.0, 1.0),
        "sheen_weight": 0.0,
        "sheen_color": (1.0, 1.0, 1.0),
        "sheen_roughness": 0.3,
    },
)
OPEN_PBR: Final = ShaderDialect(
    "open_pbr_surface",
    ("open_pbr", "OpenPBR"),
    {
        "base_weight": "base_weight",
        "base_color": "base_color",
        "metallic": "base_metalness",
        "roughness": "specular_roughness",
        "normal": "geometry_normal",
        "emissive_luminance": "emission_luminance",
        "emissive": "emission_color",
        "opacity": "geometry_opacity",
        "ior": "specular_ior",
        "clearcoat": "coat_weight",
        "clearcoat_roughness": "coat_roughness",
        "transmission": "transmission_weight",
        "specular_weight": "specular_weight",
        "specular_tint": "specular_color",
        "sheen_weight": "fuzz_weight",
        "sheen_color": "fuzz_color",
        "sheen_roughness": "fuzz_roughness",
        "film_weight": "thin_film_weight",
        "film_ior": "thin_film_ior",
        "film_thickness_um": "thin_film_thickness",
    },
    defaults={
        "base_weight": 1.0,
        "base_color": (0.8, 0.8, 0.8),
        "roughness": 0.3,
        "emissive_luminance": 0.0,
        "emissive": (1.0, 1.0, 1.0),
        "ior": 1.5,
        "specular_weight": 1.0,
        "specular_tint": (1.0, 1.0, 1.0),
        "sheen_weight": 0.0,
        "sheen_color": (1.0, 1.0, 1.0),
        "sheen_roughness": 0.5,
        "film_weight": 0.0,
        "film_ior": 1.4,
        "film_thickness_um": 0.5,
    },
)
GLTF_PBR: Final = ShaderDialect(
    "gltf_pbr",
    ("gltf_pbr",),
    {
        "base_color": "base_color",
        "metallic": "metallic",
        "roughness": "roughness",
        "normal": "normal",
        "occlusion": "occlusion",
        "emissive": "emissive",
        "opacity": "alpha",
        "cutoff": "alpha_cutoff",
        "ior": "ior",
        "clearcoat": "clearcoat",
        "clearcoat_roughness": "clearcoat_roughness",
        "transmission": "transmission",
        "dispersion": "dispersion",
        "specular_weight": "specular",
        "specular_tint": "specular_color",
        "sheen_color": "sheen_color",
        "sheen_roughness": "sheen_roughness",
        "anisotropy": "anisotropy_strength",
        "anisotropy_rad": "anisotropy_rotation",
        "emissive_strength": "emissive_strength",
    },
    defaults={
        "base_color": (1.0, 1.0, 1.0),
        "metallic": 1.0,
        "roughness": 1.0,
        "ior": 1.5,
        "specular_weight": 1.0,
        "specular_tint": (1.0, 1.0, 1.0),
        "sheen_weight": 1.0,
        "sheen_color": (0.0, 0.0, 0.0),
        "sheen_roughness": 0.0,
        "emissive_strength": 1.0,
    },
)
OMNI_GLASS: Final = ShaderDialect(
    "OmniGlass",
    ("OmniGlass",),
    {
        "base_color": "glass_color",
        "roughness": "frosting_roughness",
        "ior": "glass_ior",
        "opacity_switch": "enable_opacity",
        "opacity": "cutout_opacity",
        "uv_scale": "texture_scale",
        "uv_rotation_deg": "texture_rotate",
        "uv_offset": "texture_translate",
    },
    {"base_color": "glass_color_texture", "roughness": "roughness_texture", "normal": "normal_map_texture"},
    {
        "base_color": (1.0, 1.0, 1.0),
        "roughness": 0.0,
        "ior": 1.491,
        "opacity_switch": False,
        "transmission": 1.0,
    },
)
OMNI_PBR: Final = ShaderDialect(
    "OmniPBR",
    ("OmniPBR", "OmniSurface"),
    {
        "base_color": "diffuse_color_constant",
        "base_tint": "diffuse_tint",
        "metallic": "metallic_constant",
        "roughness": "reflection_roughness_constant",
        "emissive_switch": "enable_emission",
        "emissive": "emissive_color",
        "clearcoat_switch": "enable_clearcoat",
        "clearcoat": "clearcoat_weight",
        "clearcoat_roughness": "clearcoat_reflection_roughness",
        "opacity_switch": "enable_opacity",
        "opacity": "opacity_constant",
        "cutoff": "opacity_threshold",
        "orm_switch": "enable_ORM_texture",
        "normal_scale": "bump_factor",
        "uv_scale": "texture_scale",
        "uv_rotation_deg": "texture_rotate",
        "uv_offset": "texture_translate",
    },
    {
        "base_color": "diffuse_texture",
        "metallic": "metallic_texture",
        "roughness": "reflectionroughness_texture",
        "normal": "normalmap_texture",
        "occlusion": "ao_texture",
        "emissive": "emissive_color_texture",
        "opacity": "opacity_texture",
        "orm": "ORM_texture",
    },
    {
        "base_color": (0.2, 0.2, 0.2),
        "base_tint": (1.0, 1.0, 1.0),
        "roughness": 0.5,
        "emissive_switch": False,
        "emissive": (1.0, 0.1, 0.1),
        "opacity_switch": False,
        "orm_switch": False,
        "ior": 1.5,
    },
)
DIALECTS: Final = (PREVIEW, STANDARD_SURFACE, OPEN_PBR, GLTF_PBR, OMNI_GLASS, OMNI_PBR)


def is_known(identifier: str) -> bool:
    """Whether a dialect recognises the shader by its id."""
    return any(part in identifier for dialect in DIALECTS for part in dialect.identifiers)


def dialect_of(identifier: str, names: tuple[str, ...]) -> ShaderDialect:
    """The dialect of a shader: by its id, else the one with most of its authored input `names`."""
    for dialect in DIALECTS:
        if any(part in identifier for part in dialect.identifiers):
            return dialect
    return max(DIALECTS, key=lambda d: len({*d.inputs.values(), *d.maps.values()} & set(names)))
