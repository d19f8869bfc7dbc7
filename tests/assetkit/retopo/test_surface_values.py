"""Values of a surface are those of its pictures at its coordinates: channel, wrap, filter, factor and tilt."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from assetkit.retopo.surface_values import bilinear, decoded, shading_normals, surfaces_of
from schemas.appearance.conversions import srgb_to_linear
from schemas.appearance.material import Material, TextureUse
from schemas.model import Mesh, Model
from tests.assetkit.retopo.things import model_of, picture

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
FACE = np.zeros(1, dtype=np.int64)


def triangle(material: Material, *levels: np.ndarray, colors: np.ndarray | None = None) -> Model:
    """A triangle in the plane whose coordinates are its x and y."""
    mesh = Mesh("m", CORNERS, np.array([[0, 1, 2]], dtype=np.int32), uvs=(CORNERS[None, :, :2].astype(np.float32),))
    textures = tuple(picture(f"t{k}", each) for k, each in enumerate(levels))
    return model_of(replace(mesh, material=0, colors=colors), materials=(material,), textures=textures)


def at(u: float, v: float) -> np.ndarray:
    return np.array([[1.0 - u - v, u, v]])


def test_v_points_up_and_colours_are_linear() -> None:
    """The lower left texel of a picture is at small u and small v."""
    levels = np.zeros((2, 2, 3), dtype=np.uint8)
    levels[1, 0] = (188, 0, 0)  # last row of the file: the bottom
    (surface,) = surfaces_of(
        model := triangle(Material("m", base_color_texture=TextureUse("t0", wrap_s="clamp", wrap_t="clamp")), levels),
        model.meshes,
    )
    low, high = (surface.colour("base_color_texture", FACE, at(0.2, v))[0, 0] for v in (0.1, 0.79))
    assert (low, high) == (pytest.approx(float(srgb_to_linear(np.array(188 / 255.0)))), pytest.approx(0.0))


def test_one_channel_is_scaled_and_other_channels_do_not_matter() -> None:
    levels = np.full((4, 4, 3), 255, dtype=np.uint8)
    levels[..., 1] = 102
    use = TextureUse("t0", "g", scale=0.5, bias=0.25)
    model = triangle(Material("m", roughness_texture=use), levels)
    (surface,) = surfaces_of(model, model.meshes)
    assert surface.scalar("roughness_texture", FACE, at(0.3, 0.3))[0] == pytest.approx(0.4 * 0.5 + 0.25, abs=1e-6)
    assert surface.scalar("metallic_texture", FACE, at(0.3, 0.3))[0] == 1.0


def test_vertex_colours_multiply_the_picture_and_the_factor_does_not() -> None:
    levels = np.full((2, 2, 3), 255, dtype=np.uint8)
    colors = np.array([[[1.0, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]]], dtype=np.float32)
    model = triangle(Material("m", (0.1, 0.1, 0.1), TextureUse("t0")), levels, colors=colors)
    (surface,) = surfaces_of(model, model.meshes)
    np.testing.assert_allclose(surface.colour("base_color_texture", FACE, at(0.3, 0.2)), [[0.5, 0.3, 0.2]], atol=1e-6)


@pytest.mark.parametrize(("wrap", "expected"), [("repeat", 0.25), ("clamp", 0.875), ("mirror", 0.75)])
def test_wrap_modes_beyond_the_picture(wrap: Literal["repeat", "clamp", "mirror"], expected: float) -> None:
    ramp = np.repeat(((np.arange(4) + 0.5) / 4).astype(np.float32)[None, :, None], 4, axis=2).repeat(4, axis=0)
    use = TextureUse("t", wrap_s=wrap, wrap_t=wrap)
    value = bilinear(ramp, np.array([[1.25, 0.5]]), use)[0, 0]
    assert value == pytest.approx(expected, abs=1e-6)


def test_filtering_is_linear_between_the_middles_of_texels() -> None:
    ramp = np.repeat(np.arange(8, dtype=np.float32)[None, :, None], 4, axis=2).repeat(8, axis=0)
    places = np.random.default_rng(0).uniform(0.1, 0.9, size=(50, 2))
    np.testing.assert_allclose(bilinear(ramp, places, TextureUse("t"))[:, 0], places[:, 0] * 8 - 0.5, atol=1e-9)


def test_a_reduced_picture_holds_means_of_linear_light() -> None:
    levels = np.zeros((4, 4, 3), dtype=np.uint8)
    levels[::2] = 255
    reduced = decoded(picture("t", levels).data, srgb=True, factor=2)
    assert reduced is not None
    np.testing.assert_allclose(reduced[..., 0], 0.5, atol=1e-6)
    assert decoded(b"no picture", srgb=True) is None


def test_a_normal_map_tilts_along_u_and_v() -> None:
    """Red above the middle leans toward growing u, green toward growing v."""
    for channel, axis in ((0, 0), (1, 1)):
        levels = np.full((2, 2, 3), (128, 128, 255), dtype=np.uint8)
        levels[..., channel] = 200
        model = triangle(Material("m", normal_texture=TextureUse("t0")), levels)
        (surface,) = surfaces_of(model, model.meshes)
        normal = surface.shaded_normals(FACE, at(0.3, 0.3))[0]
        assert normal[axis] > 0.4
        assert abs(normal[1 - axis]) < 0.02


def test_normals_against_the_winding_are_turned_and_missing_ones_are_those_of_the_face() -> None:
    mesh = Mesh("m", CORNERS, np.array([[0, 1, 2]], dtype=np.int32))
    given = np.array([[[0, 0, -1], [0, 0, 1], [0, 0, 0]]], dtype=np.float32)
    np.testing.assert_allclose(shading_normals(replace(mesh, normals=given)), [[[0, 0, 1]] * 3])
