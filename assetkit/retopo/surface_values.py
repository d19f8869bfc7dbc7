"""Values of a surface at places on its triangles: base colour, occlusion, roughness, metalness, emission, normal.

Colours are linear light; textures are multiplied by vertex colours but not by the factors of the material, which a
baked material keeps. Textures are read with bilinear filtering, those of much finer grain than wanted reduced before.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image

from assetkit.materials.surface_samples import wrapped_index
from geom.mesh.corner_normals import corner_normals, face_vectors
from geom.mesh.surface_distance import triangle_areas
from geom.mesh.tangent_frames import TangentFrames, out_of_frame, tangent_frames
from render.surfaces import placed_uvs
from schemas.appearance.conversions import srgb_to_linear
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.arrays import AnyFloatArray, Float32Array, FloatArray, IntArray
from schemas.model import Mesh, Model

COLOUR_FIELDS = ("base_color_texture", "emissive_texture")
SCALAR_FIELDS = ("occlusion_texture", "roughness_texture", "metallic_texture")
NORMAL_FIELD = "normal_texture"
BAKED_FIELDS = (*COLOUR_FIELDS, *SCALAR_FIELDS, NORMAL_FIELD)
_CHANNELS = {"r": 0, "g": 1, "b": 2, "a": 3, "rgb": 0}
_TINY = 1e-12
_SRGB_LEVELS = srgb_to_linear(np.arange(256) / 255.0).astype(np.float32)


@dataclass(frozen=True)
class Surface:
    """A mesh with its material, ready to be evaluated.

    normals   (m, 3, 3) unit corner normals on the side of the winding.
    frames    tangent frames by set of texture coordinates and transform, for the normal map alone.
    pictures  texels (h, w, 4) float32 by field of the material, first row at the bottom, colours as linear light.
    """

    mesh: Mesh
    material: Material
    normals: FloatArray
    frames: TangentFrames | None
    pictures: dict[str, Float32Array]

    def colour(self, field: str, faces: IntArray, weights: FloatArray) -> FloatArray:
        """(k, 3) linear colours of a texture, white without one; of the base with the vertex colours."""
        texels = self._texels(field, faces, weights)
        use = self.material.texture_uses.get(field)
        colours = np.ones((len(faces), 3)) if texels is None or use is None else _placed(texels[:, :3], use)
        if field == "base_color_texture" and self.mesh.colors is not None:
            colours = colours * np.einsum("kc,kcx->kx", weights, self.mesh.colors[faces, :, :3].astype(np.float64))
        return colours

    def scalar(self, field: str, faces: IntArray, weights: FloatArray) -> FloatArray:
        """(k,) values of one channel of a texture, 1 without one."""
        texels = self._texels(field, faces, weights)
        use = self.material.texture_uses.get(field)
        if texels is None or use is None:
            return np.ones(len(faces))
        return _placed(texels[:, _CHANNELS[use.channel]], use)

    def shaded_normals(self, faces: IntArray, weights: FloatArray) -> FloatArray:
        """(k, 3) unit normals as they are shaded: interpolated between corners, tilted by the normal map."""
        smooth = unit(np.einsum("kc,kcx->kx", weights, self.normals[faces]))
        texels = self._texels(NORMAL_FIELD, faces, weights)
        if texels is None or self.frames is None:
            return smooth
        tilt = texels[:, :3].astype(np.float64) * 2.0 - 1.0
        tilt[:, :2] *= self.material.normal_scale
        return unit(out_of_frame(tilt, smooth, self.frames.tangents[faces], self.frames.sides[faces]))

    def _texels(self, field: str, faces: IntArray, weights: FloatArray) -> FloatArray | None:
        picture, use = self.pictures.get(field), self.material.texture_uses.get(field)
        if picture is None or use is None:
            return None
        uvs = np.einsum("kc,kcx->kx", weights, self.mesh.uvs[use.uv_set][faces].astype(np.float64))
        return bilinear(picture, placed_uvs(uvs, use).astype(np.float64), use)


def surfaces_of(model: Model, meshes: Sequence[Mesh], texels_per_length: float | None = None) -> tuple[Surface, ...]:
    """The surfaces of some meshes of `model`; textures of at least twice `texels_per_length` are reduced to it."""
    textures = {texture.name: texture for texture in model.textures}
    cache: dict[tuple[str, bool, int], Float32Array | None] = {}
    return tuple(_surface(mesh, model, textures, texels_per_length, cache) for mesh in meshes)


def _surface(
    mesh: Mesh,
    model: Model,
    textures: dict[str, Texture],
    texels_per_length: float | None,
    cache: dict[tuple[str, bool, int], Float32Array | None],
) -> Surface:
    material = Material(mesh.name, (1.0, 1.0, 1.0)) if mesh.material is None else model.materials[mesh.material]
    pictures: dict[str, Float32Array] = {}
    for field, use in material.texture_uses.items():
        if field not in BAKED_FIELDS or use.texture not in textures or use.uv_set >= len(mesh.uvs):
            continue
        texture = textures[use.texture]
        key = (use.texture, field in COLOUR_FIELDS, _reduction(mesh, use, texture, texels_per_length))
        if key not in cache:
            cache[key] = decoded(texture.data, srgb=key[1], factor=key[2])
        picture = cache[key]
        if picture is not None:
            pictures[field] = picture
    frames, bumps = None, material.normal_texture
    if NORMAL_FIELD in pictures and bumps is not None:
        frames = tangent_frames(mesh.points, mesh.triangles, placed_uvs(mesh.uvs[bumps.uv_set], bumps))
    return Surface(mesh, material, shading_normals(mesh), frames, pictures)


def shading_normals(mesh: Mesh) -> FloatArray:
    """(m, 3, 3) unit corner normals on the side of the winding, as the renderer takes them; smooth where it has none.

    Corners without a valid normal take that of their face.
    """
    if mesh.normals is None:
        return corner_normals(mesh.points, mesh.triangles).astype(np.float64)
    face = face_vectors(mesh.points, mesh.triangles)
    normals = mesh.normals.astype(np.float64)
    usable = np.isfinite(normals).all(axis=2, keepdims=True) & normals.any(axis=2, keepdims=True)
    outward = np.where(np.einsum("mcx,mx->mc", normals, face)[..., None] < 0.0, -normals, normals)
    return unit(np.where(usable, outward, face[:, None]))


def unit(vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3) at unit length; zero stays zero."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), _TINY**2)


def decoded(data: bytes, *, srgb: bool, factor: int = 1) -> Float32Array | None:
    """(h, w, 4) float32 texels in 0..1, first row at the bottom, reduced by a whole factor; None if undecodable.

    With `srgb` colours are decoded to linear light, before they are averaged.
    """
    try:
        with Image.open(io.BytesIO(data)) as image:
            if image.mode.startswith("I"):  # 16 bit; Pillow's own conversion clips at 255.
                image = Image.fromarray((np.asarray(image, dtype=np.int64) >> 8).clip(0, 255).astype(np.uint8))
            levels = np.asarray(image.convert("RGBA"))[::-1]
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return None  # Readers have reported damaged images.
    texels = levels.astype(np.float32) / np.float32(255.0)
    if srgb:
        texels[..., :3] = _SRGB_LEVELS[levels[..., :3]]
    return _reduced(texels, factor)


def _reduced(texels: Float32Array, factor: int) -> Float32Array:
    """Means of squares of `factor` texels; rows and columns beyond the last whole square are left out."""
    height, width = (size // factor * factor for size in texels.shape[:2])
    if factor == 1 or not height or not width:
        return texels
    squares = texels[:height, :width].reshape(height // factor, factor, width // factor, factor, 4)
    return squares.mean(axis=(1, 3), dtype=np.float32)


def _reduction(mesh: Mesh, use: TextureUse, texture: Texture, texels_per_length: float | None) -> int:
    """The whole factor by which a texture is finer than `texels_per_length`, by the areas of the whole mesh."""
    if texels_per_length is None:
        return 1
    flat = placed_uvs(mesh.uvs[use.uv_set], use).astype(np.float64)
    first, second = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    covered = 0.5 * float(np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum())
    area = float(triangle_areas(mesh.points[mesh.triangles]).sum())
    density = np.sqrt(covered * texture.width * texture.height / max(area, _TINY**2))
    return max(1, int(density / texels_per_length))


def bilinear(picture: Float32Array, uvs: FloatArray, use: TextureUse) -> FloatArray:
    """(k, 4) texels at coordinates (k, 2), mixed of the four around each; what `black` leaves dark is clamped."""
    height, width = picture.shape[:2]
    x, y = uvs[:, 0] * width - 0.5, uvs[:, 1] * height - 0.5
    column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    right, up = (x - column)[:, None], (y - row)[:, None]
    columns = [wrapped_index(column + step, width, use.wrap_s) for step in (0, 1)]
    rows = [wrapped_index(row + step, height, use.wrap_t) for step in (0, 1)]
    lower = picture[rows[0], columns[0]] * (1.0 - right) + picture[rows[0], columns[1]] * right
    upper = picture[rows[1], columns[0]] * (1.0 - right) + picture[rows[1], columns[1]] * right
    return lower * (1.0 - up) + upper * up


def _placed(texels: AnyFloatArray, use: TextureUse) -> FloatArray:
    return np.clip(texels.astype(np.float64) * use.scale + use.bias, 0.0, 1.0)
