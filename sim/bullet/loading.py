"""Put loose probes on, into or against a body in PyBullet, and record how all of them move."""

from __future__ import annotations

import math

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from geom import pose
from geom.convex.support_function import diagonal
from schemas.arrays import FloatArray
from schemas.physics import RigidBody
from sim.bullet.probes import build_loose
from sim.bullet.scene import SPINNING_RESISTANCE
from sim.bullet.shapes import PARKED_M
from sim.bullet.world import dynamic_body, private_client, scaled, static_body
from sim.loading import LOAD_FRICTION, LoadOutcome, LoadTask
from sim.port import ROLLING_RESISTANCE, model_scale, pair_value

_OTHERS = math.sqrt(LOAD_FRICTION)  # of ground and probes: the engine multiplies both sides
_BODY_GROUP, _PROBE_GROUP = 1, 2


def load(body: RigidBody, task: LoadTask) -> LoadOutcome:
    """See `sim.port.Simulator`. Raises RuntimeError when PyBullet has no client left."""
    scale = model_scale(diagonal(body.shapes))
    root = math.sqrt(scale)
    with private_client() as client:
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=task.step_s,
            numSolverIterations=100,
            enableFileCaching=0,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )
        pybullet.setGravity(*task.gravity_mps2, physicsClientId=client)
        handle, X_AI = _build_body(body, task, scale, client)
        probes = [_build_probe(task, number, scale, client) for number in range(len(task.probes))]
        rows = [_row((handle, *probes), client)]
        finite = True
        for _ in range(math.ceil(task.duration_s * root / task.step_s - 1e-9)):
            pybullet.stepSimulation(physicsClientId=client)
            row = _row((handle, *probes), client)
            if not np.all(np.abs(row) < PARKED_M):  # also true of NaN
                finite = False
                break
            rows.append(row)
    X_WB = _poses(np.array(rows), scale)
    return LoadOutcome(
        times_s=np.arange(len(rows), dtype=np.float64) * (task.step_s / root),
        X_WA=X_WB[:, 0] @ scaled(pose.inverse(X_AI), 1.0 / scale),
        X_WP=X_WB[:, 1:],
        finite=finite,
    )


def _build_body(body: RigidBody, task: LoadTask, scale: float, client: int) -> tuple[int, FloatArray]:
    """The engine's handle of the body in its pose, and its frame X_AI (4, 4) in that of the body, model metres."""
    dynamic = None if task.is_fixed else dynamic_body(body.shapes, body.mass, scale, client)
    handle = static_body(body.shapes, scale, client) if dynamic is None else dynamic.handle
    X_AI = np.eye(4) if dynamic is None else dynamic.X_AI
    X_WI = scaled(task.X_WA, scale) @ X_AI
    quat_xyzw = Rotation.from_matrix(X_WI[:3, :3]).as_quat().tolist()
    pybullet.resetBasePositionAndOrientation(handle, X_WI[:3, 3].tolist(), quat_xyzw, physicsClientId=client)
    contact, size = body.contact, scale * diagonal(body.shapes)
    pybullet.changeDynamics(
        handle,
        -1,
        lateralFriction=pair_value(contact.dynamic_friction, LOAD_FRICTION, contact.combine) / _OTHERS,
        rollingFriction=0.0 if task.is_fixed else ROLLING_RESISTANCE * size,
        spinningFriction=0.0 if task.is_fixed else SPINNING_RESISTANCE * size,
        physicsClientId=client,
    )
    if task.is_fixed:
        pybullet.setCollisionFilterGroupMask(handle, -1, _BODY_GROUP, _PROBE_GROUP, physicsClientId=client)
    else:
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
        ground = pybullet.createMultiBody(0, plane, useMaximalCoordinates=1, physicsClientId=client)
        pybullet.changeDynamics(ground, -1, lateralFriction=_OTHERS, physicsClientId=client)
    return handle, X_AI


def _build_probe(task: LoadTask, number: int, scale: float, client: int) -> int:
    probe = task.probes[number]
    handle = build_loose(probe.shape, scale, probe.mass_kg * scale**3, client)
    pybullet.changeDynamics(
        handle, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING, physicsClientId=client
    )
    velocity = (np.array(probe.velocity_mps) * math.sqrt(scale)).tolist()
    pybullet.resetBaseVelocity(handle, velocity, [0.0, 0.0, 0.0], physicsClientId=client)
    if task.is_fixed:
        pybullet.setCollisionFilterGroupMask(handle, -1, _PROBE_GROUP, _BODY_GROUP, physicsClientId=client)
    return handle


def _row(handles: tuple[int, ...], client: int) -> FloatArray:
    """(b, 7) position and quaternion xyzw of each body."""
    places = [pybullet.getBasePositionAndOrientation(handle, physicsClientId=client) for handle in handles]
    return np.array([(*at, *quat_xyzw) for at, quat_xyzw in places])


def _poses(rows: FloatArray, scale: float) -> FloatArray:
    """X_WB (k, b, 4, 4) at true size from rows (k, b, 7)."""
    X_WB = np.tile(np.eye(4), (*rows.shape[:2], 1, 1))
    X_WB[..., :3, :3] = Rotation.from_quat(rows[..., 3:].reshape(-1, 4)).as_matrix().reshape(*rows.shape[:2], 3, 3)
    X_WB[..., :3, 3] = rows[..., :3] / scale
    return X_WB
