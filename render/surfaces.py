"""Converts the visible surfaces of a model into VTK actors, one per material and set of vertex attributes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from render.camera import AnnotationFrame
from render.polydata import triangle_soup
from render.shader import (
    CLEARED,
    TextureSlot,
    fragment_replacements,
    sampler_name,
    texture_uses,
    vertex_replacements,
)
from render.textures import TextureSet
from schemas.appearance.material import Material, TextureUse
from schemas.arrays import AnyFloatArray, Float32Array
from schemas.model import Mesh, Model

_NEUTRAL = Material(name="neutral", base_color=(0.62, 0.62, 0.62), roughness=0.6)
FAINT = (0.55, 0.55, 0.55)  # a body of which something else is to be seen
_COLOR = "manaColor"


@dataclass(frozen=True)
class ShadedSurface:
    """Triangles that share a material and the same vertex attributes.

    points, normals  (m, 3, 3) float32 per corner, annotation frame.
    attributes       (m, 3, k) float32 per corner: colours and transformed texture coordinates.
    """

    material: Material
    slots: tuple[TextureSlot, ...]
    points: Float32Array
    normals: AnyFloatArray
    attributes: dict[str, Float32Array]


def surfaces(model: Model, frame: AnnotationFrame) -> tuple[ShadedSurface, ...]:
    """The surfaces of `model`; meshes without material are neutral grey, non-finite triangles are left out."""
    textures = frozenset(texture.name for texture in model.textures)
    parts: dict[tuple[int, tuple[str, ...]], list[ShadedSurface]] = {}
    for mesh in model.meshes:
        surface = _surface(mesh, model, frame, textures)
        key = (-1 if mesh.material is None else mesh.material, (*surface.attributes, *(s.input for s in surface.slots)))
        parts.setdefault(key, []).append(surface)
    return tuple(_merged(group) for group in parts.values())


def actor(surface: ShadedSurface, textures: TextureSet) -> vtkActor:
    """`surface` shaded with its material, visible from both sides."""
    material = surface.material
    mapper = vtkPolyDataMapper()
    mapper.SetInputDataObject(triangle_soup(surface.points, surface.normals, surface.attributes))
    mapper.ScalarVisibilityOff()
    result = vtkActor()
    result.SetMapper(mapper)
    slots = _bind(result, surface.slots, textures)
    components = {name: values.shape[2] for name, values in surface.attributes.items()}
    for name in components:
        mapper.MapDataArrayToVertexAttribute(name, name, vtkDataObject.FIELD_ASSOCIATION_POINTS, -1)
    shader = result.GetShaderProperty()
    for old, new in vertex_replacements(components):
        shader.AddVertexShaderReplacement(old, True, new, True)
    for old, new in fragment_replacements(material, slots, components):
        shader.AddFragmentShaderReplacement(old, old.startswith("//VTK"), new, True)
    shader.GetFragmentCustomUniforms().SetUniform3f("manaEmissive", material.emissive)
    set_material(result, material, slots)
    return result


def plain_actor(parts: tuple[ShadedSurface, ...], color: tuple[float, float, float]) -> vtkActor:
    """All `parts` as one matte opaque body of a linear RGB `color`."""
    points = np.concatenate([part.points for part in parts])
    normals = np.concatenate([part.normals for part in parts])
    material = Material(name="plain", base_color=color, roughness=0.9)
    result = actor(ShadedSurface(material, (), points, normals, {}), TextureSet(()))
    # Collision shapes often touch the surface: pushed back, it does not flicker through them.
    result.GetMapper().SetRelativeCoincidentTopologyPolygonOffsetParameters(2.0, 8.0)
    return result


def set_material(target: vtkActor, material: Material, slots: tuple[TextureSlot, ...] = ()) -> None:
    """Give an actor the plain values of a material; its pictures, emission and alpha mode stay."""
    surface = target.GetProperty()
    surface.SetInterpolationToPBR()
    surface.SetColor(*material.base_color)
    surface.SetMetallic(material.metallic)
    surface.SetRoughness(max(material.roughness, 0.05))  # A perfect mirror would show the studio, not the object.
    surface.SetBaseIOR(min(max(material.ior, 1.0), 2.3))
    surface.SetCoatStrength(material.clearcoat)
    surface.SetCoatRoughness(max(material.clearcoat_roughness, 0.05))
    opacity = material.opacity if material.alpha_mode != "opaque" else 1.0
    textured = any(slot.input == "transmission" for slot in slots)  # Then the shader clears texel by texel.
    surface.SetOpacity(opacity if textured else opacity * (1.0 - CLEARED * material.transmission))
    if material.alpha_mode == "blend" or material.transmission > 0.0:
        target.ForceTranslucentOn()
    else:
        target.ForceOpaqueOn()


def _bind(target: vtkActor, slots: tuple[TextureSlot, ...], textures: TextureSet) -> tuple[TextureSlot, ...]:
    """Bind the textures of `slots`; the slots whose image exists and decodes."""
    bound = []
    for slot in slots:
        repeat = "repeat" in (slot.use.wrap_s, slot.use.wrap_t)
        texture = textures.get(slot.use.texture, srgb=slot.input in ("base_color", "emissive"), repeat=repeat)
        if texture is not None:
            target.GetProperty().SetTexture(sampler_name(slot), texture)
            bound.append(slot)
    return tuple(bound)


def _surface(mesh: Mesh, model: Model, frame: AnnotationFrame, textures: frozenset[str]) -> ShadedSurface:
    material = _NEUTRAL if mesh.material is None else model.materials[mesh.material]
    points = frame.from_asset(mesh.points)[mesh.triangles].astype(np.float32)
    keep = np.isfinite(points).all(axis=(1, 2))
    attributes: dict[str, Float32Array] = {}
    if mesh.colors is not None:
        attributes[_COLOR] = np.nan_to_num(mesh.colors[keep])
    slots = []
    mappings: dict[tuple[object, ...], str] = {}
    for name, use in texture_uses(material):
        if use.texture not in textures or use.uv_set >= len(mesh.uvs):
            continue
        mapping = (use.uv_set, use.uv_scale, use.uv_rotation_rad, use.uv_offset)
        attribute = mappings.setdefault(mapping, f"manaUV{len(mappings)}")
        if attribute not in attributes:
            attributes[attribute] = placed_uvs(mesh.uvs[use.uv_set][keep], use)
        slots.append(TextureSlot(name, use, attribute))
    return ShadedSurface(material, tuple(slots), points[keep], _normals(mesh, points)[keep], attributes)


def _normals(mesh: Mesh, points: Float32Array) -> AnyFloatArray:
    """(m, 3, 3) corner normals on the side from which each triangle is wound counter-clockwise.

    Corners without a valid normal (zero or not finite) take that of their face.
    """
    if mesh.normals is None:
        from geom.mesh.corner_normals import corner_normals  # Loads scipy; most assets bring normals.

        return corner_normals(mesh.points, mesh.triangles)
    face = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    side = np.einsum("mck,mk->mc", mesh.normals, face)[..., None]
    usable = np.isfinite(mesh.normals).all(axis=2, keepdims=True) & mesh.normals.any(axis=2, keepdims=True)
    return np.where(usable, np.where(side < 0.0, -mesh.normals, mesh.normals), face[:, None])


def placed_uvs(uvs: Float32Array, use: TextureUse) -> Float32Array:
    """Texture coordinates after the transform of `use`: scale, then rotate counter-clockwise, then translate."""
    scaled = uvs * np.asarray(use.uv_scale, dtype=np.float32)
    cosine, sine = np.cos(use.uv_rotation_rad), np.sin(use.uv_rotation_rad)
    rotated = np.stack(
        [scaled[..., 0] * cosine - scaled[..., 1] * sine, scaled[..., 0] * sine + scaled[..., 1] * cosine], axis=-1
    )
    return np.nan_to_num(rotated + np.asarray(use.uv_offset)).astype(np.float32)


def _merged(parts: list[ShadedSurface]) -> ShadedSurface:
    if len(parts) == 1:
        return parts[0]
    attributes = {n: np.concatenate([part.attributes[n] for part in parts]) for n in parts[0].attributes}
    points = np.concatenate([part.points for part in parts])
    normals = np.concatenate([part.normals for part in parts])
    return ShadedSurface(parts[0].material, parts[0].slots, points, normals, attributes)
