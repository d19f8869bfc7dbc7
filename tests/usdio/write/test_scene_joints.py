"""Written scenes with articulated objects: links stand where the state puts them, in the USD and in the engine."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdPhysics

from cli.scene.settle import settled
from gate.external_validators import usd_validation
from geom.pose import matrix_of, pose
from scenec.bind.asset_library import AssetLibrary
from scenec.compile import compile_program
from schemas.scene.compiled import CompiledScene
from schemas.scene.program import FixedAsset
from tests.support.scene.articulated import articulated_library
from usdio.reread.mechanism import reread_mechanism
from usdio.reread.scene import reread_scene
from usdio.write.scene import write_scene

PROGRAM = """\
background: {asset: drawer_unit, joints: {drawer_1: 0.1}, yaw_deg: 20, position: [0.3, 0.1, 0.2]}
anchors:
  top: {object: background, surface: auto}
  low: {object: background, volume: drawer_1/inside}
  plate: {object: oven, surface: plate/top}
objects:
  - {id: oven, asset: microwave}
  - {id: cube, asset: {type: box, size_m: [0.05, 0.05, 0.04]}}
layout:
  nodes:
    oven: {object: oven, joints: {door_deg: 70, turn_deg: 200}, placement: {type: discrete, surface: top, poses: [{x: 0, y: 0, z: 0.05}]}}
    dish: {object: cube, placement: {type: surface, surface: plate}}
    sock: {object: cube, placement: {type: volume, volume: low}}
