"""Appearance of surface regions: shares of tones, roughness and metalness, from materials and textures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.materials.colour_names import lab_of
from assetkit.materials.surface_samples import Pixels, base_colours, pixels_of, sample_surface, scalars
from schemas.appearance.material import Material
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh, Model

TONES = ("dark", "grey", "white", "earthy", "muted", "vivid")
ROUGHNESSES = ("smooth", "satin", "rough")
METALNESSES = ("dielectric", "half_metallic", "metallic")
_APPEARANCE_SAMPLES = 1000  # per region and mesh: a share is known to 3 percent
_INPUTS = ("base_color_texture", "metallic_texture", "roughness_texture", "opacity_texture")
_SEE_THROUGH_OPACITY = 0.6  # of the opacity, below which light gets through
_DEFAULT_MAX_CHROMA, _DEFAULT_MIN_LIGHTNESS = 3.0, 50.0


@dataclass(frozen=True)
class SurfaceAppearance:
    """Shares of a region's surface, each row (k,) summing to 1, None where nothing is stated.

    tones        of `TONES`: base colours in CIELAB.
    painted      whether the colours come from a picture or vertices, not from one value for all.
    roughness    of `ROUGHNESSES`; metalness  of `METALNESSES`.
    see_through  share through which light gets.
    """

    tones: FloatArray | None = None
    painted: bool = False
    roughness: FloatArray | None = None
    metalness: FloatArray | None = None
    see_through: float = 0.0


class AppearanceSampler:
    """Samples the appearance of regions of one model; its textures are decoded once."""

    def __init__(self, model: Model) -> None:
        self._materials = model.materials
        self._pixels: Pixels = pixels_of(model, _INPUTS)

    def of(self, regions: Sequence[tuple[Mesh, IntArray]]) -> SurfaceAppearance:
        """The appearance of triangles (k,) of each mesh together."""
        rows_of: dict[str, list[tuple[float, FloatArray]]] = {}
        painted = total = 0.0
        for mesh, faces in regions:
            material = None if mesh.material is None else self._materials[mesh.material]
            area, region_shares, drawn = self._shares(mesh, material, faces)
            total += area
            painted += area * drawn
            for key, shares in region_shares.items():
                rows_of.setdefault(key, []).append((area, shares))
        # What is stated on a fifth of the region counts for all of it.
        mixed = {key: _mean(rows) for key, rows in rows_of.items() if sum(a for a, _ in rows) >= 0.2 * total > 0.0}
        clear = sum(area * float(row[0]) for area, row in rows_of.get("see_through", ())) / max(total, 1e-300)
        return SurfaceAppearance(
            mixed.get("tones"), painted > 0.5 * total, mixed.get("roughness"), mixed.get("metalness"), min(clear, 1.0)
        )

    def _shares(self, mesh: Mesh, material: Material | None, faces: IntArray) -> tuple[float, Mapping, bool]:
        points = sample_surface(mesh, _APPEARANCE_SAMPLES, faces)
        if not len(points.faces) or points.area <= 0.0:
            return 0.0, {}, False
        shares: dict[str, FloatArray] = {}
        colours = base_colours(mesh, material, points, self._pixels)
        painted = mesh.colors is not None or (
            material is not None and material.base_color_texture is not None and colours is not None
        )
        if colours is not None and (painted or not _is_default_grey(colours)):
            shares["tones"] = tones_of(colours)
        if material is None:
            return points.area, shares, painted
        metallic = scalars(mesh, material.metallic, material.metallic_texture, points, self._pixels)
        rough = scalars(mesh, material.roughness, material.roughness_texture, points, self._pixels)
        # glTF has 1 and 1 where a file states nothing; other readers have 0 for metallic where nothing is stated.
        if metallic is None and material.metallic > 0.0 and not material.metallic == material.roughness == 1.0:
            metallic = np.full(1, material.metallic)
        if metallic is not None:
            shares["metalness"] = _binned(metallic, (0.25, 0.6))
            rough = np.full(1, material.roughness) if rough is None else rough
        if rough is not None:
            shares["roughness"] = _binned(rough, (0.3, 0.7))
        opacity = scalars(mesh, material.opacity, material.opacity_texture, points, self._pixels)
        opaque = np.full(1, material.opacity * (1.0 - material.transmission)) if opacity is None else opacity
        if material.alpha_mode == "blend" or material.transmission > 0.0:
            shares["see_through"] = np.array([float(np.mean(opaque < _SEE_THROUGH_OPACITY))])
        return points.area, shares, painted


def tones_of(linear_rgb: FloatArray) -> FloatArray:
    """(6,) shares of `TONES` among linear colours (n, 3)."""
    lightness, a, b = lab_of(linear_rgb).T
    chroma, hue = np.hypot(a, b), np.degrees(np.arctan2(b, a)) % 360.0
    # Browns and tans; what is redder and stronger is red.
    earthy = (hue > 35.0) & (hue < 95.0) & (lightness > 12.0) & (chroma > 9.0) & ((hue > 48.0) | (chroma < 40.0))
    tone = np.select(
        [
            (lightness < 28.0) & (chroma < 12.0),
            (chroma < 9.0) & (lightness < 78.0),
            (chroma < 12.0) & (lightness >= 78.0),
            chroma > 62.0,
            earthy,
        ],
        [0, 1, 2, 5, 3],
        4,
    )
    return np.bincount(tone, minlength=len(TONES)) / max(len(tone), 1)


def _is_default_grey(linear_rgb: FloatArray) -> bool:
    """Whether a uniform colour is a light grey, the default that tools give."""
    lightness, a, b = lab_of(linear_rgb[:1])[0]
    return bool(np.hypot(a, b) < _DEFAULT_MAX_CHROMA and lightness > _DEFAULT_MIN_LIGHTNESS)


def _binned(values: FloatArray, edges: tuple[float, float]) -> FloatArray:
    return np.bincount(np.digitize(values, edges), minlength=3) / len(values)


def _mean(rows: Sequence[tuple[float, FloatArray]]) -> FloatArray:
    return np.average([shares for _, shares in rows], axis=0, weights=[area for area, _ in rows])
