"""Openings of joints: shares of their range, from the limit nearer to rest."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from geom.mechanism_pose import movable_joints, opened
from tests.support.mechanism.mechanism_samples import JOINTS, articulated


def test_a_joint_opens_from_the_limit_nearer_to_rest():
    hinge = JOINTS[0]
    assert opened([hinge], 0.5) == {"hinge": pytest.approx(0.95)}
    assert opened([hinge], 0.0) == {"hinge": -0.1}
    assert opened([replace(hinge, limits=(-2.0, 0.3))], 0.0) == {"hinge": 0.3}
    assert opened([replace(hinge, limits=(-2.0, 0.3))], 1.0) == {"hinge": -2.0}


def test_a_joint_without_limits_makes_one_turn():
    turn = replace(JOINTS[2], rest=0.25)
    assert opened([turn], 0.5) == {"turn": 0.25 + math.pi}


def test_followers_ball_joints_and_closing_joints_do_not_move_on_their_own():
    mechanism = articulated().mechanism
    assert mechanism is not None
    ball = replace(JOINTS[2], name="ball", kind="ball", axis=np.array([0.0, 0.0, 1.0]))
    closing = replace(JOINTS[0], name="closing", closes_loop=True)
    joints = movable_joints(replace(mechanism, joints=(*JOINTS[:2], ball, closing)))
    assert [joint.name for joint in joints] == ["hinge"]
