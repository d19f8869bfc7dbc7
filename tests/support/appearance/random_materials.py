"""Random materials with every layer and texture, for laws of the shaders that are written for them."""

from __future__ import annotations

import io

import numpy as np
from hypothesis import strategies as st
from PIL import Image

from schemas.appearance.material import (
    Anisotropy,
    DiffuseTransmission,
    Iridescence,
    Material,
    Sheen,
    Specular,
    Texture,
    TextureUse,
    Volume,
)


def picture(name: str, mode: str) -> Texture:
    """An 8 x 8 PNG of random values in `mode`."""
    channels = {"L": (), "RGB": (3,), "RGBA": (4,)}[mode]
    pixels = np.random.default_rng(len(name)).integers(0, 256, (8, 8, *channels), dtype=np.uint8)
    data = io.BytesIO()
    Image.fromarray(pixels).save(data, "PNG")
    return Texture(name, data.getvalue(), "png", 8, 8)


IMAGES = {name: picture(name, mode) for name, mode in (("grey", "L"), ("packed", "RGB"), ("clear", "RGBA"))}
unit = st.integers(0, 20).map(lambda steps: steps / 20)
half = st.integers(0, 20).map(lambda steps: steps / 40)
color = st.tuples(unit, unit, unit)


def uses(*channels: str) -> st.SearchStrategy[TextureUse | None]:
    """No texture, or one read in any channel of these, placed and scaled."""
    placed = st.builds(
        TextureUse,
        texture=st.sampled_from(("packed", "clear")),
        channel=st.sampled_from(channels),
        uv_set=st.integers(0, 1),
        wrap_s=st.sampled_from(("repeat", "clamp", "mirror")),
        wrap_t=st.sampled_from(("repeat", "clamp")),
        uv_scale=st.tuples(st.floats(0.5, 4.0, width=32), st.floats(-4.0, -0.5, width=32)),
        uv_rotation_rad=st.floats(-3.0, 3.0, width=32),
        uv_offset=st.tuples(unit, unit),
        scale=half,
        bias=half,
    )
    return st.none() | placed


def materials() -> st.SearchStrategy[Material]:
    """Materials within the ranges of `assetkit.materials.ranges`."""
    rgb, number = uses("rgb"), uses("r", "g", "b", "a")
    normal = st.none() | st.builds(TextureUse, texture=st.just("packed"))
    return st.builds(
        Material,
        name=st.just("m"),
        base_color=color,
        base_color_texture=rgb,
        metallic=unit,
        metallic_texture=number,
        roughness=unit,
        roughness_texture=number,
        normal_texture=normal,
        normal_scale=half,
        emissive=color,
        emissive_texture=rgb,
        opacity=unit,
        opacity_texture=number,
        alpha_mode=st.sampled_from(("opaque", "mask", "blend")),
        alpha_cutoff=unit,
        ior=st.floats(1.0, 3.0, width=32),
        clearcoat=unit,
        clearcoat_texture=number,
        clearcoat_roughness=unit,
        clearcoat_roughness_texture=number,
        clearcoat_normal_texture=normal,
        transmission=unit,
        transmission_texture=number,
        dispersion=half,
        specular=st.none() | st.builds(Specular, unit, number, color, rgb),
        volume=st.none() | st.builds(Volume, half, st.none(), st.just(float("inf")) | st.floats(0.01, 2.0), color),
        sheen=st.none() | st.builds(Sheen, color, rgb, unit, number),
        anisotropy=st.none() | st.builds(Anisotropy, unit, st.floats(-3.0, 3.0, width=32)),
        iridescence=st.none()
        | st.builds(Iridescence, unit, number, st.floats(1.0, 2.0), st.just((100.0, 400.0)), number),
        diffuse_transmission=st.none() | st.builds(DiffuseTransmission, unit, number, color, rgb),
    )
