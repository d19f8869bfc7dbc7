"""Simulate a grasp with a parallel-jaw gripper in PyBullet: close on a body, lift, hold, shake, carry, set down.

What the hand does is data (`sim.grasp_trial.HandMotion`); its motion is prescribed, its contacts are not.
"""

from __future__ import annotations

import math

import numpy as np
import pybullet

from geom import pose
from geom.convex.support_function import diagonal, heights
from geom.grasp.gripper import boxes
from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import RigidBody
from sim.bullet.gripper import BulletGripper
from sim.bullet.world import dynamic_body, private_client, scaled
from sim.grasp_trial import DROP_M, GraspOutcome, GraspTask, GraspTrace, Landing, Phase
from sim.gripper_description import LINK_KG
from sim.port import model_scale, rms_speeds

REST_S = 0.05  # before the motion begins
HAND_FORCE_FACTOR = 100.0  # times the weight of hand and body: force limit of the joints that move the hand
_LINKS = 6  # that the mount moves at most
_CARRIED = (Phase.LIFT, Phase.HOLD, Phase.CARRY, Phase.SHAKE)  # with both pads on the body at their end
_CLOSED = (Phase.CLOSE, *_CARRIED, Phase.LOWER)


def grasp(body: RigidBody, X_WA: FloatArray, task: GraspTask) -> GraspOutcome:
    """See `sim.port.Simulator`. Raises RuntimeError when PyBullet has no client left."""
    with private_client() as client:
        return _Trial(client, body, X_WA, task).run()


