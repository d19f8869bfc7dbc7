"""Mass and friction values read from USD files, in the model frame, compared with OpenUSD's own computation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from assetkit.readers.usd import read_usd
from assetkit.sources.source_file import SourceFile
from geom.mass.principal_axes import principal_axes
from schemas.model import Model
from schemas.stated_physics import StatedMass
from tests.support.present import present

_TOKEN = Sdf.ValueTypeNames.Token
TURN = Gf.Rotation(Gf.Vec3d(1, 2, 3), 40.0)


def new_stage(folder: Path, meters_per_unit: float = 1.0) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(folder / "part.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, meters_per_unit)
    UsdGeom.SetStageUpAxis(stage, "Z")
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Root").GetPrim())
    return stage


def cube(stage: Usd.Stage, path: str, *, size: float = 0.2, at: tuple = (0, 0, 0), collider: bool = True) -> Usd.Prim:
    gprim = UsdGeom.Cube.Define(stage, path)
    gprim.CreateSizeAttr(size)
    UsdGeom.XformCommonAPI(gprim).SetTranslate(Gf.Vec3d(*at))
    if collider:
        UsdPhysics.CollisionAPI.Apply(gprim.GetPrim())
    return gprim.GetPrim()


def rigid(prim: Usd.Prim) -> Usd.Prim:
    UsdPhysics.RigidBodyAPI.Apply(prim)
    return prim


def weigh(prim: Usd.Prim, mass: float = 0.0, *, density: float = 0.0, centre=None, moments=None, axes=None) -> None:
    api = UsdPhysics.MassAPI.Apply(prim)
    if mass:
        api.CreateMassAttr(mass)
    if density:
        api.CreateDensityAttr(density)
    if centre is not None:
        api.CreateCenterOfMassAttr(Gf.Vec3f(*centre))
    if moments is not None:
        api.CreateDiagonalInertiaAttr(Gf.Vec3f(*moments))
    if axes is not None:
        api.CreatePrincipalAxesAttr(Gf.Quatf(*axes))


def material(stage: Usd.Stage, name: str, *prims: Usd.Prim, **values: float) -> None:
    prim = UsdShade.Material.Define(stage, f"/Root/{name}").GetPrim()
    api = UsdPhysics.MaterialAPI.Apply(prim)
    for key, value in values.items():
        getattr(api, f"Create{key}Attr")(value)
    for bound in prims:
        UsdShade.MaterialBindingAPI.Apply(bound).Bind(UsdShade.Material(prim), materialPurpose="physics")


def model(stage: Usd.Stage) -> Model:
    stage.Save()
    path = Path(stage.GetRootLayer().realPath)
    value = read_usd(SourceFile(path, path.parent)).value
    assert value is not None
    return value


def only_mass(stage: Usd.Stage) -> StatedMass:
    (stated,) = model(stage).masses
    return stated


def test_a_body_states_mass_centre_and_tensor(tmp_path):
    stage = new_stage(tmp_path)
    body = rigid(stage.GetPrimAtPath("/Root"))
    cube(stage, "/Root/a")
    cube(stage, "/Root/b", at=(0.2, 0, 0))
    weigh(body, 2.5, centre=(0.1, 0, 0.02), moments=(0.01, 0.02, 0.025), axes=(1, 0, 0, 0))
    stated = only_mass(stage)
    assert stated.mass_kg == 2.5
    assert stated.covers == ("/Root/a", "/Root/b")
    assert stated.triangles == 24
    assert stated.where.prim == "/Root"
    assert_allclose(present(stated.centre), [0.1, 0, 0.02], atol=1e-8)
    assert_allclose(present(stated.inertia), np.diag([0.01, 0.02, 0.025]), atol=1e-9)


def test_nested_turned_and_scaled_bodies_agree_with_openusd(tmp_path):
    """`ComputeMassProperties` answers in the body's rigid frame: centre scaled, tensor as authored."""
    stage = new_stage(tmp_path, meters_per_unit=0.01)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 0.5)
    outer = UsdGeom.Xform.Define(stage, "/Root/outer")
    outer.AddTranslateOp().Set(Gf.Vec3d(3, -2, 7))
    outer.AddOrientOp().Set(Gf.Quatf(TURN.GetQuat()))
    outer.AddScaleOp().Set(Gf.Vec3f(2, 2, 2))
    inner = UsdGeom.Xform.Define(stage, "/Root/outer/inner")
    inner.AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))
    inner.AddRotateZOp().Set(30.0)
    prim = rigid(inner.GetPrim())
    shape = cube(stage, "/Root/outer/inner/shape", size=8.0)
    half = np.sqrt(0.5)
    weigh(prim, 3.0, centre=(0.5, 1.0, -0.5), moments=(40.0, 50.0, 60.0), axes=(half, 0, 0, half))
    stated = only_mass(stage)

    mass, moments, centre, axes = UsdPhysics.RigidBodyAPI(prim).ComputeMassProperties(_unit_information)
    rigid_pose = Gf.Transform(UsdGeom.XformCache().GetLocalToWorldTransform(prim))
    R_WB = np.array(Gf.Matrix3d(rigid_pose.GetRotation())).T
    R_BP = np.array(Gf.Matrix3d(Gf.Rotation(Gf.Quatd(axes)))).T
    assert stated.covers == (str(shape.GetPath()),)
    assert stated.mass_kg == pytest.approx(0.5 * mass)
    assert_allclose(present(stated.centre), R_WB @ np.array(centre) + np.array(rigid_pose.GetTranslation()), atol=1e-5)
    assert_allclose(
        present(stated.inertia), 0.5 * R_WB @ R_BP @ np.diag(moments) @ R_BP.T @ R_WB.T, rtol=1e-5, atol=1e-4
    )
    assert_allclose(principal_axes(present(stated.inertia))[0], [20, 25, 30], rtol=1e-5)


