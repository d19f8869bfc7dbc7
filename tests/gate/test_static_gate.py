"""The static gate on clean packages, on files Mana did not make, and on broken ones."""

from __future__ import annotations

import random
import re
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pxr import Usd, UsdGeom, UsdPhysics

from gate.rules.collider import collider_cavity
from gate.static_gate import RULES, gate
from gate.subject import Subject
from geom.convex.penetration import box_overlap, penetration_depth, shared_volume
from geom.solid.solid_volume import volume_properties
from schemas.diagnostics import Diagnostic
from schemas.package import PackageContent
from schemas.physics import Solid
from tests.support import package_samples as samples
from tests.support.bad_inputs.assets import joined
from tests.support.gate_packages import cabinet
from tests.support.mechanism.mechanism_samples import JOINTS, LINKS, articulated
from tests.support.present import present
from usdio.stage import open_stage
from usdio.write.package import write_package


def errors(findings: tuple[Diagnostic, ...]) -> list[str]:
    return [f"{d.code} {d.headline} {d.where} {d.value} {d.bound}" for d in findings if d.severity == "error"]


def convex_package(shape: trimesh.Trimesh, density_kgm3: float) -> PackageContent:
    """A package of one solid as the pipeline would make it: bottom centre at the origin, hull collider, real mass."""
    low, high = shape.bounds
    shape.apply_translation([*(-0.5 * (low + high)[:2]), -low[2]])
    mesh = samples.mesh_from(shape, "solid")
    mass = volume_properties(Solid(mesh.points, mesh.triangles, "closed"))[0].filled(density_kgm3)
    content = samples.content(samples.model([mesh]), [samples.hull_shape(mesh)])
    return samples.replace(content, mass=mass, density_kgm3=density_kgm3)


@settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    corners=st.integers(8, 40),
    seed=st.integers(0, 2**32 - 1),
    size_m=st.floats(np.log(0.004), np.log(4.0)).map(np.exp),
    flatness=st.floats(0.05, 1.0),
    density_kgm3=st.floats(np.log(8.0), np.log(11000.0)).map(np.exp),
)
def test_convex_solids_of_any_size_and_material_pass(
    corners: int,
    seed: int,
    size_m: float,
    flatness: float,
    density_kgm3: float,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    cloud = np.random.default_rng(seed).normal(size=(corners, 3))
    cloud *= size_m / np.ptp(cloud, axis=0).max() * np.array([1.0, 1.0, flatness])
    content = convex_package(trimesh.convex.convex_hull(cloud), density_kgm3)
    assert gate(write_package(content, tmp_path_factory.mktemp("solid") / content.asset_id)) == ()


@pytest.mark.parametrize(
    ("shape", "density_kgm3"),
    [
        (trimesh.creation.box((0.3, 0.2, 0.001)), 700.0),
        (trimesh.creation.box((0.01, 0.01, 1.8)), 7800.0),
        (trimesh.creation.icosphere(1, 0.02), 80.0),
        (trimesh.creation.cylinder(0.2, 0.9, sections=24), 7800.0),
    ],
    ids=["sheet of card", "steel rod", "ball of foam", "steel drum"],
)
def test_everyday_extremes_pass(shape: trimesh.Trimesh, density_kgm3: float, tmp_path: Path) -> None:
    content = convex_package(shape, density_kgm3)
    assert gate(write_package(content, tmp_path / content.asset_id)) == ()


def test_hollow_things_pass(tmp_path: Path) -> None:
    """A cardboard box of 4 mm walls: its inertia is 1.6 times, its mass a ninth of that of the full box."""
    outer, inner = trimesh.creation.box((0.4, 0.3, 0.25)), trimesh.creation.box((0.392, 0.292, 0.242))
    inner.invert()
    for part in (outer, inner):
        part.apply_translation((0.0, 0.0, 0.125))
    wall = joined(outer, inner)
    mesh = samples.mesh_from(wall, "wall")
    mass = volume_properties(Solid(mesh.points, mesh.triangles, "closed"))[0].filled(150.0)
    content = samples.content(samples.model([mesh]), [samples.hull_shape(samples.mesh_from(outer))])
    content = samples.replace(content, mass=mass, density_kgm3=150.0)
    assert gate(write_package(content, tmp_path / content.asset_id)) == ()


@pytest.mark.parametrize("scale", [0.4, 1.0, 2.5])
def test_cabinets_of_any_size_pass(scale: float, tmp_path: Path) -> None:
    assert gate(cabinet(tmp_path, scale)) == ()


def mechanism_package(folder: Path, **changes: object) -> Path:
    """The small mechanism of the tests, its tray moved into its door."""
    content = articulated()
    shift = np.subtract(LINKS[1][1], LINKS[2][1]) * 0.9
    meshes = [samples.replace(m, points=m.points + shift * (m.link == "tray")) for m in content.model.meshes]
    shapes = tuple(samples.hull_shape(mesh) for mesh in meshes)
    moved = samples.replace(content, model=samples.model(meshes), shapes=shapes)
    return write_package(samples.replace(moved, **changes), folder / content.asset_id)


def test_links_that_a_filtered_pair_names_may_overlap(tmp_path: Path) -> None:
    def severities(package: Path) -> list[str]:
        return [d.severity for d in gate(package) if d.code == "asset/gate-links-overlap"]

    assert severities(mechanism_package(tmp_path / "filtered")) == ["warning"]
    assert severities(mechanism_package(tmp_path / "colliding", filtered_pairs=())) == ["error"]


def test_a_hinge_at_rest_beyond_half_a_turn_is_at_its_angle(tmp_path: Path) -> None:
    mechanism = present(articulated().mechanism)
    hinge = samples.replace(JOINTS[0], rest=3.6, limits=(3.5, 5.0), spring_rest=3.5)
    joints = (hinge, samples.replace(JOINTS[1], coupling=None), JOINTS[2])
    package = mechanism_package(tmp_path, mechanism=samples.replace(mechanism, joints=joints))
    (joint,) = (j for j in Subject(open_stage(package), package).joints if j.path.endswith("/hinge"))
    assert present(joint.rest()).coordinate == pytest.approx(np.degrees(3.6), abs=1e-3)
    assert "asset/gate-joint-rest" not in [d.code for d in gate(package)]


def test_real_foreign_files_have_no_false_error(shared_assets: Path) -> None:
    """Files of others that load and simulate: what they lack to be a package is at most a warning."""
    for name in ("nwt_cartpole_usda/cartpole.usda", "nwt_fourbar_usda/boxes_fourbar.usda", "uwg_teapot/Teapot.usd"):
        assert errors(gate(shared_assets / "usd" / name)) == []
    for file in (shared_assets / "usdz").glob("*/*.usdz"):
        assert errors(gate(file)) == []


def test_centimetres_and_y_up_are_converted_not_refused(tmp_path: Path) -> None:
    """A steel ball of 5 cm, 0.51 kg, in a file that is y-up and in centimetres: nothing about it is wrong."""
    file = tmp_path / "ball.usda"
    stage = Usd.Stage.CreateNew(str(file))
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, "Y")
    ball = UsdGeom.Sphere.Define(stage, "/Ball")
    ball.CreateRadiusAttr(2.5)
    stage.SetDefaultPrim(ball.GetPrim())
    UsdPhysics.RigidBodyAPI.Apply(ball.GetPrim())
    UsdPhysics.CollisionAPI.Apply(ball.GetPrim())
    mass = UsdPhysics.MassAPI.Apply(ball.GetPrim())
    mass.CreateMassAttr(0.51)
    mass.CreateDiagonalInertiaAttr((1.275, 1.275, 1.275))  # 2/5 m r^2 in kg cm2
    stage.GetRootLayer().Save()
    assert {d.severity for d in gate(file)} == {"info"}
    mass.GetMassAttr().Set(510.0)
    stage.GetRootLayer().Save()
    assert "asset/gate-density" in {d.code for d in gate(file) if d.severity == "warning"}


def test_scenes_without_physics_say_next_to_nothing(tmp_path: Path) -> None:
    file = tmp_path / "scene.usda"
    file.write_text('#usda 1.0\n(\n defaultPrim = "A"\n upAxis = "Y"\n)\ndef Xform "A"\n{\n def Cube "c"\n {\n }\n}\n')
    assert {d.severity for d in gate(file)} <= {"info"}


def test_unreadable_files_are_findings(tmp_path: Path) -> None:
    file = tmp_path / "x.usda"
    file.write_text("not usd")
    assert [d.code for d in gate(file)] == ["asset/package-invalid"]


