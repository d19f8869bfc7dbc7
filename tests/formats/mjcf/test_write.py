"""What is written as MJCF reads back as the same description, and is the same model to MuJoCo."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import mujoco
import numpy as np
import pybullet_data
import pytest
from hypothesis import given, settings

from formats import link_poses, read_mjcf, read_urdf, write_mjcf
from geom.pose import pose
from schemas.diagnostics import InvalidInput
from schemas.robot_description import RobotDescription
from tests.support.bad_inputs.robot import AB, inertial, joint, link, urdf, write
from tests.support.drawn_robots import descriptions, differences
from tests.support.present import present


@given(descriptions("mjcf"))
@settings(max_examples=150)
def test_what_is_written_reads_back_as_the_same(
    tmp_path_factory: pytest.TempPathFactory, drawn: RobotDescription
) -> None:
    path = tmp_path_factory.mktemp("law") / "model.xml"
    written = write_mjcf(drawn)
    assert written.lost == ()
    path.write_bytes(written.data)
    assert differences(in_body_axes(drawn), in_body_axes(read_mjcf(path))) == []


def in_body_axes(description: RobotDescription) -> RobotDescription:
    """Inertials with their frames along the axes of the links: MJCF has full tensors there alone."""
    links = []
    for body in description.links:
        given = body.inertial
        if given is not None and given.inertia_kgm2 is not None:
            R = given.X_LI[:3, :3]
            turned = dataclasses.replace(
                given, X_LI=pose(None, given.X_LI[:3, 3]), inertia_kgm2=R @ given.inertia_kgm2 @ R.T
            )
            body = dataclasses.replace(body, inertial=turned)
        links.append(body)
    return dataclasses.replace(description, links=tuple(links))


def test_mujoco_finds_the_links_of_a_urdf_where_it_has_them(tmp_path: Path) -> None:
    """Kuka's arm, a mimic added, without shapes: read from URDF, written as MJCF, loaded by MuJoCo."""
    arm = read_urdf(Path(pybullet_data.getDataPath()) / "kuka_iiwa" / "model.urdf")
    arm = dataclasses.replace(arm, links=tuple(dataclasses.replace(part, shapes=()) for part in arm.links))
    written = write_mjcf(arm)
    assert {d.code for d in written.lost} == {"robot/not-expressible"}
    model = mujoco.MjModel.from_xml_string(written.data.decode())
    data, rng = mujoco.MjData(model), np.random.default_rng(1)
    moving = [j for j in arm.joints if j.moves]
    assert [model.joint(k).name for k in range(model.njnt)] == [j.name for j in moving]
    np.testing.assert_allclose(model.jnt_range, np.array([present(j.limits) for j in moving]))
    q = rng.uniform(-1.5, 1.5, len(moving))
    data.qpos[:] = q
    mujoco.mj_kinematics(model, data)
    X_RL = link_poses(arm, dict(zip([j.name for j in moving], q, strict=True)))
    for part in arm.links:
        body = data.body(part.name)
        np.testing.assert_allclose(X_RL[part.name], pose(body.xmat.reshape(3, 3), body.xpos), atol=1e-9)
        if part.inertial is not None and part.name != arm.root:
            assert model.body(part.name).mass[0] == pytest.approx(part.inertial.mass_kg)


def test_a_mimic_is_an_equality_to_mujoco(tmp_path: Path) -> None:
    mimic = '<mimic joint="i" multiplier="-2" offset="0.1"/>'
    parts = [link(n, inertial(1.0)) for n in "abc"]
    text = urdf(*parts, joint("i", "a", "b"), joint("j", "b", "c", inside=mimic))
    model = mujoco.MjModel.from_xml_string(write_mjcf(read_urdf(write(text, tmp_path))).data.decode())
    assert model.neq == 1
    np.testing.assert_allclose(model.eq_data[0, :5], [0.1, -2.0, 0.0, 0.0, 0.0])


def test_a_planar_joint_is_not_expressible(tmp_path: Path) -> None:
    description = read_urdf(write(urdf(AB, joint("j", "a", "b", "planar")), tmp_path))
    with pytest.raises(InvalidInput) as refused:
        write_mjcf(description)
    assert refused.value.diagnostic.code == "robot/not-expressible"
