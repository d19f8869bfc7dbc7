"""The table that settled the differences of the readers before `formats`: replay's (URDF, MJCF), the sim gap's (URDF).

Each case has what each of them did (a code, "read", or what was wrong) and what all of Mana does now: a code, or `None`
for a file that is read; then `holds` states what the description must say.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import trimesh

from formats import link_mass, read_mjcf, read_urdf
from schemas.diagnostics import InvalidInput
from schemas.robot_description import DescribedJoint, DescribedShape, JointLimits, Mimic, RobotDescription
from tests.support.bad_inputs.robot import AB, Files, inertial, joint, link, mjcf, shape, urdf, write
from tests.support.present import present

Holds = Callable[[RobotDescription], object]


class Case(NamedTuple):
    """`replay` and `simgap`: what the readers before did; "-" where the reader had no such input."""

    files: Files
    replay: str
    simgap: str
    code: str | None
    holds: Holds = lambda description: True
    notes: tuple[str, ...] = ()


def one_shape(d: RobotDescription) -> DescribedShape:
    return next(shape for link in d.links for shape in link.shapes)


def moving(d: RobotDescription) -> DescribedJoint:
    return next(joint for joint in d.joints if joint.moves)


def mesh_path(d: RobotDescription) -> str:
    mesh = one_shape(d).mesh
    assert mesh is not None
    return mesh.path


def mesh_problem(d: RobotDescription) -> str:
    mesh = one_shape(d).mesh
    assert mesh is not None
    assert mesh.problem is not None
    return mesh.problem.code


def turned(d: RobotDescription, expected: tuple[float, float, float]) -> bool:
    """Whether the z axis of the first joint's child points along `expected`."""
    return bool(np.allclose(d.joints[0].X_PC[:3, 2], expected, atol=1e-12))


OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
BOMB = '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">' + "".join(
    f'<!ENTITY {b} "{("&" + a + ";") * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True)
)
MESH = '<mesh filename="{}"/>'
FOLLOWS = '<axis xyz="0 1 0"/><mimic joint="{}" multiplier="-2" offset="0.1"/>'
HINGE = '<body name="a"><joint name="j" {}/><geom size="1"/></body>\n'
NESTED = """<default>
<geom size="0.1"/><default class="outer"><geom size="0.2" density="10"/><joint type="slide" axis="1 0 0"/>
<default class="inner"><geom size="0.3"/></default></default></default>
"""

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
    "MJCF body of one name twice": Case(mjcf('<body name="a"/><body name="a"/>'), "read", "-", "robot/duplicate-name"),
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
    "MJCF joint equality": Case(
        {
            "model.xml": '<mujoco><worldbody><body name="a"><joint name="i" ref="10"/><geom size="1"/></body>'
            '<body name="b"><joint name="j" ref="30"/><geom size="1"/></body></worldbody>'
            '<equality><joint joint1="j" joint2="i" polycoef="0.1 2 0 0 0"/></equality></mujoco>'
        },
        "not read",
        "-",
        None,
        lambda d: (
            d.joints[1].mimic is not None
            and np.isclose(d.joints[1].mimic.offset, np.radians(30) + 0.1 - 2 * np.radians(10))
        ),
    ),
    "URDF floating joint": Case(
        urdf(AB, joint("j", "a", "b", "floating")),
        "replay/unsupported-model",
        "ValueError in simulation",
        None,
        lambda d: moving(d).kind == "floating",
    ),
    "MJCF ball joint": Case(
        mjcf(HINGE.format('type="ball" range="0 90"')),
        "replay/unsupported-model",
        "-",
        None,
        lambda d: moving(d).kind == "ball" and np.isclose(present(moving(d).limits).upper, np.pi / 2),
    ),
    "MJCF freejoint": Case(
        mjcf('<body name="a"><freejoint/><geom size="1"/></body>'),
        "read",
        "-",
        None,
        lambda d: (moving(d).kind, moving(d).name) == ("floating", "a_joint0"),
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
    "MJCF range without limited, autolimits off": Case(
        mjcf(HINGE.format('range="0 90"'), '<compiler autolimits="false"/>'), "read", "-", "robot/invalid-value"
    ),
    "MJCF limited=false": Case(
        mjcf(HINGE.format('range="0 90" limited="false"')),
        "read",
        "-",
        None,
        lambda d: (moving(d).kind, moving(d).limits) == ("continuous", None),
    ),
    "MJCF angles in radians": Case(
        mjcf(HINGE.format('range="0 1"'), '<compiler angle="radian"/>'),
        "read",
        "-",
        None,
        lambda d: moving(d).limits == JointLimits(0.0, 1.0),
    ),
    "MJCF eulerseq": Case(
        mjcf('<body name="a" euler="0 0 90"/>', '<compiler eulerseq="ZYX"/>'),
        "read",
        "-",
        None,
        lambda d: turned(d, (0.0, -1.0, 0.0)),
    ),
    "MJCF eulerseq of other letters": Case(
        mjcf('<body euler="0 90 90"/>', '<compiler eulerseq="abc"/>'), "crash", "-", "robot/invalid-value"
    ),
    "MJCF two orientations": Case(
        mjcf('<body euler="90 0 0" quat="1 0 0 0"/>'), "one of them", "-", "robot/invalid-orientation"
    ),
    "MJCF orientation over another one of a class": Case(
        mjcf(
            '<body name="a"><geom size="1" zaxis="0 1 0"/></body>',
            '<default><geom axisangle="1 0 0 90"/></default>',
        ),
        "that of the class",
        "-",
        None,
        lambda d: np.allclose(one_shape(d).X_LS[:3, 2], [0.0, 1.0, 0.0]),
    ),
    "MJCF zaxis of zeros": Case(
        mjcf('<body zaxis="0 0 0"/>'), "replay/invalid-value", "-", "robot/invalid-orientation"
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
    "MJCF mesh folder": Case(
        mjcf('<geom type="mesh" mesh="a"/>', '<compiler meshdir="m"/><asset><mesh file="a.obj"/></asset>')
        | {"m/a.obj": OBJ},
        "read",
        "-",
        None,
        lambda d: mesh_path(d) == "m/a.obj",
    ),
    "MJCF strippath": Case(
        mjcf(
            '<geom type="mesh" mesh="a"/>',
            '<compiler meshdir="m" strippath="true"/><asset><mesh file="C:/far/a.obj"/></asset>',
        )
        | {"m/a.obj": OBJ},
        "replay/missing-mesh",
        "-",
        None,
        lambda d: mesh_path(d) == "m/a.obj",
    ),
    "MJCF mesh with refpos": Case(
        mjcf('<geom type="mesh" mesh="a"/>', '<asset><mesh file="a.obj" refpos="1 0 0" scale="2 2 2"/></asset>')
        | {"a.obj": OBJ},
        "replay/unsupported-model",
        "-",
        None,
        lambda d: present(one_shape(d).mesh).reference_position_m == (1.0, 0.0, 0.0),
    ),
    "MJCF mesh in the model": Case(
        mjcf('<geom type="mesh" mesh="a"/>', '<asset><mesh name="a" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'),
        "replay/unsupported-model",
        "-",
        None,
        lambda d: present(present(one_shape(d).mesh).vertices).shape == (4, 3),
    ),
    "MJCF primitive fitted to a mesh": Case(
        mjcf('<geom type="box" mesh="a"/>', '<asset><mesh file="a.obj"/></asset>') | {"a.obj": OBJ},
        "replay/unsupported-model",
        "-",
        None,
        lambda d: present(one_shape(d).problem).code == "robot/unsupported-shape",
        ("robot/unsupported-shape",),
    ),
    "MJCF geom with a mesh and no type": Case(
        mjcf('<geom mesh="a"/>', '<asset><mesh file="a.obj"/></asset>') | {"a.obj": OBJ},
        "taken as a mesh",
        "-",
        None,
        lambda d: one_shape(d).kind == "fitted",  # MuJoCo: a sphere fitted to the mesh.
        ("robot/unsupported-shape",),
    ),
    "MJCF box between two points": Case(
        mjcf('<geom type="box" size="0.1" fromto="0 0 0 0 0 2"/>'),
        "z axis the other way",
        "-",
        None,
        lambda d: np.allclose(one_shape(d).X_LS[:3, 2], [0.0, 0.0, -1.0]) and one_shape(d).size_m == (0.2, 0.2, 2.0),
    ),
    "MJCF heightfield": Case(
        mjcf('<geom type="hfield" hfield="h"/>'),
        "replay/unsupported-model",
        "-",
        None,
        lambda d: one_shape(d).kind == "heightfield",
        ("robot/unsupported-shape",),
    ),
    "MJCF drawn geom of no size": Case(
        mjcf('<geom type="box" size="1 0 1" contype="0" conaffinity="0"/>'),
        "read",
        "-",
        None,
        lambda d: present(one_shape(d).problem).code == "robot/invalid-size",
        ("robot/invalid-size",),
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
    "MJCF inertial beside geoms": Case(
        mjcf('<body name="a"><inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/><geom size="1"/></body>'),
        "read",
        "-",
        None,
        lambda d: present(link_mass(d.links[1])).mass_kg == 3.0,
    ),
    "MJCF inertiafromgeom": Case(
        mjcf(
            '<body name="a"><inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/><geom size="1" mass="5"/></body>',
            '<compiler inertiafromgeom="true"/>',
        ),
        "read",
        "-",
        None,
        lambda d: present(link_mass(d.links[1])).mass_kg == 5.0,
    ),
    "MJCF balanceinertia": Case(
        mjcf(HINGE.format(""), '<compiler balanceinertia="true"/>'),
        "read",
        "-",
        None,
        lambda d: d.settings["balanceinertia"] == "true",
    ),
    # Classes and includes.
    "MJCF nested classes": Case(
        mjcf('<body name="a" childclass="outer"><joint name="j"/><geom class="inner"/></body>', NESTED),
        "read",
        "-",
        None,
        lambda d: (one_shape(d).size_m, one_shape(d).density_kgm3, moving(d).kind) == ((0.3,), 10.0, "prismatic"),
    ),
    "MJCF class that is not there": Case(
        mjcf('<geom class="wood" size="1"/>'), "replay/invalid-value", "-", "robot/unknown-class"
    ),
    "MJCF class defined twice": Case(
        mjcf(before='<default><default class="a"/><default class="a"/></default>'),
        "last one won",
        "-",
        "robot/duplicate-name",
    ),
    "MJCF include in a folder": Case(
        mjcf(
            '<include file="parts/a.xml"/>',
            **{"parts/a.xml": "<mujocoinclude>" + HINGE.format("") + "</mujocoinclude>"},
        ),
        "read",
        "-",
        None,
        lambda d: moving(d).source.file == "parts/a.xml",
    ),
    "MJCF include that climbs and comes back": Case(
        {
            "m/model.xml": '<mujoco><worldbody><include file="../m/a.xml"/></worldbody></mujoco>',
            "m/a.xml": f"<mujoco>{HINGE.format('')}</mujoco>",
        },
        "read",
        "-",
        None,
        lambda d: moving(d).source.file == "m/a.xml",
    ),
    "MJCF include beside the including file": Case(
        mjcf(
            '<include file="parts/a.xml"/>',
            **{
                "parts/a.xml": '<mujoco><include file="b.xml"/></mujoco>',
                "parts/b.xml": f"<mujoco>{HINGE.format('')}</mujoco>",
            },
        ),
        "replay/missing-file",
        "-",
        None,
        lambda d: moving(d).source.file == "parts/b.xml",
    ),
    "MJCF includes in a circle": Case(
        mjcf('<include file="a.xml"/>', **{"a.xml": '<mujoco><include file="model.xml"/></mujoco>'}),
        "replay/invalid-value",
        "-",
        "robot/repeated-include",
    ),
    "MJCF include twice": Case(
        mjcf('<include file="a.xml"/><include file="a.xml"/>', **{"a.xml": "<mujoco/>"}),
        "read",
        "-",
        "robot/repeated-include",
    ),
    "MJCF include outside": Case(
        mjcf(before='<include file="../../a.xml"/>'), "replay/path-escape", "-", "robot/path-escape"
    ),
    "MJCF absolute include outside": Case(
        mjcf(before='<include file="/etc/hostname"/>'), "replay/path-escape", "-", "robot/path-escape"
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
    "MJCF tendons, sensors, actuators": Case(
        {
            "model.xml": "<mujoco><worldbody/><tendon><fixed/></tendon><actuator><motor/></actuator>\n"
            "<sensor><gyro/></sensor><equality><weld/></equality></mujoco>"
        },
        "dropped",
        "-",
        None,
        lambda d: (
            [(e.tag, e.source.line) for e in d.unread] == [("tendon", 1), ("actuator", 1), ("sensor", 2), ("weld", 2)]
        ),
        ("robot/unread-element",) * 4,
    ),
    "MJCF element that makes bodies": Case(
        mjcf('<body name="a"><composite type="cable"/></body>'),
        "replay/unsupported-model",
        "-",
        None,
        lambda d: [e.changes_bodies for e in d.unread] == [True],
        ("robot/unread-element",),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_case_is_settled(name: str, tmp_path: Path) -> None:
    case = CASES[name]
    path = write(case.files, tmp_path)
    read_file = read_urdf if path.suffix == ".urdf" else read_mjcf
    if case.code is not None:
        with pytest.raises(InvalidInput) as refused:
            read_file(path, tmp_path)
        assert refused.value.diagnostic.code == case.code
        assert refused.value.diagnostic.where.file
        assert refused.value.diagnostic.where.line
        return
    description = read_file(path, tmp_path)
    assert case.holds(description)
    harmless = ("robot/missing-inertial", "robot/unread-element", "robot/missing-limit")
    codes = tuple(note.code for note in description.notes)
    assert tuple(c for c in codes if c in case.notes or c not in harmless) == case.notes


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
