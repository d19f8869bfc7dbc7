"""Shared parts of free-body roll-outs in PyBullet: the world with its support, contact parameters, states as rows.

A row is the mass centre (3), the quaternion xyzw of the inertial frame, its velocity (3), its turning rate (3); world
axes. `X_BI` is the pose of the inertial frame in the measured frame.
"""

from __future__ import annotations

from typing import Self

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray
from sim.bullet.world import STEP_S
from sim.dynamics.body_rollout import BodyModel, BodyMotion, BodyWindows

BODY_STEP_S = STEP_S
HOLD_S = 1.0 / 120.0  # forces of effects are held at most so long: they follow speed and position, not contacts
# Share of a penetration that is undone per second. The engine takes it per step (0.2 at 240 steps a second): finer
# steps would throw out harder what starts a little inside the support.
_RECOVERY_PER_S = 0.2 * 240.0
_ESCAPED_M = 1e3


class WindowsClient:
    """One private DIRECT client with one body in it; close it, or use it as a context manager.

    `_handle` is the engine's body, `_X_BI` (4, 4) its inertial frame in the measured frame.
    """

    def __init__(self, largest_step_s: float = BODY_STEP_S) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        self._usual_step_s = self._largest_step_s = largest_step_s
        self._handle = -1
        self._X_BI = np.eye(4)

    def close(self) -> None:
        """Free the engine's world; the object cannot be used afterwards."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def empty_world(model: BodyModel, step_s: float, client: int) -> None:
    """A world with the model's gravity and support, and nothing else."""
    pybullet.resetSimulation(physicsClientId=client)
    pybullet.setPhysicsEngineParameter(
        fixedTimeStep=step_s,
        numSubSteps=1,
        contactERP=_RECOVERY_PER_S * step_s,
        enableFileCaching=0,
        deterministicOverlappingPairs=1,
        physicsClientId=client,
    )
    pybullet.setGravity(*model.gravity_W.tolist(), physicsClientId=client)
    if model.has_support:
        plane = pybullet.createCollisionShape(
            pybullet.GEOM_PLANE, planeNormal=model.plane_normal_W.tolist(), physicsClientId=client
        )
        at = (model.plane_height_m * model.plane_normal_W).tolist()
        ground = pybullet.createMultiBody(0, plane, basePosition=at, useMaximalCoordinates=1, physicsClientId=client)
        pybullet.changeDynamics(ground, -1, lateralFriction=1.0, restitution=1.0, physicsClientId=client)


def contact_parameters(model: BodyModel) -> dict[str, float | list[float]]:
    """Arguments of `changeDynamics`; the support has 1 and 1, so that products are the values of the pair."""
    soft = {}
    if model.stiffness_Npm is not None and model.damping_Nspm is not None:
        soft = {"contactStiffness": model.stiffness_Npm, "contactDamping": model.damping_Nspm}
    return {
        "lateralFriction": model.friction,
        "restitution": model.restitution,
        "rollingFriction": model.rolling_friction_m,
        "spinningFriction": model.spinning_friction_m,
        "anisotropicFriction": model.friction_ratio_B.tolist(),
        **soft,
    }


def steps_for(span_s: FloatArray | float, largest_step_s: float) -> FloatArray:
    """Number of equal steps for a span of time."""
    return np.maximum(1.0, np.ceil(np.asarray(span_s) / largest_step_s - 1e-6))


def start_states(windows: BodyWindows, X_BI: FloatArray) -> FloatArray:
    """(w, 13) rows at the starts of windows."""
    R_WB = Rotation.from_quat(np.roll(windows.quat_wxyz, -1, axis=1))
    lever, w_W = R_WB.apply(X_BI[:3, 3]), R_WB.apply(windows.w_B)
    quat_xyzw = (R_WB * Rotation.from_matrix(X_BI[:3, :3])).as_quat()
    return np.concatenate([windows.p + lever, quat_xyzw, windows.v_W + np.cross(w_W, lever), w_W], axis=1)


def measured_motion(rows: FloatArray, X_BI: FloatArray) -> BodyMotion:
    """Rows (w, k, 13) as motion of the measured frame."""
    shape = rows.shape[:2]
    flat = rows.reshape(-1, 13)
    R_WI = Rotation.from_quat(flat[:, 3:7])
    R_WB = R_WI * Rotation.from_matrix(X_BI[:3, :3]).inv()
    lever: FloatArray = R_WB.apply(X_BI[:3, 3])
    quats = np.roll(R_WB.as_quat(), 1, axis=1)
    return BodyMotion(
        p=(flat[:, :3] - lever).reshape(*shape, 3),
        quat_wxyz=quats.reshape(*shape, 4),
        v_W=(flat[:, 7:10] - np.cross(flat[:, 10:13], lever)).reshape(*shape, 3),
        w_B=R_WB.inv().apply(flat[:, 10:13]).reshape(*shape, 3),
    )


def hold_last_valid(rows: FloatArray) -> FloatArray:
    """Rows (w, k, n); rows that are not finite or far away are replaced by the last valid row before them."""
    sound = np.isfinite(rows).all(axis=2) & (np.abs(rows[..., :3]).max(axis=2) < _ESCAPED_M)
    latest = np.maximum.accumulate(np.where(sound, np.arange(rows.shape[1]), 0), axis=1)
    return np.take_along_axis(rows, latest[..., None], axis=1)
