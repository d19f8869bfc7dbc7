"""The table that settled how URDF is read: what replay's and the sim gap's readers did, what all of Mana does now."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest
import trimesh

from formats import link_mass, read_urdf
from schemas.robot_description import JointLimits, Mimic, RobotDescription
from tests.formats.settled import OBJ, Case, check_case, mesh_path, moving, one_shape
from tests.support.bad_inputs.robot import AB, inertial, joint, link, shape, urdf, write
from tests.support.present import present

BOMB = '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">' + "".join(
    f'<!ENTITY {b} "{("&" + a + ";") * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True)
)
MESH = '<mesh filename="{}"/>'
FOLLOWS = '<axis xyz="0 1 0"/><mimic joint="{}" multiplier="-2" offset="0.1"/>'


def mesh_problem(d: RobotDescription) -> str:
    mesh = one_shape(d).mesh
    assert mesh is not None
    assert mesh.problem is not None
    return mesh.problem.code


CASES: Mapping[str, Case] = {
    # The tree.
    "URDF loop": Case(
        urdf(AB, joint("i", "a", "b"), joint("j", "b", "a")), "replay/invalid-value", "ValueError", "robot/link-cycle"
    ),
    "URDF loop beside a sound root": Case(
        urdf(link("root"), AB, joint("i", "a", "b"), joint("j", "b", "a")),
        "replay/invalid-value",
        "ValueError",
        "robot/link-cycle",
    ),
    "URDF link with two parents": Case(
        urdf(AB, link("c"), joint("h", "a", "b"), joint("i", "a", "c"), joint("j", "b", "c")),
        "replay/invalid-value",
        "ValueError",
        "robot/two-parents",
    ),
    "URDF with two roots": Case(urdf(AB), "replay/invalid-value", "ValueError", "robot/several-roots"),
    "URDF joint to a link that is not there": Case(
        urdf(link("a"), joint("j", "a", "b")), "replay/invalid-value", "ValueError", "robot/missing-link"
    ),
    "URDF joint without a parent": Case(
        urdf(AB, joint("j", "a", "b").replace('<parent link="a"/>', "")),
        "replay/invalid-value",
        "ValueError",
        "robot/missing-link",
    ),
    "URDF links of one name": Case(
        urdf(link("a"), link("a")), "replay/invalid-value", "last one won", "robot/duplicate-name"
    ),
    "URDF joints of one name": Case(
        urdf(AB, link("c"), joint("j", "a", "b"), joint("j", "b", "c")),
        "replay/invalid-value",
        "read",
        "robot/duplicate-name",
    ),
    "URDF joint without a name": Case(urdf(AB, joint("", "a", "b")), "read", "read", "robot/missing-name"),
    "URDF with no link": Case(urdf(), "replay/invalid-value", "ValueError", "robot/no-links"),
    # Joints.
    "URDF mimic": Case(
        urdf(AB, link("c"), joint("i", "a", "b"), joint("j", "b", "c", inside=FOLLOWS.format("i"))),
        "read",
        "ValueError in simulation",
        None,
        lambda d: d.joints[1].mimic == Mimic("i", -2.0, 0.1),
    ),
    "URDF mimic of a joint that is not there": Case(
        urdf(AB, joint("j", "a", "b", inside=FOLLOWS.format("k"))),
        "replay/invalid-value",
        "ValueError",
        "robot/unknown-reference",
    ),
    "URDF mimics in a circle": Case(
        urdf(
            AB,
            link("c"),
            joint("i", "a", "b", inside=FOLLOWS.format("j")),
            joint("j", "b", "c", inside=FOLLOWS.format("i")),
        ),
        "replay/invalid-value",
        "ValueError",
        "robot/mimic-cycle",
    ),
    "URDF floating joint": Case(
        urdf(AB, joint("j", "a", "b", "floating")),
        "replay/unsupported-model",
        "ValueError in simulation",
        None,
        lambda d: moving(d).kind == "floating",
    ),
    "URDF axis of zeros": Case(
        urdf(AB, joint("j", "a", "b", inside='<axis xyz="0 0 0"/>')),
        "replay/invalid-value",
        "ValueError in simulation",
        "robot/zero-axis",
    ),
    "URDF axis of zeros of a fixed joint": Case(
        urdf(AB, joint("j", "a", "b", "fixed", '<axis xyz="0 0 0"/>')), "read", "read", None
    ),
    "URDF axis that is not normalised": Case(
        urdf(AB, joint("j", "a", "b", inside='<axis xyz="0 0 -2"/>')),
        "read",
        "read",
        None,
        lambda d: d.joints[0].axis_C.tolist() == [0.0, 0.0, -1.0],
        ("robot/axis-not-unit",),
    ),
    "URDF without an axis": Case(
        urdf(AB, joint("j", "a", "b")), "read", "read", None, lambda d: d.joints[0].axis_C.tolist() == [1.0, 0.0, 0.0]
    ),
    "URDF revolute without limits": Case(
        urdf(AB, joint("j", "a", "b", "revolute")),
        "read",
        "read",
        None,
        lambda d: d.joints[0].limits is None,
        ("robot/missing-limit",),
    ),
    "URDF limits upside down": Case(
        urdf(AB, joint("j", "a", "b", "revolute", '<limit lower="1" upper="-1" effort="5" velocity="2"/>')),
        "read",
        "taken as none",
        None,
        lambda d: (d.joints[0].limits, d.joints[0].effort, d.joints[0].velocity) == (JointLimits(1.0, -1.0), 5.0, 2.0),
        ("robot/reversed-limits",),
    ),
    "URDF limit that is no number": Case(
        urdf(AB, joint("j", "a", "b", "revolute", '<limit lower="nan" upper="1"/>')),
        "read",
        "taken as none",
        "robot/invalid-number",
    ),
    # Shapes.
    "URDF capsule": Case(
        urdf(link("a", shape('<capsule radius="0.1" length="0.3"/>'))),
        "read",
        "read",
        None,
        lambda d: (one_shape(d).kind, one_shape(d).size_m) == ("capsule", (0.1, 0.3)),
    ),
    "URDF shape of negative size": Case(
        urdf(link("a", shape('<sphere radius="-1"/>'))),
        "replay/invalid-value",
        "read",
        None,
        lambda d: present(one_shape(d).problem).code == "robot/invalid-size",
        ("robot/invalid-size",),
    ),
    "URDF shape of an unknown kind": Case(
        urdf(link("a", shape('<cone radius="1"/>'))),
        "replay/unsupported-model",
        "ValueError in simulation",
        None,
        lambda d: present(one_shape(d).problem).code == "robot/unsupported-shape",
        ("robot/unsupported-shape",),
    ),
    "URDF mesh in a package": Case(
        {"arm/urdf/model.urdf": urdf(link("a", shape(MESH.format("package://arm/meshes/a.obj"))))["model.urdf"]}
        | {"arm/meshes/a.obj": OBJ},
        "only with --meshes",
        "refused",
        None,
        lambda d: mesh_path(d) == "arm/meshes/a.obj",
    ),
    "URDF mesh in the folder above, inside the root": Case(
        {"urdf/model.urdf": urdf(link("a", shape(MESH.format("../a.obj"))))["model.urdf"], "a.obj": OBJ},
        "only with --meshes",
        "read",
        None,
        lambda d: mesh_path(d) == "a.obj",
    ),
    "URDF mesh outside the root": Case(
        urdf(link("a", shape(MESH.format("../../a.obj")))),
        "replay/path-escape",
        "refused",
        None,
        lambda d: mesh_problem(d) == "robot/path-escape" and mesh_path(d) == "",
        ("robot/path-escape",),
    ),
    "URDF absolute mesh outside the root": Case(
        urdf(link("a", shape(MESH.format("/etc/hostname.obj")))),
        "replay/missing-mesh",
        "refused",
        None,
        lambda d: mesh_problem(d) == "robot/path-escape",
        ("robot/path-escape",),
    ),
    "URDF mesh of the network": Case(
        urdf(link("a", shape(MESH.format("https://example.org/a.obj")))),
        "replay/missing-mesh",
        "refused",
        None,
        lambda d: mesh_problem(d) == "robot/path-escape",
        ("robot/path-escape",),
    ),
    "URDF mesh scale": Case(
        urdf(link("a", shape('<mesh filename="a.obj" scale="1 -1 2"/>'))) | {"a.obj": OBJ},
        "read",
        "read",
        None,
        lambda d: present(one_shape(d).mesh).scale == (1.0, -1.0, 2.0),
    ),
    # Masses.
    "URDF without an inertial": Case(
        urdf(link("a", shape('<sphere radius="1"/>'))),
        "read",
        "read without mass",
        None,
        lambda d: link_mass(d.links[0]) is None and d.links[0].inertia_source == "missing",
        ("robot/missing-inertial",),
    ),
    "URDF mass of zero": Case(
        urdf(link("a", inertial(0.0))),
        "read",
        "read without mass",
        None,
        lambda d: link_mass(d.links[0]) is None and d.links[0].inertial.mass_kg == 0.0,
        ("robot/invalid-mass",),
    ),
    "URDF negative mass": Case(
        urdf(link("a", inertial(-2.0))),
        "read",
        "read without mass",
        None,
        lambda d: link_mass(d.links[0]) is None,
        ("robot/invalid-mass",),
    ),
    "URDF tensor that breaks the triangle inequality": Case(
        urdf(link("a", inertial(1.0, ixx=3.0))),
        "read",
        "read",
        None,
        lambda d: d.links[0].inertial.inertia_kgm2[0, 0] == 3.0,
        ("robot/invalid-inertia",),
    ),
    "URDF mass that is no number": Case(
        urdf(link("a", inertial(float("nan")))), "read", "read", "robot/invalid-number"
    ),
    # Numbers and XML.
    "numbers with commas": Case(
        urdf(AB, joint("j", "a", "b", inside='<origin xyz="0.07, 0, -0.69"/>')),
        "read",
        "ValueError in simulation",
        None,
        lambda d: d.joints[0].X_PC[:3, 3].tolist() == [0.07, 0.0, -0.69],
    ),
    "number that is none": Case(
        urdf(AB, joint("j", "a", "b", inside='<origin xyz="0 nan 0"/>')),
        "replay/invalid-value",
        "ValueError in simulation",
        "robot/invalid-number",
    ),
    "entities that grow": Case(
        {"model.urdf": BOMB + ']>\n<robot name="r"><link name="&i;"/></robot>'},
        "replay/unreadable or a name of entities",
        "ValueError or a name of entities",
        "robot/xml-declarations",
    ),
    "entity of a file": Case(
        {
            "model.urdf": '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/hostname">]>\n'
            '<robot name="r"><link name="a">&x;</link></robot>'
        },
        "read",
        "read",
        "robot/xml-declarations",
    ),
    "xacro": Case(urdf(link("${p}a")), "read", "read", "robot/xacro"),
    "elements that are not understood": Case(
        urdf(link("a"), '<transmission name="t"><type>x</type></transmission>\n'),
        "dropped",
        "dropped",
        None,
        lambda d: (
            [(e.tag, e.source.line, e.text[:23]) for e in d.unread] == [("transmission", 3, '<transmission name="t">')]
        ),
        ("robot/unread-element",),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_case_is_settled(name: str, tmp_path: Path) -> None:
    check_case(CASES[name], read_urdf, tmp_path)


def test_meshes_outside_the_root_are_not_opened(tmp_path: Path) -> None:
    """Neither by `..` nor through a link, though the file is there."""
    (tmp_path / "root").mkdir()
    trimesh.creation.box().export(tmp_path / "secret.obj")
    (tmp_path / "root" / "link.obj").symlink_to(tmp_path / "secret.obj")
    for name in ("../secret.obj", "link.obj", str(tmp_path / "secret.obj"), "package://../secret.obj"):
        path = write(urdf(link("a", shape(MESH.format(name)))), tmp_path / "root")
        description = read_urdf(path)
        assert mesh_path(description) == ""
        assert mesh_problem(description) == "robot/path-escape"
