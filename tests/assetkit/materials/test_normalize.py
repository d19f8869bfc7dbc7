"""Materials as released: ranges of all layers, lengths in metres, values with evidence, what shaders do not show."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from assetkit.materials.normalize import in_metres, normalize
from assetkit.materials.ranges import RANGES, limited
from schemas.appearance.material import (
    Anisotropy,
    DiffuseTransmission,
    Iridescence,
    Material,
    Origin,
    Sheen,
    Specular,
    Texture,
    TextureUse,
    Volume,
)
from schemas.appearance.optics import stated_values
from schemas.appearance.record import AppearanceSection
from schemas.evidence import declared
from tests.support import package_samples as samples

NAN, INF = math.nan, math.inf
GREY = Texture("t", samples.png(), "png", 4, 4)


def result(material: Material, **options: Any) -> Any:
    mesh = samples.box_mesh(material=0)
    mesh = replace(mesh, uvs=(samples.uvs(mesh),))
    return normalize(samples.model([mesh], [material], [GREY]), **options)


def released(material: Material, **options: Any) -> Material:
    value = result(material, **options).value
    return value.materials[0]


@pytest.mark.parametrize(
    ("broken", "field", "wanted"),
    [
        ({"roughness": 1.5}, "roughness", 1.0),
        ({"base_color": (-1.0, 0.5, NAN)}, "base_color", (0.0, 0.5, 0.0)),
        ({"emissive": (7.0, -1.0, 0.0)}, "emissive", (7.0, 0.0, 0.0)),
        ({"ior": 0.3}, "ior", 1.5),
        ({"normal_scale": NAN}, "normal_scale", 1.0),
        ({"sheen": Sheen((2.0, 0.1, 0.1), roughness=-1.0)}, "sheen.color", (1.0, 0.1, 0.1)),
        ({"sheen": Sheen((0.1, 0.1, 0.1), roughness=-1.0)}, "sheen.roughness", 0.0),
        ({"specular": Specular(weight=3.0, color=(2.0, 1.0, -1.0))}, "specular.color", (2.0, 1.0, 0.0)),
        ({"volume": Volume(-1.0, None, -2.0, (0.5, 1.5, 0.5))}, "volume.attenuation_distance", INF),
        ({"anisotropy": Anisotropy(9.0)}, "anisotropy.strength", 1.0),
        ({"iridescence": Iridescence(1.0, ior=0.1, thickness_nm=(-5.0, 400.0))}, "iridescence.thickness_nm", (0, 400)),
        ({"diffuse_transmission": DiffuseTransmission(2.0)}, "diffuse_transmission.factor", 1.0),
    ],
)
def test_values_out_of_range_are_limited_and_reported(broken: dict[str, Any], field: str, wanted: Any) -> None:
    outcome = result(Material("m", **broken))
    assert outcome.value is not None
    layer, _, name = field.rpartition(".")
    material = outcome.value.materials[0]
    assert getattr(getattr(material, layer) if layer else material, name) == wanted
    (repair,) = [r for r in outcome.repairs if r.name == "invalid_material_value"]
    assert field in repair.before
    assert any(d.code == "asset/invalid-material-value" and field in d.headline for d in outcome.diagnostics)


def test_every_number_of_a_material_has_a_range() -> None:
    whole = Material(
        "m",
        specular=Specular(),
        volume=Volume(attenuation_distance=1.0),
        sheen=Sheen((0.0, 0.0, 0.0)),
        anisotropy=Anisotropy(0.1),
        iridescence=Iridescence(0.1),
        diffuse_transmission=DiffuseTransmission(0.1),
    )
    numbers = {n for n, v in stated_values(whole).items() if isinstance(v, float | tuple) and not isinstance(v, bool)}
    assert numbers == set(RANGES)
    assert limited(whole) == (whole, [])


def test_uses_of_textures_that_are_not_there_are_dropped_in_layers_too() -> None:
    gone, there = TextureUse("gone"), TextureUse("t")
    material = Material("m", base_color_texture=there, sheen=Sheen((1, 1, 1), gone, roughness_texture=there))
    clean = released(material)
    assert clean.base_color_texture == there
    assert clean.sheen == Sheen((1, 1, 1), None, roughness_texture=there)


def test_lengths_of_a_volume_become_metres_and_say_so() -> None:
    unit = declared(0.01, "the file")
    volume = Volume(2.0, None, 5.0, (0.5, 0.5, 0.5))
    origins = {"volume.thickness": Origin("declared", "KHR_materials_volume.thicknessFactor")}
    glass = Material("m", transmission=1.0, volume=volume, origins=origins)
    metric = in_metres(glass, unit)
    assert metric.volume is not None
    assert (metric.volume.thickness, metric.volume.attenuation_distance) == pytest.approx((0.02, 0.05))
    assert metric.origins["volume.thickness"].method == "KHR_materials_volume.thicknessFactor, times 0.01 m per unit"
    assert in_metres(glass, None) is glass
    assert released(glass, meters_per_unit=unit).volume == metric.volume


def test_values_have_the_evidence_of_their_origin() -> None:
    origins = {"roughness": Origin("inferred", "Ns 100 as roughness", 0.6)}
    section: AppearanceSection = result(Material("m", roughness=0.2, clearcoat=0.5, origins=origins)).value.section
    (record,) = section.render_materials
    assert (record.name, record.optics) == ("m", "coated")
    assert record.shaders == ("UsdPreviewSurface", "OpenPBR", "OmniPBR_ClearCoat")
    stated, unknown = record.values["roughness"], record.values["clearcoat"]
    assert (stated.value, stated.source) == (0.2, "inferred")
    assert (stated.method, stated.confidence) == ("Ns 100 as roughness", 0.6)
    assert (unknown.value, unknown.source, unknown.confidence) == (0.5, "default", 0.0)
    assert AppearanceSection.model_validate_json(section.model_dump_json()) == section


def test_a_texture_use_is_a_value_with_evidence() -> None:
    section = result(Material("m", base_color_texture=TextureUse("t", uv_scale=(2.0, 1.0)))).value.section
    value = section.render_materials[0].values["base_color_texture"].value
    assert (value["texture"], tuple(value["uv_scale"])) == ("t", (2.0, 1.0))
    assert section.texels_per_m is not None


def codes(material: Material) -> dict[str, Any]:
    return {d.code: d.value for d in result(material).diagnostics}


def test_what_one_shader_does_not_show_is_reported_once() -> None:
    assert codes(Material("m")) == {}
    found = codes(Material("m", sheen=Sheen((1.0, 0.0, 0.0))))
    assert found == {"asset/shader-lacks-layer": "UsdPreviewSurface: sheen.color; OmniPBR: sheen.color"}
    found = codes(Material("m", transmission=1.0))
    assert found == {"asset/shader-lacks-layer": "UsdPreviewSurface: transmission"}
    assert codes(Material("m", occlusion_texture=TextureUse("t", "r"))) == {}  # for rasterisers only


def test_what_no_shader_shows_is_reported_as_such() -> None:
    assert codes(Material("m", unlit=True)) == {"asset/material-extension-fallback": "unlit"}


def test_textures_above_the_budget_are_made_smaller_and_recorded() -> None:
    outcome = result(Material("m", base_color_texture=TextureUse("t")), max_texture=2)
    assert outcome.value is not None
    assert (outcome.value.textures[0].width, outcome.value.textures[0].height) == (2, 2)
    (repair,) = outcome.repairs
    assert (repair.before["size"], repair.after["size"]) == ("4 x 4 px", "2 x 2 px")
    assert repair.after["filter"] == "Lanczos, as colour"
    assert [d.code for d in outcome.diagnostics] == ["asset/texture-resampled"]
    assert result(Material("m"), max_texture=4).repairs == ()


def test_a_mesh_without_coordinates_is_reported() -> None:
    mesh = samples.box_mesh(material=0)
    outcome = normalize(samples.model([mesh], [Material("m", base_color_texture=TextureUse("t"))], [GREY]))
    assert "asset/missing-texture-coordinates" in [d.code for d in outcome.diagnostics]
    assert np.isfinite(mesh.points).all()
