"""Materials of USD files: preview surfaces, textures, MDL, MaterialX."""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image as Picture

from schemas.appearance.conversions import metallic_from_specular
from tests.support.usd_files import QUAD, material_of, model_of, preview, read, write


def textured(primvar: str = "st", extra: str = "", path: str = "./a.png") -> str:
    return f"""def Shader "t" {{ uniform token info:id = "UsdUVTexture"
        asset inputs:file = @{path}@
        float2 inputs:st.connect = </Root/m/uv.outputs:result>
        {extra}
        float3 outputs:rgb
      }}
      def Shader "uv" {{ uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "{primvar}"
      }}"""


BOUND = f"""def Mesh "q" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ {QUAD}
  rel material:binding = </Root/m>
  texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )
  texCoord2f[] primvars:zz = [(5, 0), (6, 0), (6, 1), (5, 1)] ( interpolation = "vertex" )
}}
"""


def picture(folder: Path, name: str = "a.png") -> None:
    data = io.BytesIO()
    Picture.new("RGB", (2, 2), (255, 0, 0)).save(data, "PNG")
    (folder / name).write_bytes(data.getvalue())


def test_preview_surface_scalars(tmp_path: Path) -> None:
    inputs = """color3f inputs:diffuseColor = (0.1, 0.2, 0.3)
      float inputs:metallic = 1\n float inputs:roughness = 0.4\n float inputs:ior = 1.45
      float inputs:opacity = 0.5\n float inputs:clearcoat = 0.25\n color3f inputs:emissiveColor = (0, 1, 0)"""
    got = material_of(write(tmp_path, BOUND + preview("m", inputs)))
    assert (got.base_color, got.metallic, got.roughness, got.ior) == ((0.1, 0.2, 0.3), 1.0, 0.4, 1.45)
    assert (got.opacity, got.alpha_mode, got.clearcoat, got.emissive) == (0.5, "blend", 0.25, (0.0, 1.0, 0.0))
    assert got.unmapped == {}


def test_textures_carry_channel_tint_wrap_and_uv_transform(tmp_path: Path) -> None:
    picture(tmp_path)
    inputs = """color3f inputs:diffuseColor.connect = </Root/m/t.outputs:rgb>
      float inputs:roughness.connect = </Root/m/t.outputs:g>"""
    extra = (
        """float4 inputs:scale = (0.5, 0.25, 1, 1)\n token inputs:wrapS = "clamp"\n token inputs:wrapT = "mirror\""""
    )
    nodes = textured("zz", extra).replace("st.connect = </Root/m/uv", "st.connect = </Root/m/x")
    nodes += """def Shader "x" { uniform token info:id = "UsdTransform2d"
      float2 inputs:in.connect = </Root/m/uv.outputs:result>
      float2 inputs:scale = (2, 3)\n float inputs:rotation = 90\n float2 inputs:translation = (0.5, 0)
    }"""
    model = model_of(write(tmp_path, BOUND + preview("m", inputs, nodes)))
    (got,) = model.materials
    assert got.base_color == (0.5, 0.25, 1.0)
    use = got.base_color_texture
    assert use is not None
    assert got.roughness_texture is not None
    assert (use.channel, use.wrap_s, use.wrap_t) == ("rgb", "clamp", "mirror")
    assert (use.uv_scale, use.uv_offset, use.uv_set) == ((2.0, 3.0), (0.5, 0.0), 0)
    assert math.isclose(use.uv_rotation_rad, math.pi / 2)
    assert (got.roughness_texture.channel, got.roughness) == ("g", 0.25)
    assert [t.name for t in model.textures] == ["a"]
    assert model.meshes[0].uvs[0].min() == 0.0
    assert model.meshes[0].uvs[0][..., 0].min() == 5.0  # set 0 is the one the material reads


