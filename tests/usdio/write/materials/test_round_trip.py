"""A material that is written as one shader alone is read back as the same material."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pxr import Sdf, Usd, UsdShade

from schemas.appearance.material import Material, Sheen, Specular, TextureUse
from schemas.appearance.optics import effective
from tests.support.appearance.random_materials import IMAGES, color, half, unit
from tests.support.usd_files import QUAD, material_of, write
from usdio.write.materials.mesh_materials import MeshMaterial
from usdio.write.materials.network import Network, TextureFiles
from usdio.write.materials.omni_glass import OMNI_GLASS
from usdio.write.materials.omni_pbr import OMNI_PBR
from usdio.write.materials.open_pbr import OPEN_PBR
from usdio.write.materials.output import ShaderOutput
from usdio.write.materials.preview_surface import PREVIEW_SURFACE

BOUND = f"""def Mesh "q" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ {QUAD}
  rel material:binding = </Root/m>
  texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )
}}
"""
COATED = ("metallic", "roughness", "normal_scale", "opacity", "ior", "clearcoat", "clearcoat_roughness")
COLORS = ("base_color", "emissive")
TEXTURES = ("base_color_texture", "emissive_texture", "metallic_texture", "roughness_texture", "normal_texture")


def placed(**fields: object) -> st.SearchStrategy[TextureUse]:
    return st.builds(
        TextureUse,
        texture=st.just("packed"),
        wrap_s=st.sampled_from(("repeat", "clamp", "mirror")),
        uv_scale=st.tuples(st.sampled_from((0.5, 1.0, 2.0)), st.sampled_from((-1.0, 4.0))),
        uv_rotation_rad=st.sampled_from((0.0, 0.5, -1.0)),
        uv_offset=st.tuples(unit, unit),
        **{name: st.just(value) for name, value in fields.items()},
    )


PLAIN = st.builds(
    Material,
    name=st.just("m"),
    base_color=color,
    base_color_texture=st.none() | placed(),
    metallic=unit,
    metallic_texture=st.none() | placed(channel="b"),
    roughness=unit,
    roughness_texture=st.none() | placed(channel="g"),
    normal_texture=st.none() | placed(),
    normal_scale=half,
    emissive=color,
    emissive_texture=st.none() | placed(),
    ior=st.sampled_from((1.0, 1.3, 1.45, 2.4)),
)


def round_trip(folder: Path, output: ShaderOutput, material: Material) -> Material:
    return material_of(authored(folder, (output,), material))


def authored(folder: Path, outputs: tuple[ShaderOutput, ...], material: Material) -> Path:
    """A stage with one quad in a material that has these surfaces."""
    path = write(folder, BOUND)
    for name, image in IMAGES.items():
        (folder / f"{name}.png").write_bytes(image.data)
    stage = Usd.Stage.Open(str(path))
    prim = UsdShade.Material.Define(stage, Sdf.Path("/Root/m"))
    files = TextureFiles({name: f"./{name}.png" for name in IMAGES}, IMAGES, "mdl")
    for output in outputs:
        output.author(Network(stage, prim, files), MeshMaterial("m", effective(material)))
    stage.Save()
    return path


def assert_same(got: Material, wanted: Material, names: tuple[str, ...]) -> None:
    for name in names:
        value, expected = getattr(got, name), getattr(wanted, name)
        if not isinstance(expected, TextureUse):
            assert value == pytest.approx(expected, abs=1e-5), name
            continue
        assert value is not None, name
        assert value.uv_rotation_rad == pytest.approx(expected.uv_rotation_rad, abs=1e-5)
        for field in ("uv_scale", "uv_offset", "scale", "bias"):
            assert getattr(value, field) == pytest.approx(getattr(expected, field), abs=1e-5), (name, field)
        same = {"uv_scale": (1.0, 1.0), "uv_offset": (0.0, 0.0), "uv_rotation_rad": 0.0, "scale": 1.0, "bias": 0.0}
        assert replace(value, **same) == replace(expected, **same), name


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(PLAIN, unit, unit, unit)
def test_openpbr(tmp_path: Path, material: Material, coat: float, rough: float, clear: float) -> None:
    layered = replace(material, clearcoat=coat, clearcoat_roughness=rough, transmission=clear)
    got = round_trip(tmp_path, OPEN_PBR, layered)
    assert_same(got, effective(layered), (*COATED, "transmission", *COLORS, *TEXTURES))


@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(PLAIN, unit)
def test_usd_preview_surface(tmp_path: Path, material: Material, coat: float) -> None:
    coated = replace(material, clearcoat=coat)
    got = round_trip(tmp_path, PREVIEW_SURFACE, coated)
    assert_same(got, effective(coated), (*COATED, *COLORS, *TEXTURES))


@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(color, unit, unit, unit, half)
def test_omni_pbr(
    tmp_path: Path, base: tuple[float, float, float], metal: float, rough: float, clear: float, bump: float
) -> None:
    """Constants, and pictures of one placement."""
    use = TextureUse("packed", uv_scale=(2.0, 0.5), uv_rotation_rad=math.pi / 6, uv_offset=(0.25, 0.5))
    for picture in (None, use):
        material = Material(
            "m",
            base_color=base,
            base_color_texture=picture,
            metallic=metal,
            roughness=rough,
            opacity=clear,
            alpha_mode="blend",
            normal_texture=picture,
            normal_scale=bump,
        )
        got = round_trip(tmp_path, OMNI_PBR, material)
        names = (
            "base_color",
            "metallic",
            "roughness",
            "opacity",
            "normal_scale",
            "base_color_texture",
            "normal_texture",
        )
        assert_same(got, effective(material), names)


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(PLAIN, unit, unit, color)
def test_layers_that_the_preview_lacks_come_from_the_other_surface(
    tmp_path: Path, material: Material, clear: float, bent: float, fibres: tuple[float, float, float]
) -> None:
    """A material with both surfaces is read as if it had the richer one; values of both are the preview's."""
    sheen = Sheen(fibres, roughness=0.25)
    layered = replace(material, transmission=clear, sheen=sheen, specular=Specular(bent))
    path = authored(tmp_path, (PREVIEW_SURFACE, OPEN_PBR), layered)
    got, visible = material_of(path), effective(layered)
    assert_same(got, visible, ("transmission", "opacity", *COLORS, *TEXTURES, "metallic", "roughness"))
    assert got.alpha_mode == visible.alpha_mode
    if visible.sheen is not None:
        assert got.sheen is not None
        assert got.sheen.color == pytest.approx(visible.sheen.color, abs=1e-5)
        assert "open_pbr" in got.origins["sheen.color"].method
    if visible.specular is not None and visible.specular.weight > 0.0:
        assert got.specular is not None
        assert got.specular.weight == pytest.approx(visible.specular.weight, abs=1e-5)
        assert got.ior == pytest.approx(visible.ior, abs=1e-5)
    if visible.transmission > 0.0:
        assert "open_pbr" in got.origins["transmission"].method


def test_textured_glass_is_read_from_the_surface_that_has_the_texture(tmp_path: Path) -> None:
    """As packages write it: OmniGlass, which is glass throughout, stands before OpenPBR among the outputs."""
    label = TextureUse("packed", channel="r")
    glass = Material("m", base_color=(0.2, 0.9, 0.4), transmission=1.0, transmission_texture=label, roughness=0.1)
    path = authored(tmp_path, (PREVIEW_SURFACE, OPEN_PBR, OMNI_GLASS), glass)
    got = material_of(path)
    assert_same(got, effective(glass), ("transmission", "transmission_texture", "opacity"))
    assert "open_pbr" in got.origins["transmission"].method


@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.floats(0.0, 1.0), st.floats(1.0, 2.4))
def test_the_preview_reflects_what_weight_and_index_reflect_together(
    tmp_path: Path, weight: float, index: float
) -> None:
    """Straight on, by Fresnel's formula, written out here once more."""
    got = round_trip(tmp_path, PREVIEW_SURFACE, Material("m", ior=index, specular=Specular(weight)))
    assert ((got.ior - 1.0) / (got.ior + 1.0)) ** 2 == pytest.approx(
        weight * ((index - 1.0) / (index + 1.0)) ** 2, abs=1e-6
    )
