"""What the USD reader makes of units, axes, meshes, instances, materials and broken values."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image as Picture
from pxr import Gf, Tf, Usd, UsdGeom, Vt

from assetkit.readers.usd import read_usd
from assetkit.source import SourceFile
from geom import gprims
from schemas.diagnostics import Diagnostic, InvalidInput
from schemas.model import Material, Mesh, Model
from schemas.outcome import Outcome
from usdio.pbr import metallic_from_specular

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "assets"
HEADER = 'defaultPrim = "Root"\n metersPerUnit = 1\n upAxis = "Z"'
QUAD = """int[] faceVertexCounts = [4]
 int[] faceVertexIndices = [0, 1, 2, 3]
 point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
 uniform token subdivisionScheme = "none"
"""


def write(folder: Path, body: str, header: str = HEADER, root: str = 'def Xform "Root"') -> Path:
    """A layer with one root prim; closing braces get the line breaks that the grammar wants around them."""
    path = folder / "part.usda"
    body = body.replace("}", "\n}\n")
    path.write_text(f"#usda 1.0\n(\n {header}\n)\n{root} {{\n {body}\n}}\n")
    return path


def read(path: Path) -> Outcome[Model]:
    return read_usd(SourceFile(path, path.parent))


def model_of(path: Path) -> Model:
    model = read(path).value
    assert model is not None
    return model


def only_mesh(path: Path) -> Mesh:
    (mesh,) = model_of(path).meshes
    return mesh


def rejection(path: Path) -> Diagnostic:
    with pytest.raises(InvalidInput) as caught:
        read(path)
    return caught.value.diagnostic


def corners(mesh: Mesh) -> np.ndarray:
    """(m, 3, 3) points of the triangles."""
    return mesh.points[mesh.triangles]


def area_vector(mesh: Mesh) -> np.ndarray:
    a, b, c = np.moveaxis(corners(mesh), 1, 0)
    return np.cross(b - a, c - a).sum(axis=0) / 2


def volume(mesh: Mesh) -> float:
    return float(np.linalg.det(corners(mesh)).sum() / 6)


# Unit, axis, default prim.


@pytest.mark.parametrize(
    ("header", "value", "source", "codes"),
    [
        ("metersPerUnit = 0.001", 0.001, "declared", []),
        ("metersPerUnit = 10", 10.0, "declared", []),
        ('doc = "nothing said"', 0.01, "declared", []),
    ],
)
def test_meters_per_unit(tmp_path: Path, header: str, value: float, source: str, codes: list[str]) -> None:
    outcome = read(write(tmp_path, 'def Cube "c" {}', header))
    assert outcome.value is not None
    assert (outcome.value.meters_per_unit.value, outcome.value.meters_per_unit.source) == (value, source)
    assert [d.code for d in outcome.diagnostics] == codes


def test_what_only_the_standard_implies_is_less_sure(tmp_path: Path) -> None:
    silent, said = (read(write(tmp_path, 'def Cube "c" {}', h)).value for h in ('doc = "x"', "metersPerUnit = 0.01"))
    assert silent is not None
    assert said is not None
    assert silent.meters_per_unit.confidence == silent.up_axis.confidence == 0.5
    assert said.meters_per_unit.confidence == 1.0


@pytest.mark.parametrize(
    ("header", "operation", "values"),
    [
        ("metersPerUnit = 0.01", "", ["0.01"]),
        ('metersPerUnit = 1\n    upAxis = "Z"', "", ["Z"]),
        ('metersPerUnit = 1\n    upAxis = "Y"', "", []),
        ('doc = "silent"', "", []),
        ("metersPerUnit = 0.01", "double3 xformOp:scale:unitsResolve = (0.01, 0.01, 0.01)", []),
    ],
)
def test_a_layer_of_another_unit_is_noticed(tmp_path: Path, header: str, operation: str, values: list[str]) -> None:
    write(tmp_path, 'def Cube "c" {}', f'defaultPrim = "Root"\n    {header}').rename(tmp_path / "layer.usda")
    body = f'def "a" (references = @layer.usda@) {{ {operation} }}'
    outcome = read(write(tmp_path, body, 'metersPerUnit = 1\n    upAxis = "Y"'))
    found = [d for d in outcome.diagnostics if d.code == "asset/contradictory-evidence"]
    assert [d.value for d in found] == values
    assert all("layer.usda" in d.headline for d in found)


@pytest.mark.parametrize("value", ["0", "-1", "nan", "inf"])
def test_a_unit_that_is_no_length_is_rejected(tmp_path: Path, value: str) -> None:
    assert rejection(write(tmp_path, 'def Cube "c" {}', f"metersPerUnit = {value}")).code == "asset/invalid-unit-value"


def test_a_unit_of_the_wrong_type_is_used_and_repaired(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(stage: Usd.Stage) -> float:  # what OpenUSD does when an old exporter stored a single
        raise Tf.ErrorException("Requested type double for stage metadatum metersPerUnit")

    monkeypatch.setattr(UsdGeom, "GetStageMetersPerUnit", refuse)
    outcome = read(write(tmp_path, 'def Cube "c" {}', "metersPerUnit = 0.5"))
    assert outcome.value is not None
    assert outcome.value.meters_per_unit.value == 0.5
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [("asset/invalid-unit-value", "warning")]
    assert [r.name for r in outcome.repairs] == ["invalid_unit_value"]


@pytest.mark.parametrize(
    ("header", "axis", "source", "repairs"),
    [
        ('upAxis = "Y"', "y", "declared", []),
        ('upAxis = "Z"', "z", "declared", []),
        ('upAxis = "X"', "x", "inferred", ["invalid_up_axis"]),
        ('upAxis = "sideways"', "y", "default", ["invalid_up_axis"]),
        ("metersPerUnit = 1", "y", "declared", []),
    ],
)
def test_up_axis(tmp_path: Path, header: str, axis: str, source: str, repairs: list[str]) -> None:
    outcome = read(write(tmp_path, 'def Cube "c" {}', header))
    assert outcome.value is not None
    assert (outcome.value.up_axis.value, outcome.value.up_axis.source) == (axis, source)
    assert [r.name for r in outcome.repairs] == repairs


def test_the_default_prim_is_what_the_file_is_about(tmp_path: Path) -> None:
    both = '{}\n}}\ndef Sphere "Other" {{'
    assert len(model_of(write(tmp_path, both.format('def Cube "c" {}'))).meshes) == 1
    assert len(model_of(write(tmp_path, both.format('def Cube "c" {}'), 'upAxis = "Z"')).meshes) == 2
    absent = read(write(tmp_path, both.format('def Cube "c" {}'), 'defaultPrim = "Nobody"'))
    assert absent.value is not None
    assert len(absent.value.meshes) == 2
    assert [r.name for r in absent.repairs] == ["invalid_default_prim"]


def test_what_the_file_says_about_itself(tmp_path: Path) -> None:
    header = (
        'doc = "units are mm"\n customLayerData = {\n dictionary SimReady_Metadata = {\n string author = "Ada"\n }\n}'
    )
    root = 'def Xform "Root" (\n assetInfo = {\n string name = "Cup"\n string license = "CC0-1.0"\n }\n)'
    model = model_of(write(tmp_path, 'def Cube "c" {}', f'{header}\n defaultPrim = "Root"', root))
    assert model.metadata == {"author": "Ada", "license": "CC0-1.0", "title": "Cup"}
    assert "units are mm" in model.hints


# Meshes.


def test_a_quad_becomes_two_triangles_that_keep_its_area_and_side(tmp_path: Path) -> None:
    mesh = only_mesh(write(tmp_path, f'def Mesh "m" {{ {QUAD} }}'))
    assert mesh.triangles.dtype == np.int32
    assert np.allclose(area_vector(mesh), [0, 0, 2])
    assert mesh.source_path == "/Root/m"


def test_a_concave_polygon_keeps_its_outline(tmp_path: Path) -> None:
    body = """int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 2, 0), (-1, -1, 0), (0, 0, 0), (1, -1, 0)]"""
    a, b, c = np.moveaxis(corners(only_mesh(write(tmp_path, f'def Mesh "m" {{ {body} }}'))), 1, 0)
    normals = np.cross(b - a, c - a)[:, 2]
    assert (normals > 0).all()  # no triangle is folded over
    assert math.isclose(normals.sum() / 2, 2.0)


def test_left_handed_and_mirrored_meshes_stay_outward(tmp_path: Path) -> None:
    stage = Usd.Stage.CreateNew(str(tmp_path / "part.usda"))
    shape = gprims.cube(2.0)
    for index, (left, scale) in enumerate([(False, 1), (True, 1), (False, -1), (True, -1)]):
        mesh = UsdGeom.Mesh.Define(stage, f"/m{index}")
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(shape.points.astype(np.float32)))
        mesh.CreateFaceVertexCountsAttr([3] * 12)
        mesh.CreateFaceVertexIndicesAttr((shape.triangles[:, ::-1] if left else shape.triangles).ravel().tolist())
        mesh.CreateNormalsAttr(
            Vt.Vec3fArray.FromNumpy(
                (shape.normals[:, ::-1] if left else shape.normals).reshape(-1, 3).astype(np.float32)
            )
        )
        mesh.SetNormalsInterpolation("faceVarying")
        mesh.CreateOrientationAttr("leftHanded" if left else "rightHanded")
        mesh.AddScaleOp().Set(Gf.Vec3f(scale, 1, 1))
    stage.Save()
    for mesh in model_of(tmp_path / "part.usda").meshes:
        assert math.isclose(volume(mesh), 8.0)
        a, b, c = np.moveaxis(corners(mesh), 1, 0)
        faces = np.cross(b - a, c - a)
        assert mesh.normals is not None
        assert np.allclose(mesh.normals, (faces / np.linalg.norm(faces, axis=1, keepdims=True))[:, None], atol=1e-6)


def test_transforms_are_applied_in_double_precision(tmp_path: Path) -> None:
    ops = "double3 xformOp:translate = (1e8, 0, 0)\n uniform token[] xformOpOrder = ['xformOp:translate']"
    mesh = only_mesh(write(tmp_path, f'def Mesh "m" {{ {QUAD} {ops} }}'.replace("'", '"')))
    assert np.array_equal(np.ptp(mesh.points, axis=0), [2, 1, 0])


INTERPOLATIONS = {
    "vertex": "[(0, 0), (1, 0), (1, 1), (0, 1)]",
    "varying": "[(0, 0), (1, 0), (1, 1), (0, 1)]",
    "faceVarying": "[(0, 0), (1, 0), (1, 1), (0, 1)]",
}


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
@pytest.mark.parametrize("indexed", [False, True])
@pytest.mark.parametrize("name", ["st", "UVMap", "map1"])
def test_uvs_of_any_interpolation_follow_their_corners(
    tmp_path: Path, interpolation: str, indexed: bool, name: str
) -> None:
    values = "[(0, 1), (1, 1), (1, 0), (0, 0)]" if indexed else INTERPOLATIONS[interpolation]
    order = f"int[] primvars:{name}:indices = [3, 2, 1, 0]" if indexed else ""
    primvar = f'texCoord2f[] primvars:{name} = {values} (\n interpolation = "{interpolation}"\n )\n {order}'
    mesh = only_mesh(write(tmp_path, f'def Mesh "m" {{ {QUAD} {primvar} }}'))
    assert np.allclose(mesh.uvs[0], corners(mesh)[..., :2] / [2, 1])


def test_uniform_and_constant_colors(tmp_path: Path) -> None:
    two = QUAD.replace("[4]", "[3, 3]").replace("[0, 1, 2, 3]", "[0, 1, 2, 0, 2, 3]")
    uniform = 'color3f[] primvars:displayColor = [(1, 0, 0), (0, 0, 1)] (\n interpolation = "uniform"\n )\n'
    mesh = only_mesh(write(tmp_path, f'def Mesh "m" {{ {two} {uniform} }}'))
    assert mesh.colors is not None
    assert np.array_equal(mesh.colors[:, :, 0], [[1, 1, 1], [0, 0, 0]])
    constant = "color3f[] primvars:displayColor = [(0.5, 0.25, 0)]\n"
    model = model_of(write(tmp_path, f'def Mesh "m" {{ {two} {constant} }}'))
    assert model.meshes[0].colors is None
    assert model.materials[0].base_color == (0.5, 0.25, 0.0)


def test_subsets_split_a_mesh_by_material(tmp_path: Path) -> None:
    two = QUAD.replace("[4]", "[3, 3]").replace("[0, 1, 2, 3]", "[0, 1, 2, 0, 2, 3]")
    subset = """def GeomSubset "lid" (prepend apiSchemas = ["MaterialBindingAPI"]) {
      uniform token elementType = "face"
      uniform token familyName = "materialBind"
      int[] indices = [1]
      rel material:binding = </Root/red>
    }"""
    red = preview("red", "color3f inputs:diffuseColor = (1, 0, 0)")
    model = model_of(write(tmp_path, f'def Mesh "m" {{ {two} {subset} }}\n {red}'))
    rest, lid = model.meshes
    assert (rest.material, lid.material) == (None, 0)
    assert (len(rest.triangles), len(lid.triangles), len(lid.points)) == (1, 1, 3)
    assert model.materials[0].base_color == (1.0, 0.0, 0.0)


def test_hole_faces_are_left_out(tmp_path: Path) -> None:
    two = QUAD.replace("[4]", "[3, 3]").replace("[0, 1, 2, 3]", "[0, 1, 2, 0, 2, 3]")
    assert len(only_mesh(write(tmp_path, f'def Mesh "m" {{ {two} int[] holeIndices = [0] }}')).triangles) == 1


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("[0, 1, 2, 3]", "[0, 1, 2, 9]", "asset/index-out-of-range"),
        ("[0, 1, 2, 3]", "[0, 1, 2, -1]", "asset/index-out-of-range"),
        ("[4]", "[5]", "asset/schema-error"),
        ("[4]", "[-4, 8]", "asset/schema-error"),
        ("(2, 1, 0)", "(nan, 1, 0)", "asset/nonfinite-vertices"),
        ("(2, 1, 0)", "(inf, 1, 0)", "asset/nonfinite-vertices"),
    ],
)
def test_broken_topology_and_points_are_rejected_with_their_prim(tmp_path: Path, old: str, new: str, code: str) -> None:
    found = rejection(write(tmp_path, f'def Mesh "m" {{ {QUAD.replace(old, new)} }}'))
    assert found.code == code
    assert found.where.prim == "/Root/m"


def test_attributes_of_the_wrong_length_are_left_out_with_a_warning(tmp_path: Path) -> None:
    primvar = (
        'texCoord2f[] primvars:st = [(0, 0)] (\n interpolation = "vertex"\n )\n normal3f[] normals = [(0, 0, 1)]\n'
    )
    outcome = read(write(tmp_path, f'def Mesh "m" {{ {QUAD} {primvar} }}'))
    assert outcome.value is not None
    assert outcome.value.meshes[0].uvs == ()
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [("asset/schema-error", "warning")] * 2


def test_zero_normals_take_the_normal_of_their_face(tmp_path: Path) -> None:
    normals = "normal3f[] normals = [(0, 0, 2), (0, 0, 0), (0, 0, 1), (0, 0, 1)]\n"
    outcome = read(write(tmp_path, f'def Mesh "m" {{ {QUAD} {normals} }}'))
    assert outcome.value is not None
    assert np.allclose(outcome.value.meshes[0].normals, [0, 0, 1])
    assert [r.name for r in outcome.repairs] == ["bad_normals"]


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("", "asset/empty-geometry"),
        ('def Mesh "m" {}', "asset/empty-geometry"),
        ('def Cube "c" { token visibility = "invisible"\n }', "asset/empty-geometry"),
        ('def Points "p" { point3f[] points = [(0, 0, 0)]\n }', "asset/no-faces"),
        ('def Mesh "m" { point3f[] points = [(0, 0, 0)]\n }', "asset/no-faces"),
        ('def Sphere "s" { double radius = nan\n }', "asset/nonfinite-vertices"),
        ('def Sphere "s" { double radius = -1\n }', "asset/schema-error"),
    ],
)
def test_nothing_to_build(tmp_path: Path, body: str, code: str) -> None:
    assert rejection(write(tmp_path, body)).code == code


def test_guides_and_proxies_count_only_when_alone(tmp_path: Path) -> None:
    guide = 'def Sphere "g" { uniform token purpose = "guide"\n }'
    assert len(model_of(write(tmp_path, f'def Cube "c" {{}}\n {guide}')).meshes) == 1
    assert len(model_of(write(tmp_path, guide)).meshes) == 1


def test_the_first_sample_of_an_animation_is_taken(tmp_path: Path) -> None:
    ops = "double3 xformOp:translate.timeSamples = { 3: (5, 0, 0), 9: (7, 0, 0) }\n"
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]\n'
    outcome = read(write(tmp_path, f'def Cube "c" {{ {ops} {order} }}'))
    assert outcome.value is not None
    assert outcome.value.meshes[0].points[:, 0].max() == 6.0
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [("asset/animation-dropped", "info")]


# Implicit shapes.

EXACT = {
    "Cube": ("double size = 3", 27.0, 0.0),
    "Sphere": ("double radius = 2", 4 / 3 * math.pi * 8, 0.01),
    "Cylinder": ('double radius = 0.5\n double height = 3\n uniform token axis = "X"', math.pi * 0.75, 0.003),
    "Cone": ('double radius = 0.5\n double height = 3\n uniform token axis = "Y"', math.pi * 0.25, 0.003),
    "Capsule": ("double radius = 0.5\n double height = 2", math.pi * (0.5 + 0.5 / 3), 0.01),
}


@pytest.mark.parametrize("kind", EXACT)
def test_implicit_shapes_have_the_volume_and_the_box_of_the_exact_shape(tmp_path: Path, kind: str) -> None:
    body, exact, tolerance = EXACT[kind]
    path = write(tmp_path, f'def {kind} "s" {{ {body}\n }}')
    mesh = only_mesh(path)
    assert exact * (1 - tolerance) - 1e-12 <= volume(mesh) <= exact + 1e-12
    stage = Usd.Stage.Open(str(path))
    box = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(stage.GetPrimAtPath("/Root/s")), 0)
    assert np.allclose([mesh.points.min(axis=0), mesh.points.max(axis=0)], np.array(box), atol=1e-6)


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
def test_planes_lie_as_usd_says(tmp_path: Path, axis: str) -> None:
    path = write(
        tmp_path, f'def Plane "s" {{ double width = 4\n double length = 2\n uniform token axis = "{axis}"\n }}'
    )
    mesh = only_mesh(path)
    stage = Usd.Stage.Open(str(path))
    box = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(stage.GetPrimAtPath("/Root/s")), 0)
    assert np.allclose([mesh.points.min(axis=0), mesh.points.max(axis=0)], np.array(box))
    assert np.allclose(area_vector(mesh), 8 * np.eye(3)["XYZ".index(axis)])


@settings(max_examples=30, deadline=None)
@given(
    height=st.floats(0.01, 100),
    bottom=st.floats(0.01, 10),
    top=st.just(0.0) | st.floats(0.01, 10),
    segments=st.sampled_from([4, 12]),
)
def test_bodies_of_revolution_are_closed_and_outward(height: float, bottom: float, top: float, segments: int) -> None:
    for shape in (gprims.cylinder(height, bottom, top, segments), gprims.capsule(height, bottom, bottom, segments)):
        edges = shape.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        forward = {(int(a), int(b)) for a, b in edges}
        assert len(forward) == len(edges)
        assert forward == {(b, a) for a, b in forward}  # every edge is met once from each side
        a, b, c = np.moveaxis(shape.points[shape.triangles], 1, 0)
        normals = np.cross(b - a, c - a)
        assert (np.einsum("fi,fi->f", normals, shape.normals.sum(axis=1)) > 0).all()
        assert np.allclose(np.linalg.norm(shape.normals, axis=2), 1.0)


# Instances.


def test_native_instances_are_read_once_per_place(tmp_path: Path) -> None:
    proto = 'def Xform "P" { def Cube "c" {}\n }'
    copies = "\n".join(
        f'def "i{x}" (instanceable = true\n references = </Root/P>) {{ double3 xformOp:translate = ({x}, 0, 0)\n'
        'uniform token[] xformOpOrder = ["xformOp:translate"]\n }'
        for x in (10, 20)
    )
    meshes = model_of(write(tmp_path, f"{proto}\n {copies}")).meshes
    assert sorted(float(m.points[:, 0].max()) for m in meshes) == [1.0, 11.0, 21.0]


def instancer(count: int) -> str:
    positions = ", ".join(f"({10 * i}, 0, 0)" for i in range(count))
    return f"""def PointInstancer "pi" {{
      rel prototypes = [</Root/pi/Protos/p>]
      int[] protoIndices = [{", ".join("0" * count)}]
      point3f[] positions = [{positions}]
      def Scope "Protos" {{ def Cube "p" {{ float3 xformOp:scale = (2, 1, 1)
        uniform token[] xformOpOrder = ["xformOp:scale"]
      }}
      }}
    }}"""


def test_point_instancers_are_expanded_up_to_a_limit(tmp_path: Path) -> None:
    meshes = model_of(write(tmp_path, instancer(3))).meshes
    assert [float(m.points[:, 0].max()) for m in meshes] == [2.0, 12.0, 22.0]
    assert len({m.name for m in meshes}) == 3
    assert rejection(write(tmp_path, instancer(1001))).code == "asset/resource-limit"


# Materials.


def preview(name: str, inputs: str, nodes: str = "") -> str:
    return f"""def Material "{name}" {{
      token outputs:surface.connect = </Root/{name}/s.outputs:surface>
      def Shader "s" {{ uniform token info:id = "UsdPreviewSurface"
        {inputs}
        token outputs:surface
      }}
      {nodes}
    }}"""


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


def material_of(path: Path) -> Material:
    (material,) = model_of(path).materials
    return material


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
        found = read(write(tmp_path, mesh + f'def {kind} "p" {{}}\n')).diagnostics
        assert [(d.code, d.severity, d.where.prim) for d in found] == [("asset/geometry-left-out", severity, "/Root/p")]


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
    base, metallic = metallic_from_specular(color, (0.04, 0.04, 0.04))
    assert metallic == pytest.approx(0.0, abs=1e-9)
    assert base == pytest.approx(color)
    base, metallic = metallic_from_specular((0.0, 0.0, 0.0), color)
    assert metallic == pytest.approx(1.0, abs=1e-9)
    assert base == pytest.approx(color)


# Articulation, and the shared files.


def test_joints_between_bodies_are_named(tmp_path: Path) -> None:
    body = """def Cube "a" {}\n def Cube "b" {}
      def PhysicsRevoluteJoint "hinge" { rel physics:body0 = </Root/a>\n rel physics:body1 = </Root/b>\n }"""
    (found,) = read(write(tmp_path, body)).diagnostics
    assert (found.code, found.severity, found.value) == ("asset/articulated-source", "warning", "/Root/hinge")
    fixed = body.replace("rel physics:body0 = </Root/a>\n", "")
    assert read(write(tmp_path, fixed)).diagnostics == ()


def shared_rows() -> list[dict[str, str]]:
    if not SHARED.is_dir():
        return []
    with (SHARED / "manifest.csv").open() as file:
        return [row for row in csv.DictReader(file) if row["format"] in ("usd", "usdz")]


@pytest.mark.shared
@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared data folder is absent")
def test_shared_assets_end_as_the_manifest_says() -> None:
    rows = shared_rows()
    assert len(rows) > 20
    for row in rows:
        path = SHARED / row["path"]
        depth = 3 if row["path"].startswith("malformed") else 2
        source = SourceFile(path, SHARED.joinpath(*Path(row["path"]).parts[:depth]))
        if row["outcome"] == "reject":
            with pytest.raises(InvalidInput) as caught:
                read_usd(source)
            assert caught.value.diagnostic.code == "asset/" + row["reason"].replace("_", "-"), row["id"]
            continue
        outcome = read_usd(source)
        assert outcome.value is not None, row["id"]
        assert bool(outcome.repairs) == (row["outcome"] == "repair"), row["id"]
        if row["meters_per_unit"]:
            assert outcome.value.meters_per_unit.value == float(row["meters_per_unit"]), row["id"]
            assert outcome.value.up_axis.value == row["up_axis"], row["id"]
        points = np.concatenate([mesh.points for mesh in outcome.value.meshes])
        measured = np.array([float(part) for part in row["measured_extent_native"].split("x")])
        # The measured boxes also count lights, and the boxes of rotated boxes.
        assert (np.ptp(points, axis=0) <= measured * (1 + 1e-4)).all(), row["id"]


@pytest.mark.shared
@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared data folder is absent")
def test_reading_twice_gives_the_same_model() -> None:
    path = SHARED / "usd" / "uwg_teapot" / "Teapot.usd"
    first, second = (read_usd(SourceFile(path, path.parent)).value for _ in range(2))
    assert first is not None
    assert second is not None
    assert all(np.array_equal(a.points, b.points) for a, b in zip(first.meshes, second.meshes, strict=True))
    assert (first.materials, first.metadata, first.hints) == (second.materials, second.metadata, second.hints)
