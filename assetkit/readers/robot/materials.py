"""The material that a robot description states for a shape, as a metallic-roughness Material.

Sources: URDF `<material>` (colour, texture); MJCF `asset/material` with its layers (XML reference of MuJoCo).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from assetkit.readers.common.phong import linear_rgb, origins_of, roughness_from_exponent, unit_interval
from schemas.appearance.material import Channel, LinearRGB, Material, Origin, TextureUse
from schemas.robot_description import DescribedMaterial

_MOST_EXPONENT = 128.0  # MuJoCo's renderer (OpenGL): the exponent of shininess 1
_WHITE = (1.0, 1.0, 1.0, 1.0)
# The fields that a layer of each role fills, with the channel that it reads (XML reference, material/layer/role).
_LAYERS: dict[str, tuple[tuple[str, Channel], ...]] = {
    "occlusion": (("occlusion_texture", "r"),),
    "roughness": (("roughness_texture", "r"),),
    "metallic": (("metallic_texture", "r"),),
    "normal": (("normal_texture", "rgb"),),
    "emissive": (("emissive_texture", "rgb"),),
    "opacity": (("opacity_texture", "r"),),
    "orm": (("occlusion_texture", "r"), ("roughness_texture", "g"), ("metallic_texture", "b")),
}
# The attributes from which each field is made, the first that stands counts.
_ATTRIBUTES: dict[str, tuple[str, ...]] = {
    "base_color": ("rgba",),
    "base_color_texture": ("texture",),
    "opacity": ("rgba",),
    "alpha_mode": ("rgba",),
    "metallic": ("metallic",),
    "roughness": ("roughness",),
    "emissive": ("emission",),
}


def stated_material(described: DescribedMaterial, texture_of: Callable[[str], TextureUse | None]) -> Material:
    """The material with the origin of each value; `texture_of` gives the use of a texture file, None without it.

    Colours are display values. What no field holds is in `unmapped`.
    """
    red, green, blue, alpha = described.rgba or _WHITE
    base = linear_rgb((red, green, blue))
    unmapped = dict(described.unread)
    material = Material(
        described.name or "material",
        base_color=base,
        base_color_texture=texture_of(described.texture) if described.texture else None,
        opacity=unit_interval(alpha),
        alpha_mode="blend" if alpha < 1.0 else "opaque",
        metallic=unit_interval(described.metallic or 0.0),
        roughness=_roughness(described),
        emissive=_times(base, described.emission or 0.0),
        normal_green="undeclared",
    )
    for role, file in described.layers:
        if role not in _LAYERS:
            unmapped[f"layer {role}"] = file
        elif (use := texture_of(file)) is not None:
            material = _with_layer(material, role, use)
    lost = ("base_color_texture",) if described.texture and material.base_color_texture is None else ()
    return replace(material, origins=_origins(material, described), unmapped=unmapped, lost_textures=lost)


def _roughness(described: DescribedMaterial) -> float:
    """As stated, else from the highlight where one is stated, else that of `Material`."""
    if described.roughness is not None:
        return unit_interval(described.roughness)
    if described.specular == 0.0:
        return 1.0
    if described.shininess is not None:
        return roughness_from_exponent(_MOST_EXPONENT * described.shininess)
    return Material("").roughness


def _with_layer(material: Material, role: str, use: TextureUse) -> Material:
    """The material with the pictures of a layer; a picture of roughness or metalness counts from full strength."""
    for field, channel in _LAYERS[role]:
        material = material.with_value(field, replace(use, channel=channel))
    if role in ("roughness", "orm"):
        material = replace(material, roughness=1.0)
    if role in ("metallic", "orm"):
        material = replace(material, metallic=1.0)
    if role == "emissive" and not any(material.emissive):
        material = replace(material, emissive=(1.0, 1.0, 1.0))
    return replace(material, alpha_mode="blend") if role == "opacity" else material


def _origins(material: Material, described: DescribedMaterial) -> dict[str, Origin]:
    names = ("metallic", "roughness", "specular", "shininess", "emission")
    stated = {name: name for name in names if getattr(described, name) is not None}
    stated |= {"rgba": "rgba"} if described.rgba is not None else {}
    stated |= {"texture": "texture"} if described.texture else {}
    origins = origins_of(material, _ATTRIBUTES, stated, exponent="shininess", metal=False)
    if "emissive" in origins:
        origins["emissive"] = Origin("declared", "emission times rgba")
    for role, _ in described.layers:
        for field, _ in _LAYERS.get(role, ()):
            origins[field] = Origin("declared", f"layer {role}")
            if (factor := field.removesuffix("_texture")) in ("metallic", "roughness", "emissive"):
                origins[factor] = origins[field]
    return origins


def _times(color: LinearRGB, factor: float) -> LinearRGB:
    return color[0] * factor, color[1] * factor, color[2] * factor
