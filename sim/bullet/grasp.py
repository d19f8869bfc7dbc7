"""Simulate a grasp with a parallel-jaw gripper in PyBullet: close on a body, lift, hold, shake, release.

The hand is mounted on three prismatic joints along the world axes, so that its motion is prescribed and its contacts
are not; two fingers slide in it, coupled by a gear, for without it both drift to one side with the body between them.
"""

from __future__ import annotations

import math

import numpy as np
import pybullet

from geom import pose
from geom.convex.support_function import diagonal
from geom.grasp.gripper import boxes
from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import RigidBody
from sim.bullet.world import dynamic_body, private_client, scaled
from sim.port import GraspOutcome, GraspTask, model_scale

GRASP_STEP_S = 1.0 / 240.0
# Seconds until each phase ends.
REST_S, CLOSED_S, LIFTED_S, HELD_S, SHAKEN_S, RELEASED_S = 0.05, 0.35, 1.15, 2.15, 3.65, 4.0
LIFT_M, DROP_M = 0.3, 0.1
SHAKE_HZ, SHAKE_M = 2.0, 0.01
CLOSING_MPS = 0.05
HAND_FORCE_FACTOR = 100.0  # times the weight of hand and body: force limit of the joints that move the hand
LINK_KG = 0.5
_X, _Y, _Z, _HAND, _LEFT, _RIGHT = range(6)


def grasp_and_lift(body: RigidBody, X_WA: FloatArray, task: GraspTask) -> GraspOutcome:
    """See `sim.port.Simulator`. Raises RuntimeError when PyBullet has no client left."""
    with private_client() as client:
        return _Trial(client, body, X_WA, task).run()