@pytest.mark.parametrize("seed", range(4))
def test_no_text_makes_a_rule_fail(seed: int, tmp_path: Path) -> None:
    """Values replaced at random by others of any kind: findings, never an exception."""
    clean = cabinet(tmp_path).read_text().splitlines()
    odd = ["nan", "-inf", "0", "-1", "1e30", '"text"', "()", "[]", "(nan, nan, nan)", "[nan]", "</gone>", "@x@", '""']
    kinds = ["string", "int", "float[]", "token", "quatd", "asset", "float3", "matrix4d"]
    draw = random.Random(seed)
    for trial in range(60):
        lines = list(clean)
        for index in draw.sample([i for i, line in enumerate(lines) if "=" in line], 3):
            name, _, _ = lines[index].partition("=")
            if draw.random() < 0.3:
                name = re.sub(r"\b(float3?|double3?|quatf|token|point3f)\b", draw.choice(kinds), name, count=1)
            lines[index] = f"{name}= {draw.choice(odd)}"
        file = tmp_path / f"odd_{trial}.usda"
        file.write_text("\n".join(lines))
        assert "asset/internal-error" not in {d.code for d in gate(file)}, file.read_text()


def test_the_rules_that_read_numbers_take_a_fraction_of_a_second(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All but the one that looks for openings in the visible surface, which takes longer than all others together."""
    monkeypatch.setattr("gate.static_gate.RULES", tuple(rule for rule in RULES if rule is not collider_cavity.RULE))
    file = cabinet(tmp_path)
    gate(file)
    started = time.process_time()
    gate(file)
    assert time.process_time() - started < 0.3


def test_rules_are_described() -> None:
    assert len({rule.code.name for rule in RULES}) == len(RULES) >= 30
    assert all(rule.bound and rule.source for rule in RULES)


@given(st.floats(-0.3, 0.3), st.floats(0.05, 0.5), st.floats(0.05, 0.5))
@settings(max_examples=30, deadline=None, derandomize=True)
def test_boxes_overlap_as_deep_as_their_edges_say(offset: float, a: float, b: float) -> None:
    """Closed form: for boxes side by side along x the depth is the least of the three overlaps of their edges."""
    first = np.array(trimesh.creation.box((a, 0.4, 0.6)).vertices)
    second = trimesh.creation.box((b, 0.4, 0.6)).vertices + np.array([offset, 0.0, 0.0])
    along = 0.5 * (a + b) - abs(offset)
    assert penetration_depth(first, second) == pytest.approx(max(0.0, min(along, 0.4)), abs=1e-9)
    assert shared_volume(first, second) == pytest.approx(max(0.0, min(along, a, b)) * 0.24, abs=1e-9)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None, derandomize=True)
def test_the_depth_is_the_least_way_out(seed: int) -> None:
    """Moved by its depth along some direction the hulls part; along none of 500 do they part sooner."""
    random_ = np.random.default_rng(seed)
    first, second = random_.normal(size=(20, 3)), random_.normal(size=(30, 3)) * [0.2, 1.0, 2.0]
    depth = penetration_depth(first, second)
    assert 0.0 <= depth <= max(0.0, box_overlap(first, second)) + 1e-12
    directions = random_.normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    needed = (first @ directions.T).max(axis=0) - (second @ directions.T).min(axis=0)
    assert needed.min() >= depth - 1e-9
    assert penetration_depth(first, second + np.array([50.0, 0.0, 0.0])) == 0.0


def test_instances_and_internal_references_are_followed(tmp_path: Path) -> None:
    """Four wheels that are instances of one prototype, in centimetres and y-up: sound, and each has its collider."""
    file = tmp_path / "car.usda"
    stage = Usd.Stage.CreateNew(str(file))
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, "Y")
    tyre = UsdGeom.Cylinder.Define(stage, "/Parts/Wheel/tyre")
    tyre.CreateRadiusAttr(10.0)
    tyre.CreateHeightAttr(5.0)
    UsdPhysics.CollisionAPI.Apply(tyre.GetPrim())
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Car").GetPrim())
    for number in range(4):
        wheel = UsdGeom.Xform.Define(stage, f"/Car/wheel_{number}")
        wheel.AddTranslateOp().Set((50.0 * number, 10.0, 0.0))
        UsdPhysics.RigidBodyAPI.Apply(wheel.GetPrim())
        UsdPhysics.MassAPI.Apply(wheel.GetPrim()).CreateMassAttr(2.0)
        shape = stage.DefinePrim(f"/Car/wheel_{number}/shape", "Xform")
        shape.GetReferences().AddInternalReference("/Parts/Wheel")
        shape.SetInstanceable(True)
    stage.GetRootLayer().Save()
    assert {d.severity for d in gate(file)} == {"info"}
    stage.GetPrimAtPath("/Car/wheel_2").GetAttribute("physics:mass").Set(2000.0)
    UsdPhysics.RigidBodyAPI.Apply(tyre.GetPrim())
    stage.GetRootLayer().Save()
    prims_by_code = {(d.code, d.where.prim) for d in gate(file)}
    assert ("asset/gate-nested-body", "/Car/wheel_2/shape/tyre") in prims_by_code
