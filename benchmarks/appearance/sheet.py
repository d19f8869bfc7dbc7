"""Contact sheets: rows of source, release and their FLIP, by Cycles and by Mana, a column for each view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from benchmarks.appearance.cycles import Picture
from benchmarks.appearance.flip import flip_map
from schemas.arrays import Float32Array

Views = Mapping[str, Picture]
BAND_PX = 14  # one line of PIL's built-in font
SCALE = 2.0  # FLIP 0.5 is drawn white: readable where the targets lie, below 0.1
TILE_PX = 400  # width of one sample on the sheet of all
COLUMNS = 3


def write(target: Path, name: str, by_cycles: tuple[Views, Views], own: tuple[Views, Views]) -> None:
    """Write the sheet of one sample; each pair is the source and the release."""
    rows: list[tuple[str, list[Float32Array]]] = []
    for renderer, (source, release) in (("Cycles", by_cycles), ("Mana", own)):
        rows.append((f"{name}: source, {renderer}", [picture.rgb for picture in source.values()]))
        rows.append((f"released USD, {renderer}", [picture.rgb for picture in release.values()]))
        grey = [_grey(picture, release[view]) for view, picture in source.items()]
        rows.append((f"FLIP x {SCALE:g}, {renderer}", grey))
    strips = [part for text, pictures in rows for part in (_band(text, pictures), np.concatenate(pictures, axis=1))]
    _image(np.concatenate(strips)).save(target)


def tile(target: Path, name: str, source: Views, release: Views, flips: Mapping[str, float]) -> None:
    """Write source, release and FLIP beside each other in the view that differs most, by one renderer."""
    view = max(flips, key=lambda each: flips[each])
    pictures = [source[view].rgb, release[view].rgb, _grey(source[view], release[view])]
    label = f"{name}: {view.removeprefix('view_')}, FLIP {flips[view]:.3f}"
    _image(np.concatenate([_band(label, pictures), np.concatenate(pictures, axis=1)])).save(target)


def overview(tiles: Sequence[Path], target: Path) -> None:
    """All tiles beside and below each other, in order."""
    pictures = [_shrunk(Image.open(each)) for each in tiles]
    if not pictures:
        return
    height = max(picture.height for picture in pictures)
    canvas = Image.new("RGB", (COLUMNS * TILE_PX, -(-len(pictures) // COLUMNS) * height), "white")
    for number, picture in enumerate(pictures):
        canvas.paste(picture, ((number % COLUMNS) * TILE_PX, (number // COLUMNS) * height))
    canvas.save(target)


def _shrunk(picture: Image.Image) -> Image.Image:
    height = round(picture.height * TILE_PX / picture.width)
    return picture.resize((TILE_PX, height), Image.Resampling.LANCZOS)


def _grey(source: Picture, release: Picture) -> Float32Array:
    flip = np.clip(SCALE * flip_map(source.rgb, release.rgb), 0.0, 1.0)
    return np.repeat(flip[..., None], 3, axis=2)


def _band(text: str, pictures: list[Float32Array]) -> Float32Array:
    band = Image.new("RGB", (sum(picture.shape[1] for picture in pictures), BAND_PX), "white")
    ImageDraw.Draw(band).text((4, 1), text, fill="black")
    return np.asarray(band, dtype=np.float32) / 255.0


def _image(rgb: Float32Array) -> Image.Image:
    return Image.fromarray(np.round(255.0 * np.clip(rgb, 0.0, 1.0)).astype(np.uint8))
