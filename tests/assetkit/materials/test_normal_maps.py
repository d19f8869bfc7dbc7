"""Which way green points is found from pictures of known heights, never from pictures that are none."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from assetkit.materials.normal_maps import green_direction, with_green_up
from assetkit.materials.normalize import normalize
from schemas.appearance.material import Material, NormalGreen, Origin, Texture, TextureUse
from tests.support import package_samples as samples
from tests.support.appearance.normal_maps import bumps, normal_map


def texture(pixels: np.ndarray, name: str = "bumps") -> Texture:
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return Texture(name, stream.getvalue(), "png", pixels.shape[1], pixels.shape[0])


def material(green: NormalGreen) -> Material:
    origins = {"normal_texture": Origin("declared", "norm")}
    return Material("m", normal_texture=TextureUse("bumps"), normal_green=green, origins=origins)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000), st.sampled_from((1.0, -1.0)), st.sampled_from((64, 96, 200)))
def test_bumps_of_known_green(seed: int, green: float, side: int) -> None:
    way = green_direction(texture(normal_map(bumps(side, seed), green)))
    assert way.green == ("up" if green > 0 else "down")
    assert way.correlation * green > 0.3


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000), st.booleans())
def test_mirrored_pictures_keep_their_way(seed: int, rows: bool) -> None:
    """Heights turned over are heights again; the picture alone turned over is not the map of any."""
    heights = bumps(96, seed)
    turned = heights[::-1] if rows else heights[:, ::-1]
    assert green_direction(texture(normal_map(turned))).green == "up"
    assert green_direction(texture(normal_map(heights)[::-1])).green == "down"


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_pictures_that_are_no_heights_are_unknown(seed: int) -> None:
    rng = np.random.default_rng(seed)
    noise = np.clip(rng.normal([128, 128, 240], [20, 20, 5], (128, 128, 3)), 0, 255).astype(np.uint8)
    assert green_direction(texture(noise)).green == "unknown"


@pytest.mark.parametrize("pixels", [np.full((64, 64, 3), (128, 128, 255), np.uint8), np.zeros((2, 2, 3), np.uint8)])
def test_even_and_tiny_pictures_are_unknown(pixels: np.ndarray) -> None:
    assert green_direction(texture(pixels)).green == "unknown"


def test_lines_in_one_direction_are_unknown() -> None:
    """Heights that depend on u alone have no slope along v, whichever way green points."""
    ridges = np.tile(np.sin(np.arange(128) / 3.0), (128, 1))
    assert green_direction(texture(normal_map(ridges))).green == "unknown"


def test_a_map_of_undeclared_way_is_turned_and_the_rest_left() -> None:
    down, up = texture(normal_map(bumps(64), -1.0)), texture(normal_map(bumps(64)))
    pictures = {"bumps": down}
    turned, ways = with_green_up(material("undeclared"), pictures, {})
    assert turned.normal_texture == TextureUse("bumps_green_up")
    assert ways["normal_texture"].green == "down"
    pixels = np.asarray(Image.open(io.BytesIO(pictures["bumps_green_up"].data)))
    assert np.abs(pixels.astype(int) - normal_map(bumps(64)).astype(int)).max() <= 1
    assert turned.origins["normal_texture"].source == "inferred"
    for unturned, picture in ((material("up"), down), (material("undeclared"), up)):
        assert with_green_up(unturned, {"bumps": picture}, {})[0].normal_texture == TextureUse("bumps")


@pytest.mark.parametrize(("green", "repairs"), [("undeclared", ["turn_normal_map"]), ("up", [])])
def test_the_appearance_stage_reports_it(green: NormalGreen, repairs: list[str]) -> None:
    mesh = samples.box_mesh(material=0)
    mesh = replace(mesh, uvs=(samples.uvs(mesh),))
    outcome = normalize(samples.model([mesh], [material(green)], [texture(normal_map(bumps(64), -1.0))]))
    assert "asset/normal-map-green-down" in {diagnostic.code for diagnostic in outcome.diagnostics}
    assert [repair.name for repair in outcome.repairs] == repairs
