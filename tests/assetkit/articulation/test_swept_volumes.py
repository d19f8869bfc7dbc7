"""Swept volumes of joints cover the moved collision shapes of all links that move, also of those that follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from assetkit.affordances.anchors import shape_of
from assetkit.articulation.swept_volumes import swept_volumes, with_swept_volumes
from geom.convex.support_function import surface
from geom.mechanism_pose import link_motions
from geom.pose import apply, pose
from schemas.articulation import SweptVolume
from schemas.mechanism import JointCoupling, Mechanism, MechanismJoint, MechanismLink
from schemas.physics import CollisionShape

DOOR = MechanismJoint(
    "hinge", "revolute", "case", "door", np.array([-0.2, -0.2, 0.0]), np.array([0.0, 0.0, -1.0]), 0.2, (0.0, 1.8)
)
KNOB = MechanismJoint("twist", "continuous", "door", "knob", np.array([0.15, -0.22, 0.3]), np.array([0.0, -1.0, 0.0]))
TRAY = MechanismJoint(
    "slide",
    "prismatic",
    "case",
    "tray",
    np.zeros(3),
    np.array([0.0, -1.0, 0.0]),
    0.02,
    (0.0, 0.2),
    coupling=JointCoupling("hinge", 0.1, 0.0),
)
SHAPES = {
    "case": [CollisionShape("box", (0.4, 0.4, 0.6), pose(None, (0.0, 0.0, 0.3)))],
    "door": [CollisionShape("box", (0.4, 0.02, 0.6), pose(None, (0.0, -0.21, 0.3)))],
    "knob": [CollisionShape("cylinder", (0.02, 0.05), pose(None, (0.15, -0.24, 0.3)))],
    "tray": [CollisionShape("sphere", (0.05,), pose(None, (0.0, -0.1, 0.3)))],
}


def mechanism(*joints: MechanismJoint) -> Mechanism:
    names = ["case", *(joint.child for joint in joints)]
    return Mechanism(tuple(MechanismLink(name, np.zeros(3)) for name in names), joints)


def covers(volume: SweptVolume, points: np.ndarray) -> bool:
    inside = np.zeros(len(points), dtype=bool)
    for prism in volume.prisms:
        level = (points[:, 2] >= prism.low_m) & (points[:, 2] <= prism.high_m)
        inside[level] |= shapely.contains_xy(shape_of(prism.polygon), points[level, 0], points[level, 1])
    return bool(inside.all())


@pytest.mark.parametrize("joints", [(DOOR,), (DOOR, KNOB), (DOOR, KNOB, TRAY)], ids=["door", "knob", "follower"])
def test_what_moves_with_a_door_lies_in_its_volume(joints: tuple[MechanismJoint, ...]) -> None:
    whole = mechanism(*joints)
    volume = swept_volumes(whole, SHAPES)["hinge"]
    for q in np.linspace(0.0, 1.8, 19):
        motions = link_motions(whole, {"hinge": float(q)})
        for joint in joints:
            for shape in SHAPES[joint.child]:
                assert covers(volume, apply(motions[joint.child], surface(shape)[0])), (joint.name, q)


def test_the_case_is_in_no_volume_and_followers_have_none() -> None:
    volumes = swept_volumes(mechanism(DOOR, KNOB, TRAY), SHAPES)
    assert set(volumes) == {"hinge", "twist"}
    assert not covers(volumes["twist"], np.array([[0.0, 0.0, 0.3]]))
    assert volumes["hinge"].volume_m3 < 0.3, "a quarter of a disc of 0.4 m, 0.6 m high, and the tray"


def test_a_joint_of_links_without_shapes_has_no_volume() -> None:
    assert swept_volumes(mechanism(replace(DOOR, rest=0.0)), {"case": SHAPES["case"]}) == {}
    assert with_swept_volumes((), {}) == ()
