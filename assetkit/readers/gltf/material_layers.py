"""The ratified KHR_materials_* extensions of glTF as layers of a material: one function and one row each.

Source: the specifications in github.com/KhronosGroup/glTF, extensions/2.0/Khronos. A function gives the material with
the layer; what of the extension has no field it leaves to `unmapped` by returning False.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from assetkit.readers.gltf.json import Json
from assetkit.readers.gltf.material_values import MaterialValues, rgb
from schemas.appearance.material import (
    WHITE,
    Anisotropy,
    DiffuseTransmission,
    Iridescence,
    Material,
    Origin,
    Sheen,
    Specular,
    Volume,
)

_SAME_SCALE = 1e-6  # relative; rounding of a product of single-precision matrices
_MEDIAN_CONFIDENCE = 0.5
Layer = Callable[[Json, MaterialValues, Material], tuple[Material, bool]]


def _anisotropy(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    layer = Anisotropy(
        strength=values.fraction(extension, "anisotropyStrength", 0.0, "anisotropy.strength"),
        rotation_rad=values.number(extension, "anisotropyRotation", 0.0, "anisotropy.rotation_rad"),
        texture=values.use(extension, "anisotropyTexture", "anisotropy.texture"),
    )
    return replace(base, anisotropy=layer), True


def _clearcoat(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    normal = extension.get("clearcoatNormalTexture")
    coated = replace(
        base,
        clearcoat=values.fraction(extension, "clearcoatFactor", 0.0, "clearcoat"),
        clearcoat_texture=values.use(extension, "clearcoatTexture", "clearcoat_texture", "r"),
        clearcoat_roughness=values.fraction(extension, "clearcoatRoughnessFactor", 0.0, "clearcoat_roughness"),
        clearcoat_roughness_texture=values.use(
            extension, "clearcoatRoughnessTexture", "clearcoat_roughness_texture", "g"
        ),
        clearcoat_normal_texture=values.use(extension, "clearcoatNormalTexture", "clearcoat_normal_texture"),
        clearcoat_normal_scale=1.0 if normal is None else values.number(normal, "scale", 1.0, "clearcoat_normal_scale"),
    )
    return coated, True


def _diffuse_transmission(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    field = "diffuse_transmission"
    layer = DiffuseTransmission(
        factor=values.fraction(extension, "diffuseTransmissionFactor", 0.0, f"{field}.factor"),
        texture=values.use(extension, "diffuseTransmissionTexture", f"{field}.texture", "a"),
        color=values.color(extension, "diffuseTransmissionColorFactor", WHITE, f"{field}.color"),
        color_texture=values.use(extension, "diffuseTransmissionColorTexture", f"{field}.color_texture"),
    )
    return replace(base, diffuse_transmission=layer), True


def _dispersion(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    return replace(base, dispersion=max(values.number(extension, "dispersion", 0.0, "dispersion"), 0.0)), True


def _emissive_strength(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    strength = max(extension.number("emissiveStrength", 1.0), 0.0)
    values.declare("emissive", "emissiveFactor times KHR_materials_emissive_strength.emissiveStrength")
    return replace(base, emissive=rgb([strength * channel for channel in base.emissive])), True


def _ior(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    """An index of 0 stands for a surface of specular-glossiness, which mirrors everything: it has no field."""
    ior = values.number(extension, "ior", 1.5, "ior")
    return (replace(base, ior=ior), True) if ior >= 1.0 else (base, False)


def _iridescence(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    layer = Iridescence(
        factor=values.fraction(extension, "iridescenceFactor", 0.0, "iridescence.factor"),
        texture=values.use(extension, "iridescenceTexture", "iridescence.texture", "r"),
        ior=max(values.number(extension, "iridescenceIor", 1.3, "iridescence.ior"), 1.0),
        thickness_nm=(
            max(values.number(extension, "iridescenceThicknessMinimum", 100.0, "iridescence.thickness_nm"), 0.0),
            max(values.number(extension, "iridescenceThicknessMaximum", 400.0, "iridescence.thickness_nm"), 0.0),
        ),
        thickness_texture=values.use(extension, "iridescenceThicknessTexture", "iridescence.thickness_texture", "g"),
    )
    return replace(base, iridescence=layer), True


def _sheen(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    layer = Sheen(
        color=values.color(extension, "sheenColorFactor", (0.0, 0.0, 0.0), "sheen.color"),
        color_texture=values.use(extension, "sheenColorTexture", "sheen.color_texture"),
        roughness=values.fraction(extension, "sheenRoughnessFactor", 0.0, "sheen.roughness"),
        roughness_texture=values.use(extension, "sheenRoughnessTexture", "sheen.roughness_texture", "a"),
    )
    return replace(base, sheen=layer), True


def _specular(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    """The colour may exceed 1: the reflection at normal incidence is limited, not the factor."""
    color = extension.vector("specularColorFactor", WHITE)
    values.state(extension, "specularColorFactor", "specular.color")
    layer = Specular(
        weight=values.fraction(extension, "specularFactor", 1.0, "specular.weight"),
        weight_texture=values.use(extension, "specularTexture", "specular.weight_texture", "a"),
        color=rgb([max(channel, 0.0) for channel in color]),
        color_texture=values.use(extension, "specularColorTexture", "specular.color_texture"),
    )
    return replace(base, specular=layer), True


def _transmission(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    clear = replace(
        base,
        transmission=values.fraction(extension, "transmissionFactor", 0.0, "transmission"),
        transmission_texture=values.use(extension, "transmissionTexture", "transmission_texture", "r"),
    )
    return clear, True


def _unlit(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    values.declare("unlit", "KHR_materials_unlit")
    return replace(base, unlit=True), True


def _volume(extension: Json, values: MaterialValues, base: Material) -> tuple[Material, bool]:
    """The thickness is in the frame of the mesh, which nodes may scale: see `with_scaled_volume`."""
    distance = values.number(extension, "attenuationDistance", float("inf"), "volume.attenuation_distance")
    layer = Volume(
        thickness=max(values.number(extension, "thicknessFactor", 0.0, "volume.thickness"), 0.0),
        thickness_texture=values.use(extension, "thicknessTexture", "volume.thickness_texture", "g"),
        attenuation_distance=distance if distance > 0.0 else float("inf"),
        attenuation_color=values.color(extension, "attenuationColor", WHITE, "volume.attenuation_color"),
    )
    return replace(base, volume=layer), True


def with_scaled_volume(material: Material, scales: Sequence[float]) -> Material:
    """The material with the thickness of its volume in metres, where nodes draw it at these scales.

    The attenuation distance is in metres already (KHR_materials_volume). Where nodes scale it differently, one material
    cannot have all thicknesses: it has the median, half sure.
    """
    if material.volume is None or not scales or all(scale == 1.0 for scale in scales):
        return material
    scale = float(np.median(scales))
    field = "volume.thickness"
    stated = material.origins[field]
    same = max(scales) - min(scales) <= _SAME_SCALE * max(scales)
    method = f"{stated.method} times {scale:g}, the {'' if same else 'median '}scale of its nodes"
    origin = Origin(stated.source if same else "inferred", method, stated.confidence)
    volume = replace(material.volume, thickness=material.volume.thickness * scale)
    origins = {**material.origins, field: origin if same else replace(origin, confidence=_MEDIAN_CONFIDENCE)}
    return replace(material, volume=volume, origins=origins)


LAYERS: Final[dict[str, Layer]] = {
    "KHR_materials_anisotropy": _anisotropy,
    "KHR_materials_clearcoat": _clearcoat,
    "KHR_materials_diffuse_transmission": _diffuse_transmission,
    "KHR_materials_dispersion": _dispersion,
    "KHR_materials_emissive_strength": _emissive_strength,
    "KHR_materials_ior": _ior,
    "KHR_materials_iridescence": _iridescence,
    "KHR_materials_sheen": _sheen,
    "KHR_materials_specular": _specular,
    "KHR_materials_transmission": _transmission,
    "KHR_materials_unlit": _unlit,
    "KHR_materials_volume": _volume,
}
