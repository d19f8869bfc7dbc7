"""Packages of other makers: other words for a body give the same body, assumptions are findings, the rest is a code."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import trimesh
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from geom.convex.hull import volume
from geom.convex.support_function import bounds
from schemas.diagnostics import Diagnostic, InvalidInput
from tests.support.gate_packages import cabinet, prop
from tests.support.present import present
from usdio.reread.body import reread_package
from usdio.reread.foreign import ForeignPackage, reread_foreign

EDGE = 0.1
DENSITY, MASS = 400.0, 0.4  # of a cube of that edge
INERTIA = MASS * EDGE**2 / 6.0


class Maker:
    """A stage with one rigid cube of 0.1 m on the ground, 400 kg/m3, in any unit, up axis and place of the file."""

    def __init__(self, metres: float = 1.0, up: str = "Z", body: str = "/Thing") -> None:
        self.stage = Usd.Stage.CreateInMemory()
        self.metres, self.up = metres, up
        UsdGeom.SetStageMetersPerUnit(self.stage, metres)
        UsdGeom.SetStageUpAxis(self.stage, up)
        self.stage.SetDefaultPrim(UsdGeom.Xform.Define(self.stage, "/Thing").GetPrim())
        self.body = UsdGeom.Xform.Define(self.stage, body).GetPrim()
        UsdPhysics.RigidBodyAPI.Apply(self.body)

    def at(self, x: float, y: float, z: float) -> Gf.Vec3d:
        """A point given in metres, z up, in words of the stage."""
        return Gf.Vec3d(*(v / self.metres for v in ((x, y, z) if self.up == "Z" else (y, z, x))))

    def cube(self, name: str = "shape", x: float = 0.0) -> Usd.Prim:
        cube = UsdGeom.Cube.Define(self.stage, self.body.GetPath().AppendChild(name))
        cube.CreateSizeAttr(EDGE / self.metres)
        cube.AddTranslateOp().Set(self.at(x, 0.0, EDGE / 2))
        return self.collide(cube.GetPrim())

    def mesh(self, points, counts, indices, approximation: str) -> Usd.Prim:
        mesh = UsdGeom.Mesh.Define(self.stage, self.body.GetPath().AppendChild("shape"))
        mesh.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in points])
        mesh.CreateFaceVertexCountsAttr(list(counts))
        mesh.CreateFaceVertexIndicesAttr([int(i) for i in indices])
        UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr(approximation)
        return self.collide(mesh.GetPrim())

    def collide(self, prim: Usd.Prim) -> Usd.Prim:
        UsdPhysics.CollisionAPI.Apply(prim)
        return prim

    def weigh(self, prim: Usd.Prim | None = None, density: float = 0.0, mass: float = 0.0) -> None:
        api = UsdPhysics.MassAPI.Apply(prim or self.body)
        if density:
            api.CreateDensityAttr(density)
        if mass:
            api.CreateMassAttr(mass)

    def rub(self, prim: Usd.Prim, friction: float | None = 0.7) -> UsdPhysics.MaterialAPI:
        material = UsdShade.Material.Define(self.stage, "/Thing/Rubber")
        api = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
        if friction is not None:
            api.CreateStaticFrictionAttr(friction)
            api.CreateDynamicFrictionAttr(friction)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, materialPurpose="physics")
        return api

    def read(self, folder: Path) -> ForeignPackage:
        file = folder / "thing.usda"
        self.stage.Export(str(file))
        return reread_foreign(file)


def complete(**fields) -> Maker:
    maker = Maker(**fields)
    maker.rub(maker.cube())
    maker.weigh(density=DENSITY * maker.metres**3)
    return maker


def about(findings: tuple[Diagnostic, ...], word: str) -> list[Diagnostic]:
    return [f for f in findings if word in f.headline]


def test_a_package_of_mana_reads_as_its_own_reader_has_it(tmp_path: Path) -> None:
    file = prop(tmp_path)
    ours, theirs = reread_package(file), reread_foreign(file)
    assert theirs.findings == ()
    assert theirs.content.shape_contacts == ours.shape_contacts
    np.testing.assert_array_equal(theirs.content.visual_points, ours.visual_points)
    np.testing.assert_array_equal(theirs.content.visual_triangles, ours.visual_triangles)
    assert (ours.body.name, ours.body.contact) == (theirs.content.body.name, theirs.content.body.contact)
    np.testing.assert_allclose(bounds(theirs.content.body.shapes), bounds(ours.body.shapes), atol=1e-9)
    np.testing.assert_allclose(
        theirs.content.body.mass.inertia_kgm2, ours.body.mass.inertia_kgm2, rtol=1e-9, atol=1e-15
    )
    np.testing.assert_allclose(theirs.content.body.mass.centre_of_mass_m, ours.body.mass.centre_of_mass_m, atol=1e-12)


def test_joints_are_read_and_what_holds_the_base_is_left_out(tmp_path: Path) -> None:
    read = reread_foreign(cabinet(tmp_path))
    mechanism = read.content.mechanism
    assert mechanism is not None
    assert [link.name for link in mechanism.links] == [body.name for body in read.content.links]
    assert {(j.name, j.kind, j.parent, j.child) for j in mechanism.joints} == {
        ("slide", "prismatic", "base", "drawer"),
        ("hinge", "revolute", "base", "door"),
    }
    (note,) = about(read.findings, "fixes a body to the world")
    assert note.code == "asset/foreign-converted"
    np.testing.assert_allclose(bounds(read.content.body.shapes)[1, 2], 0.8, atol=1e-6)


def test_joints_on_bodies_that_are_turned_and_scaled_are_where_the_stage_has_them(tmp_path: Path) -> None:
    maker = complete()
    maker.body.RemoveAPI(UsdPhysics.RigidBodyAPI)
    maker.stage.RemovePrim("/Thing/shape")
    for name, x in (("left", 0.0), ("right", 0.3)):
        cube = UsdGeom.Cube.Define(maker.stage, f"/Thing/{name}")
        cube.CreateSizeAttr(1.0)
        cube.AddTranslateOp().Set(Gf.Vec3d(x, 0.0, 0.1))
        cube.AddRotateZOp().Set(90.0)
        cube.AddScaleOp().Set(Gf.Vec3f(0.1, 0.2, 0.2))  # 0.2 along x, 0.1 along y of the stage
        UsdPhysics.RigidBodyAPI.Apply(maker.collide(cube.GetPrim()))
        maker.weigh(cube.GetPrim(), mass=1.0)
    joint = UsdPhysics.RevoluteJoint.Define(maker.stage, "/Thing/hinge")
    joint.CreateBody0Rel().SetTargets(["/Thing/left"])
    joint.CreateBody1Rel().SetTargets(["/Thing/right"])
    joint.CreateAxisAttr("Y")  # of the bodies: -x of the stage
    joint.CreateLocalPos0Attr(Gf.Vec3f(0.0, -0.75, 0.0))
    joint.CreateLocalPos1Attr(Gf.Vec3f(0.0, 0.75, 0.0))
    (hinge,) = present(maker.read(tmp_path).content.mechanism).joints
    np.testing.assert_allclose(hinge.axis, [-1.0, 0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(hinge.anchor, [0.0, 0.0, 0.1], atol=1e-6)  # in the middle of both


@pytest.mark.parametrize(("metres", "up"), [(1.0, "Z"), (0.01, "Z"), (1.0, "Y"), (0.01, "Y")])
def test_units_and_up_axis_are_scaled_and_turned_into_metres_and_z(metres: float, up: str, tmp_path: Path) -> None:
    read = complete(metres=metres, up=up).read(tmp_path)
    body = read.content.body
    np.testing.assert_allclose(bounds(body.shapes), [[-0.05, -0.05, 0.0], [0.05, 0.05, 0.1]], atol=1e-6)
    assert body.mass.mass_kg == pytest.approx(MASS, rel=1e-5)
    np.testing.assert_allclose(body.mass.inertia_kgm2, INERTIA * np.eye(3), rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(read.content.visual_points.max(axis=0), [0.05, 0.05, 0.1], atol=1e-6)
    assert bool(about(read.findings, "unit of length")) == (metres != 1.0)
    assert bool(about(read.findings, "is up")) == (up != "Z")


def test_stated_mass_centre_and_inertia_are_converted_with_the_units(tmp_path: Path) -> None:
    maker = complete(metres=0.01, up="Y")
    api = UsdPhysics.MassAPI(maker.body)
    api.CreateMassAttr(2.0)
    api.CreateCenterOfMassAttr(Gf.Vec3f(maker.at(0.01, 0.02, 0.03)))
    api.CreateDiagonalInertiaAttr(Gf.Vec3f(10.0, 20.0, 30.0))  # kg cm2, axes of the stage: its y is our z
    mass = maker.read(tmp_path).content.body.mass
    assert mass.mass_kg == 2.0
    np.testing.assert_allclose(np.sort(np.diag(mass.inertia_kgm2)), [1e-3, 2e-3, 3e-3], rtol=1e-6)
    assert mass.inertia_kgm2[2, 2] == pytest.approx(2e-3)
    assert mass.centre_of_mass_m[2] == pytest.approx(0.03)


def test_friction_that_no_material_states_is_assumed_and_said(tmp_path: Path) -> None:
    maker = Maker()
    maker.cube()
    maker.weigh(density=DENSITY)
    read = maker.read(tmp_path)
    assert (read.content.body.contact.static_friction, read.content.body.contact.restitution) == (0.5, 0.0)
    (said,) = about(read.findings, "friction 0.5")
    assert (said.code, said.severity) == ("asset/foreign-assumed", "warning")


def test_a_material_without_friction_has_that_of_the_schema(tmp_path: Path) -> None:
    maker = Maker()
    maker.rub(maker.cube(), friction=None)
    maker.weigh(density=DENSITY)
    read = maker.read(tmp_path)
    assert read.content.body.contact.dynamic_friction == 0.0
    assert len(about(read.findings, "states no staticFriction and no dynamicFriction")) == 1


def on_body(maker: Maker) -> None:
    maker.weigh(mass=3.0)
    maker.weigh(maker.stage.GetPrimAtPath("/Thing/shape"), density=7.0)


def on_collider(maker: Maker) -> None:
    maker.weigh(density=7.0)
    maker.weigh(maker.stage.GetPrimAtPath("/Thing/shape"), density=DENSITY)


def collider_mass(maker: Maker) -> None:
    maker.weigh(maker.stage.GetPrimAtPath("/Thing/shape"), mass=5.0)


def of_material(maker: Maker) -> None:
    UsdPhysics.MaterialAPI(maker.stage.GetPrimAtPath("/Thing/Rubber")).CreateDensityAttr(600.0)


@pytest.mark.parametrize(
    ("state", "mass_kg", "words"),
    [
        (on_body, 3.0, "no mass centre and no inertia"),
        (on_collider, MASS, "density 400 kg/m3 of 'shape'"),
        (collider_mass, 5.0, "masses of colliders"),
        (of_material, 0.6, "density 600 kg/m3 of the material 'Rubber'"),
        (lambda maker: None, 1.0, "1000 kg/m3 that UsdPhysics takes"),
    ],
)
def test_mass_follows_the_rules_of_usd_physics(
    state: Callable[[Maker], None], mass_kg: float, words: str, tmp_path: Path
) -> None:
    maker = Maker()
    maker.rub(maker.cube())
    state(maker)
    read = maker.read(tmp_path)
    assert read.content.body.mass.mass_kg == pytest.approx(mass_kg, rel=1e-5)
    np.testing.assert_allclose(read.content.body.mass.inertia_kgm2, mass_kg * EDGE**2 / 6.0 * np.eye(3), rtol=1e-4)
    assert [f.code for f in about(read.findings, words)] == ["asset/foreign-assumed"]


def test_a_body_below_the_default_prim_that_is_turned_keeps_its_place(tmp_path: Path) -> None:
    maker = Maker(body="/Thing/Deep/Body")
    UsdGeom.Xformable(maker.stage.GetPrimAtPath("/Thing")).AddTranslateOp().Set(Gf.Vec3d(1.0, 2.0, 3.0))
    UsdGeom.Xformable(maker.body).AddRotateZOp().Set(90.0)
    maker.rub(maker.cube(x=0.2))
    maker.cube("other", x=-0.2)
    maker.weigh(density=DENSITY)
    read = maker.read(tmp_path)
    np.testing.assert_allclose(bounds(read.content.body.shapes), [[-0.05, -0.25, 0.0], [0.05, 0.25, 0.1]], atol=1e-6)
    np.testing.assert_allclose(read.content.body.mass.centre_of_mass_m, [0.0, 0.0, 0.05], atol=1e-6)
    assert about(read.findings, "bottom centre")
    assert about(read.findings, "1 of 2 colliders have no contact material")


QUADS = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]
CORNERS = [(x, y, z) for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (0.0, 0.1)]
BALL = trimesh.creation.icosphere(subdivisions=3, radius=0.05)
_SLABS = [
    trimesh.creation.box(bounds=[[0, 0, 0], [0.2, 0.1, 0.02]]),
    trimesh.creation.box(bounds=[[0, 0, 0.03], [0.02, 0.1, 0.2]]),
]
ANGLE = cast(trimesh.Trimesh, trimesh.util.concatenate(_SLABS))


@pytest.mark.parametrize(
    ("source", "approximation", "kinds"),
    [
        (None, "convexHull", ["hull"]),
        (None, "none", ["hull"]),
        (ANGLE, "convexHull", ["hull"]),
        (ANGLE, "boundingCube", ["box"]),
        (ANGLE, "boundingSphere", ["sphere"]),
        (ANGLE, "convexDecomposition", ["hull", "hull"]),
        (BALL, "convexHull", ["hull"]),
    ],
)
def test_meshes_become_what_their_approximation_names(source, approximation: str, kinds: list, tmp_path: Path) -> None:
    maker = Maker()
    if source is None:
        prim = maker.mesh(CORNERS, [4] * 6, QUADS, approximation)
    else:
        prim = maker.mesh(source.vertices, [3] * len(source.faces), source.faces.ravel(), approximation)
    maker.rub(prim)
    maker.weigh(mass=1.0)
    read = maker.read(tmp_path)
    shapes = read.content.body.shapes
    assert [shape.kind for shape in shapes] == kinds
    points = np.array(CORNERS) if source is None else source.vertices
    if approximation != "boundingSphere":
        np.testing.assert_allclose(np.ptp(bounds(shapes), axis=0), np.ptp(points, axis=0), atol=0.005)
    assert all(shape.points is None or len(shape.points) <= 64 for shape in shapes)
    assert all(f.code == "asset/foreign-converted" for f in about(read.findings, "collider 'shape'"))
    if kinds != ["hull"] or source is not None:
        assert about(read.findings, "'shape'")


def test_colliders_in_an_instance_count(tmp_path: Path) -> None:
    maker = Maker()
    UsdGeom.Xform.Define(maker.stage, "/Template")
    cube = UsdGeom.Cube.Define(maker.stage, "/Template/cube")
    cube.CreateSizeAttr(EDGE)
    maker.collide(cube.GetPrim())
    part = UsdGeom.Xform.Define(maker.stage, "/Thing/part").GetPrim()
    part.GetReferences().AddInternalReference(Sdf.Path("/Template"))
    part.SetInstanceable(True)
    maker.weigh(mass=1.0)
    assert len(maker.read(tmp_path).content.body.shapes) == 1


def test_lines_of_grasps_come_in_the_frame_of_the_asset(tmp_path: Path) -> None:
    maker = complete(metres=0.01, up="Y")
    line = UsdGeom.BasisCurves.Define(maker.stage, "/Thing/grasp_identifier_01")
    line.CreatePointsAttr([Gf.Vec3f(maker.at(-0.06, 0.0, 0.05)), Gf.Vec3f(maker.at(0.06, 0.0, 0.05))])
    frame = UsdGeom.Xform.Define(maker.stage, "/Thing/grasp_identifier_02")
    child = UsdGeom.BasisCurves.Define(maker.stage, frame.GetPath().AppendChild("line"))
    child.CreatePointsAttr([Gf.Vec3f(maker.at(0.0, -0.06, 0.05)), Gf.Vec3f(maker.at(0.0, 0.06, 0.05))])
    UsdGeom.BasisCurves.Define(maker.stage, "/Thing/grasp_identifier_03").CreatePointsAttr([Gf.Vec3f(0.0)])
    read = maker.read(tmp_path)
    lines = np.array(read.grasp_lines_m)
    assert lines.shape == (2, 2, 3)
    np.testing.assert_allclose(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1), 0.12, rtol=1e-5)
    np.testing.assert_allclose(lines[..., 2], 0.05, atol=1e-6)
    assert len(about(read.findings, "without a line of two points")) == 1


def two_bodies(maker: Maker) -> None:
    maker.rub(maker.cube())
    UsdPhysics.RigidBodyAPI.Apply(UsdGeom.Xform.Define(maker.stage, "/Thing/Other").GetPrim())
    maker.collide(UsdGeom.Cube.Define(maker.stage, "/Thing/Other/shape").GetPrim())


def not_moving(maker: Maker) -> None:
    maker.cube()
    UsdPhysics.RigidBodyAPI(maker.body).CreateRigidBodyEnabledAttr(False)


def nan_mass(maker: Maker) -> None:
    maker.cube()
    maker.weigh(mass=float("nan"))


def concave(maker: Maker) -> None:
    maker.mesh(ANGLE.vertices, [3] * len(ANGLE.faces), ANGLE.faces.ravel(), "none")


def on_a_group(maker: Maker) -> None:
    maker.collide(UsdGeom.Xform.Define(maker.stage, "/Thing/group").GetPrim())


def flat(maker: Maker) -> None:
    maker.mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [3], [0, 1, 2], "convexHull")


def negative_friction(maker: Maker) -> None:
    maker.rub(maker.cube(), friction=-1.0)
    maker.weigh(mass=1.0)


@pytest.mark.parametrize(
    ("author", "words"),
    [
        (two_bodies, "2 bodies without joints"),
        (not_moving, "no rigid body that moves"),
        (nan_mass, "is no number"),
        (concave, "not convex, with approximation 'none'"),
        (on_a_group, "a collider of type 'Xform'"),
        (flat, "spans no volume"),
        (lambda maker: None, "a body without colliders"),
        (negative_friction, "friction or restitution is no number"),
    ],
)
def test_what_cannot_be_exercised_is_refused_with_the_reason(
    author: Callable[[Maker], None], words: str, tmp_path: Path
) -> None:
    maker = Maker()
    author(maker)
    with pytest.raises(InvalidInput) as refused:
        maker.read(tmp_path)
    assert refused.value.diagnostic.code == "asset/foreign-unsupported"
    assert words in refused.value.diagnostic.headline


def test_mirrored_colliders_stay_outward_and_proper(tmp_path: Path) -> None:
    maker = Maker()
    UsdGeom.Xformable(maker.body).AddScaleOp().Set(Gf.Vec3f(-1.0, 1.0, 1.0))
    maker.rub(maker.mesh(CORNERS, [4] * 6, QUADS, "none"))
    UsdGeom.Xformable(maker.cube("cube", x=0.3)).AddRotateZOp().Set(30.0)
    maker.weigh(density=DENSITY)
    shapes = maker.read(tmp_path).content.body.shapes
    assert {shape.kind for shape in shapes} == {"hull", "box"}
    for shape in shapes:
        if shape.points is None:
            assert np.linalg.det(shape.X_AS[:3, :3]) == pytest.approx(1.0)
            along_x = np.abs(shape.X_AS[:3, :3] @ [1.0, 0.0, 0.0])
            assert along_x.max() == pytest.approx(np.cos(np.radians(30.0)), abs=1e-6)
        else:
            assert volume(shape.points, present(shape.triangles)) == pytest.approx(0.2 * 0.1 * 0.1, rel=1e-5)
