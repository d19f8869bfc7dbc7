"""Splits pictures that hold a colour and a varying alpha: the colour in one file, the alpha in a grey one.

A file that is read both as sRGB colour and as raw opacity is right by the specification of UsdPreviewSurface. But
importers hold a file once, with one colour space: Blender 5.0 reads the colour as raw where any reader of the file is
raw, and multiplies colours by an alpha that nothing reads. Files of one meaning look alike everywhere.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

from PIL import Image

from assetkit.materials.texture_budget import COLOUR_FIELDS
from assetkit.readers.common.texture_table import picture
from schemas.appearance.material import Material, Texture, TextureUse

Half = Literal["rgb", "alpha"]
OPAQUE = 255  # 8 bits


def with_alpha_apart(
    materials: Sequence[Material], textures: Mapping[str, Texture]
) -> tuple[tuple[Material, ...], dict[str, Texture]]:
    """The materials with uses of the halves of such pictures, and the textures by name with the halves added.

    Halves are PNGs named NAME_rgb and NAME_alpha; no value of a texel changes, and a picture that nothing reads any
    more is left out. A picture without alpha, or with an alpha of 1 everywhere, stays as it is, and so do uses of
    single colour channels as data.
    """
    pictures = dict(textures)
    halves: dict[tuple[str, Half], str | None] = {}

    def half(use: TextureUse, part: Half) -> TextureUse:
        key = (use.texture, part)
        if key not in halves:
            cut = _half(pictures[use.texture], part)
            halves[key] = None if cut is None else _add(cut, pictures)
        name = halves[key]
        return use if name is None else replace(use, texture=name, channel="r" if part == "alpha" else use.channel)

    split: list[Material] = []
    for material in materials:
        for field, use in material.texture_uses.items():
            if use.texture in pictures and (field in COLOUR_FIELDS or use.channel == "a"):
                material = material.with_value(field, half(use, "alpha" if use.channel == "a" else "rgb"))
        split.append(material)
    used = {use.texture for material in split for use in material.texture_uses.values()}
    replaced = {texture for (texture, _), name in halves.items() if name is not None} - used
    return tuple(split), {name: texture for name, texture in pictures.items() if name not in replaced}


def _half(texture: Texture, part: Half) -> Texture | None:
    """One half of the picture as PNG; None where it has no alpha, or the same everywhere that hides nothing."""
    image = picture(texture)
    if not ("A" in image.getbands() or "transparency" in image.info):
        return None
    *colours, alpha = image.convert("RGBA").split()
    if alpha.getextrema() == (OPAQUE, OPAQUE):
        return None
    stream = io.BytesIO()
    (alpha if part == "alpha" else Image.merge("RGB", colours)).save(stream, "PNG")
    return replace(texture, name=f"{texture.name}_{part}", data=stream.getvalue(), extension="png")


def _add(texture: Texture, pictures: dict[str, Texture]) -> str:
    """Put the texture among `pictures` under a free name, which is returned."""
    names = (texture.name, *(f"{texture.name}_{n}" for n in range(2, len(pictures) + 3)))
    name = next(each for each in names if each not in pictures)
    pictures[name] = replace(texture, name=name)
    return name
