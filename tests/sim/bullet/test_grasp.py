"""The gripper of PyBullet holds what friction holds, and nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

from assetkit.affordances.grasps import pad_friction, propose_grasps
from geom.pose import pose_from_quat
from schemas.affordances import Grasp
from schemas.physics import RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.grasp_trial import GraspOutcome, GraspTask
from tests.assetkit.affordances.test_grasps import THINGS


def lift(body: RigidBody, grasp: Grasp, *, friction: float | None = None, force: float = 1.0) -> GraspOutcome:
    task = GraspTask(
        pose_from_quat(np.array(grasp.quat_wxyz), grasp.position_m),
        grasp.opening_m,
        force * grasp.force_n,
        pad_friction(body.contact) if friction is None else friction,
    )
    with BulletSimulator() as simulator:
        return simulator.grasp(body, np.eye(4), task)


@pytest.mark.parametrize("name", THINGS)
def test_the_best_grasp_holds_and_lets_go(name: str):
    outcome = lift(THINGS[name], propose_grasps(THINGS[name], ()).grasps[0])
    assert outcome.held
    assert outcome.released
    assert outcome.slip_m < 0.01


def test_pads_that_are_too_smooth_or_too_weak_do_not_hold():
    body = THINGS["box"]
    grasp = propose_grasps(body, ()).grasps[0]
    for outcome in (lift(body, grasp, friction=0.05), lift(body, grasp, force=0.2)):
        assert not outcome.held
        assert math.isinf(outcome.slip_m)


def test_pads_beside_the_body_hold_nothing():
    grasp = propose_grasps(THINGS["box"], ()).grasps[0]
    beside = grasp.model_copy(update={"position_m": (0.3, 0.3, 0.1)})
    assert not lift(THINGS["box"], beside).held


def test_equal_trials_end_equal():
    grasp = propose_grasps(THINGS["can"], ()).grasps[0]
    assert lift(THINGS["can"], grasp) == lift(THINGS["can"], grasp)