"""  # noqa: E501
STATES = {"background": {"drawer_1": 0.1}, "oven": {"door": np.radians(70.0), "turn": np.radians(200.0)}}
ASSETS = {"background": "drawer_unit", "oven": "microwave"}


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> AssetLibrary:
    return AssetLibrary(articulated_library(tmp_path_factory.mktemp("library")))


@pytest.fixture(scope="module")
def scene(library: AssetLibrary, tmp_path_factory: pytest.TempPathFactory) -> CompiledScene:
    file = tmp_path_factory.mktemp("program") / "program.yaml"
    file.write_text(PROGRAM)
    result = compile_program(file, library=library)
    assert result.report.verdict == "compiled", result.report.diagnostics
    return result.scenes[0]


@pytest.fixture(scope="module")
def stage_file(scene: CompiledScene, library: AssetLibrary, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_scene(scene, library.folder, tmp_path_factory.mktemp("scene") / "scene.usda")


@pytest.fixture(scope="module")
def stage(stage_file: Path) -> Usd.Stage:
    return Usd.Stage.Open(str(stage_file))


def test_links_are_read_back_where_the_state_puts_them(
    stage_file: Path, stage: Usd.Stage, scene: CompiledScene, library: AssetLibrary
):
    bodies = {body.name: body for body in reread_scene(stage_file)}
    assert [name for name, body in bodies.items() if not body.moves] == ["background"]
    for name, state in STATES.items():
        expected = library.geometry(FixedAsset(type="fixed", id=ASSETS[name]), state=tuple(sorted(state.items())))
        item = scene.background if name == "background" else next(o for o in scene.objects if o.id == name)
        assert item is not None
        assert expected.posed is not None
        body = bodies[name]
        np.testing.assert_allclose(body.X_WA, pose(matrix_of(np.array(item.quat_wxyz)), item.position_m), atol=1e-8)
        links = [prim.GetName() for prim in _object(stage, name).GetChildren() if _is_body(prim)]
        shapes = [s for link in links for s in _shapes_of(expected.posed.linkage.links, expected.posed, link)]
        for one, other in zip(body.body.shapes, shapes, strict=True):
            np.testing.assert_allclose(one.X_AS, other, atol=1e-6)
        assert body.body.mass.mass_kg == pytest.approx(expected.posed.body.mass.mass_kg, rel=1e-6)
        found, meant = body.body.mass.centre_of_mass_m, expected.posed.body.mass.centre_of_mass_m
        np.testing.assert_allclose(found, meant, atol=1e-6)


def _shapes_of(links, posed, name: str) -> list[np.ndarray]:
    origin = next(link.origin for link in posed.linkage.mechanism.links if link.name == name)
    X_AL = posed.motions[name] @ pose(None, origin)
    return [X_AL @ shape.X_AS for link in links if link.name == name for shape in link.shapes]


def _is_body(prim: Usd.Prim) -> bool:
    return prim.HasAPI(UsdPhysics.RigidBodyAPI)


def _object(stage: Usd.Stage, name: str) -> Usd.Prim:
    return stage.GetPrimAtPath("/World/Background" if name == "background" else f"/World/Objects/{name}")


def test_joints_of_the_stage_are_at_the_written_positions(stage: Usd.Stage):
    """As a simulator takes them: from the poses of the two bodies of a joint."""
    for name, state in STATES.items():
        prim = _object(stage, name)
        frames = {link.GetName(): _frame(link, prim) for link in prim.GetChildren() if _is_body(link)}
        for joint, position in state.items():
            api = UsdPhysics.Joint(prim.GetPrimAtPath(f"Joints/{joint}"))
            parent, child = (rel.GetTargets()[0].name for rel in (api.GetBody0Rel(), api.GetBody1Rel()))
            X0 = frames[parent] @ _local(api.GetLocalPos0Attr().Get(), api.GetLocalRot0Attr().Get())
            X1 = frames[child] @ _local(api.GetLocalPos1Attr().Get(), api.GetLocalRot1Attr().Get())
            X = np.linalg.inv(X0) @ X1
            axis = "XYZ".index(api.GetPrim().GetAttribute("physics:axis").Get())
            if joint.startswith("drawer"):
                assert X[axis, 3] == pytest.approx(position, abs=1e-6)
            else:
                a, b = [(1, 2), (2, 0), (0, 1)][axis]
                off = math.remainder(math.atan2(X[b, a], X[a, a]) - position, math.tau)
                assert off == pytest.approx(0.0, abs=1e-5)
        assert prim.GetCustomDataByKey("mana:joints") == pytest.approx({**_rest(name), **state}, abs=1e-8)


def _rest(name: str) -> dict[str, float]:
    return {"drawer_1": 0.0, "drawer_2": 0.0} if name == "background" else {"door": 0.0, "turn": 0.0}


def _frame(prim: Usd.Prim, ancestor: Usd.Prim) -> np.ndarray:
    cache = UsdGeom.XformCache()
    world = cache.GetLocalToWorldTransform(prim) * cache.GetLocalToWorldTransform(ancestor).GetInverse()
    return np.array(world).T


def _local(position, rotation) -> np.ndarray:
    quat = np.array([rotation.GetReal(), *rotation.GetImaginary()], dtype=np.float64)
    return pose(matrix_of(quat), np.array(position, dtype=np.float64))


def test_the_background_is_held_and_its_links_are_free(stage: Usd.Stage, scene: CompiledScene):
    prim = _object(stage, "background")
    held = UsdPhysics.FixedJoint(prim.GetChild("HeldInWorld"))
    assert held.GetBody0Rel().GetTargets() == []
    assert [target.name for target in held.GetBody1Rel().GetTargets()] == ["case"]
    assert scene.background is not None
    np.testing.assert_allclose(held.GetLocalPos0Attr().Get(), scene.background.position_m, atol=1e-6)
    assert all(
        UsdPhysics.RigidBodyAPI(link).GetRigidBodyEnabledAttr().Get() for link in prim.GetChildren() if _is_body(link)
    )
    assert not _object(stage, "oven").GetChild("HeldInWorld")


def test_outside_judges_pass_and_nothing_falls(stage_file: Path):
    verdict = usd_validation(stage_file)
    assert verdict.passed, verdict.findings
    rows = settled(stage_file)
    assert {row.id for row in rows} == {"oven", "dish", "sock"}
    assert next(row for row in rows if row.id == "sock").stayed


def test_links_at_rest_are_left_to_the_package(library: AssetLibrary, tmp_path: Path):
    (tmp_path / "p.yaml").write_text(
        "background: {asset: {type: box, size_m: [1, 1, 0.1]}}\nanchors: {top: {object: background}}\n"
        "objects: [{id: unit, asset: drawer_unit}]\n"
        "layout: {nodes: {unit: {object: unit, joints: {drawer_2: 0.1}, placement: {type: surface, surface: top}}}}\n"
    )
    (scene,) = compile_program(tmp_path / "p.yaml", library=library).scenes
    text = write_scene(scene, library.folder, tmp_path / "out" / "scene.usda").read_text()
    assert 'over Xform "drawer_2"' in text
    assert '"drawer_1"' not in text.replace('"mana:joints"', "").split("over Xform")[1]
    again = write_scene(scene, library.folder, tmp_path / "again" / "scene.usda").read_text()
    assert again == text


def test_a_mechanism_in_a_scene_is_still_one(stage_file: Path, stage: Usd.Stage):
    prim = _object(stage, "oven")
    assert prim.HasAPI(UsdPhysics.ArticulationRootAPI)
    package = Usd.Stage.Open(str(stage_file.parent / "packages" / "microwave" / "usd" / "microwave.usda"))
    bodies = [p for p in package.Traverse() if _is_body(p)]
    assert [joint.name for joint in reread_mechanism(package, bodies, stage_file).joints] == ["door", "turn"]
