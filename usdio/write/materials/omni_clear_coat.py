"""OmniPBR_ClearCoat, the MDL material of Omniverse for surfaces under a clear coat."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from schemas.appearance.material import Material, Texture
from usdio.write.materials.mdl import author_picture, is_plain, placement_of
from usdio.write.materials.mesh_materials import MeshMaterial
from usdio.write.materials.network import Network, Types, set_input
from usdio.write.materials.omni_pbr import author_base, lost_beside, maps_of, shown
from usdio.write.materials.open_pbr import COAT_IOR
from usdio.write.materials.output import ShaderOutput


def _lost(mesh_material: MeshMaterial, images: Mapping[str, Texture]) -> frozenset[str]:
    """What OmniPBR lacks, and maps of the coat's weight and roughness; the coat keeps its normal map."""
    material = mesh_material.material
    coat = {"clearcoat", "clearcoat_roughness", "clearcoat_normal_scale"}
    if _has_normals(material, images):
        coat.add("clearcoat_normal_texture")
    return lost_beside(shown(material, images) | coat, mesh_material)


def _author(network: Network, mesh_material: MeshMaterial) -> None:
    material = mesh_material.material
    shader = network.module("OmniPBR_ClearCoat")
    author_base(network, shader, material)
    set_input(shader, "enable_clearcoat", Types.Bool, True)
    set_input(shader, "clearcoat_weight", Types.Float, material.clearcoat)
    set_input(shader, "clearcoat_reflection_roughness", Types.Float, material.clearcoat_roughness)
    set_input(shader, "clearcoat_ior", Types.Float, COAT_IOR)
    if _has_normals(material, network.files.images):
        author_picture(network, shader, "clearcoat_normalmap_texture", material.clearcoat_normal_texture, "raw")
        set_input(shader, "clearcoat_bump_factor", Types.Float, material.clearcoat_normal_scale)
    network.connect_surface(shader, "out", "mdl")


def _has_normals(material: Material, images: Mapping[str, Texture]) -> bool:
    """Whether the coat's normal map is placed as the other textures are."""
    use = material.clearcoat_normal_texture
    return use is not None and is_plain(use) and placement_of((*maps_of(material, images).uses, use)) is not None


OMNI_CLEAR_COAT: Final = ShaderOutput("OmniPBR_ClearCoat", "mdl", _lost, _author)