@pytest.mark.parametrize("tiles", [(1001,), (1002,), (1001, 1002, 1011)])
def test_of_several_tiles_the_first_is_shown_and_said(tmp_path: Path, tiles: tuple[int, ...]) -> None:
    for number in tiles:
        picture(tmp_path, f"a.{number}.png")
    nodes = textured(path="./a.<UDIM>.png")
    body = BOUND + preview("m", "color3f inputs:diffuseColor.connect = </Root/m/t.outputs:rgb>", nodes)
    outcome = read(write(tmp_path, body))
    assert outcome.value is not None
    assert [t.name for t in outcome.value.textures] == [f"a.{tiles[0]}"]
    assert [d.code for d in outcome.diagnostics] == ["asset/unsupported-texture"] * (len(tiles) > 1)


def test_what_has_no_triangles_is_left_out_with_a_word(tmp_path: Path) -> None:
    mesh = f'def Mesh "q" {{ {QUAD} }}\n'
    for kind, severity in (("NurbsPatch", "warning"), ("TetMesh", "warning"), ("BasisCurves", "info")):
        diagnostics = read(write(tmp_path, mesh + f'def {kind} "p" {{}}\n')).diagnostics
        assert [(d.code, d.severity, d.where.prim) for d in diagnostics] == [
            ("asset/geometry-left-out", severity, "/Root/p")
        ]


def test_a_missing_texture_leaves_the_fallback(tmp_path: Path) -> None:
    inputs = "color3f inputs:diffuseColor.connect = </Root/m/t.outputs:rgb>"
    nodes = textured(extra="float4 inputs:fallback = (0.5, 0, 0, 1)")
    outcome = read(write(tmp_path, BOUND + preview("m", inputs, nodes)))
    assert outcome.value is not None
    assert outcome.value.materials[0].base_color == (0.5, 0.0, 0.0)
    assert outcome.value.materials[0].base_color_texture is None
    assert [(d.code, d.where.file) for d in outcome.diagnostics] == [("asset/missing-texture", "part.usda")]
    assert [r.name for r in outcome.repairs] == ["missing_texture"]


def test_windows_separators_in_texture_paths(tmp_path: Path) -> None:
    (tmp_path / "textures").mkdir()
    picture(tmp_path / "textures")
    inputs = "color3f inputs:diffuseColor.connect = </Root/m/t.outputs:rgb>"
    outcome = read(write(tmp_path, BOUND + preview("m", inputs, textured(path=r".\textures\a.png"))))
    assert outcome.value is not None
    assert len(outcome.value.textures) == 1
    assert outcome.diagnostics == ()


def test_normal_map_strength_is_half_the_texel_scale(tmp_path: Path) -> None:
    picture(tmp_path)
    inputs = "normal3f inputs:normal.connect = </Root/m/t.outputs:rgb>"
    extra = "float4 inputs:scale = (1, 1, 2, 1)\n float4 inputs:bias = (-0.5, -0.5, -1, 0)"
    got = material_of(write(tmp_path, BOUND + preview("m", inputs, textured(extra=extra))))
    assert got.normal_texture is not None
    assert (got.normal_scale, got.normal_texture.scale, got.normal_texture.bias) == (0.5, 1.0, 0.0)


def test_a_material_that_reads_display_color_takes_it_from_each_mesh(tmp_path: Path) -> None:
    inputs = "color3f inputs:diffuseColor.connect = </Root/m/t.outputs:result>"
    nodes = """def Shader "t" { uniform token info:id = "UsdPrimvarReader_float3"
      string inputs:varname = "displayColor"\n }"""
    cubes = "\n".join(
        f"""def Cube "c{i}" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
        rel material:binding = </Root/m>\n color3f[] primvars:displayColor = [({i}, 0, 0)]\n }}"""
        for i in (0, 1)
    )
    model = model_of(write(tmp_path, cubes + preview("m", inputs, nodes)))
    assert [m.base_color for m in model.materials] == [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]
    assert len({m.name for m in model.materials}) == 2


def test_values_out_of_range_are_clamped_with_a_warning(tmp_path: Path) -> None:
    outcome = read(write(tmp_path, BOUND + preview("m", "float inputs:roughness = 3\n float inputs:metallic = nan")))
    assert outcome.value is not None
    assert (outcome.value.materials[0].roughness, outcome.value.materials[0].metallic) == (1.0, 0.0)
    assert [d.code for d in outcome.diagnostics] == ["asset/invalid-material-value"] * 2


