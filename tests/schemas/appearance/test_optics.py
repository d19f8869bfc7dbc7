"""The optics of a material, and which of its layers change a picture."""

from __future__ import annotations

import math

from hypothesis import given, settings

from schemas.appearance.material import (
    Anisotropy,
    Iridescence,
    Material,
    Sheen,
    Specular,
    TextureUse,
    Volume,
)
from schemas.appearance.optics import (
    effective,
    inner_color,
    is_thin_walled,
    optics_of,
    stated_values,
    unlike_plain,
)
from tests.support.appearance.random_materials import materials

GLASS = Material("glass", base_color=(0.5, 1.0, 0.5), transmission=1.0)


def test_optics_are_those_of_the_layer_that_light_meets() -> None:
    assert optics_of(Material("m")) == "opaque"
    assert optics_of(Material("m", alpha_mode="blend", opacity=0.1)) == "opaque"
    assert optics_of(Material("m", clearcoat=0.2)) == "coated"
    assert optics_of(Material("m", clearcoat=0.2, transmission=0.3)) == "transmissive"
    assert optics_of(Material("m", metallic=1.0, transmission=1.0)) == "opaque"
    patterned = Material("m", metallic=1.0, metallic_texture=TextureUse("t", "b"), transmission=1.0)
    assert optics_of(patterned) == "transmissive"


def test_layers_of_no_weight_are_none() -> None:
    idle = Material(
        "m",
        sheen=Sheen((0.0, 0.0, 0.0), roughness=0.3),
        anisotropy=Anisotropy(0.0, 1.0),
        iridescence=Iridescence(0.0),
        specular=Specular(),
        volume=Volume(0.1),
        dispersion=0.5,
        clearcoat_roughness=0.4,
        clearcoat_normal_texture=TextureUse("t"),
        normal_scale=0.3,
        alpha_cutoff=0.9,
        opacity=0.4,
    )
    assert effective(idle) == Material("m")
    assert unlike_plain(effective(idle)) == frozenset()


def test_layers_with_weight_stay() -> None:
    busy = Material("m", sheen=Sheen((0.1, 0.0, 0.0)), specular=Specular(weight=0.4), transmission=0.5, dispersion=0.2)
    assert effective(busy) == busy
    assert unlike_plain(busy) == {"sheen.color", "specular.weight", "transmission", "dispersion"}


@settings(max_examples=25, deadline=None)
@given(materials())
def test_what_changes_no_picture_is_taken_away_once(material: Material) -> None:
    once = effective(material)
    assert effective(once) == once
    assert optics_of(once) == optics_of(material)


def test_light_is_tinted_by_the_volume_or_by_the_surface() -> None:
    assert inner_color(GLASS) == ((0.5, 1.0, 0.5), 0.0)
    assert is_thin_walled(GLASS)
    body = Material("m", transmission=1.0, volume=Volume(0.01, None, 0.2, (1.0, 0.2, 0.2)))
    assert inner_color(body) == ((1.0, 0.2, 0.2), 0.2)
    assert not is_thin_walled(body)
    pane = Material("m", transmission=1.0, volume=Volume(0.0, None, 0.2, (1.0, 0.2, 0.2)))
    assert inner_color(pane) == ((0.8, 0.8, 0.8), 0.0)
    assert is_thin_walled(pane)
    clear = Material("m", transmission=1.0, volume=Volume(0.01, None, math.inf, (1.0, 0.2, 0.2)))
    assert inner_color(clear) == ((0.8, 0.8, 0.8), 0.0)


def test_values_are_listed_with_those_of_layers_and_without_absent_ones() -> None:
    values = stated_values(Material("m", sheen=Sheen((0.1, 0.2, 0.3)), volume=Volume(0.01)))
    assert values["sheen.color"] == (0.1, 0.2, 0.3)
    assert values["sheen.roughness"] == 0.0
    assert values["volume.thickness"] == 0.01
    assert "volume.attenuation_distance" not in values
    assert "iridescence" not in values
    assert "base_color_texture" not in values
    assert "name" not in values
