"""The OpenPBR network has the values of the material, by MaterialX's own definitions of its nodes."""

from __future__ import annotations

import importlib
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Sdf, Usd, UsdShade

from gate.rules.visual.shader_node import USD_TYPES
from schemas.appearance.material import Iridescence, Material, Sheen, TextureUse, Volume
from schemas.appearance.optics import effective
from tests.support.appearance.material_x import placed, value_of
from tests.support.appearance.random_materials import IMAGES, materials
from usdio.write.materials.mesh_materials import MeshMaterial
from usdio.write.materials.network import Network, TextureFiles
from usdio.write.materials.open_pbr import OPEN_PBR

PIXELS = {"packed": (0.2, 0.4, 0.6, 1.0), "clear": (0.9, 0.5, 0.1, 0.3), "grey": (0.7, 0.7, 0.7, 1.0)}
LINEAR = {
    name: (*(v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in rgba[:3]), rgba[3])
    for name, rgba in PIXELS.items()
}


@pytest.fixture(scope="module")
def library() -> Any:
    mx: Any = importlib.import_module("MaterialX")  # its bindings have no types
    document = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), document)
    return document


def authored(material: Material, vertex_colors: bool = False) -> tuple[Usd.Stage, UsdShade.Shader]:
    stage = Usd.Stage.CreateInMemory()
    prim = UsdShade.Material.Define(stage, Sdf.Path("/m"))
    files = TextureFiles({name: name for name in IMAGES}, IMAGES, "mdl")
    OPEN_PBR.author(Network(stage, prim, files, "mtlx_"), MeshMaterial("m", effective(material), vertex_colors))
    return stage, UsdShade.Shader(prim.ComputeSurfaceSource("mtlx")[0])


def inputs_of(material: Material) -> dict[str, Any]:
    stage, shader = authored(material)
    assert stage  # without it the prims expire
    return {port.GetBaseName(): value_of(port, PIXELS) for port in shader.GetInputs()}


def number(factor: float, use: TextureUse | None) -> float:
    if use is None:
        return factor
    return factor * (PIXELS[use.texture]["rgba".index(use.channel)] * use.scale + use.bias)


def rgb(factor: tuple[float, float, float], use: TextureUse | None) -> np.ndarray:
    texel = 1.0 if use is None else np.array(LINEAR[use.texture][:3]) * use.scale + use.bias
    return np.array(factor) * texel


@settings(max_examples=30, deadline=None)
@given(materials())
def test_every_value_of_the_material_is_in_the_network(material: Material) -> None:
    got, m = inputs_of(material), effective(material)
    expected: dict[str, Any] = {
        "base_color": rgb(m.base_color, m.base_color_texture),
        "base_metalness": number(m.metallic, m.metallic_texture),
        "specular_roughness": number(m.roughness, m.roughness_texture),
        "specular_ior": m.ior,
    }
    if m.specular:
        expected["specular_weight"] = number(m.specular.weight, m.specular.weight_texture)
        expected["specular_color"] = rgb(m.specular.color, m.specular.color_texture)
    if m.alpha_mode == "blend":
        expected["geometry_opacity"] = number(m.opacity, m.opacity_texture)
    if m.alpha_mode == "mask" and abs(number(m.opacity, m.opacity_texture) - m.alpha_cutoff) > 1e-6:
        expected["geometry_opacity"] = float(number(m.opacity, m.opacity_texture) > m.alpha_cutoff)
    if m.transmission:
        expected["transmission_weight"] = number(m.transmission, m.transmission_texture)
        expected["geometry_thin_walled"] = m.volume is None or m.volume.thickness == 0.0
        if m.volume and m.volume.thickness and math.isfinite(m.volume.attenuation_distance):
            expected["transmission_color"] = np.array(m.volume.attenuation_color)
            expected["transmission_depth"] = m.volume.attenuation_distance
        else:
            expected["transmission_color"] = rgb(m.base_color, m.base_color_texture)
            expected["transmission_depth"] = 0.0
    if m.dispersion:
        expected["transmission_dispersion_abbe_number"] = 20.0 / m.dispersion
    if m.clearcoat:
        expected["coat_weight"] = number(m.clearcoat, m.clearcoat_texture)
        expected["coat_roughness"] = number(m.clearcoat_roughness, m.clearcoat_roughness_texture)
        expected["coat_ior"] = 1.5
    if m.sheen:
        expected["fuzz_roughness"] = number(m.sheen.roughness, m.sheen.roughness_texture)
    if m.iridescence:
        expected["thin_film_weight"] = number(m.iridescence.factor, m.iridescence.texture)
        expected["thin_film_ior"] = m.iridescence.ior
    if m.anisotropy:
        expected["specular_roughness_anisotropy"] = m.anisotropy.strength
    if m.diffuse_transmission:
        expected["subsurface_weight"] = number(m.diffuse_transmission.factor, m.diffuse_transmission.texture)
        expected["subsurface_color"] = rgb(m.diffuse_transmission.color, m.diffuse_transmission.color_texture)
        expected["geometry_thin_walled"] = True
    for name, value in expected.items():
        assert got[name] == pytest.approx(value, rel=1e-5, abs=1e-6), name
    if max(m.emissive) > 0.0:
        light = got["emission_luminance"] * got["emission_color"]
        assert light == pytest.approx(1000.0 * rgb(m.emissive, m.emissive_texture), rel=1e-4, abs=1e-3)
    if m.sheen:
        fuzz = got["fuzz_weight"] * got["fuzz_color"]
        assert fuzz == pytest.approx(rgb(m.sheen.color, m.sheen.color_texture), rel=1e-4, abs=1e-6)


