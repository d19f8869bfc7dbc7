"""A PyBullet world for episode resets: bodies stay while their poses (W, m) and materials change."""

from __future__ import annotations

import math

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from geom import pose
from geom.convex.support_function import diagonal
from geom.mass.principal_axes import principal_axes
from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import Contact, MassProperties, RigidBody
from sim.bullet.scene import SPINNING_RESISTANCE
from sim.bullet.shapes import PARKED_M
from sim.bullet.world import STEP_S, DynamicBody, dynamic_body, static_body
from sim.port import ROLLING_RESISTANCE


class BulletResets:
    """`sim.port.ResetWorld` in the PyBullet client `client`, at true size; the client is the caller's.

    The engine multiplies friction and restitution of both sides, so each body has the root of its coefficient.
    """

    def __init__(self, client: int) -> None:
        self.client = client
        self._bodies: list[tuple[int, DynamicBody | None, float]] = []
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=STEP_S, numSolverIterations=100, enableFileCaching=0, deterministicOverlappingPairs=1,
            physicsClientId=client,
        )  # fmt: skip
        pybullet.setGravity(0.0, 0.0, -GRAVITY_MPS2, physicsClientId=client)

    def __len__(self) -> int:
        return len(self._bodies)

    def add(self, body: RigidBody, moves: bool) -> int:
        """Build a body, parked; returns its number."""
        dynamic = dynamic_body(body.shapes, body.mass, 1.0, self.client) if moves else None
        handle = dynamic.handle if dynamic else static_body(body.shapes, 1.0, self.client)
        self._bodies.append((handle, dynamic, diagonal(body.shapes)))
        self.set_material(len(self._bodies) - 1, body.mass, body.contact)
        self.set_pose(len(self._bodies) - 1, None)
        return len(self._bodies) - 1

    def set_pose(self, number: int, X_WA: FloatArray | None) -> None:
        """Put a body at rest at X_WA (4, 4); None parks it far beside the scene, where it falls and touches nothing."""
        handle, dynamic, size = self._bodies[number]
        beside = np.array([PARKED_M + number * 10.0 * max(size, 1.0), 0.0, PARKED_M])
        at = pose.pose(None, beside) if X_WA is None else X_WA
        X_WI = at @ dynamic.X_AI if dynamic else at
        quat_xyzw = Rotation.from_matrix(X_WI[:3, :3]).as_quat().tolist()
        pybullet.resetBasePositionAndOrientation(handle, X_WI[:3, 3].tolist(), quat_xyzw, physicsClientId=self.client)
        pybullet.resetBaseVelocity(handle, [0.0] * 3, [0.0] * 3, physicsClientId=self.client)

    def set_material(self, number: int, mass: MassProperties, contact: Contact) -> None:
        """Set the mass properties of a body, about the same mass centre, and its contact values, in one call."""
        handle, dynamic, size = self._bodies[number]
        physics = {}
        if dynamic:
            physics = {"mass": mass.mass_kg, "localInertiaDiagonal": principal_axes(mass.inertia_kgm2)[0].tolist()}
        pybullet.changeDynamics(
            handle,
            -1,
            lateralFriction=math.sqrt(contact.dynamic_friction),
            rollingFriction=ROLLING_RESISTANCE * size if dynamic else 1.0,
            spinningFriction=SPINNING_RESISTANCE * size if dynamic else 1.0,
            restitution=math.sqrt(contact.restitution),
            physicsClientId=self.client,
            **physics,
        )

    def dynamics(self, number: int) -> tuple[float, FloatArray, float]:
        """Mass (kg), principal moments (3,) and friction of a body, as the engine has them.

        The engine does not return the restitution of such bodies: it reads 0 whatever was set.
        """
        info = pybullet.getDynamicsInfo(self._bodies[number][0], -1, physicsClientId=self.client)
        return float(info[0]), np.array(info[2]), float(info[1])

    def handle(self, number: int) -> int:
        """The engine's handle of a body."""
        return self._bodies[number][0]

    def poses(self) -> FloatArray:
        """X_WA (n, 4, 4) of all bodies."""
        poses_WA = []
        for handle, dynamic, _ in self._bodies:
            position, quat_xyzw = pybullet.getBasePositionAndOrientation(handle, physicsClientId=self.client)
            X_WI = pose.pose(Rotation.from_quat(quat_xyzw).as_matrix(), np.array(position))
            poses_WA.append(X_WI @ pose.inverse(dynamic.X_AI) if dynamic else X_WI)
        return np.stack(poses_WA)

    def run(self, duration_s: float) -> None:
        """Step the world for `duration_s`."""
        for _ in range(math.ceil(duration_s / STEP_S)):
            pybullet.stepSimulation(physicsClientId=self.client)
