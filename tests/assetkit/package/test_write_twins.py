"""Twins of an articulated package: URDF and MJCF read back with the joints, poses and masses of the USD."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from assetkit.package.write_twins import write_twins
from formats import link_poses, read_mjcf, read_urdf
from gate.static_gate import gate
from geom.mechanism_pose import link_frames
from geom.pose import inverse
from schemas.package import PackageContent
from schemas.robot_description import RobotDescription
from tests.support.mechanism.mechanism_samples import LINKS, articulated
from tests.support.present import present
from usdio.reread.body import RereadPackage, reread_package
from usdio.write.package import write_package

STATES = ({}, {"hinge": 1.5}, {"hinge": -0.05, "turn": 2.0}, {"hinge": 0.9, "slide": 0.1, "turn": -0.7})


def written(content: PackageContent, folder: Path) -> tuple[RereadPackage, Path, Path]:
    """The package as it is on disk, and its URDF and MJCF."""
    place = folder / content.asset_id
    on_disk = reread_package(write_package(content, place))
    urdf, mjcf = write_twins(on_disk, content, place)
    return on_disk, urdf, mjcf


@pytest.mark.parametrize(("read", "index"), [(read_urdf, 0), (read_mjcf, 1)], ids=["urdf", "mjcf"])
def test_links_of_the_twins_stand_where_those_of_the_package_do(
    read: Callable[[Path], RobotDescription], index: int, tmp_path: Path
) -> None:
    on_disk, urdf, mjcf = written(articulated(), tmp_path)
    description, mechanism = read((urdf, mjcf)[index]), present(on_disk.mechanism)
    rest = {joint.name: joint.rest for joint in mechanism.joints}
    for state in STATES:
        right = link_frames(mechanism, state)
        in_twin = link_poses(description, rest | state if "slide" in state or not state else state)
        for name, _ in LINKS:
            relative = inverse(in_twin["case"]) @ in_twin[name]
            assert relative == pytest.approx(inverse(right["case"]) @ right[name], abs=1e-6), (name, state)


def test_numbers_of_joints_reach_the_twins(tmp_path: Path) -> None:
    _, urdf, mjcf = written(articulated(), tmp_path)
    for description in (read_urdf(urdf), read_mjcf(mjcf)):
        joints = {joint.name: joint for joint in description.joints}
        assert present(joints["hinge"].limits) == pytest.approx((-0.1, 2.0))
        assert (joints["hinge"].damping, joints["hinge"].friction) == pytest.approx((0.2, 0.01))
        assert joints["turn"].limits is None
        mimic = present(joints["slide"].mimic)
        assert (mimic.joint, mimic.multiplier, mimic.offset) == ("hinge", pytest.approx(0.05), pytest.approx(0.005))


def test_a_closing_joint_is_in_no_twin(tmp_path: Path) -> None:
    content = articulated()
    mechanism = present(content.mechanism)
    closing = replace(mechanism.joints[2], name="brace", parent="tray", closes_loop=True)
    loop = replace(content, mechanism=replace(mechanism, joints=(*mechanism.joints, closing)))
    on_disk, urdf, mjcf = written(loop, tmp_path)
    assert [joint.name for joint in present(on_disk.mechanism).joints if joint.closes_loop] == ["brace"]
    assert all("brace" not in {j.name for j in d.joints} for d in (read_urdf(urdf), read_mjcf(mjcf)))


@pytest.mark.parametrize(("kind", "points"), [("revolute", 2), ("ball", 1), ("prismatic", 0)])
def test_a_closing_joint_keeps_its_points_together_in_mujoco(kind: str, points: int, tmp_path: Path) -> None:
    """At rest both sites of each pair lie on the axis of the joint, at one place; other joint positions part them."""
    content = articulated()
    mechanism = present(content.mechanism)
    anchor, axis = np.array([0.02, 0.01, 0.05]), np.array([0.0, 0.6, 0.8])
    closing = replace(
        mechanism.joints[2], name="brace", kind=kind, parent="tray", anchor=anchor, axis=axis, closes_loop=True
    )
    loop = replace(content, mechanism=replace(mechanism, joints=(*mechanism.joints, closing)))
    on_disk, _, mjcf = written(loop, tmp_path)
    model = mujoco.MjModel.from_xml_path(str(mjcf))
    data = mujoco.MjData(model)
    for joint in present(on_disk.mechanism).tree:
        data.qpos[model.joint(joint.name).qposadr[0]] = joint.rest
    mujoco.mj_forward(model, data)
    connects = [i for i in range(model.neq) if model.eq_type[i] == mujoco.mjtEq.mjEQ_CONNECT]
    assert len(connects) == points
    places = [(data.site_xpos[model.eq_obj1id[i]], data.site_xpos[model.eq_obj2id[i]]) for i in connects]
    for first, second in places:
        assert first == pytest.approx(second, abs=1e-6)
        assert np.cross(first - data.body("case").xpos - anchor, axis) == pytest.approx(np.zeros(3), abs=1e-6)
    data.qpos[model.joint("hinge").qposadr[0]] += 0.5
    mujoco.mj_forward(model, data)
    assert all(np.linalg.norm(first - second) > 1e-3 for first, second in places)


def test_the_gate_compares_every_link_with_its_twin(tmp_path: Path) -> None:
    content = articulated()
    _, urdf, _ = written(content, tmp_path)
    main_file = tmp_path / content.asset_id / "usd" / f"{content.asset_id}.usda"

    def findings() -> list[tuple[str, str | None]]:
        return [(d.headline, d.where.prim) for d in gate(main_file) if d.code == "asset/gate-twin"]

    assert findings() == []
    text = urdf.read_text()
    weight = [line for line in text.splitlines() if "<mass" in line][[name for name, _ in LINKS].index("tray")]
    urdf.write_text(text.replace(weight, '<mass value="2.5" />'))
    assert findings() == [("the mass is not that of the URDF twin", "/sample_1/tray")]
    urdf.write_text(text.replace('name="tray"', 'name="shelf"'))
    assert findings() == [("the URDF twin has no link of this body", "/sample_1/tray")]