@settings(max_examples=15, deadline=None)
@given(materials(), st.booleans())
def test_the_network_is_sound_by_the_library_of_material_x(library: Any, material: Material, colored: bool) -> None:
    """Every node exists, and every input is one of its inputs, of its type; every connection has that type too."""
    stage, _ = authored(material, colored)
    for prim in stage.Traverse():
        if not prim.IsA(UsdShade.Shader):
            continue
        shader = UsdShade.Shader(prim)
        definition = library.getNodeDef(shader.GetShaderId())
        assert definition is not None, shader.GetShaderId()
        for port in shader.GetInputs():
            declared = definition.getActiveInput(port.GetBaseName())
            assert declared is not None, (shader.GetShaderId(), port.GetBaseName())
            assert str(port.GetTypeName()) in USD_TYPES[declared.getType()], (prim.GetName(), port.GetBaseName())
            for source in port.GetConnectedSources()[0]:
                upstream = library.getNodeDef(UsdShade.Shader(source.source.GetPrim()).GetShaderId())
                assert upstream.getActiveOutput(source.sourceName).getType() == declared.getType()


@given(st.floats(-3.0, 3.0), st.floats(0.2, 4.0), st.floats(-2.0, 2.0))
@settings(max_examples=20, deadline=None)
def test_pictures_are_placed_as_usd_places_them(turn: float, scale: float, shift: float) -> None:
    """Scale, then rotate counter-clockwise, then translate (UsdTransform2d)."""
    use = TextureUse("packed", uv_set=1, uv_scale=(scale, 2.0), uv_rotation_rad=turn, uv_offset=(shift, 0.25))
    stage, shader = authored(Material("m", base_color_texture=use))
    assert stage
    name, at = placed(shader.GetInput("base_color"), (0.3, 0.7))
    x, y = 0.3 * scale, 0.7 * 2.0
    c, s = math.cos(turn), math.sin(turn)
    assert name == "st1"
    assert at == pytest.approx([c * x - s * y + shift, s * x + c * y + 0.25], abs=1e-4)


def test_thickness_of_a_film_is_between_its_bounds() -> None:
    film = Iridescence(1.0, None, 1.3, (200.0, 600.0), TextureUse("packed", "g"))
    assert inputs_of(Material("m", iridescence=film))["thin_film_thickness"] == pytest.approx(0.2 + 0.4 * 0.4)
    plain = Iridescence(1.0, None, 1.3, (200.0, 600.0))
    assert inputs_of(Material("m", iridescence=plain))["thin_film_thickness"] == pytest.approx(0.6)


def test_normal_maps_of_base_and_coat_keep_their_own_strength() -> None:
    use = TextureUse("packed")
    material = Material(
        "m",
        normal_texture=use,
        normal_scale=0.5,
        clearcoat=1.0,
        clearcoat_normal_texture=use,
        clearcoat_normal_scale=2.0,
    )
    got = inputs_of(material)
    assert got["geometry_normal"][::2] == ("normal map", 0.5)
    assert got["geometry_coat_normal"][::2] == ("normal map", 2.0)
    assert got["geometry_normal"][1] == pytest.approx(PIXELS["packed"][:3])  # data, not decoded from sRGB


def test_what_openpbr_lacks_is_named() -> None:
    def lost(**fields: Any) -> frozenset[str]:
        return OPEN_PBR.lost(MeshMaterial("m", effective(Material("m", **fields))), IMAGES)

    assert lost() == frozenset()
    assert lost(occlusion_texture=TextureUse("grey", "r")) == {"occlusion_texture"}
    assert lost(unlit=True) == {"unlit"}
    assert lost(ior=4.0) == {"ior"}
    assert lost(transmission=1.0, volume=Volume(0.1, TextureUse("grey", "g"))) == {"volume.thickness_texture"}
    assert lost(sheen=Sheen((1.0, 0.0, 0.0)), clearcoat=1.0, transmission=1.0, dispersion=0.2) == frozenset()


def test_vertex_colours_feed_the_base() -> None:
    stage, shader = authored(Material("m", alpha_mode="blend"), vertex_colors=True)
    assert stage
    assert value_of(shader.GetInput("base_color"), {}) == ("primvar", "displayColor")
    assert value_of(shader.GetInput("geometry_opacity"), {}) == ("primvar", "displayOpacity")
