"""Links and joints of foreign stages: units, frames, directions, loops, surroundings; and packages read as sources."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from schemas.mechanism import Mechanism
from tests.support.present import present
from tests.support.usd_files import model_of, read, rejection, write

BODY = """def Xform "{}" (
 prepend apiSchemas = ["PhysicsRigidBodyAPI"]
) {{
 double3 xformOp:translate = {}
 float3 xformOp:scale = {}
 uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
 def Cube "c" {{}}
}}
"""
A, B, C = (
    BODY.format(name, at, "(1, 1, 1)") for name, at in (("a", "(0, 0, 0)"), ("b", "(3, 0, 0)"), ("c", "(6, 0, 0)"))
)


def joint(name: str, first: str, second: str, more: str = "", kind: str = "Revolute") -> str:
    ends = "".join(f"rel physics:body{i} = </Root/{b}>\n" for i, b in enumerate((first, second)) if b)
    return f'def Physics{kind}Joint "{name}" {{\n{ends}{more}\n}}\n'


def follower(name: str, first: str, second: str, leader: str) -> str:
    return joint(name, first, second, f"rel newton:mimicJoint = </Root/{leader}>")


def mechanism_of(folder: Path, body: str, header: str = "") -> Mechanism:
    text = f'defaultPrim = "Root"\n metersPerUnit = 1\n upAxis = "Z"\n {header}'
    return present(model_of(write(folder, body, text)).mechanism)


def test_degrees_frames_and_drives(tmp_path: Path) -> None:
    hinge = """uniform token physics:axis = "Z"
 point3f physics:localPos0 = (2, 0, 0)
 point3f physics:localPos1 = (-1, 0, 0)
 float physics:lowerLimit = -90
 float physics:upperLimit = 45"""
    drive = """prepend apiSchemas = ["PhysicsDriveAPI:angular"]"""
    text = joint("hinge", "a", "b", hinge).replace('Joint "hinge" {', f'Joint "hinge" (\n {drive}\n) {{')
    values = """float drive:angular:physics:damping = 2
 float drive:angular:physics:stiffness = 3
 float drive:angular:physics:targetPosition = 30
 float drive:angular:physics:maxForce = 7"""
    (found,) = mechanism_of(
        tmp_path, A + B + text.replace("float physics:lower", f"{values}\n float physics:lower")
    ).joints
    assert (found.parent, found.child, found.kind) == ("a", "b", "revolute")
    assert found.anchor == pytest.approx([2, 0, 0])
    assert found.axis == pytest.approx([0, 0, 1])
    assert present(found.limits) == pytest.approx(np.radians([-90, 45]))
    assert (found.damping, found.stiffness) == pytest.approx((np.degrees(2), np.degrees(3)))
    assert (found.spring_rest, found.effort) == pytest.approx((np.radians(30), 7))


def test_forces_of_a_stage_in_centimetres_are_si(tmp_path: Path) -> None:
    values = "float drive:{0}:physics:damping = 2\n float drive:{0}:physics:maxForce = 3\n"
    schemas = 'prepend apiSchemas = ["PhysicsDriveAPI:{}"]'
    header = 'defaultPrim = "Root"\n metersPerUnit = 0.01\n upAxis = "Z"'
    for kind, name, damping, effort in (
        ("Revolute", "angular", np.degrees(2) * 1e-4, 3e-4),
        ("Prismatic", "linear", 2.0, 0.03),
    ):
        text = joint("j", "a", "b", values.format(name), kind)
        text = text.replace('Joint "j" {', f'Joint "j" (\n {schemas.format(name)}\n) {{')
        (described,) = present(model_of(write(tmp_path, A + B + text, header)).mechanism).joints
        assert (described.damping, described.effort) == pytest.approx((damping, effort))


def test_positions_at_rest_come_from_the_frames(tmp_path: Path) -> None:
    slide = 'uniform token physics:axis = "X"\n point3f physics:localPos0 = (1, 0, 0)\n'
    limits = "float physics:lowerLimit = 0\n float physics:upperLimit = 5"
    (found,) = mechanism_of(tmp_path, A + B + joint("slide", "a", "b", slide + limits, "Prismatic")).joints
    assert found.rest == pytest.approx(2.0)  # b stands at 3, the frame of a at 1
    half_turn = 'uniform token physics:axis = "Z"\n quatf physics:localRot0 = (0.70710678, 0, 0, 0.70710678)\n'
    (turned,) = mechanism_of(tmp_path, A + B + joint("hinge", "a", "b", half_turn)).joints
    assert turned.rest == pytest.approx(-np.pi / 2)


def test_positions_are_scaled_with_their_prim_and_directions_are_not(tmp_path: Path) -> None:
    scaled = BODY.format("a", "(0, 0, 0)", "(0.5, 2, 2)")
    places = "point3f physics:localPos0 = (4, 0, 0)\n point3f physics:localPos1 = (-1, 0, 0)"
    hinge = f'uniform token physics:axis = "X"\n {places}'
    (found,) = mechanism_of(tmp_path, scaled + B + joint("hinge", "a", "b", hinge)).joints
    assert found.anchor == pytest.approx([2, 0, 0])
    assert found.axis == pytest.approx([1, 0, 0])


def test_a_joint_written_the_other_way_round_turns_the_same_way(tmp_path: Path) -> None:
    limits = 'uniform token physics:axis = "Z"\n float physics:lowerLimit = 0\n float physics:upperLimit = 90'
    base = joint("ground", "", "a", kind="Fixed")
    (found,) = mechanism_of(tmp_path, A + B + base + joint("hinge", "b", "a", limits)).joints
    assert (found.parent, found.child) == ("a", "b")
    assert found.axis == pytest.approx([0, 0, -1])
    assert present(found.limits) == pytest.approx((0.0, np.pi / 2))


def test_a_loop_keeps_its_closing_joint_beside_the_tree(tmp_path: Path) -> None:
    ring = joint("i", "a", "b") + joint("j", "b", "c") + joint("k", "c", "a")
    outcome = read(write(tmp_path, A + B + C + ring))
    mechanism = present(present(outcome.value).mechanism)
    assert [j.name for j in mechanism.joints if j.closes_loop] == ["j"]
    assert len(mechanism.tree) == 2
    assert "robot/closing-joint" in [d.code for d in outcome.diagnostics]
    excluded = ring.replace('"i" {', '"i" {\nbool physics:excludeFromArticulation = 1')
    found = present(model_of(write(tmp_path, A + B + C + excluded)).mechanism)
    assert [j.name for j in found.joints if j.closes_loop] == ["i"]


def test_ground_that_no_joint_leads_to_is_left_out(tmp_path: Path) -> None:
    outcome = read(write(tmp_path, A + B + 'def Cube "ground" {}\n' + joint("hinge", "a", "b")))
    assert {mesh.link for mesh in present(outcome.value).meshes} == {"a", "b"}
    assert "asset/geometry-left-out" in [d.code for d in outcome.diagnostics]


def test_a_static_cabinet_is_the_base_of_its_door(tmp_path: Path) -> None:
    static = 'def Xform "box" {\n def Cube "c" {}\n}\n'
    model = model_of(write(tmp_path, static + B + joint("hinge", "box", "b")))
    mechanism = present(model.mechanism)
    assert [link.members for link in mechanism.links] == [("world",), ("b",)]
    assert mechanism.fixed_base


@pytest.mark.parametrize(
    ("code", "joints"),
    [
        ("robot/not-expressible", joint("rope", "a", "b", kind="Distance")),
        ("robot/several-roots", joint("hinge", "a", "b")),
        ("robot/invalid-number", joint("hinge", "a", "b", "float physics:lowerLimit = nan") + joint("i", "b", "c")),
        ("robot/mimic-cycle", follower("i", "a", "b", "j") + follower("j", "b", "c", "i")),
        ("robot/unknown-reference", joint("k", "a", "a") + follower("i", "a", "b", "k") + joint("j", "b", "c")),
        ("robot/zero-axis", joint("hinge", "a", "b", "quatf physics:localRot0 = (0, 0, 0, 0)") + joint("i", "b", "c")),
    ],
)
def test_what_no_package_can_hold_is_refused(code: str, joints: str, tmp_path: Path) -> None:
    assert rejection(write(tmp_path, A + B + C + joints)).code == code