def _unit_information(_: Usd.Prim) -> UsdPhysics.RigidBodyAPI.MassInformation:
    info = UsdPhysics.RigidBodyAPI.MassInformation()
    info.volume, info.inertia, info.centerOfMass = 1.0, Gf.Matrix3f(1.0), Gf.Vec3f(0.0)
    info.localPos, info.localRot = Gf.Vec3f(0.0), Gf.Quatf(1.0)
    return info


def test_a_mirrored_body_has_a_mirrored_tensor(tmp_path):
    stage = new_stage(tmp_path)
    prim = UsdGeom.Xform.Define(stage, "/Root/mirrored")
    prim.AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))
    cube(stage, "/Root/mirrored/shape")
    half = np.deg2rad(15)
    weigh(rigid(prim.GetPrim()), 1.0, centre=(0.05, 0, 0), moments=(1, 2, 2.5), axes=(np.cos(half), 0, 0, np.sin(half)))
    stated = only_mass(stage)
    c, s = np.cos(2 * half), np.sin(2 * half)
    turned = (
        np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        @ np.diag([1, 2, 2.5])
        @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    )
    mirror = np.diag([-1.0, 1.0, 1.0])
    assert_allclose(present(stated.centre), [-0.05, 0, 0], atol=1e-8)
    assert_allclose(present(stated.inertia), mirror @ turned @ mirror, atol=1e-6)


def test_zero_means_not_stated_and_absurd_values_are_passed_on(tmp_path):
    stage = new_stage(tmp_path)
    body = rigid(stage.GetPrimAtPath("/Root"))
    cube(stage, "/Root/a")
    api = UsdPhysics.MassAPI.Apply(body)
    api.CreateMassAttr(0.0)
    api.CreateDiagonalInertiaAttr(Gf.Vec3f(0.0))
    assert model(stage).masses == ()
    api.GetMassAttr().Set(-1.0)
    assert only_mass(stage).mass_kg == -1.0
    assert only_mass(stage).inertia is None
    assert only_mass(stage).centre is None


