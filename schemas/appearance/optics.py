"""The optical behaviour of a material: which layers it really has, what they state, and the class of its optics."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass, replace
from typing import Any

from schemas.appearance.material import (
    WHITE,
    Anisotropy,
    DiffuseTransmission,
    Iridescence,
    Material,
    Sheen,
    Specular,
    Volume,
)
from schemas.appearance.record import Optics

_NOT_OPTICAL = ("name", "normal_green", "origins", "unmapped", "lost_textures")
_LEAST_DISPERSION = 1e-3  # an Abbe number of 20000, hundreds of times that of any glass
_LAYERS: dict[str, type] = {
    "specular": Specular,
    "volume": Volume,
    "sheen": Sheen,
    "anisotropy": Anisotropy,
    "iridescence": Iridescence,
    "diffuse_transmission": DiffuseTransmission,
}


def effective(material: Material) -> Material:
    """`material` without what changes no picture: layers of no weight, and inner values of light that never enters.

    A metal lets no light in; without transmission there is no inside, no thickness and no dispersion.
    """
    metal = material.metallic >= 1.0 and material.metallic_texture is None
    clear = material.transmission > 0.0 and not metal
    coated = material.clearcoat > 0.0
    diffuse = None if metal else material.diffuse_transmission
    default = Material(material.name)
    seen = replace(
        material,
        transmission=material.transmission if clear else 0.0,
        transmission_texture=material.transmission_texture if clear else None,
        dispersion=material.dispersion if clear and material.dispersion >= _LEAST_DISPERSION else 0.0,
        volume=material.volume if clear else None,
        diffuse_transmission=diffuse if diffuse is not None and diffuse.factor > 0.0 else None,
        sheen=material.sheen if material.sheen is not None and max(material.sheen.color) > 0.0 else None,
        anisotropy=material.anisotropy if material.anisotropy and material.anisotropy.strength > 0.0 else None,
        iridescence=material.iridescence if material.iridescence and material.iridescence.factor > 0.0 else None,
        normal_scale=material.normal_scale if material.normal_texture else 1.0,
        alpha_cutoff=material.alpha_cutoff if material.alpha_mode == "mask" else default.alpha_cutoff,
        opacity=material.opacity if material.alpha_mode != "opaque" else 1.0,
        opacity_texture=material.opacity_texture if material.alpha_mode != "opaque" else None,
        specular=None if _plain_specular(material) or metal else material.specular,
        emissive_texture=material.emissive_texture if any(material.emissive) else None,
    )
    if coated:
        return replace(seen, clearcoat_normal_scale=seen.clearcoat_normal_scale if seen.clearcoat_normal_texture else 1)
    return replace(
        seen,
        clearcoat=0.0,
        clearcoat_texture=None,
        clearcoat_roughness=0.0,
        clearcoat_roughness_texture=None,
        clearcoat_normal_texture=None,
        clearcoat_normal_scale=1.0,
    )


def optics_of(material: Material) -> Optics:
    """`transmissive` where light passes through, else `coated` where a clear coat lies on top, else `opaque`.

    Cut-outs and blended alpha are coverage and no optics: a leaf of a tree in a picture with alpha is opaque.
    """
    seen = effective(material)
    if seen.transmission > 0.0:
        return "transmissive"
    return "coated" if seen.clearcoat > 0.0 else "opaque"


def stated_values(material: Material) -> dict[str, Any]:
    """Every value by field, of layers as "sheen.color"; without absent layers, absent textures and infinite lengths."""
    return {
        name: value
        for name, value in _values(material, "")
        if value is not None and not (isinstance(value, float) and math.isinf(value))
    }


def unlike_plain(material: Material) -> frozenset[str]:
    """The fields of `material`, of layers as "sheen.color", whose values are not those of a plain grey surface."""
    return frozenset(name for name, value in _values(material, "") if value is not None and value != _plain(name))


def inner_color(material: Material) -> tuple[tuple[float, float, float], float]:
    """The colour of light that has passed through, and the length after which it has it (0: at once, at the surface).

    KHR_materials_volume attenuates over a length; without it the base colour tints what passes (KHR_materials_
    transmission). One colour cannot say both: where light is attenuated, the tint of the surface is left to the base.
    """
    volume = material.volume
    if volume is None or is_thin_walled(material) or math.isinf(volume.attenuation_distance):
        return material.base_color, 0.0
    return volume.attenuation_color, volume.attenuation_distance


def is_thin_walled(material: Material) -> bool:
    """Whether light passes through without entering a body: no volume, or one of no thickness."""
    return material.volume is None or material.volume.thickness == 0.0


def _plain_specular(material: Material) -> bool:
    specular = material.specular
    if specular is None:
        return True
    textures = specular.weight_texture or specular.color_texture
    return textures is None and specular.weight == 1.0 and specular.color == WHITE


def _plain(name: str) -> Any:
    """The value of a field where nothing is stated; None for fields that a layer must state."""
    layer, _, field = name.rpartition(".")
    owner = _LAYERS[layer] if layer else Material
    stated = next(entry for entry in fields(owner) if entry.name == field)
    return None if stated.default is MISSING else stated.default


def _values(layer: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    for entry in fields(layer):
        value = getattr(layer, entry.name)
        if not prefix and entry.name in _NOT_OPTICAL:
            continue
        if is_dataclass(value) and not entry.name.endswith("texture"):
            yield from _values(value, f"{entry.name}.")
        else:
            yield f"{prefix}{entry.name}", value