class _Trial:
    """One body and one gripper in a world of their own, `scale` times as large (Froude similarity, `model_scale`)."""

    def __init__(self, client: int, body: RigidBody, X_WA: FloatArray, task: GraspTask) -> None:
        self._client, self._task, self._steps, self._of = client, task, 0, body
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
        X_WG = X_WA @ task.X_AG
        self._R_WG = X_WG[:3, :3]
        self._gripper = BulletGripper(client, task, scaled(X_WG, self._scale), self._scale)
        self._weight_n = (body.mass.mass_kg * self._scale**3 + _LINKS * LINK_KG) * GRAVITY_MPS2
        self._trace: list[tuple[float, FloatArray, FloatArray]] = []

    def run(self) -> GraspOutcome:
        """The whole motion; it ends early when the body has fallen."""
        start, _ = self._task.motion.at(0.0, self._R_WG)
        self._gripper.place(self._model(start))
        self._step_until(REST_S, 0.0)
        before = self._centre()
        moved_m, slip_m, released = 0.0, 0.0, False
        closed = self._in_gripper()
        let_go, landing = before, self._pose()
        for phase, end_s in self._task.motion.ends():
            if phase is Phase.CLOSE:
                moved_m = float(np.linalg.norm(self._centre() - before)) / self._scale
            if phase is Phase.RELEASE:
                let_go, landing = self._in_gripper(), self._pose()
                slip_m = float(np.linalg.norm(let_go - closed)) / self._scale
            closing = 1.0 if phase in _CLOSED else -1.0 if phase is Phase.RELEASE else 0.0
            self._step_until(REST_S + end_s, closing)
            if phase is Phase.CLOSE:
                closed = self._in_gripper()
            if phase in _CARRIED and not self._is_carried(closed):
                return GraspOutcome(phase, math.inf, released=False, moved_m=moved_m, trace=self._traced())
            if phase in (Phase.RELEASE, Phase.RETREAT):
                apart = float(np.linalg.norm(self._in_gripper() - let_go)) > DROP_M * self._scale
                released = apart and not self._gripper.touches(self._body)
        lands = Phase.STAY in {phase for phase, _ in self._task.motion.phases}
        return GraspOutcome(None, slip_m, released, moved_m, self._landing(landing) if lands else None, self._traced())

    def _is_carried(self, closed: FloatArray) -> bool:
        """Whether the body has not fallen in the gripper and both fingers touch it; false of NaN."""
        fallen = (self._R_WH() @ (closed - self._in_gripper()))[2]
        up = fallen <= DROP_M * self._scale
        return up and self._gripper.touches(self._body, self._gripper.left, self._gripper.right)

    def _step_until(self, end_s: float, closing: float) -> None:
        """Step to a moment; the fingers close (1), stay (0) or open (-1)."""
        task, gripper = self._task, self._gripper
        force = task.force_n * self._scale**3
        strong = HAND_FORCE_FACTOR * self._weight_n
        gripper.move_fingers(closing * task.gripper.speed_mps * self._root, force + strong * (closing <= 0.0))
        while self._steps * task.step_s < end_s * self._root - 1e-9:
            self._steps += 1
            time_s = self._steps * task.step_s / self._root
            place, rate = task.motion.at(time_s - REST_S, self._R_WG)
            gripper.drive(self._model(place), self._model(rate) / self._root, strong)
            pybullet.stepSimulation(physicsClientId=self._client)
            if task.trace_s is not None and time_s >= len(self._trace) * task.trace_s:
                self._trace.append((time_s, self._pose(), gripper.boxes()))

    def _model(self, mount: FloatArray) -> FloatArray:
        """Positions (4,) of the mount, or their rates per true second, with lengths of the model."""
        return mount * [self._scale, self._scale, self._scale, 1.0]

    def _centre(self) -> FloatArray:
        where = pybullet.getBasePositionAndOrientation(self._body, physicsClientId=self._client)[0]
        return np.array(where)

    def _pose(self) -> FloatArray:
        """X_WA (4, 4) of the body, lengths of the model."""
        place, quat_xyzw = pybullet.getBasePositionAndOrientation(self._body, physicsClientId=self._client)
        return pose.pose_from_quat(pose.to_wxyz(np.asarray(quat_xyzw)), place) @ self._X_IA

    def _R_WH(self) -> FloatArray:
        return self._gripper.hand_pose()[:3, :3]

    def _in_gripper(self) -> FloatArray:
        """(3,) mass centre in the axes of the gripper, from the hand, model metres."""
        X_WH = self._gripper.hand_pose()
        return (self._centre() - X_WH[:3, 3]) @ X_WH[:3, :3]

    def _landing(self, let_go: FloatArray) -> Landing:
        """How the body lies now, against its pose X_WA when the pads began to open."""
        X_WA, mass = self._pose(), self._of.mass
        centre = np.append(self._scale * np.asarray(mass.centre_of_mass_m), 1.0)
        drift = (X_WA @ centre - let_go @ centre)[:2]
        linear, angular = pybullet.getBaseVelocity(self._body, physicsClientId=self._client)
        true = np.array(linear) / self._root, np.array(angular) * self._root
        lowest = heights(self._of.shapes, X_WA[None, :3, 3] / self._scale, X_WA[None, :3, :3])
        contacts = pybullet.getContactPoints(self._body, self._ground, physicsClientId=self._client)
        turn = pose.angle_between(pose.quat_of(X_WA[:3, :3]), pose.quat_of(let_go[:3, :3]))
        return Landing(
            drift_m=float(np.linalg.norm(drift)) / self._scale,
            turn_rad=float(turn),
            speed_mps=float(rms_speeds(mass, X_WA[None, :3, :3], true[0][None], true[1][None])[0]),
            penetration_m=max(0.0, -float(lowest[0])),
            is_supported=bool(contacts),
        )

    def _traced(self) -> GraspTrace | None:
        if self._task.trace_s is None:
            return None
        times, bodies, grippers = (np.array(rows) for rows in zip(*self._trace, strict=True))
        bodies[:, :3, 3] /= self._scale
        grippers[:, :, :3, 3] /= self._scale
        _, half = boxes(self._task.gripper, np.array([self._task.opening_m]))
        return GraspTrace(times, bodies, grippers, half[0])

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
