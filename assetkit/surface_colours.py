"""Which colours an object shows: base colours over its visible surface, by area."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from assetkit.colour_names import basic_terms
from assetkit.readers.corners import srgb_to_linear
from render.surfaces import placed_uvs
from render.textures import decode_rgba
from schemas.model import FloatArray, IntArray, Material, Mesh, Model, TextureUse

MIN_SHARE = 0.05  # Colours of less of the surface are labels and seams.
_MAX_SAMPLES = 4000  # per mesh, faces drawn evenly by area; a share is then known to about a percent.
_PLACEHOLDER = Material(name="")


def surface_colours(model: Model) -> dict[str, float]:
    """Basic colour terms with their share of the surface that has a stated colour, the largest first.

    {} when nothing states a colour: no material, or only one with our own grey. Lighting, emission and metal are left
    out of account: it is the colour that the material states.
    """
    decoded = {t.name: decode_rgba(t.data) for t in model.textures if t.name in _base_textures(model)}
    pixels = {name: image for name, image in decoded.items() if image is not None}
    area_of: dict[str, float] = defaultdict(float)
    for mesh in model.meshes:
        material = None if mesh.material is None else model.materials[mesh.material]
        faces, area = _samples(mesh)
        colours = _colours(mesh, material, faces, pixels)
        if colours is None:
            continue
        terms, counts = np.unique(basic_terms(colours), return_counts=True)
        for term, count in zip(terms, counts, strict=True):
            area_of[str(term)] += area * float(count) / len(faces)
    total = sum(area_of.values())
    shares = {term: round(area / total, 3) for term, area in area_of.items() if area >= MIN_SHARE * total > 0.0}
    return dict(sorted(shares.items(), key=lambda pair: (-pair[1], pair[0])))


def _samples(mesh: Mesh) -> tuple[IntArray, float]:
    """Indices of faces, each as often as its area deserves, and the whole area."""
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    ends = np.cumsum(areas)
    count = min(_MAX_SAMPLES, 4 * len(areas))
    return np.searchsorted(ends, (np.arange(count) + 0.5) / count * ends[-1]).clip(0, len(areas) - 1), float(ends[-1])


def _colours(mesh: Mesh, material: Material | None, faces: IntArray, pixels: dict[str, IntArray]) -> FloatArray | None:
    """(n, 3) linear base colours at places inside the sampled faces; None where nothing states one."""
    use = material.base_color_texture if material else None
    if use is not None and not (use.texture in pixels and use.uv_set < len(mesh.uvs)):
        use = None
    stated = material is not None and (use is not None or material.base_color != _PLACEHOLDER.base_color)
    if mesh.colors is None and not stated:
        return None
    weights = _barycentric(len(faces))
    colours = np.tile(np.array(material.base_color) if material is not None and stated else np.ones(3), (len(faces), 1))
    if mesh.colors is not None:
        colours = colours * np.einsum("nk,nkc->nc", weights, mesh.colors[faces, :, :3])
    if use is not None:
        uvs = np.einsum("nk,nkc->nc", weights, mesh.uvs[use.uv_set][faces])
        colours = colours * _texels(pixels[use.texture], use, uvs)
    return colours


def _barycentric(count: int) -> FloatArray:
    """(n, 3) weights of evenly spread places in a triangle: the R2 sequence, folded; no random numbers."""
    u, v = ((np.arange(count) * step) % 1.0 for step in (0.7548776662466927, 0.5698402909980532))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    return np.stack([1.0 - u - v, u, v], axis=1)


def _base_textures(model: Model) -> set[str]:
    return {m.base_color_texture.texture for m in model.materials if m.base_color_texture}


def _texels(pixels: IntArray, use: TextureUse, uvs: FloatArray) -> FloatArray:
    """(n, 3) linear colours of the nearest texels; `pixels` (height, width, 4) uint8, first row at the bottom."""
    height, width = pixels.shape[:2]
    u, v = placed_uvs(uvs, use).T
    column = _wrapped(np.floor(u * width).astype(int), width, use.wrap_s)
    row = _wrapped(np.floor(v * height).astype(int), height, use.wrap_t)
    return srgb_to_linear(pixels[row, column, :3] / 255.0) * use.scale + use.bias


def _wrapped(index: IntArray, size: int, wrap: str) -> IntArray:
    """Texel indices within the image; what `black` would leave dark is clamped: it is hardly the object's colour."""
    if wrap == "repeat":
        return index % size
    if wrap == "mirror":
        return np.minimum(index % (2 * size), 2 * size - 1 - index % (2 * size))
    return index.clip(0, size - 1)
