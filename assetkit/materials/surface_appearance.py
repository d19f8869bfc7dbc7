"""How a region of the visible surface looks: statistics of what its materials and their textures say there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.materials.colour_names import lab_of
from assetkit.materials.surface_samples import Pixels, base_colours, pixels_of, places_on, scalars
from schemas.model import FloatArray, IntArray, Material, Mesh, Model

TONES = ("dark", "grey", "white", "earthy", "muted", "vivid")
ROUGHNESSES = ("smooth", "satin", "rough")
METALNESSES = ("dielectric", "half_metallic", "metallic")
_MAX_SAMPLES = 1000  # per region and mesh: a share is known to 3 percent
_INPUTS = ("base_color_texture", "metallic_texture", "roughness_texture", "opacity_texture")
_CLEAR = 0.6  # of the opacity, below which light gets through
_SILENT_CHROMA, _SILENT_LIGHTNESS = 3.0, 50.0


@dataclass(frozen=True)
class Look:
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


class Looks:
    """Looks of regions of one model; its textures are decoded once."""

    def __init__(self, model: Model) -> None:
        self._materials = model.materials
        self._pixels: Pixels = pixels_of(model, _INPUTS)

    def of(self, regions: Sequence[tuple[Mesh, IntArray]]) -> Look:
        """The look of triangles (k,) of each mesh together."""
        said: dict[str, list[tuple[float, FloatArray]]] = {}
        painted = total = 0.0
        for mesh, faces in regions:
            material = None if mesh.material is None else self._materials[mesh.material]
            area, found, drawn = self._shares(mesh, material, faces)
            total += area
            painted += area * drawn
            for key, shares in found.items():
                said.setdefault(key, []).append((area, shares))
        # What is stated of a fifth of the region speaks for all of it.
        mixed = {key: _mean(rows) for key, rows in said.items() if sum(a for a, _ in rows) >= 0.2 * total > 0.0}
        clear = sum(area * float(row[0]) for area, row in said.get("see_through", ())) / max(total, 1e-300)
        return Look(
            mixed.get("tones"), painted > 0.5 * total, mixed.get("roughness"), mixed.get("metalness"), min(clear, 1.0)
        )

    def _shares(self, mesh: Mesh, material: Material | None, faces: IntArray) -> tuple[float, Mapping, bool]:
        places = places_on(mesh, _MAX_SAMPLES, faces)
        if not len(places.faces) or places.area <= 0.0:
            return 0.0, {}, False
        found: dict[str, FloatArray] = {}
        colours = base_colours(mesh, material, places, self._pixels)
        painted = mesh.colors is not None or (
            material is not None and material.base_color_texture is not None and colours is not None
        )
        if colours is not None and (painted or not _silent(colours)):
            found["tones"] = tones_of(colours)
        if material is None:
            return places.area, found, painted
        metallic = scalars(mesh, material.metallic, material.metallic_texture, places, self._pixels)
        rough = scalars(mesh, material.roughness, material.roughness_texture, places, self._pixels)
        # glTF has 1 and 1 where a file says nothing; other readers have 0 for metallic where nothing is said.
        if metallic is None and material.metallic > 0.0 and not material.metallic == material.roughness == 1.0:
            metallic = np.full(1, material.metallic)
        if metallic is not None:
            found["metalness"] = _binned(metallic, (0.25, 0.6))
            rough = np.full(1, material.roughness) if rough is None else rough
        if rough is not None:
            found["roughness"] = _binned(rough, (0.3, 0.7))
        opacity = scalars(mesh, material.opacity, material.opacity_texture, places, self._pixels)
        opaque = np.full(1, material.opacity * (1.0 - material.transmission)) if opacity is None else opacity
        if material.alpha_mode == "blend" or material.transmission > 0.0:
            found["see_through"] = np.array([np.mean(opaque < _CLEAR)])
        return places.area, found, painted


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


def _silent(linear_rgb: FloatArray) -> bool:
    """Whether one colour for all is a light grey, as tools give to what nobody painted."""
    lightness, a, b = lab_of(linear_rgb[:1])[0]
    return bool(np.hypot(a, b) < _SILENT_CHROMA and lightness > _SILENT_LIGHTNESS)


def _binned(values: FloatArray, edges: tuple[float, float]) -> FloatArray:
    return np.bincount(np.digitize(values, edges), minlength=3) / len(values)


def _mean(rows: Sequence[tuple[float, FloatArray]]) -> FloatArray:
    return np.average([shares for _, shares in rows], axis=0, weights=[area for area, _ in rows])
