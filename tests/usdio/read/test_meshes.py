"""Meshes of USD files: faces, sides, coordinates, colours, subsets, implicit shapes, instances."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf, Usd, UsdGeom, Vt

from geom.mesh import primitives
from tests.support.present import present
from tests.support.usd_files import (
    QUAD,
    area_vector,
    corners,
    model_of,
    only_mesh,
    preview,
    read,
    rejection,
    volume,
    write,
)

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
    shape = primitives.cube(2.0)
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
    diagnostic = rejection(write(tmp_path, f'def Mesh "m" {{ {QUAD.replace(old, new)} }}'))
    assert diagnostic.code == code
    assert diagnostic.where.prim == "/Root/m"


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
    assert np.allclose(present(outcome.value.meshes[0].normals), [0, 0, 1])
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
    for shape in (
        primitives.cylinder(height, bottom, top, segments),
        primitives.capsule(height, bottom, bottom, segments),
    ):
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
