"""Texture coordinates are there where a material reads them, finite, spread over an area; and how dense texels are."""

from __future__ import annotations

import numpy as np
import pytest

from assetkit.materials.texel_density import texel_density, weighted_percentiles
from assetkit.materials.texture_coordinates import check_coordinates
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.model import Mesh, Model
from tests.support import package_samples as samples

QUAD = np.array([[0, 0, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0]], dtype=float)
FACES = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
WHOLE = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], dtype=np.float32)


def model(*sets: np.ndarray, use: TextureUse | None = TextureUse("t"), size: tuple[int, int] = (512, 512)) -> Model:
    material = Material("m", base_color_texture=use)
    mesh = Mesh("q", QUAD, FACES, uvs=tuple(np.asarray(uvs, dtype=np.float32) for uvs in sets), material=0)
    return samples.model([mesh], [material], [Texture("t", b"", "png", *size)])


def codes(checked: Model) -> list[str]:
    return [note.code.removeprefix("asset/") for note in check_coordinates(checked)]


def test_sound_coordinates_give_no_finding() -> None:
    assert codes(model(WHOLE)) == []
    assert codes(model(use=None)) == []


def test_a_set_that_is_not_there() -> None:
    assert codes(model()) == ["missing-texture-coordinates"]
    assert codes(model(WHOLE, use=TextureUse("t", uv_set=1))) == ["missing-texture-coordinates"]
    assert codes(model(WHOLE, WHOLE, use=TextureUse("t", uv_set=1))) == []


def test_coordinates_in_one_point() -> None:
    assert codes(model(np.full_like(WHOLE, 0.3))) == ["collapsed-texture-coordinates"]
    line = WHOLE * np.array([1.0, 0.0], dtype=np.float32)
    assert codes(model(line)) == []  # a strip of a gradient is a picture


def test_coordinates_that_are_no_numbers() -> None:
    broken = WHOLE.copy()
    broken[0, 1, 1] = np.nan
    assert codes(model(broken)) == ["nonfinite-texture-coordinates"]


def test_coordinates_of_layers_that_show_nothing_are_not_needed() -> None:
    idle = Material("m", clearcoat=0.0, clearcoat_texture=TextureUse("t", uv_set=3))
    mesh = Mesh("q", QUAD, FACES, uvs=(WHOLE,), material=0)
    assert codes(samples.model([mesh], [idle])) == []


def test_texels_per_metre_of_a_square() -> None:
    """512 texels over 0.5 m; twice as many where the picture repeats, by its transform."""
    density = texel_density(model(WHOLE))
    assert density is not None
    assert (density.value, density.source) == (1024.0, "measured")
    repeated = texel_density(model(WHOLE, use=TextureUse("t", uv_scale=(2.0, 2.0), uv_rotation_rad=1.0)))
    assert repeated is not None
    assert repeated.value == 2048.0
    assert texel_density(model(use=None)) is None
    assert texel_density(model()) is None


def test_the_median_is_over_the_area() -> None:
    """One tenth of the area has all of the texels; the median is that of the other nine."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 0.9, 0], [0, 0.9, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    faces = np.array([[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]], dtype=np.int32)
    uvs = np.zeros((4, 3, 2), dtype=np.float32)
    uvs[:2] = WHOLE * 0.1
    uvs[2:] = WHOLE
    mesh = Mesh("q", points, faces, uvs=(uvs,), material=0)
    density = texel_density(samples.model([mesh], [Material("m", base_color_texture=TextureUse("t"))], [PICTURE]))
    assert density is not None
    assert density.value == pytest.approx(np.sqrt(0.01 * 100 * 100 / 0.9), abs=0.1)
    assert density.bounds is not None
    assert density.bounds[1] > 100.0


PICTURE = Texture("t", b"", "png", 100, 100)


def test_weighted_percentiles_are_values_that_occur() -> None:
    ones = np.ones(4)
    assert weighted_percentiles(np.array([4.0, 1.0, 3.0, 2.0]), ones, (0.0, 0.5, 1.0)) == (1.0, 2.0, 4.0)
    heavy = np.array([1.0, 1.0, 1.0, 9.0])  # the last value has nine twelfths of the weight
    assert weighted_percentiles(np.array([4.0, 1.0, 3.0, 2.0]), heavy, (0.5, 0.9)) == (2.0, 3.0)
