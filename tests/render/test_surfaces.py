"""Textures, transparency, normals and light of drawn models."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from geom.mesh.primitives import sphere
from schemas.appearance.material import Material, TextureUse
from schemas.model import Mesh
from tests.support.drawn import BACK, FRONT, QUAD, RED, UNIT_UVS, at, image, linear, model, pictures, textured, upright

PLACES = {"top left": (0.0, -0.5, 1.5), "top right": (0.0, 0.5, 1.5), "bottom left": (0.0, -0.5, 0.5)}


@pytest.mark.parametrize(
    ("use", "channels"),
    [
        (TextureUse("corners"), {"top left": 0, "top right": 1, "bottom left": 2}),
        # Moving the coordinates by half an image puts the right half to the left; clamped, the right edge fills all.
        (TextureUse("corners", uv_offset=(0.5, 0.0)), {"top left": 1, "top right": 0}),
        (TextureUse("corners", uv_offset=(0.5, 0.0), wrap_s="clamp"), {"top left": 1, "top right": 1}),
        (TextureUse("corners", uv_offset=(0.5, 0.0), wrap_s="mirror"), {"top left": 1, "top right": 1}),
        # Scale first, then turn: (u, v) -> (-v, u) samples the image a quarter turn on.
        (TextureUse("corners", uv_rotation_rad=np.pi / 2), {"bottom left": None, "top left": 2, "top right": 0}),
    ],
    ids=["plain", "offset", "clamp", "mirror", "rotated"],
)
def test_textures_lie_where_their_coordinates_say(
    use: TextureUse, channels: dict[str, int | None], tmp_path: Path
) -> None:
    content = textured(use)
    picture = pictures(content, tmp_path)["view_front"]
    for place, channel in channels.items():
        color = at(picture, content, FRONT, PLACES[place])
        if channel is None:  # the yellow quarter
            assert min(color[:2]) > color[2] + 100
        else:
            assert color[channel] > np.delete(color, channel).max() + 100


def test_alpha_modes(tmp_path: Path) -> None:
    alpha = np.zeros((8, 8, 4))
    alpha[..., :3], alpha[:4, :, 3], alpha[4:, :, 3] = 255, 255, 100  # upper half solid, lower half 0.39
    use, hole = TextureUse("alpha"), TextureUse("alpha", channel="a")
    front = Material("front", base_color=(0.05, 0.6, 0.05), base_color_texture=use, opacity_texture=hole, roughness=1.0)
    back = Material("back", base_color=RED, roughness=1.0)
    upper, lower = (0.2, 0.0, 1.5), (0.2, 0.0, 0.5)
    colors = {}
    for mode in ("opaque", "mask", "blend"):
        content = model(
            upright(x=0.2),
            upright(x=-0.2, material=1),
            materials=(dataclasses.replace(front, alpha_mode=mode), back),
            textures=(image("alpha", alpha),),
        )
        picture = pictures(content, tmp_path / mode)["view_front"]
        colors[mode] = at(picture, content, FRONT, upper), at(picture, content, FRONT, lower)
        assert colors[mode][0][1] > colors[mode][0][0] + 60, mode
    assert colors["opaque"][1][1] > colors["opaque"][1][0] + 60
    assert colors["mask"][1][0] > colors["mask"][1][1] + 60
    mixed = 100 / 255 * colors["opaque"][1] + 155 / 255 * colors["mask"][1]
    assert colors["blend"][1] == pytest.approx(mixed, abs=14)


def test_sheets_are_lit_from_both_sides_and_without_normals(tmp_path: Path) -> None:
    content = model(upright(), materials=(Material("red", base_color=RED),))
    turned = model(dataclasses.replace(content.meshes[0], triangles=QUAD[:, ::-1].copy()), materials=content.materials)
    seen, other = pictures(content, tmp_path), pictures(turned, tmp_path)
    middle = (0.0, 0.0, 1.0)
    front, back = at(seen["view_front"], content, FRONT, middle), at(seen["view_back"], content, BACK, middle)
    assert front == pytest.approx(back, abs=6)
    assert front[0] > 150
    assert at(other["view_front"], content, FRONT, middle) == pytest.approx(front, abs=6)


def test_normals_against_the_winding_are_turned(tmp_path: Path) -> None:
    ball = sphere(0.5, 32)
    mesh = Mesh("ball", ball.points, ball.triangles.astype(np.int32), ball.normals.astype(np.float32))
    inward = dataclasses.replace(mesh, normals=-ball.normals.astype(np.float32))
    assert (pictures(model(mesh), tmp_path)["view_left"] == pictures(model(inward), tmp_path)["view_left"]).all()


def test_missing_normals_come_from_the_face(tmp_path: Path) -> None:
    normals = np.zeros((2, 3, 3), dtype=np.float32)
    normals[1] = np.nan
    bare, poor = upright(), dataclasses.replace(upright(), normals=normals)
    red = (Material("red", base_color=RED),)
    first, second = pictures(model(bare, materials=red), tmp_path), pictures(model(poor, materials=red), tmp_path)
    assert all((first[name] == second[name]).all() for name in first)


@pytest.mark.parametrize("stretch", [(1, 1), (-1, 1), (1, 4), (4, 1), (-4, 1)])
def test_normal_maps_shade_like_tilted_normals(stretch: tuple[int, int], tmp_path: Path) -> None:
    uvs, mirrored = UNIT_UVS * np.array(stretch, dtype=np.float32), stretch[0] < 0
    texel = np.array([60, 170, 235])
    bumpy = Material("m", normal_texture=TextureUse("bump"), roughness=1.0)
    textures = (image("bump", np.tile(texel, (4, 4, 1))),)
    mapped = pictures(model(upright(uvs), materials=(bumpy,), textures=textures), tmp_path)
    u, v, out = texel / 255.0 * 2.0 - 1.0
    tilted = np.array([out, -u if mirrored else u, v]) / np.linalg.norm([u, v, out])  # sheet: +y is u, +z is v
    mesh = dataclasses.replace(upright(), normals=np.tile(tilted.astype(np.float32), (2, 3, 1)))
    expected = pictures(model(mesh, materials=(Material("m", roughness=1.0),)), tmp_path)
    flat = pictures(model(upright(), materials=(Material("m", roughness=1.0),)), tmp_path)
    assert max(np.abs(mapped[name] - expected[name]).max() for name in flat) <= 3
    assert max(np.abs(mapped[name] - flat[name]).max() for name in flat) >= 12


def test_scalar_inputs_read_their_channel(tmp_path: Path) -> None:
    packed = (image("orm", np.full((4, 4, 3), (255, 64, 255))),)
    scalar = Material("m", base_color=RED, metallic=1.0, roughness=64 / 255)
    mapped = dataclasses.replace(
        scalar, roughness=1.0, metallic_texture=TextureUse("orm", "b"), roughness_texture=TextureUse("orm", "g")
    )
    first = pictures(model(upright(), materials=(mapped,), textures=packed), tmp_path)["view_top"]
    second = pictures(model(upright(), materials=(scalar,)), tmp_path)["view_top"]
    assert np.abs(first - second).max() <= 2


def test_vertex_colors_and_light_of_its_own(tmp_path: Path) -> None:
    colors = np.tile(np.array([0.0, 0.0, 0.6, 1.0], dtype=np.float32), (2, 3, 1))
    blue = dataclasses.replace(upright(), colors=colors)
    lamp = Material("lamp", base_color=(0.0, 0.0, 0.0), emissive=(0.0, 0.5, 0.0))
    content = model(blue, materials=(Material("white", base_color=(1, 1, 1)),))
    assert np.argmax(at(pictures(content, tmp_path)["view_front"], content, FRONT, (0, 0, 1))) == 2
    content = model(upright(), materials=(lamp,))
    green = linear(at(pictures(content, tmp_path)["view_front"], content, FRONT, (0, 0, 1)))
    assert green[1] - green[0] == pytest.approx(0.5, abs=0.05)
