"""Joints of a written package: read back they are the same, by our own reader and as a foreign source."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdPhysics

from assetkit.readers.usd import read_usd
from assetkit.sources.source_file import SourceFile
from schemas.mechanism import MechanismJoint
from tests.support.mechanism.mechanism_samples import JOINTS, LINKS, articulated
from tests.support.present import present
from usdio.reread.body import reread_package
from usdio.write.package import write_package


@pytest.fixture
def package(tmp_path: Path) -> Path:
    wanted_content = articulated()
    return write_package(wanted_content, tmp_path / wanted_content.asset_id)


def assert_same(joint: MechanismJoint, written: MechanismJoint) -> None:
    for field in ("kind", "parent", "child", "closes_loop"):
        assert getattr(joint, field) == getattr(written, field)
    for field in ("anchor", "axis", "rest", "damping", "friction", "armature", "stiffness", "effort", "velocity"):
        expected = getattr(written, field)
        assert getattr(joint, field) == (
            expected if expected is None else pytest.approx(expected, rel=1e-5, abs=1e-6)
        ), field
    assert (joint.coupling is None) == (written.coupling is None)
    if joint.coupling is not None:
        assert joint.coupling.joint == present(written.coupling).joint
        assert joint.coupling.multiplier == pytest.approx(present(written.coupling).multiplier, rel=1e-5)
        assert joint.coupling.offset == pytest.approx(present(written.coupling).offset, rel=1e-5)
    assert (joint.limits is None) == (written.limits is None)
    assert joint.limits is None or joint.limits == pytest.approx(written.limits, rel=1e-5)


def test_a_package_read_back_has_the_joints_and_masses_that_were_written(package: Path) -> None:
    read_back, wanted_content = reread_package(package), articulated()
    mechanism = present(read_back.mechanism)
    assert [link.name for link in mechanism.links] == [name for name, _ in LINKS]
    for found, wanted in zip(mechanism.joints, JOINTS, strict=True):
        assert_same(found, wanted)
    for body, link, (_, origin) in zip(read_back.links, wanted_content.links, LINKS, strict=True):
        assert body.mass.mass_kg == pytest.approx(link.mass.mass_kg)
        assert body.mass.centre_of_mass_m + np.array(origin) == pytest.approx(link.mass.centre_of_mass_m, abs=1e-6)
    assert read_back.body.mass.mass_kg == pytest.approx(sum(link.mass.mass_kg for link in wanted_content.links))
    assert len(read_back.body.shapes) == len(LINKS)


@pytest.mark.parametrize(
    "joint",
    [
        replace(JOINTS[0], rest=3.6, limits=(3.5, 5.0), spring_rest=3.5),
        replace(JOINTS[0], kind="ball", axis=np.array([0.0, 0.0, 1.0]), rest=0.0, limits=(0.0, 0.7)),
    ],
    ids=["rest beyond half a turn", "cone of a ball joint"],
)
def test_rest_and_limits_survive_in_both_readers(joint: MechanismJoint, tmp_path: Path) -> None:
    content = articulated()
    joints = (joint, replace(JOINTS[1], coupling=None), JOINTS[2])
    content = replace(content, mechanism=replace(present(content.mechanism), joints=joints))
    package = write_package(content, tmp_path / content.asset_id)
    as_source = present(present(read_usd(SourceFile(package, package.parent)).value).mechanism)
    for read_back in (present(reread_package(package).mechanism), as_source):
        (found,) = (j for j in read_back.joints if j.name == joint.name)
        assert (found.kind, found.rest) == (joint.kind, pytest.approx(joint.rest, abs=1e-6))
        assert found.limits == pytest.approx(joint.limits, rel=1e-5)


def test_a_package_as_a_source_has_the_same_mechanism(package: Path) -> None:
    model_ = present(read_usd(SourceFile(package, package.parent)).value)
    mechanism = present(model_.mechanism)
    by_name = {joint.name: joint for joint in mechanism.joints}
    for wanted in JOINTS:
        assert_same(by_name[wanted.name], wanted)
    assert {mesh.link for mesh in model_.meshes} == {name for name, _ in LINKS}


def test_links_are_flat_siblings_below_one_articulation_root(package: Path) -> None:
    stage = Usd.Stage.Open(str(package))
    root = stage.GetDefaultPrim()
    roots = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.ArticulationRootAPI)]
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    assert roots == [root]
    assert {prim.GetParent() for prim in bodies} == {root}
    assert {prim.GetParent().GetPath().name for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)} == {"Joints"}
    drive = UsdPhysics.DriveAPI(root.GetPrimAtPath("Joints/hinge"), "angular")
    assert drive.GetDampingAttr().Get() == pytest.approx(np.radians(0.2))  # N m s per degree
    pairs = UsdPhysics.FilteredPairsAPI(root.GetChild("door")).GetFilteredPairsRel().GetTargets()
    assert [path.name for path in pairs] == ["tray"]
