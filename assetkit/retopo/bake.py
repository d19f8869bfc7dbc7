"""Maps of a light mesh, baked from the source surface: base colour, occlusion/roughness/metalness, emission, normals.

Normals are in the tangent frame that renderers derive from the texture coordinates (`geom.mesh.tangent_frames`), green
up along v. Only inputs that vary on the surface get a map: a material keeps its factors.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from PIL import Image

from assetkit.retopo.projection import Projector
from assetkit.retopo.surface_values import BAKED_FIELDS, NORMAL_FIELD, Surface, surfaces_of, unit
from assetkit.retopo.texels import AtlasTexels, atlas_texels, dilated
from geom.mesh.corner_normals import corner_normals
from geom.mesh.surface_distance import sample_surface, triangle_areas
from geom.mesh.tangent_frames import into_frame, tangent_frames
from schemas.appearance.conversions import linear_to_srgb
from schemas.appearance.material import WHITE, Channel, Material, Origin, Texture, TextureUse
from schemas.arrays import BoolArray, Float32Array, FloatArray
from schemas.model import Mesh, Model

DILATION_PX = 16  # beyond the charts; four halvings of the picture see no background
ORM: dict[str, Channel] = {"occlusion_texture": "r", "roughness_texture": "g", "metallic_texture": "b"}
TEXTURE_NAMES = {
    "base_color_texture": "retopo_base_color",
    "emissive_texture": "retopo_emissive",
    NORMAL_FIELD: "retopo_normal",
    "orm": "retopo_orm",
}
_PNG_LEVEL = 4  # a fifth larger than level 6 in a third of the time
_TEXELS_AT_A_TIME = 1 << 19  # texels at a time: 200 MB of rays and values
_REACH_SAMPLES = 20_000
_METHOD = "baked from the source surface by rays along the normals of the light mesh"
_SMOOTH_RAD = float(np.pi)


@dataclass(frozen=True)
class Baked:
    """Meshes with their materials and maps; `by_ray` is the share of texels that rays found, `used` that of the atlas
    that charts cover.
    """

    meshes: tuple[Mesh, ...]
    materials: tuple[Material, ...]
    textures: tuple[Texture, ...]
    by_ray: float
    used: float


def bake(model: Model, sources: Sequence[Mesh], light: Sequence[Mesh], size_px: int) -> Baked:
    """The `light` meshes, each with maps of the source mesh at its place, from the textures of `model`.

    The materials are those of `model`, in order, where meshes of `sources` use them with maps of the atlas. A mesh
    without material whose corners have colours gets one.
    """
    texels = atlas_texels(light, size_px)
    area = sum(float(triangle_areas(mesh.points[mesh.triangles]).sum()) for mesh in light)
    count = sum(len(each.rows) for each in texels)
    surfaces = surfaces_of(model, sources, float(np.sqrt(count / area)))
    fields = varying_fields(surfaces)
    canvas = _Canvas(size_px, frozenset(field for of_surface in fields for field in of_surface))
    hit = sum(_paint(canvas, *each) for each in zip(surfaces, light, texels, fields, strict=True))
    meshes, materials = list(light), list(model.materials)
    for k, (surface, varying) in enumerate(zip(surfaces, fields, strict=True)):
        index = meshes[k].material
        if index is not None:
            materials[index] = _with_maps(surface.material, varying)
        elif varying:
            plain = replace(surface.material, name=f"{surface.mesh.name}_colors", base_color=WHITE)
            materials.append(_with_maps(plain, varying))
            meshes[k] = replace(meshes[k], material=len(materials) - 1)
    return Baked(tuple(meshes), tuple(materials), canvas.textures(), hit / max(count, 1), count / size_px**2)


def varying_fields(surfaces: Sequence[Surface]) -> tuple[frozenset[str], ...]:
    """Per surface the inputs that get a map: textures that can be read, vertex colours, and always the relief.

    Those with a material in common have the same ones; a mesh without material and colours has none.
    """
    of_material: dict[int, set[str]] = {}
    fields: list[set[str]] = []
    for surface in surfaces:
        index, coloured = surface.mesh.material, surface.mesh.colors is not None
        mine = set[str]() if index is None else of_material.setdefault(index, set())
        if index is not None or coloured:
            mine |= {*surface.pictures, NORMAL_FIELD} | ({"base_color_texture"} if coloured else set())
        fields.append(mine)
    return tuple(frozenset(mine) for mine in fields)


def _paint(canvas: _Canvas, surface: Surface, light: Mesh, texels: AtlasTexels, fields: frozenset[str]) -> float:
    """Paint the texels of one mesh; the number of those that rays found."""
    projector = Projector(surface.mesh)
    samples, _ = sample_surface(light.points, light.triangles, _REACH_SAMPLES, 0)
    reach = projector.reach_to(np.concatenate([samples, light.points]))
    corners = light.points[light.triangles]
    outward = corner_normals(light.points, light.triangles, _SMOOTH_RAD).astype(np.float64)
    normals = np.zeros((0, 3, 3)) if light.normals is None else light.normals.astype(np.float64)
    frames = tangent_frames(light.points, light.triangles, light.uvs[0])
    hit_count = 0.0
    for start in range(0, len(texels.rows), _TEXELS_AT_A_TIME):
        part = slice(start, start + _TEXELS_AT_A_TIME)
        faces, weights = texels.faces[part], texels.weights[part]
        places, ways, shaded = (np.einsum("kc,kcx->kx", weights, of[faces]) for of in (corners, outward, normals))
        there = projector(places, unit(ways), reach)
        hit_count += float(there.by_ray.sum())
        target = (texels.rows[part], texels.columns[part])
        for field in fields:
            if field in ORM:
                canvas.put(field, target, surface.scalar(field, there.faces, there.weights))
            elif field != NORMAL_FIELD:
                canvas.put(field, target, surface.colour(field, there.faces, there.weights))
            else:
                tilted = surface.shaded_normals(there.faces, there.weights)
                local = into_frame(tilted, unit(shaded), frames.tangents[faces], frames.sides[faces])
                canvas.put(NORMAL_FIELD, target, local)
    return hit_count


class _Canvas:
    """The maps while they are painted, first row at the bottom, and which texels of the atlas a mesh has painted."""

    def __init__(self, size_px: int, fields: frozenset[str]) -> None:
        plain = {"base_color_texture": 3, "emissive_texture": 3, NORMAL_FIELD: 3}
        self._pictures: dict[str, Float32Array] = {
            field: np.zeros((size_px, size_px, count), dtype=np.float32)
            for field, count in plain.items()
            if field in fields
        }
        if fields & ORM.keys():
            self._pictures["orm"] = np.ones((size_px, size_px, 3), dtype=np.float32)
        self._painted: dict[str, BoolArray] = {
            name: np.zeros((size_px, size_px), dtype=bool) for name in self._pictures
        }

    def put(self, field: str, target: tuple[np.ndarray, np.ndarray], values: FloatArray) -> None:
        """Write (k, 3) or (k,) values of an input into the texels at rows and columns (k,)."""
        name = "orm" if field in ORM else field
        channel = list(ORM).index(field) if field in ORM else slice(None)
        self._pictures[name][(*target, channel)] = values
        self._painted[name][target] = True

    def textures(self) -> tuple[Texture, ...]:
        """The maps as PNG, their charts continued beyond their edges."""
        encoded: list[Texture] = []
        for name, picture in self._pictures.items():
            full = dilated(picture, self._painted[name], DILATION_PX)
            if name == NORMAL_FIELD:
                full = unit(full.astype(np.float64)) * 0.5 + 0.5
            elif name != "orm":
                full = linear_to_srgb(full)
            levels = np.round(np.clip(full, 0.0, 1.0)[::-1] * 255.0).astype(np.uint8)
            stream = io.BytesIO()
            Image.fromarray(levels).save(stream, "PNG", compress_level=_PNG_LEVEL)
            encoded.append(Texture(TEXTURE_NAMES[name], stream.getvalue(), "png", levels.shape[1], levels.shape[0]))
        return tuple(encoded)


def _with_maps(material: Material, fields: frozenset[str]) -> Material:
    """The material with maps of the atlas in `fields` and no others; factors stay."""
    origins = dict(material.origins)
    uses: dict[str, TextureUse | None] = {}
    for field in BAKED_FIELDS:
        uses[field] = None
        if field in fields:
            name = TEXTURE_NAMES["orm" if field in ORM else field]
            uses[field] = TextureUse(name, ORM.get(field, "rgb"), wrap_s="clamp", wrap_t="clamp")
            origins[field] = _origin(origins.get(field))
    return replace(material, **uses, normal_scale=1.0, normal_green="up", origins=origins)


def _origin(before: Origin | None) -> Origin:
    """The origin of a baked map: as sure as that of the values it was baked from, measured where that is the shape."""
    if before is None:
        return Origin("measured", _METHOD)
    return Origin("inferred", f"{before.method}; {_METHOD}", before.confidence)
