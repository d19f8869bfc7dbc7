"""Textures no larger than a budget: resampled by Lanczos, colours in linear light, normals back to unit length."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal, NamedTuple

import numpy as np
from PIL import Image

from schemas.appearance.conversions import srgb_to_linear
from schemas.appearance.material import Material, Texture
from schemas.arrays import AnyFloatArray, FloatArray

Meaning = Literal["colour", "normal", "data"]
COLOUR_FIELDS: Final = (
    "base_color_texture",
    "emissive_texture",
    "specular.color_texture",
    "sheen.color_texture",
    "diffuse_transmission.color_texture",
)
_NORMALS: Final = ("normal_texture", "clearcoat_normal_texture")
_JPEG_QUALITY = 95  # Pillow's highest quality that still shrinks files; without chroma subsampling
_LEAST_ALPHA = 1e-6


class Resampled(NamedTuple):
    """A texture that was made smaller, and what it was."""

    old: Texture
    new: Texture
    meaning: Meaning


def within_budget(
    textures: Sequence[Texture], materials: Sequence[Material], most_pixels: int | None
) -> tuple[tuple[Texture, ...], list[Resampled]]:
    """`textures` of at most `most_pixels` a side, their proportions kept, and those that were resampled for it.

    The meaning comes from the uses: a picture that any material reads as a normal map or as data is no colour. Smaller
    textures keep their bytes; without a budget all do.
    """
    if most_pixels is None:
        return tuple(textures), []
    meanings = _meanings(materials)
    changed: list[Resampled] = []
    results: list[Texture] = []
    for texture in textures:
        if max(texture.width, texture.height) > most_pixels:
            meaning = meanings.get(texture.name, "data")
            changed.append(Resampled(texture, resampled(texture, meaning, most_pixels), meaning))
            results.append(changed[-1].new)
        else:
            results.append(texture)
    return tuple(results), changed


def resampled(texture: Texture, meaning: Meaning, most_pixels: int) -> Texture:
    """`texture` with its longer side at `most_pixels`, in its own format (8 bits a channel, 16 for grey PNGs of 16)."""
    factor = most_pixels / max(texture.width, texture.height)
    size = (max(1, round(texture.width * factor)), max(1, round(texture.height * factor)))
    with Image.open(io.BytesIO(texture.data)) as image:
        deep = image.mode.startswith("I")
        plain = image if deep or image.mode in ("L", "LA", "RGB", "RGBA") else image.convert(_plain_mode(image))
        values = np.asarray(plain, dtype=np.float32)
        mode = plain.mode
    channels = values.reshape(*values.shape[:2], -1) / (65535.0 if deep else 255.0)
    small = _smaller(channels, size, meaning, has_alpha=mode in ("LA", "RGBA"))
    if deep:
        picture = Image.fromarray(np.round(small[..., 0] * 65535.0).astype(np.uint16))
    else:
        shown = np.round(small * 255.0).astype(np.uint8)
        picture = Image.fromarray(shown[..., 0] if mode == "L" else shown, mode)
    return replace(texture, data=_encoded(picture, texture.extension), width=size[0], height=size[1])


def _smaller(channels: AnyFloatArray, size: tuple[int, int], meaning: Meaning, *, has_alpha: bool) -> AnyFloatArray:
    """(h, w, c) values 0..1 at the new size (width, height); colours are weighted by their alpha, if any."""
    count = channels.shape[2]
    shown = count - 1 if has_alpha else count
    alpha = channels[..., count - 1] if has_alpha else np.ones(channels.shape[:2], dtype=np.float32)
    small_alpha = np.clip(_lanczos(alpha, size), 0.0, 1.0) if has_alpha else np.ones(size[::-1], dtype=np.float32)
    out: list[AnyFloatArray] = []
    for channel in range(shown):
        values = channels[..., channel]
        if meaning == "colour":
            light = _lanczos(srgb_to_linear(values) * np.maximum(alpha, _LEAST_ALPHA), size)
            values = _linear_to_srgb(light / np.maximum(small_alpha, _LEAST_ALPHA))
        else:
            values = _lanczos(values, size)
        out.append(np.clip(values, 0.0, 1.0))
    if meaning == "normal" and shown == 3:
        out = _unit_normals(out)
    return np.stack([*out, small_alpha] if has_alpha else out, axis=2)


def _lanczos(values: AnyFloatArray, size: tuple[int, int]) -> FloatArray:
    image = Image.fromarray(np.ascontiguousarray(values, dtype=np.float32))
    return np.asarray(image.resize(size, Image.Resampling.LANCZOS), dtype=np.float64)


def _unit_normals(channels: list[AnyFloatArray]) -> list[AnyFloatArray]:
    """The three channels of a normal map with vectors of length 1; where they cancel out, the plain normal."""
    vectors = np.stack(channels, axis=2) * 2.0 - 1.0
    lengths = np.linalg.norm(vectors, axis=2, keepdims=True)
    flat = lengths < _LEAST_ALPHA
    unit = np.where(flat, np.array([0.0, 0.0, 1.0]), vectors / np.where(flat, 1.0, lengths))
    return list(np.moveaxis(unit * 0.5 + 0.5, 2, 0))


def _linear_to_srgb(light: AnyFloatArray) -> FloatArray:
    """IEC 61966-2-1; values outside 0..1 are clamped."""
    v = np.clip(light, 0.0, 1.0)
    return np.where(v <= 0.0031308, v * 12.92, 1.055 * v ** (1 / 2.4) - 0.055)


def _meanings(materials: Sequence[Material]) -> dict[str, Meaning]:
    """The meaning of each texture's colour channels, by name; a use of the alpha channel alone says nothing on it."""
    meanings: dict[str, set[Meaning]] = {}
    for material in materials:
        for field, use in material.texture_uses.items():
            if use.channel == "a":
                continue
            meaning: Meaning = "colour" if field in COLOUR_FIELDS else "normal" if field in _NORMALS else "data"
            meanings.setdefault(use.texture, set()).add(meaning)
    return {name: next(iter(of)) if len(of) == 1 else "data" for name, of in meanings.items()}


def _plain_mode(image: Image.Image) -> str:
    """The mode without a palette: with alpha where the palette has some."""
    if image.mode == "P":
        return "RGBA" if "transparency" in image.info else "RGB"
    return "L" if image.mode in ("1", "F") else "RGBA" if image.mode.endswith(("A", "a")) else "RGB"


def _encoded(picture: Image.Image, extension: str) -> bytes:
    stream = io.BytesIO()
    if extension == "jpg":
        picture.save(stream, "JPEG", quality=_JPEG_QUALITY, subsampling=0)
    else:
        picture.save(stream, "PNG")
    return stream.getvalue()
