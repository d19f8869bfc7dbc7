"""The USD material of each mesh: source materials, with or without vertex colours, under unique prim names."""

from __future__ import annotations

from dataclasses import dataclass, replace

from schemas.appearance.material import Material
from schemas.identifiers import unique_identifiers
from schemas.model import Model

MATERIAL_FALLBACK = "material"
NEUTRAL = Material(name="neutral")


@dataclass(frozen=True)
class MeshMaterial:
    """One USD material: a source material, with its base colour taken from vertex colours or not."""

    prim_name: str
    material: Material
    vertex_colors: bool = False


def materials_per_mesh(model: Model) -> tuple[MeshMaterial, ...]:
    """The material of every mesh, in mesh order; equal ones are the same object.

    A mesh without material gets a neutral grey one, because everything visible must be bound (VM.MAT.001). Vertex
    colours are used where there is no base colour texture: UsdPreviewSurface cannot multiply the two. One source
    material may thus become two USD materials.
    """
    keys = [_key(model, index) for index in range(len(model.meshes))]
    unique = sorted(set(keys), key=lambda key: (len(model.materials) if key[0] is None else key[0], key[1]))
    materials = [_material(model, *key) for key in unique]
    names = unique_identifiers(
        (m.name + ("_vertex_colors" if k[1] else "") for m, k in zip(materials, unique, strict=True)), MATERIAL_FALLBACK
    )
    mesh_materials = {
        key: MeshMaterial(name, material, key[1]) for key, name, material in zip(unique, names, materials, strict=True)
    }
    return tuple(mesh_materials[key] for key in keys)


def material_prim_names(model: Model) -> dict[str, str]:
    """Prim name -> source name of every material that is written, in order of first use."""
    return {mesh_material.prim_name: mesh_material.material.name for mesh_material in materials_per_mesh(model)}


def uv_primvar(uv_set: int) -> str:
    """Name of the primvar that holds a UV set: st, st1, st2 ..."""
    return "st" if uv_set == 0 else f"st{uv_set}"


def _key(model: Model, mesh_index: int) -> tuple[int | None, bool]:
    mesh = model.meshes[mesh_index]
    textured = mesh.material is not None and model.materials[mesh.material].base_color_texture is not None
    return mesh.material, mesh.colors is not None and not textured


def _material(model: Model, index: int | None, vertex_colors: bool) -> Material:
    if index is not None:
        return model.materials[index]
    return replace(NEUTRAL, base_color=(1.0, 1.0, 1.0)) if vertex_colors else NEUTRAL