class _Trial:
    """One body and one gripper in a world of their own, `scale` times as large (Froude similarity, `model_scale`)."""

    def __init__(self, client: int, body: RigidBody, X_WA: FloatArray, task: GraspTask) -> None:
        self._client, self._task, self._steps = client, task, 0
        self._scale = model_scale(diagonal(body.shapes))
        self._time_scale = math.sqrt(self._scale)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=GRASP_STEP_S,
            numSolverIterations=60,
            enableFileCaching=0,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )
        pybullet.setGravity(0.0, 0.0, -GRAVITY_MPS2, physicsClientId=client)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
        pybullet.createMultiBody(0, plane, useMaximalCoordinates=1, physicsClientId=client)
        self._body = self._place_body(body, X_WA)
        X_WG = X_WA @ task.X_AG
        self._hand = self._build_gripper(X_WG)
        self._weight_n = (body.mass.mass_kg * self._scale**3 + 6.0 * LINK_KG) * GRAVITY_MPS2
        self._R_WG = X_WG[:3, :3]

    def run(self) -> GraspOutcome:
        """The whole motion; it ends early when the body has fallen."""
        self._step_until(REST_S, 0.0)
        self._step_until(CLOSED_S, 1.0)
        closed = self._in_gripper()
        height_m = self._height()
        for end_s in (LIFTED_S, HELD_S, SHAKEN_S):
            self._step_until(end_s, 1.0)
            if not self._is_up(height_m):
                return GraspOutcome(held=False, released=False, slip_m=math.inf)
        slip_m = float(np.linalg.norm(self._in_gripper() - closed)) / self._scale
        before_m = self._height()
        self._step_until(RELEASED_S, -1.0)
        return GraspOutcome(held=True, released=before_m - self._height() > DROP_M * self._scale, slip_m=slip_m)

    def _is_up(self, from_m: float) -> bool:
        """Whether the body is lifted and both fingers touch it."""
        up = self._height() - from_m >= (LIFT_M - DROP_M) * self._scale
        return up and all(
            pybullet.getContactPoints(self._hand, self._body, link, -1, physicsClientId=self._client)
            for link in (_LEFT, _RIGHT)
        )

    def _step_until(self, end_s: float, closing: float) -> None:
        """Step to a moment; the fingers close (1), stay (0) or open (-1)."""
        client, joint = self._client, pybullet.setJointMotorControl2
        force = self._task.force_n * self._scale**3
        for finger in (_LEFT, _RIGHT):
            joint(
                self._hand,
                finger,
                pybullet.VELOCITY_CONTROL,
                targetVelocity=closing * CLOSING_MPS * self._time_scale,
                force=force + HAND_FORCE_FACTOR * self._weight_n * (closing <= 0.0),
                physicsClientId=client,
            )
        while self._steps * GRASP_STEP_S < end_s * self._time_scale - 1e-9:
            self._steps += 1
            place, moving = _hand_at(self._steps * GRASP_STEP_S / self._time_scale)
            pybullet.setJointMotorControlArray(
                self._hand,
                [_X, _Y, _Z],
                pybullet.POSITION_CONTROL,
                targetPositions=(place * self._scale).tolist(),
                targetVelocities=(moving * self._time_scale).tolist(),
                forces=[HAND_FORCE_FACTOR * self._weight_n] * 3,
                positionGains=[0.3] * 3,
                velocityGains=[1.0] * 3,
                physicsClientId=client,
            )
            pybullet.stepSimulation(physicsClientId=client)

    def _height(self) -> float:
        """Height of the mass centre, model metres; NaN compares as fallen."""
        return pybullet.getBasePositionAndOrientation(self._body, physicsClientId=self._client)[0][2]

    def _in_gripper(self) -> FloatArray:
        """(3,) mass centre in the axes of the gripper, from the hand, model metres."""
        where = pybullet.getBasePositionAndOrientation(self._body, physicsClientId=self._client)[0]
        hand = pybullet.getLinkState(self._hand, _HAND, physicsClientId=self._client)[0]
        return (np.array(where) - np.array(hand)) @ self._R_WG

    def _place_body(self, body: RigidBody, X_WA: FloatArray) -> int:
        client, scale = self._client, self._scale
        dynamic = dynamic_body(body.shapes, body.mass, scale, client)
        pybullet.changeDynamics(dynamic.handle, -1, lateralFriction=self._task.friction, physicsClientId=client)
        X_WI = scaled(X_WA, scale) @ dynamic.X_AI
        quat_xyzw = pose.to_xyzw(pose.quat_of(X_WI[:3, :3])).tolist()
        pybullet.resetBasePositionAndOrientation(
            dynamic.handle, X_WI[:3, 3].tolist(), quat_xyzw, physicsClientId=client
        )
        return dynamic.handle

    def _build_gripper(self, X_WG: FloatArray) -> int:
        """Base at the grip centre; links: three slides along the world axes, hand, left and right finger."""
        client, scale = self._client, self._scale
        X_GB, half = boxes(self._task.gripper, np.array([self._task.opening_m]))
        shapes = [
            pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=(scale * h).tolist(), physicsClientId=client)
            for h in half[0]
        ]
        left, right, hand = (scale * X_GB[0, b, :3, 3] for b in range(3))
        none, here, level = -1, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]
        turned = pose.to_xyzw(pose.quat_of(X_WG[:3, :3])).tolist()
        slide, fixed = pybullet.JOINT_PRISMATIC, pybullet.JOINT_FIXED
        gripper = pybullet.createMultiBody(
            baseMass=0.0,
            basePosition=(scale * X_WG[:3, 3]).tolist(),
            linkMasses=[LINK_KG] * 6,
            linkCollisionShapeIndices=[none, none, none, shapes[2], shapes[0], shapes[1]],
            linkVisualShapeIndices=[none] * 6,
            linkPositions=[
                here,
                here,
                here,
                (X_WG[:3, :3] @ hand).tolist(),
                (left - hand).tolist(),
                (right - hand).tolist(),
            ],
            linkOrientations=[level, level, level, turned, level, level],
            linkInertialFramePositions=[here] * 6,
            linkInertialFrameOrientations=[level] * 6,
            linkParentIndices=[0, 1, 2, 3, 4, 4],
            linkJointTypes=[slide, slide, slide, fixed, slide, slide],
            linkJointAxis=[[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1], [1, 0, 0], [-1, 0, 0]],
            physicsClientId=client,
        )
        gear = pybullet.createConstraint(
            gripper, _LEFT, gripper, _RIGHT, pybullet.JOINT_GEAR, [1, 0, 0], here, here, physicsClientId=client
        )
        pybullet.changeConstraint(gear, gearRatio=-1, erp=0.5, maxForce=1e4 * scale**3, physicsClientId=client)
        for link in range(6):
            pybullet.changeDynamics(
                gripper, link, lateralFriction=1.0, linearDamping=0.0, angularDamping=0.0, physicsClientId=client
            )
            pybullet.setCollisionFilterGroupMask(gripper, link, 2, 1, physicsClientId=client)
        return gripper


def _hand_at(time_s: float) -> tuple[FloatArray, FloatArray]:
    """Where the hand is to be (3,), from where it began, and its velocity (3,): smooth lift, then circles."""
    share = min(max((time_s - CLOSED_S) / (LIFTED_S - CLOSED_S), 0.0), 1.0)
    height = LIFT_M * share * share * (3.0 - 2.0 * share)
    rising = LIFT_M * 6.0 * share * (1.0 - share) / (LIFTED_S - CLOSED_S)
    place, moving = np.array([0.0, 0.0, height]), np.array([0.0, 0.0, rising])
    if HELD_S < time_s <= SHAKEN_S:
        rate = 2.0 * math.pi * SHAKE_HZ
        turn = rate * (time_s - HELD_S)
        place[:2] = SHAKE_M * np.array([math.sin(turn), 1.0 - math.cos(turn)])
        moving[:2] = SHAKE_M * rate * np.array([math.cos(turn), math.sin(turn)])
    return place, moving
