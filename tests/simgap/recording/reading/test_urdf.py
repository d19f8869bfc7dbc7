"""Subjects given as URDF: the same numbers as a table or a second reader gives, and refusals that say why."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pybullet_data
import pytest
import trimesh
from lxml import etree

from schemas.measurement import MeasurementSpec
from sim.dynamics.tree import inverse_dynamics
from simgap.kinds.free_body.declared_model import build_body
from simgap.kinds.free_body.toss import corners
from simgap.kinds.linkage.declared_model import build_linkage
from simgap.kinds.mechanism.declared_model import build_mechanism
from tests.support.present import present

KUKA = Path(pybullet_data.getDataPath()) / "kuka_iiwa"
LINK = '<link name="{n}"><inertial><mass value="{m}"/><inertia ixx="1" iyy="1" izz="1"/></inertial>{c}</link>'
PART = '<joint name="{n}" type="{t}"><parent link="{p}"/><child link="{c}"/><origin xyz="{x}" rpy="{r}"/></joint>'
BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'


def robot(*parts: str) -> str:
    return f'<robot name="r">{"".join(parts)}</robot>'


def link(name: str, mass: float = 1.0, collision: str = BALL) -> str:
    return LINK.format(n=name, m=mass, c=collision)


def joint(name: str, kind: str, parent: str, child: str, xyz: str = "0 0 0", rpy: str = "0 0 0") -> str:
    return PART.format(n=name, t=kind, p=parent, c=child, x=xyz, r=rpy)


def subject(kind: str, folder: Path, urdf: str, **more: object) -> MeasurementSpec:
    (folder / "model.urdf").write_text(urdf)
    data = {"schema_version": 1, "name": "x", "kind": kind, "subject": {"urdf": "model.urdf", **more}}
    return MeasurementSpec.model_validate(data)


def test_an_arm_has_the_dynamics_that_mujoco_reads_from_the_same_file(tmp_path: Path) -> None:
    text = (KUKA / "model.urdf").read_bytes()
    bare = etree.fromstring(text)
    for shape in list(bare.iter("visual", "collision")):  # Their meshes are of no use to dynamics.
        present(shape.getparent()).remove(shape)
    spec = subject("mechanism", tmp_path, etree.tostring(bare).decode())
    ours = build_mechanism(spec, tmp_path)
    etree.SubElement(etree.SubElement(bare, "mujoco"), "compiler", balanceinertia="false", fusestatic="true")
    judge = mujoco.MjModel.from_xml_string(etree.tostring(bare).decode())
    data, rng = mujoco.MjData(judge), np.random.default_rng(1)
    assert [link.name for link in ours.tree] == [judge.joint(j).name for j in range(judge.njnt)]
    for _ in range(5):
        q, qd, qdd = rng.uniform(-1.5, 1.5, (3, judge.nv))  # within all limits
        data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(judge, data)
        passive = data.qfrc_inverse + data.qfrc_passive
        effort, _ = inverse_dynamics(ours.tree, q[None], qd[None], qdd[None], ours.gravity_W)
        np.testing.assert_allclose(effort[0], passive, rtol=1e-6, atol=1e-6)


def test_a_base_pose_turns_the_whole_mechanism(tmp_path: Path) -> None:
    text = robot(link("a"), link("b"), joint("swing", "continuous", "a", "b", "0.2 0 0"))
    plain = build_mechanism(subject("mechanism", tmp_path, text), tmp_path)
    upright = [0.0, 0.0, 1.0, np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0]
    turned = build_mechanism(subject("mechanism", tmp_path, text, base_pose=upright), tmp_path)
    np.testing.assert_allclose(plain.tree[0].X_PJ[:3, 3], [0.2, 0.0, 0.0])
    np.testing.assert_allclose(turned.tree[0].X_PJ[:3, 3], [0.0, 0.0, 0.8], atol=1e-12)


def test_parts_joined_fast_are_one_body(tmp_path: Path) -> None:
    text = robot(link("a", 1.0), link("b", 3.0), joint("glue", "fixed", "a", "b", "0.4 0 0", "0 0 1.5707963267948966"))
    body = build_body(subject("free_body", tmp_path, text), tmp_path)
    assert body.mass_kg == pytest.approx(4.0)
    np.testing.assert_allclose(body.com_B, [0.3, 0.0, 0.0], atol=1e-12)
    # Two unit tensors, and 1 kg at 0.3 m and 3 kg at 0.1 m from the common centre (Steiner).
    np.testing.assert_allclose(body.inertia_B, np.diag([2.0, 2.12, 2.12]), atol=1e-12)
    np.testing.assert_allclose([s.X_AS[:3, 3] for s in body.shapes], [[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]], atol=1e-12)


def test_joints_come_parents_first_whatever_the_order_in_the_file(tmp_path: Path) -> None:
    late = (joint("second", "revolute", "b", "c", "0 0 1"), joint("first", "prismatic", "a", "b", "1 0 0"))
    spec = subject("free_body", tmp_path, robot(*(link(n) for n in "cba"), *late))
    model = build_linkage(spec, tmp_path)
    assert [j.name for j in model.joints.tree] == ["first", "second"]
    assert [j.parent for j in model.joints.tree] == [-1, 0]
    assert model.names == ("a", "b", "c")


def test_meshes_count_as_hulls_and_what_the_subject_says_wins(tmp_path: Path) -> None:
    trimesh.creation.box(extents=(0.1, 0.2, 0.3)).export(tmp_path / "block.obj")
    mesh = '<collision><geometry><mesh filename="block.obj" scale="2 2 2"/></geometry></collision>'
    text = robot(link("a", 2.0, mesh + "<contact><lateral_friction value='0.7'/></contact>"))
    body = build_body(subject("free_body", tmp_path, text), tmp_path)
    assert body.shapes[0].kind == "hull"
    np.testing.assert_allclose(np.ptp(corners(body.shapes), axis=0), [0.2, 0.4, 0.6])
    assert body.friction == 0.7
    said = build_body(subject("free_body", tmp_path, text, mass_kg=4.0, contact={"friction": 0.2}), tmp_path)
    assert (said.mass_kg, said.friction) == (4.0, 0.2)
    np.testing.assert_allclose(said.inertia_B, 2.0 * body.inertia_B)


REFUSED = {
    "a joint that mimics": robot(
        link("a"), link("b"), joint("j", "revolute", "a", "b").replace("</joint>", '<mimic joint="k"/></joint>')
    ),
    "a floating joint": robot(link("a"), link("b"), joint("j", "floating", "a", "b")),
    "two roots": robot(link("a"), link("b")),
    "a loop": robot(link("a"), link("b"), joint("i", "fixed", "a", "b"), joint("j", "fixed", "b", "a")),
    "a link that is nowhere": robot(link("a"), joint("j", "fixed", "a", "b")),
    "a mesh outside": robot(
        link("a", 1.0, '<collision><geometry><mesh filename="/etc/x.obj"/></geometry></collision>')
    ),
    "no mass": robot('<link name="a"/>'),
    "a box without size": robot(link("a", 1.0, BALL.replace('sphere radius="0.1"', "box"))),
    "not finite": robot(link("a"), link("b"), joint("j", "fixed", "a", "b", "nan 0 0")),
}


@pytest.mark.parametrize("text", REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_simulated_is_refused(text: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        build_body(subject("free_body", tmp_path, text), tmp_path)
