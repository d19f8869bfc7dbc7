"""The gripper of PyBullet holds what friction holds, and nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

from assetkit.affordances.grasps import pad_friction, propose_grasps
from geom.pose import angle_between, pose_from_quat, quat_of, rotation_about
from schemas.affordances import Grasp
from schemas.physics import RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.grasp_trial import TILT_RAD, GraspOutcome, GraspTask, HandMotion, Phase
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


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_wrist_turns_what_it_holds_about_the_closing_axis(sense: float):
    grasp = propose_grasps(THINGS["box"], ()).grasps[0]
    phases = ((Phase.CLOSE, 0.35), (Phase.LIFT, 0.8), (Phase.TILT, 3.0), (Phase.RELEASE, 0.3))
    X_AG = pose_from_quat(np.array(grasp.quat_wxyz), grasp.position_m)
    task = GraspTask(
        X_AG, grasp.opening_m, grasp.force_n, 0.6, motion=HandMotion(phases, wrist_sense=sense), trace_s=0.05
    )
    with BulletSimulator() as simulator:
        outcome = simulator.grasp(THINGS["box"], np.eye(4), task)
    assert outcome.held
    assert outcome.slip_m < 0.01
    assert outcome.trace is not None
    middle = int(np.argmin(np.abs(outcome.trace.times_s - (0.05 + 0.35 + 0.8 + 1.5))))
    wanted = rotation_about(X_AG[:3, 0], sense * TILT_RAD)
    assert angle_between(quat_of(outcome.trace.X_WA[middle, :3, :3]), quat_of(wanted)) < math.radians(3.0)
