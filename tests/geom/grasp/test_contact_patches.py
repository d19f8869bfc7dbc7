"""What pads touch of boxes, edges and balls, and the force that then holds a weight."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geom.convex.convex_union import ConvexUnion
from geom.grasp.contact_patches import LEAST_ARM_M, ContactPatches, contact_patches, holding_force
from geom.grasp.gripper import Gripper
from geom.pose import pose
from schemas.physics import CollisionShape

GRIPPER = Gripper()


def patches(
    shape: Literal["box", "sphere"],
    size: tuple[float, ...],
    width_m: float,
    X_WA: np.ndarray | None = None,
    z: float = 0.0,
) -> ContactPatches:
    """The grasp along x with its pads at height z, both turned and moved by X_WA."""
    X_WA = pose() if X_WA is None else X_WA
    union = ConvexUnion([CollisionShape(shape, size, X_WA)])
    X_AG = X_WA @ pose(None, (0.0, 0.0, z))
    return contact_patches(union, X_AG[None], np.array([width_m]), GRIPPER)


def test_a_face_fills_the_pads() -> None:
    """Friction of a square turns about its middle at 0.383 of its edge; nine points make it 0.358."""
    found = patches("box", (0.04, 0.1, 0.1), 0.04)
    assert found.share == pytest.approx([1.0])
    assert found.arm_m == pytest.approx([0.383 * 0.02], rel=0.07)
    assert found.middle_m == pytest.approx(np.zeros((1, 3)))


def test_pads_that_reach_over_an_edge_touch_with_the_rest() -> None:
    """One of three rows; its middle lies below the middle of the pads."""
    found = patches("box", (0.04, 0.1, 0.1), 0.04, z=0.052)
    assert found.share == pytest.approx([1.0 / 3.0])
    assert found.middle_m[0, 2] < 0.052 - 0.005


def test_round_things_are_touched_less_the_smaller_they_are() -> None:
    """A cap of 1 mm height has the radius sqrt(2 r h)."""
    shares = [patches("sphere", (r,), 2.0 * r).share[0] for r in (0.005, 0.02, 0.035)]
    assert shares == sorted(shares)
    assert shares[0] < 0.2 < shares[2] < 1.0


def test_patches_turn_and_move_with_the_body() -> None:
    X_WA = pose(Rotation.from_rotvec([0.3, -0.7, 0.4]).as_matrix(), (0.2, 0.1, -0.3))
    here, there = (patches("box", (0.04, 0.03, 0.012), 0.04, X, z=0.004) for X in (None, X_WA))
    assert there.share == pytest.approx(here.share)
    assert there.arm_m == pytest.approx(here.arm_m)
    assert there.middle_m[0] == pytest.approx(X_WA[:3, :3] @ here.middle_m[0] + X_WA[:3, 3], abs=1e-9)


def test_a_weight_off_the_line_of_the_pads_and_a_lean_need_more_force() -> None:
    """Twice the arm away it takes sqrt(5) times as much; straight below it takes half the weight over the friction."""
    arm = np.full(3, 0.007)
    force = holding_force(2.0, np.array([0.0, 0.014, 0.0]), arm, np.array([0.0, 0.0, 0.3]), 0.5)
    assert force[:2] == pytest.approx([2.0, 2.0 * np.sqrt(5.0)])
    assert force[2] > force[0]
    assert np.isfinite(holding_force(2.0, np.array([0.1]), np.array([LEAST_ARM_M]), np.array([np.arctan(0.5)]), 0.5))
