"""Which way green of a normal map points, from the picture alone, and maps of the other way turned to OpenGL's.

A normal map that was made from heights h(u, v) has slopes p = dh/du and q = dh/dv, whose cross derivatives are equal:
dq/du = dp/dv. Where green points down along v (DirectX's way) q has the other sign, and so has the correlation of both
derivatives. Source: integrability of gradient fields (Frankot and Chellappa 1988).
"""

from __future__ import annotations

import io
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from PIL import Image
from scipy.ndimage import uniform_filter

from assetkit.readers.common.texture_table import picture
from schemas.appearance.material import Material, Origin, Texture
from schemas.arrays import FloatArray

Green = Literal["up", "down", "unknown"]
FIELDS = ("normal_texture", "clearcoat_normal_texture")
_MOST_SIDE = 1024  # pixels; larger pictures are reduced by a whole factor
_LEAST_Z = 0.2  # steeper texels (78 degrees) have no usable slope
_LEAST_CURVATURE = 1e-3  # slope change per pixel, root mean square: below it 8-bit rounding rules (1/255 over 3 x 3)
# What counts: a correlation in the whole picture, and blocks whose mean lies this many standard errors from zero.
# White noise stays below 0.02; of seven maps of dev assets with curvature, all made with green up, five are found to be
# up, none down, and all five to be down when they are turned (0.17 to 0.76).
_LEAST_CORRELATION = 0.1
_LEAST_ERRORS = 5.0
_LEAST_BLOCKS = 8
_SPLITS = 8
_CLIP = 4.0  # root mean squares; seams between charts are jumps


@dataclass(frozen=True)
class GreenDirection:
    """The way of green, and the correlation in -1..1 that decides it (0: no curvature)."""

    green: Green
    correlation: float


def green_direction(texture: Texture) -> GreenDirection:
    """The way that green points in a normal map; `unknown` for pictures without enough curvature or of both signs."""
    slope_u, slope_v = _slopes(_pixels(texture))
    if min(slope_u.shape) < 4:
        return GreenDirection("unknown", 0.0)
    across = np.gradient(slope_v, axis=1)
    along = -np.gradient(slope_u, axis=0)  # rows run against v
    whole = _correlation(across, along)
    blocks = np.array([_correlation(a, b) for a, b in zip(_blocks(across), _blocks(along), strict=True)])
    blocks = blocks[blocks != 0.0]
    if len(blocks) < _LEAST_BLOCKS or abs(whole) < _LEAST_CORRELATION:
        return GreenDirection("unknown", whole)
    error = float(blocks.std(ddof=1)) / np.sqrt(len(blocks))
    if blocks.mean() * np.sign(whole) < _LEAST_ERRORS * error:
        return GreenDirection("unknown", whole)
    return GreenDirection("up" if whole > 0.0 else "down", whole)


def _blocks(field: FloatArray) -> list[FloatArray]:
    """The picture in _SPLITS rows and columns of blocks."""
    return [block for rows in np.array_split(field, _SPLITS) for block in np.array_split(rows, _SPLITS, axis=1)]


def with_green_up(
    material: Material, textures: dict[str, Texture], directions: dict[str, GreenDirection]
) -> tuple[Material, dict[str, GreenDirection]]:
    """The material with its maps of green down turned where the source leaves the way open, and the way of each map.

    `textures` holds the model's pictures by name and receives turned ones as NAME_green_up; `directions` holds the way
    of each picture that was examined. Where the source defines green as up its maps are left as they are: a bad
    correlation may then be the picture's.
    """
    ways: dict[str, GreenDirection] = {}
    for field in FIELDS:
        use = material.texture_uses.get(field)
        if use is None or use.texture not in textures:
            continue
        if use.texture not in directions:
            directions[use.texture] = green_direction(textures[use.texture])
        way = ways[field] = directions[use.texture]
        if material.normal_green != "undeclared":
            continue
        method = material.origins[field].method if field in material.origins else "normal map"
        if way.green == "down":
            turned = replace(_turned(textures[use.texture]), name=f"{use.texture}_green_up")
            textures[turned.name] = turned
            material = material.with_value(field, replace(use, texture=turned.name))
        guess = {"up": "found to be up", "down": "found to be down and turned", "unknown": "taken to be up"}[way.green]
        origin = Origin("inferred", f"{method}; green {guess}", round(abs(way.correlation), 2))
        material = replace(material, origins={**material.origins, field: origin})
    return material, ways


def _pixels(texture: Texture) -> FloatArray:
    """Texels (h, w, 3) in 0..1, large pictures reduced by a whole factor."""
    image = picture(texture).convert("RGB")
    factor = -(-max(image.size) // _MOST_SIDE)
    if factor > 1 and min(image.size) >= factor:
        image = image.reduce(factor)
    return np.asarray(image, dtype=np.float64) / 255.0


def _slopes(pixels: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Slopes along u and v (h, w) of the smoothed picture; 0 where the surface is too steep."""
    normals = uniform_filter(pixels, size=(3, 3, 1)) * 2.0 - 1.0
    z = normals[..., 2]
    steep = z < _LEAST_Z
    slopes = np.where(steep[..., None], 0.0, -normals[..., :2] / np.where(steep, 1.0, z)[..., None])
    return slopes[..., 0], slopes[..., 1]


def _correlation(first: FloatArray, second: FloatArray) -> float:
    """Correlation of both fields about zero, jumps clipped; 0 where either has too little curvature."""
    clipped: list[FloatArray] = []
    for field in (first, second):
        size = float(np.sqrt(np.mean(field**2)))
        if size < _LEAST_CURVATURE:
            return 0.0
        clipped.append(np.clip(field, -_CLIP * size, _CLIP * size))
    a, b = clipped
    return float((a * b).sum() / np.sqrt((a**2).sum() * (b**2).sum()))


def _turned(texture: Texture) -> Texture:
    """The picture with green inverted, as PNG."""
    image = picture(texture)
    bands = list(image.convert("RGBA" if "A" in image.getbands() else "RGB").split())
    bands[1] = bands[1].point([255 - level for level in range(256)])
    stream = io.BytesIO()
    Image.merge("RGBA" if len(bands) == 4 else "RGB", bands).save(stream, "PNG")
    return replace(texture, data=stream.getvalue(), extension="png")