def test_the_body_outweighs_its_colliders_and_colliders_speak_for_themselves(tmp_path):
    stage = new_stage(tmp_path)
    body = rigid(stage.GetPrimAtPath("/Root"))
    weigh(cube(stage, "/Root/a"), 1.0)
    weigh(cube(stage, "/Root/b", at=(1, 0, 0)), 2.0, centre=(0.05, 0, 0))
    assert [(m.covers, m.mass_kg) for m in model(stage).masses] == [(("/Root/a",), 1.0), (("/Root/b",), 2.0)]
    assert_allclose(present(model(stage).masses[1].centre), [1.05, 0, 0], atol=1e-7)
    weigh(body, 7.0)
    assert [(m.covers, m.mass_kg) for m in model(stage).masses] == [(("/Root/a", "/Root/b"), 7.0)]


def test_the_nearest_density_counts_before_that_of_the_material(tmp_path):
    stage = new_stage(tmp_path)
    body = rigid(stage.GetPrimAtPath("/Root"))
    prims = [cube(stage, f"/Root/{name}", at=(i, 0, 0)) for i, name in enumerate("abc")]
    material(stage, "iron", prims[0], prims[1], Density=7800.0)
    weigh(prims[0], density=100.0)
    density_of = {m.covers: m.density for m in model(stage).masses}
    assert density_of == {("/Root/a",): 100.0, ("/Root/b",): 7800.0}
    weigh(body, density=500.0)
    assert {m.covers: m.density for m in model(stage).masses} == {("/Root/a",): 100.0, ("/Root/b", "/Root/c"): 500.0}


def test_hidden_colliders_speak_for_the_surfaces_of_their_body(tmp_path):
    stage = new_stage(tmp_path)
    rigid(stage.GetPrimAtPath("/Root"))
    cube(stage, "/Root/seen", collider=False)
    hidden = [cube(stage, f"/Root/hull_{i}", at=(i, 0, 0)) for i in (0, 2)]
    for prim in hidden:
        UsdGeom.Imageable(prim).CreatePurposeAttr(UsdGeom.Tokens.guide)
    material(stage, "felt", *hidden, Density=300.0, StaticFriction=0.8)
    stated = only_mass(stage)
    assert (stated.covers, stated.density) == (("/Root/seen",), 300.0)
    assert model(stage).contacts[0].covers == ("/Root/seen",)
    weigh(hidden[0], 1.0, centre=(0, 0, 0))
    assert model(stage).masses == ()  # One states a mass, the other a density: the sum is unknown.
    weigh(hidden[1], 3.0, centre=(0, 0, 0))
    stated = only_mass(stage)
    assert stated.mass_kg == 4.0
    assert_allclose(present(stated.centre), [1.5, 0, 0])


def test_a_body_within_a_body_is_its_own(tmp_path):
    stage = new_stage(tmp_path)
    weigh(rigid(stage.GetPrimAtPath("/Root")), 5.0)
    cube(stage, "/Root/a")
    weigh(rigid(UsdGeom.Xform.Define(stage, "/Root/inner").GetPrim()), 2.0)
    cube(stage, "/Root/inner/b", at=(0.2, 0, 0))
    assert {m.covers: m.mass_kg for m in model(stage).masses} == {("/Root/a",): 5.0, ("/Root/inner/b",): 2.0}


def test_contact_materials_are_read_as_far_as_authored(tmp_path):
    stage = new_stage(tmp_path)
    rigid(stage.GetPrimAtPath("/Root"))
    prim = cube(stage, "/Root/a")
    material(stage, "grip", prim, StaticFriction=0.9, DynamicFriction=0.7, Restitution=0.0)
    stage.GetPrimAtPath("/Root/grip").CreateAttribute("physxMaterial:frictionCombineMode", _TOKEN).Set("min")
    (contact,) = model(stage).contacts
    assert (contact.static_friction, contact.dynamic_friction, contact.restitution) == pytest.approx((0.9, 0.7, 0.0))
    assert (contact.combine, contact.name, contact.covers) == ("minimum", "grip", ("/Root/a",))


def test_a_file_without_physics_states_nothing(tmp_path):
    stage = new_stage(tmp_path)
    cube(stage, "/Root/a", collider=False)
    assert (model(stage).masses, model(stage).contacts) == ((), ())
