"""Sample points on a mesh, and the values of its material there: base colour, metallic, roughness and opacity."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from render.surfaces import placed_uvs
from render.textures import decode_rgba
from schemas.appearance.conversions import srgb_to_linear
from schemas.appearance.material import Material, TextureUse
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh, Model

_CHANNELS = {"r": 0, "g": 1, "b": 2, "a": 3, "rgb": 0}
_MIN_SAMPLES = 200  # places, so that a picture on two triangles is seen too
_PLACEHOLDER = Material(name="")
Pixels = Mapping[str, IntArray]  # texture -> (height, width, 4) uint8, first row at the bottom


class SurfacePoints(NamedTuple):
    """Points on a mesh (n,), spread evenly by area: their triangles, (n, 3) barycentric weights, whole area (m2)."""

    faces: IntArray
    weights: FloatArray
    area: float


def pixels_of(model: Model, inputs: Iterable[str] = ("base_color_texture",)) -> Pixels:
    """The images that materials of `model` use for `inputs`; those that do not decode are left out."""
    uses = (getattr(material, name) for material in model.materials for name in inputs)
    used = {use.texture for use in uses if use is not None}
    decoded = ((t.name, decode_rgba(t.data)) for t in model.textures if t.name in used)
    return {name: image for name, image in decoded if image is not None}


def sample_surface(mesh: Mesh, most: int, of: IntArray | None = None) -> SurfacePoints:
    """At most `most` points on the triangles `of` the mesh, on all by default; deterministic."""
    of = np.arange(len(mesh.triangles)) if of is None else of
    a, b, c = (mesh.points[mesh.triangles[of, i]] for i in range(3))
    ends = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)
    count = min(most, max(4 * len(of), _MIN_SAMPLES)) if len(of) else 0
    drawn = np.searchsorted(ends, (np.arange(count) + 0.5) / max(count, 1) * ends[-1:]).clip(0, max(len(of) - 1, 0))
    return SurfacePoints(of[drawn], _barycentric(count), float(ends[-1]) if len(ends) else 0.0)


def base_colours(mesh: Mesh, material: Material | None, samples: SurfacePoints, pixels: Pixels) -> FloatArray | None:
    """(n, 3) linear base colours; None where nothing states one."""
    use = _usable(mesh, material.base_color_texture if material else None, pixels)
    stated = material is not None and (use is not None or material.base_color != _PLACEHOLDER.base_color)
    if mesh.colors is None and not stated:
        return None
    count = len(samples.faces)
    colours = np.tile(np.array(material.base_color) if material is not None and stated else np.ones(3), (count, 1))
    if mesh.colors is not None:
        colours = colours * np.einsum("nk,nkc->nc", samples.weights, mesh.colors[samples.faces, :, :3])
    if use is not None:
        texels = srgb_to_linear(_texels(mesh, samples, pixels[use.texture], use)[:, :3])
        colours = colours * (texels * use.scale + use.bias)
    return colours


def scalars(
    mesh: Mesh, factor: float, use: TextureUse | None, samples: SurfacePoints, pixels: Pixels
) -> FloatArray | None:
    """(n,) a factor times its texture; None without a texture that can be read."""
    use = _usable(mesh, use, pixels)
    if use is None:
        return None
    texels = _texels(mesh, samples, pixels[use.texture], use)[:, _CHANNELS[use.channel]]
    return np.clip(factor * (texels * use.scale + use.bias), 0.0, 1.0)


def _usable(mesh: Mesh, use: TextureUse | None, pixels: Pixels) -> TextureUse | None:
    return use if use is not None and use.texture in pixels and use.uv_set < len(mesh.uvs) else None


def _barycentric(count: int) -> FloatArray:
    """(n, 3) weights of evenly spread places in a triangle: the R2 sequence, folded; no random numbers."""
    u, v = ((np.arange(count) * step) % 1.0 for step in (0.7548776662466927, 0.5698402909980532))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    return np.stack([1.0 - u - v, u, v], axis=1)


def _texels(mesh: Mesh, samples: SurfacePoints, pixels: IntArray, use: TextureUse) -> FloatArray:
    """(n, 4) values of the nearest texels, 0..1, as the image holds them."""
    height, width = pixels.shape[:2]
    uvs = np.einsum("nk,nkc->nc", samples.weights, mesh.uvs[use.uv_set][samples.faces])
    u, v = placed_uvs(uvs, use).T
    column = wrapped_index(np.floor(u * width).astype(int), width, use.wrap_s)
    row = wrapped_index(np.floor(v * height).astype(int), height, use.wrap_t)
    return pixels[row, column] / 255.0


def wrapped_index(index: IntArray, size: int, wrap: str) -> IntArray:
    """Texel indices within the image; what `black` would leave dark is clamped: it is hardly the object's colour."""
    if wrap == "repeat":
        return index % size
    if wrap == "mirror":
        return np.minimum(index % (2 * size), 2 * size - 1 - index % (2 * size))
    return index.clip(0, size - 1)
