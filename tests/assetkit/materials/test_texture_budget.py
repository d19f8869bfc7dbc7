"""Textures within a budget: what they mean survives the smaller size."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from PIL import Image

from assetkit.materials.texture_budget import resampled, within_budget
from schemas.appearance.material import Material, Sheen, Texture, TextureUse


def texture(pixels: Any, extension: Any = "png", name: str = "t") -> Texture:
    image = Image.fromarray(np.asarray(pixels))
    stream = io.BytesIO()
    image.save(stream, {"png": "PNG", "jpg": "JPEG"}[extension])
    return Texture(name, stream.getvalue(), extension, *image.size)


def values(result: Texture) -> np.ndarray:
    with Image.open(io.BytesIO(result.data)) as image:
        assert image.size == (result.width, result.height)
        return np.asarray(image).astype(float)


def checkers(dark: int, light: int, size: int = 32) -> np.ndarray:
    board = np.indices((size, size)).sum(axis=0) % 2 == 0
    return np.repeat(np.where(board, light, dark).astype(np.uint8)[..., None], 3, axis=2)


def test_colours_keep_their_light_and_data_its_numbers() -> None:
    """Half of black and half of white is 188 as light (IEC 61966-2-1) and 127 or 128 as a number."""
    board = texture(checkers(0, 255))
    assert values(resampled(board, "colour", 8))[2:-2, 2:-2] == pytest.approx(188, abs=1.5)
    assert values(resampled(board, "data", 8))[2:-2, 2:-2] == pytest.approx(127.5, abs=1.5)


def test_an_even_colour_stays_what_it_is() -> None:
    for level in (20, 100, 200):
        even = texture(np.full((32, 32, 3), level, dtype=np.uint8))
        assert values(resampled(even, "colour", 8)) == pytest.approx(level, abs=1)


def test_normals_stay_of_length_one() -> None:
    rng = np.random.default_rng(0)
    vectors = rng.normal(size=(32, 32, 3)) * (0.6, 0.6, 0.1) + (0.0, 0.0, 0.7)
    unit = vectors / np.linalg.norm(vectors, axis=2, keepdims=True)
    bumps = texture(np.round((unit + 1.0) * 127.5).astype(np.uint8))
    lengths = np.linalg.norm(values(resampled(bumps, "normal", 8)) / 127.5 - 1.0, axis=2)
    assert lengths == pytest.approx(1.0, abs=0.02)
    assert np.linalg.norm(values(resampled(bumps, "data", 8)) / 127.5 - 1.0, axis=2).min() < 0.9  # so it is the step


def test_what_cannot_be_seen_does_not_colour_what_can() -> None:
    """Red on the left, opaque; green on the right, transparent: the border must not turn brown."""
    pixels = np.zeros((16, 16, 4), dtype=np.uint8)
    pixels[:, :7] = (255, 0, 0, 255)
    pixels[:, 7:] = (0, 255, 0, 0)
    small = values(resampled(texture(pixels), "colour", 4))
    seen = small[..., 3] > 8
    assert small[seen][:, 1].max() < 40
    assert small[..., 0][seen].min() > 230


@pytest.mark.parametrize("extension", ["png", "jpg"])
def test_proportions_and_format_are_kept(extension: str) -> None:
    result = resampled(texture(checkers(50, 60)[:8], extension), "colour", 16)
    assert (result.width, result.height, result.extension) == (16, 4, extension)
    with Image.open(io.BytesIO(result.data)) as image:
        assert image.format == {"png": "PNG", "jpg": "JPEG"}[extension]


def test_sixteen_bits_and_palettes_and_grey() -> None:
    deep = np.linspace(0, 65535, 32 * 32).reshape(32, 32).astype(np.uint16)
    assert values(resampled(texture(deep), "data", 8)).max() > 60000
    grey = resampled(texture(checkers(0, 255)[..., 0]), "data", 8)
    assert values(grey).ndim == 2
    stream = io.BytesIO()
    Image.fromarray(checkers(10, 200)).quantize(4).save(stream, "PNG")
    flat = resampled(Texture("p", stream.getvalue(), "png", 32, 32), "data", 8)
    assert values(flat).shape == (8, 8, 3)


def test_only_what_exceeds_the_budget_changes_and_its_meaning_is_that_of_its_uses() -> None:
    big, small = texture(checkers(0, 255), name="big"), texture(checkers(0, 255, 8), name="small")
    use = TextureUse("big")
    cases: dict[str, Material] = {
        "colour": Material("m", base_color_texture=use),
        "normal": Material("m", normal_texture=use),
        "data": Material("m", base_color_texture=use, roughness_texture=TextureUse("big", "g")),
    }
    for meaning, material in cases.items():
        kept, changed = within_budget((big, small), (material,), 16)
        assert kept[1] is small
        assert [(change.old.name, change.meaning) for change in changed] == [("big", meaning)]
    fabric = Material("m", sheen=Sheen((1, 1, 1), use), opacity_texture=TextureUse("big", "a"))
    assert within_budget((big,), (fabric,), 16)[1][0].meaning == "colour"
    assert within_budget((big, small), (), None) == ((big, small), [])