def test_a_binding_to_nothing_is_repaired(tmp_path: Path) -> None:
    outcome = read(write(tmp_path, BOUND))
    assert outcome.value is not None
    assert outcome.value.meshes[0].material is None
    assert [r.name for r in outcome.repairs] == ["missing_material"]


def test_omni_pbr_inputs_are_mapped_and_kept(tmp_path: Path) -> None:
    picture(tmp_path)
    shader = """def Material "m" { token outputs:mdl:surface.connect = </Root/m/s.outputs:out>
      def Shader "s" { uniform token info:implementationSource = "sourceAsset"
        uniform asset info:mdl:sourceAsset = @OmniPBR.mdl@
        uniform token info:mdl:sourceAsset:subIdentifier = "OmniPBR"
        asset inputs:diffuse_texture = @./a.png@
        color3f inputs:diffuse_tint = (0.5, 1, 1)
        asset inputs:ORM_texture = @./a.png@
        bool inputs:enable_ORM_texture = 1
        float inputs:detail_bump_factor = 0.3
        token outputs:out
      }
    }"""
    outcome = read(write(tmp_path, BOUND + shader))
    assert outcome.value is not None
    (got,) = outcome.value.materials
    assert got.base_color == (0.5, 1.0, 1.0)
    assert got.metallic_texture is not None
    assert got.roughness_texture is not None
    assert (got.metallic_texture.channel, got.roughness_texture.channel) == ("b", "g")
    assert math.isclose(got.unmapped["OmniPBR"]["detail_bump_factor"], 0.3, rel_tol=1e-6)
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [("asset/material-extension-fallback", "info")]


MATERIAL_X = """<materialx version="1.38">
  <nodegraph name="NG">
    <image name="color" type="color3"><input name="file" type="filename" value="tex/a.png"/></image>
    <normalmap name="bump" type="vector3"><input name="in" type="vector3" nodename="color"/></normalmap>
    <output name="c" type="color3" nodename="color"/><output name="n" type="vector3" nodename="bump"/>
  </nodegraph>
  <standard_surface name="S" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="NG" output="c"/>
    <input name="normal" type="vector3" nodegraph="NG" output="n"/>
    <input name="specular_roughness" type="float" value="0.7"/>
    <input name="subsurface" type="float" value="0.9"/>
  </standard_surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="S"/>
  </surfacematerial>
</materialx>"""


def test_material_x_documents_are_read_without_the_plugin(tmp_path: Path) -> None:
    (tmp_path / "look" / "tex").mkdir(parents=True)
    picture(tmp_path / "look" / "tex")
    (tmp_path / "look" / "look.mtlx").write_text(MATERIAL_X)
    scope = 'def "looks" (references = @look/look.mtlx@</MaterialX/Materials>) {}'
    body = BOUND.replace("</Root/m>", "</Root/looks/m>") + scope
    got = material_of(write(tmp_path, body))
    assert got.base_color_texture is not None
    assert got.normal_texture is not None
    assert (got.base_color_texture.texture, got.base_color_texture.channel, got.roughness) == ("a", "rgb", 0.7)
    assert math.isclose(got.unmapped["ND_standard_surface_surfaceshader"]["subsurface"], 0.9, rel_tol=1e-6)


@settings(max_examples=50, deadline=None)
@given(color=st.tuples(*[st.floats(0.05, 0.95)] * 3))
def test_specular_colors_convert_at_both_ends(color: tuple[float, float, float]) -> None:
    base, metallic = metallic_from_specular(np.array(color), np.full(3, 0.04))
    assert metallic == pytest.approx(0.0, abs=1e-9)
    assert base == pytest.approx(color)
    base, metallic = metallic_from_specular(np.zeros(3), np.array(color))
    assert metallic == pytest.approx(1.0, abs=1e-9)
    assert base == pytest.approx(color)
