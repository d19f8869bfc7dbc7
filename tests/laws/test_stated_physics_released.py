"""What a source states about mass and friction reaches the released package, whatever its frame and unit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade
from scipy.spatial.transform import Rotation

from assetkit.options import Options
from assetkit.package import release
from assetkit.sources.discover import discover
from assetkit.stage import Draft, Previews, Tools
from assetkit.stages.appearance import NormalizeAppearance
from assetkit.stages.canonicalize import Canonicalize
from assetkit.stages.intake import ReadSource
from assetkit.stages.interaction import ProposeParts
from assetkit.stages.physics import AuthorPhysics
from assetkit.stages.semantics import DescribeObject
from schemas.outcome import Repair
from schemas.physics import RigidBody
from sim.fake import FakeSimulator
from tests.support.gltf_files import GltfFile
from tests.support.package_samples import png
from tests.support.present import present
from usdio.reread.body import reread_body

STAGES = (Canonicalize(), NormalizeAppearance(), DescribeObject(), ProposeParts(), AuthorPhysics())
# A box of 20 x 10 x 6 cm with an eccentric mass: metres, kilograms, box frame.
SIZE_M, MASS, CENTRE_M = np.array([0.2, 0.1, 0.06]), 1.7, np.array([0.03, -0.01, 0.005])
MOMENTS = np.array([1.6e-3, 5.5e-3, 6.2e-3])
Y_TO_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def finished(file: Path, options: Options | None = None) -> tuple[Draft, list[str], list[Repair]]:
    """The draft after every stage but previews and acceptance, with all codes and repairs."""
    options = options or Options()
    taken = ReadSource().run(discover([file])[0], options)
    draft = Draft("part", file.name, taken.objects[0])
    codes, repairs = [d.code for d in taken.diagnostics], list(taken.repairs)
    for stage in STAGES:
        outcome = stage.run(draft, Tools(FakeSimulator(), file.parent / "work", options))
        codes += [d.code for d in outcome.diagnostics]
        repairs += outcome.repairs
        draft = replace(draft, **{stage.name: outcome.value})
    return replace(draft, previews=Previews({"thumbnail": png()})), codes, repairs


def released(file: Path) -> RigidBody:
    return reread_body(written(finished(file)[0], file.parent / "out"))


def written(draft: Draft, folder: Path) -> Path:
    """The main USD file of the package of a draft."""
    return release.author(draft, Tools(FakeSimulator(), folder, Options())).main_file


def box_stage(folder: Path, *, up: str = "Z", meters_per_unit: float = 1.0, scale: float = 1.0) -> Usd.Stage:
    """The box below a turned, shifted and scaled body, so that it measures `SIZE_M` whatever the unit."""
    stage = Usd.Stage.CreateNew(str(folder / "part.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, meters_per_unit)
    UsdGeom.SetStageUpAxis(stage, up)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Root").GetPrim())
    holder = UsdGeom.Xform.Define(stage, "/Root/holder")
    holder.AddTranslateOp().Set(Gf.Vec3d(0.4, -0.2, 0.1) / meters_per_unit)
    holder.AddRotateXYZOp().Set(Gf.Vec3f(20, 30, -40))
    holder.AddScaleOp().Set(Gf.Vec3f(scale))
    body = UsdGeom.Xform.Define(stage, "/Root/holder/body")
    UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
    shape = UsdGeom.Cube.Define(stage, "/Root/holder/body/shape")
    shape.CreateSizeAttr(1.0)
    shape.AddScaleOp().Set(Gf.Vec3f(*(float(v) for v in SIZE_M / (meters_per_unit * scale))))
    UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
    return stage


def state(stage: Usd.Stage, *, scale: float = 1.0, moments=MOMENTS, kilograms_per_unit: float = 1.0) -> Path:
    """Author the mass of the box in the units of the stage."""
    unit = UsdGeom.GetStageMetersPerUnit(stage)
    UsdPhysics.SetStageKilogramsPerUnit(stage, kilograms_per_unit)
    api = UsdPhysics.MassAPI.Apply(stage.GetPrimAtPath("/Root/holder/body"))
    api.CreateMassAttr(MASS / kilograms_per_unit)
    api.CreateCenterOfMassAttr(Gf.Vec3f(*(float(v) for v in CENTRE_M / (unit * scale))))
    api.CreateDiagonalInertiaAttr(Gf.Vec3f(*(float(v) for v in np.array(moments) / (kilograms_per_unit * unit**2))))
    api.CreatePrincipalAxesAttr(Gf.Quatf(1.0))
    stage.Save()
    return Path(stage.GetRootLayer().realPath)


def bottom_centre(R_AB: np.ndarray) -> np.ndarray:
    """Of the box turned by R_AB about its centre."""
    corners = np.stack(np.meshgrid(*([-0.5, 0.5],) * 3), axis=-1).reshape(-1, 3) * SIZE_M @ R_AB.T
    low, high = corners.min(axis=0), corners.max(axis=0)
    return np.array([*(0.5 * (low + high))[:2], low[2]])


def expected(stage: Usd.Stage) -> tuple[np.ndarray, np.ndarray]:
    """Mass centre and tensor in the asset frame, worked out from the corners of the box."""
    X_WB = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath("/Root/holder/body"))).T
    R_WB = X_WB[:3, :3] / np.linalg.norm(X_WB[:3, 0])
    R_AB = R_WB if UsdGeom.GetStageUpAxis(stage) == "Z" else Y_TO_Z @ R_WB
    return R_AB @ CENTRE_M - bottom_centre(R_AB), R_AB @ np.diag(MOMENTS) @ R_AB.T


@pytest.mark.parametrize(
    ("up", "meters_per_unit", "scale", "kilograms_per_unit"),
    [("Z", 1.0, 1.0, 1.0), ("Y", 0.01, 1.0, 1.0), ("Y", 0.01, 4.0, 1.0), ("Z", 0.001, 0.5, 0.001)],
    ids=["metres z-up", "centimetres y-up", "below a scale of 4", "millimetres and grams"],
)
def test_stated_mass_centre_and_tensor_are_released(tmp_path, up, meters_per_unit, scale, kilograms_per_unit):
    stage = box_stage(tmp_path, up=up, meters_per_unit=meters_per_unit, scale=scale)
    body = released(state(stage, scale=scale, kilograms_per_unit=kilograms_per_unit))
    centre, inertia = expected(stage)
    assert body.mass.mass_kg == pytest.approx(MASS)
    assert_allclose(body.mass.centre_of_mass_m, centre, atol=1e-6)
    assert_allclose(body.mass.inertia_kgm2, inertia, atol=1e-5 * MOMENTS.max())


def test_a_gltf_body_is_released_as_stated(tmp_path):
    """A turned and scaled node in the y-up frame of glTF."""
    R_WN = Rotation.from_rotvec([0.3, -0.5, 0.8])
    motion = {"mass": MASS, "centerOfMass": (CENTRE_M / 2).tolist(), "inertiaDiagonal": MOMENTS.tolist()}
    file = GltfFile()
    box = trimesh.creation.box(SIZE_M / 2)
    positions = file.accessor(box.vertices.astype("<f4"))
    file.mesh({"POSITION": positions}, indices=file.accessor(box.faces.astype("<u2").reshape(-1)))
    extensions = {"KHR_physics_rigid_bodies": {"motion": motion}}
    file.show({"mesh": 0, "rotation": R_WN.as_quat().tolist(), "scale": [2, 2, 2], "extensions": extensions})
    path = tmp_path / "part.glb"
    path.write_bytes(file.glb())
    body = released(path)
    R_AB = Y_TO_Z @ R_WN.as_matrix()
    assert body.mass.mass_kg == pytest.approx(MASS)
    assert_allclose(body.mass.centre_of_mass_m, R_AB @ CENTRE_M - bottom_centre(R_AB), atol=1e-6)
    assert_allclose(body.mass.inertia_kgm2, R_AB @ np.diag(MOMENTS) @ R_AB.T, atol=1e-5 * MOMENTS.max())


def test_the_record_says_that_they_are_declared(tmp_path):
    draft, codes, repairs = finished(state(box_stage(tmp_path)))
    section = present(draft.physics).section
    assert {section.mass_kg.source, section.centre_of_mass_m.source, section.inertia_kgm2.source} == {"declared"}
    assert section.mass_kg.method.startswith("UsdPhysics mass")
    assert section.mass_kg.inputs == ("part.usda /Root/holder/body",)
    assert section.density_kgm3.value == pytest.approx(MASS / SIZE_M.prod(), rel=1e-6)
    assert not [c for c in codes if "implausible" in c]
    assert repairs == []


def test_a_package_read_as_a_source_keeps_its_physics(tmp_path):
    draft, _, _ = finished(state(box_stage(tmp_path)))
    main_file = written(draft, tmp_path / "out")
    first = reread_body(main_file)
    again, _, repairs = finished(main_file)
    assert repairs == []
    second = present(again.physics)
    assert second.section.mass_kg.source == "declared"
    assert second.section.contacts[0].source == "declared"
    assert second.mass.mass_kg == pytest.approx(first.mass.mass_kg)
    assert_allclose(second.mass.centre_of_mass_m, first.mass.centre_of_mass_m, atol=1e-6)
    assert_allclose(second.mass.inertia_kgm2, first.mass.inertia_kgm2, atol=1e-5 * MOMENTS.max())
    assert second.contact.dynamic_friction == pytest.approx(first.contact.dynamic_friction)


def test_a_placeholder_tensor_is_replaced_and_said(tmp_path):
    draft, codes, repairs = finished(state(box_stage(tmp_path), moments=np.ones(3)))
    assert "asset/source-inertia-implausible" in codes
    assert [r.name for r in repairs] == ["implausible_inertia"]
    physics = present(draft.physics)
    assert physics.section.mass_kg.source == "declared"
    assert physics.section.inertia_kgm2.source == "inferred"
    even = MASS / 12 * (np.sum(SIZE_M**2) - SIZE_M**2)
    assert_allclose(np.linalg.eigvalsh(physics.mass.inertia_kgm2), np.sort(even), rtol=1e-5)


def test_stated_friction_is_released_and_an_impossible_one_is_not(tmp_path):
    stage = box_stage(tmp_path)
    prim = UsdShade.Material.Define(stage, "/Root/grip").GetPrim()
    material = UsdPhysics.MaterialAPI.Apply(prim)
    material.CreateStaticFrictionAttr(0.83)
    material.CreateDynamicFrictionAttr(0.61)
    material.CreateRestitutionAttr(0.05)
    shape = stage.GetPrimAtPath("/Root/holder/body/shape")
    UsdShade.MaterialBindingAPI.Apply(shape).Bind(UsdShade.Material(prim), materialPurpose="physics")
    stage.Save()
    file = Path(stage.GetRootLayer().realPath)
    contact = released(file).contact
    assert (contact.static_friction, contact.dynamic_friction, contact.restitution) == pytest.approx((0.83, 0.61, 0.05))
    material.GetDynamicFrictionAttr().Set(0.9)
    stage.Save()
    draft, codes, repairs = finished(file)
    assert "asset/source-friction-implausible" in codes
    assert "implausible_friction" in [r.name for r in repairs]
    assert present(draft.physics).section.contacts[0].source != "declared"
