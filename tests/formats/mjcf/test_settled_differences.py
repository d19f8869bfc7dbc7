"""The table that settled how MJCF is read: what replay's reader did before `formats`, what all of Mana does now."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from formats import link_mass, read_mjcf
from schemas.robot_description import JointLimits, RobotDescription
from tests.formats.settled import OBJ, Case, check_case, mesh_path, moving, one_shape
from tests.support.bad_inputs.robot import mjcf
from tests.support.present import present

HINGE = '<body name="a"><joint name="j" {}/><geom size="1"/></body>\n'
NESTED = """<default>
<geom size="0.1"/><default class="outer"><geom size="0.2" density="10"/><joint type="slide" axis="1 0 0"/>
<default class="inner"><geom size="0.3"/></default></default></default>
"""


def turned(d: RobotDescription, expected: tuple[float, float, float]) -> bool:
    """Whether the z axis of the first joint's child points along `expected`."""
    return bool(np.allclose(d.joints[0].X_PC[:3, 2], expected, atol=1e-12))


CASES: Mapping[str, Case] = {
    # The tree.
    "MJCF body of one name twice": Case(mjcf('<body name="a"/><body name="a"/>'), "read", "-", "robot/duplicate-name"),
    # Joints.
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
    check_case(CASES[name], read_mjcf, tmp_path)
