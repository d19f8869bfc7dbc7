"""A grasp with a parallel-jaw gripper in PyBullet: body, ground and gripper in a world of their own.

They are simulated `scale` times as large (Froude similarity, `sim.port.model_scale`); the course of the trial is
`sim.grasp_run`.
"""

from __future__ import annotations

import math

import numpy as np
import pybullet

from geom import pose
from geom.convex.support_function import diagonal
from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import RigidBody
from sim.bullet.gripper import BulletGripper
from sim.bullet.world import dynamic_body, private_client, scaled
from sim.grasp_run import run_grasp
from sim.grasp_trial import GraspOutcome, GraspTask
from sim.gripper_description import LINK_KG
from sim.port import model_scale

HAND_FORCE_FACTOR = 100.0  # times the weight of hand and body: force limit of the joints that move the hand
_LINKS = 6  # that the mount moves at most, beside a wrist


def grasp(body: RigidBody, X_WA: FloatArray, task: GraspTask) -> GraspOutcome:
    """See `sim.port.Simulator`. Raises RuntimeError when PyBullet has no client left."""
    with private_client() as client:
        return run_grasp(_BulletGraspWorld(client, body, X_WA, task), body, X_WA, task)


class _BulletGraspWorld:
    """See `sim.grasp_run.GraspWorld`."""

    def __init__(self, client: int, body: RigidBody, X_WA: FloatArray, task: GraspTask) -> None:
        self._client, self._task, self._steps = client, task, 0
        self._scale = model_scale(diagonal(body.shapes))
        self._root = math.sqrt(self._scale)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=task.step_s,
            numSolverIterations=60,
            enableFileCaching=0,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )
        pybullet.setGravity(0.0, 0.0, -GRAVITY_MPS2, physicsClientId=client)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
        self._ground = pybullet.createMultiBody(0, plane, useMaximalCoordinates=1, physicsClientId=client)
        self._body = self._place_body(body, X_WA)
        X_WG = scaled(X_WA @ task.X_AG, self._scale)
        self._gripper = BulletGripper(client, task, X_WG, self._scale, turns_wrist=task.motion.turns_wrist)
        links = _LINKS + task.motion.turns_wrist
        weight_n = (body.mass.mass_kg * self._scale**3 + links * LINK_KG) * GRAVITY_MPS2
        self._strong = HAND_FORCE_FACTOR * weight_n

    @property
    def time_s(self) -> float:
        """The model is as many times slower as the root of its scale."""
        return self._steps * self._task.step_s / self._root

    def place_mount(self, positions: FloatArray) -> None:
        self._gripper.place(self._model(positions))

    def drive_mount(self, positions: FloatArray, rates: FloatArray) -> None:
        self._gripper.drive(self._model(positions), self._model(rates) / self._root, self._strong)

    def drive_fingers(self, closing: float) -> None:
        force = self._task.force_n * self._scale**3
        speed = closing * self._task.gripper.speed_mps * self._root
        self._gripper.move_fingers(speed, force + self._strong * (closing <= 0.0))

    def step(self) -> None:
        pybullet.stepSimulation(physicsClientId=self._client)
        self._steps += 1

    def body_pose(self) -> FloatArray:
        place, quat_xyzw = pybullet.getBasePositionAndOrientation(self._body, physicsClientId=self._client)
        return scaled(pose.pose_from_quat(pose.to_wxyz(np.asarray(quat_xyzw)), place) @ self._X_IA, 1.0 / self._scale)

    def body_velocity(self) -> tuple[FloatArray, FloatArray]:
        linear, angular = pybullet.getBaseVelocity(self._body, physicsClientId=self._client)
        return np.array(linear) / self._root, np.array(angular) * self._root

    def gripper_poses(self) -> FloatArray:
        poses = self._gripper.boxes()
        poses[:, :3, 3] /= self._scale
        return poses

    def finger_touches(self) -> tuple[bool, bool]:
        return self._gripper.touches(self._body, self._gripper.left), self._gripper.touches(
            self._body, self._gripper.right
        )

    def hand_touches(self) -> bool:
        return self._gripper.touches(self._body)

    def is_supported(self) -> bool:
        return bool(pybullet.getContactPoints(self._body, self._ground, physicsClientId=self._client))

    def _model(self, mount: FloatArray) -> FloatArray:
        """Positions (5,) of the mount, or their rates per true second, with lengths of the model."""
        return mount * [self._scale, self._scale, self._scale, 1.0, 1.0]

    def _place_body(self, body: RigidBody, X_WA: FloatArray) -> int:
        client, scale = self._client, self._scale
        dynamic = dynamic_body(body.shapes, body.mass, scale, client)
        self._X_IA = pose.inverse(dynamic.X_AI)
        pybullet.changeDynamics(dynamic.handle, -1, lateralFriction=self._task.friction, physicsClientId=client)
        X_WI = scaled(X_WA, scale) @ dynamic.X_AI
        quat_xyzw = pose.to_xyzw(pose.quat_of(X_WI[:3, :3])).tolist()
        pybullet.resetBasePositionAndOrientation(
            dynamic.handle, X_WI[:3, 3].tolist(), quat_xyzw, physicsClientId=client
        )
        return dynamic.handle
