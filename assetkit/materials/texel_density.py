"""Texel density: how many texels of its base-colour picture lie along a metre of the surface."""

from __future__ import annotations

import numpy as np

from schemas.appearance.material import Texture, TextureUse
from schemas.arrays import FloatArray
from schemas.evidence import Evidence, measured
from schemas.model import Mesh, Model

METHOD = "square root of texels over area, per triangle; median over the textured area"


def texel_density(model: Model) -> Evidence[float] | None:
    """Texels per metre of the surfaces with a base-colour texture, the median over their area; None without any.

    The points of `model` are in metres. The bounds are the 5th and 95th percentile, again over the area.
    """
    textures = {texture.name: texture for texture in model.textures}
    densities: list[FloatArray] = []
    areas: list[FloatArray] = []
    for mesh in model.meshes:
        use = None if mesh.material is None else model.materials[mesh.material].base_color_texture
        if use is not None and use.texture in textures and use.uv_set < len(mesh.uvs) and len(mesh.triangles):
            area = _areas(mesh)
            texels = _texels(mesh, use, textures[use.texture])
            usable = (area > 0.0) & np.isfinite(texels)
            densities.append(np.sqrt(texels[usable] / area[usable]))
            areas.append(area[usable])
    if not densities or not sum(len(each) for each in densities):
        return None
    low, middle, high = weighted_percentiles(np.concatenate(densities), np.concatenate(areas), (0.05, 0.5, 0.95))
    return measured(round(middle, 1), METHOD, bounds=(round(low, 1), round(high, 1)))


def weighted_percentiles(values: FloatArray, weights: FloatArray, shares: tuple[float, ...]) -> tuple[float, ...]:
    """The smallest of `values` (n,) below or at which each share of the `weights` (n,) lies."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order]) / weights.sum()
    at = np.searchsorted(reached, shares).clip(0, len(values) - 1)
    return tuple(float(values[order][index]) for index in at)


def _areas(mesh: Mesh) -> FloatArray:
    a, b, c = (mesh.points[mesh.triangles[:, corner]] for corner in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0


def _texels(mesh: Mesh, use: TextureUse, texture: Texture) -> FloatArray:
    """(m,) texels below each triangle, repeats counted; rotation and offset change no area."""
    uvs = mesh.uvs[use.uv_set].astype(np.float64) * np.asarray(use.uv_scale)
    u, v = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    return np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2.0 * texture.width * texture.height
