"""Grasps of simple bodies: in the cone, clear of body and ground, spread, and none where none can be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from assetkit.affordances.grasps import grasps_along, propose_grasps
from geom.convex.convex_union import ConvexUnion
from geom.grasp.gripper import Gripper, boxes, lowest
from geom.pose import matrix_of, pose, pose_from_quat, quat_of
from schemas.acceptance import StablePose
from schemas.physics import CollisionShape, Contact, MassProperties, RigidBody

CONTACT = Contact(static_friction=0.5, dynamic_friction=0.4, restitution=0.0)
UP = np.array([0.0, 0.0, 1.0])


def body_of(*shapes: CollisionShape, mass_kg: float = 0.2, centre_m=(0.0, 0.0, 0.05)) -> RigidBody:
    return RigidBody("thing", shapes, MassProperties(mass_kg, np.array(centre_m), 1e-4 * np.eye(3)), CONTACT)


def box(x: float, y: float, z: float, at=None) -> CollisionShape:
    return CollisionShape("box", (x, y, z), pose(None, at or (0.0, 0.0, z / 2)))


THINGS = {
    "box": body_of(box(0.05, 0.06, 0.1)),
    "can": body_of(CollisionShape("cylinder", (0.033, 0.1), pose(None, (0.0, 0.0, 0.05)))),
    "ball": body_of(CollisionShape("sphere", (0.03,), pose(None, (0.0, 0.0, 0.03))), centre_m=(0.0, 0.0, 0.03)),
    "hammer": body_of(
        box(0.2, 0.02, 0.02, (0.0, 0.0, 0.05)), box(0.03, 0.03, 0.1, (0.1, 0.0, 0.05)), centre_m=(0.07, 0.0, 0.05)
    ),
}


@pytest.mark.parametrize("name", THINGS)
def test_every_grasp_lies_in_the_cone_and_is_clear_of_body_and_ground(name: str):
    body, gripper = THINGS[name], Gripper()
    grasps = propose_grasps(body, ()).grasps
    assert 1 <= len(grasps) <= 16
    union = ConvexUnion(body.shapes)
    for grasp in grasps:
        first, second = np.array(grasp.contacts_m)
        X_AG = pose_from_quat(np.array(grasp.quat_wxyz), grasp.position_m)
        assert grasp.angle_rad < grasp.cone_rad
        assert np.linalg.norm(second - first) == pytest.approx(grasp.width_m, abs=1e-6)
        assert X_AG[:3, 0] @ (second - first) == pytest.approx(grasp.width_m, abs=1e-6)
        assert grasp.width_m + 2 * gripper.least_m <= grasp.opening_m + 1e-9
        X_GB, half = boxes(gripper, np.array([grasp.opening_m]))
        X_AB = X_AG @ X_GB
        assert all(union.box_clear(X_AB[:, b], half[:, b] - 1e-5).all() for b in range(3))
        assert lowest(X_AB, half, UP)[0] > 0.0


def test_grasps_are_sorted_and_named_by_quality():
    grasps = propose_grasps(THINGS["box"], ()).grasps
    qualities = [g.quality for g in grasps]
    assert qualities == sorted(qualities, reverse=True)
    assert [g.affordance_id for g in grasps] == [f"grasp_{i:02d}" for i in range(1, len(grasps) + 1)]
    assert propose_grasps(THINGS["box"], ()) == propose_grasps(THINGS["box"], ())


def test_the_best_grasp_of_a_hammer_is_near_its_mass_centre():
    best = propose_grasps(THINGS["hammer"], ()).grasps[0]
    assert np.linalg.norm(np.array(best.contacts_m).mean(axis=0) - THINGS["hammer"].mass.centre_of_mass_m) < 0.03


@pytest.mark.parametrize(
    ("body", "why"),
    [
        (body_of(box(0.2, 0.2, 0.2)), "wide"),
        (body_of(box(0.05, 0.06, 0.1), mass_kg=20.0), "weighs"),
        (body_of(box(0.2, 0.2, 0.01), centre_m=(0.0, 0.0, 0.005)), "ground"),
    ],
)
def test_what_no_gripper_takes_has_no_grasp_and_a_reason(body: RigidBody, why: str):
    proposed = propose_grasps(body, ())
    assert proposed.grasps == ()
    assert why in proposed.reason


def test_a_plate_that_lies_flat_is_taken_in_the_pose_in_which_it_stands():
    plate = body_of(box(0.2, 0.2, 0.03), centre_m=(0.0, 0.0, 0.015))
    on_edge = quat_of(Rotation.from_euler("x", 90, degrees=True).as_matrix())
    poses = [
        StablePose(quat_wxyz=(1.0, 0.0, 0.0, 0.0), support_offset_m=0.0, probability=0.9),
        StablePose(quat_wxyz=tuple(on_edge.tolist()), support_offset_m=0.1, probability=0.1),
    ]
    grasps = propose_grasps(plate, poses).grasps
    assert any(1 in g.poses for g in grasps)
    for grasp in grasps:
        X_AG = pose_from_quat(np.array(grasp.quat_wxyz), grasp.position_m)
        X_GB, half = boxes(Gripper(), np.array([grasp.opening_m]))
        for index in grasp.poses:
            up = matrix_of(np.array(poses[index].quat_wxyz))[2]
            assert lowest(X_AG @ X_GB, half, up)[0] + poses[index].support_offset_m > 0.0


def test_slippery_wedges_are_not_grasped():
    points = np.array([[x, y, z] for x in (-0.03, 0.03) for y, z in ((-0.03, 0.0), (0.03, 0.0), (0.0, 0.04))])
    from geom.convex.hull import hull_shape

    wedge = hull_shape(points)
    assert wedge is not None
    slippery = Contact(static_friction=0.1, dynamic_friction=0.05, restitution=0.0, combine="minimum")
    body = RigidBody("wedge", (wedge,), MassProperties(0.1, np.array([0, 0, 0.015]), 1e-5 * np.eye(3)), slippery)
    for grasp in propose_grasps(body, ()).grasps:
        axis = np.subtract(*grasp.contacts_m)
        assert abs(axis[0]) / np.linalg.norm(axis) > math.cos(0.06)  # only along the prism


def test_grasps_along_a_line_close_on_that_line_alone() -> None:
    body = body_of(box(0.05, 0.2, 0.1))
    line = ((-0.04, 0.03, 0.06), (0.04, 0.03, 0.06))
    made = grasps_along([line], body, ())
    assert made.grasps
    for grasp in made.grasps:
        first, second = np.array(grasp.contacts_m)
        np.testing.assert_allclose(first, (-0.025, 0.03, 0.06), atol=1e-4)
        np.testing.assert_allclose(second, (0.025, 0.03, 0.06), atol=1e-4)
        assert grasp.width_m == pytest.approx(0.05, abs=1e-4)
        closing = matrix_of(np.array(grasp.quat_wxyz))[:, 0]
        assert abs(closing[0]) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(
    "line",
    [
        ((0.0, -0.15, 0.05), (0.0, 0.15, 0.05)),  # 0.2 m wide there
        ((-0.04, 0.0, 0.2), (0.04, 0.0, 0.2)),  # above it
        ((0.0, 0.0, 0.05), (0.0, 0.0, 0.05)),  # without a direction
    ],
)
def test_lines_that_no_gripper_can_close_along_give_none(line) -> None:
    made = grasps_along([line], body_of(box(0.05, 0.2, 0.1)), ())
    assert made.grasps == ()
    assert "no line crosses" in made.reason
