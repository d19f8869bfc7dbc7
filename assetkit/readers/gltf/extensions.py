"""The glTF extensions that a file may require, and the check that it requires no other."""

from __future__ import annotations

from typing import Final

from assetkit.readers.gltf.json import Json
from schemas.diagnostics import InvalidInput, finding

# Material extensions change the appearance only; what has no counterpart is kept in `Material.unmapped`.
_MATERIAL: Final = (
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
)
# Physics extensions never change the appearance; masses, mass centres, tensors and friction are read (`physics`).
_PHYSICS: Final = ("KHR_implicit_shapes", "KHR_physics_rigid_bodies", "OMI_physics_body", "OMI_physics_shape")
SUPPORTED: Final = frozenset(
    (
        *_MATERIAL,
        *_PHYSICS,
        "EXT_mesh_gpu_instancing",
        "EXT_meshopt_compression",
        "EXT_texture_webp",
        "KHR_animation_pointer",
        "KHR_draco_mesh_compression",
        "KHR_lights_punctual",
        "KHR_mesh_quantization",
        "KHR_texture_basisu",
        "KHR_texture_transform",
        "KHR_xmp_json_ld",
    )
)


def check_required(document: Json) -> None:
    """Return if every extension the document requires is read here.

    Raises InvalidInput `asset/unsupported-required-extension` naming the first one that is not (glTF 2.0, 3.12).
    """
    for required in document.items("extensionsRequired"):
        name = required.as_string()
        if name not in SUPPORTED:
            raise InvalidInput(
                finding(
                    "asset/unsupported-required-extension",
                    f"the file requires the extension '{name}'",
                    where=required.where,
                    value=name,
                )
            )
