"""What is written as URDF reads back as the same description; what URDF lacks is refused or named."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from formats import read_mjcf, read_urdf, write_urdf
from formats.urdf.edit import replace_physics
from schemas.diagnostics import InvalidInput
from schemas.robot_description import DescribedJoint, DescribedLink, Inertial, RobotDescription, ShapeFriction
from tests.support.bad_inputs.robot import AB, inertial, joint, link, mjcf, shape, urdf, write
from tests.support.drawn_robots import descriptions, differences


@given(descriptions("urdf"))
@settings(max_examples=150)
def test_what_is_written_reads_back_as_the_same(
    tmp_path_factory: pytest.TempPathFactory, drawn: RobotDescription
) -> None:
    path = tmp_path_factory.mktemp("law") / "model.urdf"
    written = write_urdf(drawn)
    assert written.lost == ()
    path.write_bytes(written.data)
    again = read_urdf(path)
    assert differences(drawn, again) == []
    assert differences(again, read_again(again, path)) == []


def read_again(description: RobotDescription, path: Path) -> RobotDescription:
    path.write_bytes(write_urdf(description).data)
    return read_urdf(path)


def two_links(**more: object) -> RobotDescription:
    moving = dataclasses.replace(DescribedJoint("j", "continuous", "a", "b"), **more)
    return RobotDescription("r", "urdf", (DescribedLink("a"), DescribedLink("b")), (moving,), "a")


@pytest.mark.parametrize("changed", [{"anchor_C": np.array([0.0, 0.0, 1.0])}, {"reference": 0.5}])
def test_axes_elsewhere_are_not_expressible(changed: dict[str, object]) -> None:
    with pytest.raises(InvalidInput) as refused:
        write_urdf(two_links(**changed))
    assert refused.value.diagnostic.code == "robot/not-expressible"


@pytest.mark.parametrize(
    "body",
    [
        '<body name="a"><inertial pos="0 0 0" mass="1"/><joint name="i"/><joint name="j" axis="1 0 0"/></body>',
        '<body name="a"><geom size="1"/></body>',
        '<geom type="ellipsoid" size="1 2 3"/>',
        '<geom type="hfield" hfield="h"/>',
    ],
    ids=["two joints of a body", "mass from shapes", "ellipsoid", "heightfield"],
)
def test_what_would_be_another_mechanism_is_refused(body: str, tmp_path: Path) -> None:
    description = read_mjcf(write(mjcf(body), tmp_path))
    with pytest.raises(InvalidInput) as refused:
        write_urdf(description)
    assert refused.value.diagnostic.code == "robot/not-expressible"
    assert refused.value.diagnostic.where.line


def test_numbers_that_urdf_lacks_and_unread_elements_are_named() -> None:
    headlines = [d.headline for d in write_urdf(two_links(armature=0.1, stiffness=2.0)).lost]
    assert headlines == [f"the {n} of joint 'j' is not written" for n in ("armature", "stiffness")]


def test_unread_elements_are_losses(tmp_path: Path) -> None:
    description = read_urdf(write(urdf(AB, joint("j", "a", "b"), "<gazebo/><gazebo/>\n"), tmp_path))
    assert [d.headline for d in write_urdf(description).lost] == ["<gazebo> is not written"]


def test_physics_of_a_file_is_replaced_and_the_rest_stays(tmp_path: Path) -> None:
    rough = '<collision name="c"><origin xyz="0.1 0 0" rpy="0.3 0.2 0.1"/><geometry><sphere radius="1"/></geometry>'
    rough += "<drake:proximity_properties><drake:mu_static value='1'/><drake:mu_dynamic value='1'/>"
    rough += "</drake:proximity_properties></collision>"
    plain = shape('<box size="1 1 1"/>')
    path = write(
        urdf(link("a", "<contact><lateral_friction value='1'/></contact>" + inertial(1.0) + rough + plain)), tmp_path
    )
    before = read_urdf(path)
    fresh = Inertial(2.0, np.eye(4), np.diag([1.0, 1.5, 2.0]))
    path.write_bytes(replace_physics(path, fresh, {"restitution": 0.5}, [ShapeFriction(0.7, 0.6)] * 2))
    after = read_urdf(path)
    shapes = tuple(
        dataclasses.replace(s, friction=ShapeFriction(0.7, 0.6)) if s.friction else s for s in before.links[0].shapes
    )
    expected = dataclasses.replace(before.links[0], inertial=fresh, contact={"restitution": 0.5}, shapes=shapes)
    assert differences(expected, after.links[0]) == []
    assert 'rpy="0.3 0.2 0.1"' in path.read_text()  # Digit for digit.
