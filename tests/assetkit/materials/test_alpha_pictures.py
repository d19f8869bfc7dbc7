"""Colour and alpha of one picture become two files with the same texels; pictures without a varying alpha stay."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from assetkit.materials.alpha_pictures import with_alpha_apart
from assetkit.materials.normalize import normalize
from schemas.appearance.material import Material, Specular, Texture, TextureUse
from tests.support import package_samples as samples


def _texture(name: str, pixels: np.ndarray) -> Texture:
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return Texture(name, stream.getvalue(), "png", pixels.shape[1], pixels.shape[0])


def _texels(texture: Texture) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(texture.data)))


def _random(channels: int) -> np.ndarray:
    return np.random.default_rng(3).integers(0, 256, (8, 4, channels), dtype=np.uint8)


def test_colour_and_opacity_of_one_picture_are_two_files_with_the_same_texels():
    pixels = _random(4)
    leaf = Material(
        "leaf",
        base_color_texture=TextureUse("leaf", uv_scale=(2.0, 3.0)),
        opacity_texture=TextureUse("leaf", "a", wrap_s="clamp"),
        alpha_mode="mask",
    )
    (split,), textures = with_alpha_apart([leaf], {"leaf": _texture("leaf", pixels)})
    assert split.base_color_texture == TextureUse("leaf_rgb", uv_scale=(2.0, 3.0))
    assert split.opacity_texture == TextureUse("leaf_alpha", "r", wrap_s="clamp")
    assert set(textures) == {"leaf_rgb", "leaf_alpha"}
    assert (_texels(textures["leaf_rgb"]) == pixels[..., :3]).all()
    assert (_texels(textures["leaf_alpha"]) == pixels[..., 3]).all()
    assert all((texture.width, texture.height) == (4, 8) for texture in textures.values())


def test_an_opaque_material_reads_colours_that_no_alpha_hides():
    opaque = Material("o", base_color_texture=TextureUse("t"), emissive_texture=TextureUse("t"), emissive=(1, 1, 1))
    (split,), textures = with_alpha_apart([opaque], {"t": _texture("t", _random(4))})
    assert split.base_color_texture == split.emissive_texture == TextureUse("t_rgb")
    assert set(textures) == {"t_rgb"}


@pytest.mark.parametrize("alpha", [None, 255])
def test_pictures_that_hide_nothing_keep_their_bytes(alpha: int | None):
    pixels = _random(4)
    pixels[..., 3] = alpha or 0
    texture = _texture("t", pixels if alpha else pixels[..., :3])
    plain = Material("m", base_color_texture=TextureUse("t"))
    assert with_alpha_apart([plain], {"t": texture}) == ((plain,), {"t": texture})


def test_uses_as_data_keep_the_picture_and_names_stay_unique():
    packed = Material(
        "m",
        base_color_texture=TextureUse("t"),
        roughness_texture=TextureUse("t", "g"),
        specular=Specular(weight_texture=TextureUse("t", "a"), color_texture=TextureUse("t")),
    )
    textures = {name: _texture(name, _random(4)) for name in ("t", "t_rgb")}
    (split,), after = with_alpha_apart([packed], textures)
    assert split.roughness_texture == TextureUse("t", "g")
    assert split.base_color_texture == TextureUse("t_rgb_2")
    assert split.specular == Specular(weight_texture=TextureUse("t_alpha", "r"), color_texture=TextureUse("t_rgb_2"))
    assert set(after) == {"t", "t_rgb", "t_rgb_2", "t_alpha"}
    assert after["t"] is textures["t"]


def test_colours_under_no_alpha_do_not_bleed_into_smaller_pictures():
    pixels = np.zeros((8, 8, 4), dtype=np.uint8)
    pixels[:, ::2] = (0, 255, 0, 255)  # columns of opaque green between hidden black ones
    leaf = Material("leaf", base_color_texture=TextureUse("t"), opacity_texture=TextureUse("t", "a"), alpha_mode="mask")
    mesh = samples.box_mesh(material=0)
    mesh = replace(mesh, uvs=(samples.uvs(mesh),))
    value = normalize(samples.model([mesh], [leaf], [_texture("t", pixels)]), max_texture=4).value
    assert value is not None
    smaller = {texture.name: _texels(texture) for texture in value.textures}
    assert set(smaller) == {"t_rgb", "t_alpha"}
    assert smaller["t_rgb"].shape == (4, 4, 3)
    assert smaller["t_rgb"][..., 1].min() > 230
    assert 50 < smaller["t_alpha"].mean() < 200
