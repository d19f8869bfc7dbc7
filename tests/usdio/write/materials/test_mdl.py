"""OmniPBR, OmniPBR_ClearCoat and OmniGlass have the values of the material where their parameters can hold them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Sdf, Usd, UsdShade

from gate.rules.visual.shader_node import USD_TYPES, shader_inputs
from schemas.appearance.material import Material, Specular, TextureUse, Volume
from schemas.appearance.optics import effective
from tests.support.appearance.random_materials import IMAGES, materials
from usdio.write.materials.mesh_materials import MeshMaterial
from usdio.write.materials.modules import MODULE_FILES, module_sources
from usdio.write.materials.network import Network, TextureFiles
from usdio.write.materials.omni_clear_coat import OMNI_CLEAR_COAT
from usdio.write.materials.omni_glass import OMNI_GLASS
from usdio.write.materials.omni_pbr import OMNI_PBR, weight_and_constant
from usdio.write.materials.output import VERTEX_COLORS, ShaderOutput

ORM: dict[str, Any] = {
    "occlusion_texture": TextureUse("packed", "r", scale=0.8, bias=0.2),
    "roughness_texture": TextureUse("packed", "g"),
    "metallic_texture": TextureUse("packed", "b"),
}


def authored(output: ShaderOutput, material: Material) -> tuple[Usd.Stage, UsdShade.Shader]:
    stage = Usd.Stage.CreateInMemory()
    prim = UsdShade.Material.Define(stage, Sdf.Path("/m"))
    files = TextureFiles({name: f"./{name}.png" for name in IMAGES}, IMAGES, "../mdl")
    output.author(Network(stage, prim, files, "mdl_"), MeshMaterial("m", effective(material)))
    return stage, UsdShade.Shader(prim.GetSurfaceOutput("mdl").GetConnectedSources()[0][0].source.GetPrim())


def values(output: ShaderOutput, material: Material) -> dict[str, Any]:
    stage, shader = authored(output, material)
    assert stage
    return {
        port.GetBaseName(): value.path if isinstance(value := port.Get(), Sdf.AssetPath) else value
        for port in shader.GetInputs()
    }


def lost(output: ShaderOutput, vertex_colors: bool = False, **fields: Any) -> frozenset[str]:
    return output.lost(MeshMaterial("m", effective(Material("m", **fields)), vertex_colors), IMAGES)


@settings(max_examples=25, deadline=None)
@given(materials(), st.sampled_from((OMNI_PBR, OMNI_CLEAR_COAT, OMNI_GLASS)))
def test_only_known_parameters_of_their_types_are_written(material: Material, output: ShaderOutput) -> None:
    stage, shader = authored(output, material)
    assert stage
    known = shader_inputs()[output.name]
    for port in shader.GetInputs():
        assert str(port.GetTypeName()) in USD_TYPES[known[port.GetBaseName()]], port.GetBaseName()
        if isinstance(port.Get(), Sdf.AssetPath):
            colour = port.GetBaseName() in ("diffuse_texture", "emissive_color_texture", "glass_color_texture")
            assert port.GetAttr().GetColorSpace() == ("sRGB" if colour else "raw")


@given(st.floats(0.0, 1.0), st.floats(-1.5, 1.5), st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_weight_over_a_constant_is_the_factor_times_scale_and_bias(f: float, s: float, b: float, texel: float) -> None:
    """OmniPBR blends constant and texture; UsdPreviewSurface multiplies and adds."""
    pair = weight_and_constant(f, TextureUse("packed", "g", scale=s, bias=b))
    if pair is not None:
        weight, constant = pair
        assert constant + weight * (texel - constant) == pytest.approx(f * (texel * s + b), abs=1e-9)
        assert 0.0 <= weight <= 1.0
        assert 0.0 <= constant <= 1.0
    elif s >= 0.0 and b == 0.0:
        assert f * s > 1.0  # nothing that a weight could say is refused


def test_packed_maps_are_read_as_one_picture() -> None:
    got = values(OMNI_PBR, Material("m", metallic=1.0, roughness=0.6, **ORM))
    assert got["enable_ORM_texture"]
    assert got["ORM_texture"] == "./packed.png"
    assert (got["reflection_roughness_texture_influence"], got["reflection_roughness_constant"]) == (
        pytest.approx(0.6),
        0.0,
    )
    assert (got["metallic_texture_influence"], got["ao_to_diffuse"]) == (1.0, pytest.approx(0.8))
    assert lost(OMNI_PBR, metallic=1.0, roughness=0.6, **ORM) == frozenset()


def test_a_packed_channel_that_is_not_used_has_no_influence() -> None:
    got = values(OMNI_PBR, Material("m", metallic=0.3, roughness=1.0, roughness_texture=ORM["roughness_texture"]))
    assert (got["metallic_texture_influence"], got["metallic_constant"]) == (0.0, pytest.approx(0.3))
    assert "ao_to_diffuse" not in got


def test_grey_pictures_are_read_as_they_are_and_coloured_ones_are_not() -> None:
    grey = TextureUse("grey", "r")
    assert values(OMNI_PBR, Material("m", roughness=1.0, roughness_texture=grey))["reflectionroughness_texture"] == (
        "./grey.png"
    )
    red = replace(grey, texture="packed")  # its red channel alone: OmniPBR would take the mean of all three
    assert lost(OMNI_PBR, roughness=1.0, roughness_texture=red) == {"roughness_texture"}


def test_all_textures_share_one_placement() -> None:
    base = TextureUse("clear", uv_set=1, uv_scale=(2.0, 3.0), uv_rotation_rad=0.5, uv_offset=(0.1, 0.2))
    elsewhere = TextureUse("packed")
    fields: dict[str, Any] = {"base_color_texture": base, "normal_texture": elsewhere}
    got = values(OMNI_PBR, Material("m", **fields))
    assert (got["uv_space_index"], tuple(got["texture_scale"])) == (1, (2.0, 3.0))
    assert got["texture_rotate"] == pytest.approx(28.6479, abs=1e-3)
    assert "normalmap_texture" not in got
    assert lost(OMNI_PBR, **fields) == {"normal_texture"}


def test_reflectance_light_and_cut_out() -> None:
    fields: dict[str, Any] = {
        "ior": 1.5,
        "emissive": (2.0, 1.0, 0.0),
        "alpha_mode": "mask",
        "alpha_cutoff": 0.3,
        "opacity": 0.9,
    }
    got = values(OMNI_PBR, Material("m", **fields))
    assert got["specular_level"] == pytest.approx(0.5)  # 4 %
    assert got["enable_emission"]
    assert got["emissive_intensity"] == 2000.0
    assert tuple(got["emissive_color"]) == (1, 0.5, 0)
    assert got["enable_opacity"]
    assert got["opacity_threshold"] == pytest.approx(0.3)
    assert got["opacity_constant"] == pytest.approx(0.9)


def test_the_coat_is_written_and_its_maps_are_named_as_lost() -> None:
    normals = TextureUse("packed")
    fields: dict[str, Any] = {"clearcoat": 0.7, "clearcoat_roughness": 0.2, "clearcoat_normal_texture": normals}
    got = values(OMNI_CLEAR_COAT, Material("m", clearcoat_normal_scale=0.4, **fields))
    assert got["enable_clearcoat"]
    assert got["clearcoat_weight"] == pytest.approx(0.7)
    assert got["clearcoat_reflection_roughness"] == pytest.approx(0.2)
    assert (got["clearcoat_normalmap_texture"], got["clearcoat_bump_factor"]) == ("./packed.png", pytest.approx(0.4))
    assert lost(OMNI_CLEAR_COAT, **fields) == frozenset()
    assert lost(OMNI_CLEAR_COAT, clearcoat_texture=normals, **fields) == {"clearcoat_texture"}
    assert "clearcoat" in lost(OMNI_PBR, **fields)


def test_glass_has_its_colour_depth_and_roughness() -> None:
    bottle = Material(
        "m",
        base_color=(0.9, 1.0, 0.9),
        transmission=1.0,
        roughness=0.1,
        ior=1.45,
        volume=Volume(0.004, None, 0.05, (0.2, 0.8, 0.3)),
        specular=Specular(color=(0.5, 0.5, 0.5)),
    )
    got = values(OMNI_GLASS, bottle)
    assert tuple(got["glass_color"]) == pytest.approx((0.2, 0.8, 0.3))
    assert got["depth"] == pytest.approx(0.05)
    assert got["glass_ior"] == pytest.approx(1.45)
    assert got["frosting_roughness"] == pytest.approx(0.1)
    assert not got["thin_walled"]
    assert tuple(got["reflection_color"]) == (0.5, 0.5, 0.5)
    pane = values(OMNI_GLASS, replace(bottle, volume=None))
    assert pane["thin_walled"]
    assert tuple(pane["glass_color"]) == pytest.approx((0.9, 1.0, 0.9))
    assert "depth" not in pane


def test_what_glass_lacks_is_named() -> None:
    assert lost(OMNI_GLASS, transmission=1.0) == frozenset()
    assert lost(OMNI_GLASS, transmission=0.5, metallic=0.5) == {"transmission", "metallic"}
    assert lost(OMNI_GLASS, True, transmission=1.0) == {VERTEX_COLORS}


def test_modules_are_variants_beside_the_textures() -> None:
    stage, shader = authored(OMNI_GLASS, Material("m", transmission=1.0))
    assert stage
    assert shader.GetSourceAsset("mdl").path == f"../mdl/{MODULE_FILES['OmniGlass']}"
    assert shader.GetSourceAssetSubIdentifier("mdl") == "OmniGlass"
    (text,) = module_sources(["OmniGlass", "UsdPreviewSurface"]).values()
    assert (
        text == "mdl 1.6;\nimport ::OmniGlass::OmniGlass;\nexport material OmniGlass(*) = ::OmniGlass::OmniGlass();\n"
    )
