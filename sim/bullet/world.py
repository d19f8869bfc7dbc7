"""Building blocks of PyBullet worlds: a private client, dynamic bodies and static bodies, scaled lengths."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pybullet

from geom import pose
from geom.mass.principal_axes import principal_axes
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape, MassProperties
from sim.bullet.shapes import PARKED_M, clear_margins, compound

STEP_S = 1.0 / 480.0  # of the engine, at model size


@contextmanager
def private_client() -> Iterator[int]:
    """A private DIRECT client, disconnected at the end. Raises RuntimeError when PyBullet has none left."""
    client = pybullet.connect(pybullet.DIRECT)
    if client < 0:
        raise RuntimeError("PyBullet has no free client; at most 1024 exist per process")
    try:
        yield client
    finally:
        pybullet.disconnect(physicsClientId=client)


@dataclass(frozen=True)
class DynamicBody:
    """A body in the engine's world, `scale` times its true size, with the mass and moments that were set.

    X_AI  inertial frame (mass centre, principal axes) in the asset frame, scaled.
    """

    handle: int
    X_AI: FloatArray
    mass_kg: float
    moments_kgm2: FloatArray


def dynamic_body(shapes: Sequence[CollisionShape], mass: MassProperties, scale: float, client: int) -> DynamicBody:
    """The body, parked, undamped and never asleep; density stays, so mass grows with scale^3, moments with scale^5."""
    moments, quat_wxyz = principal_axes(mass.inertia_kgm2)
    X_AI = pose.pose_from_quat(quat_wxyz, scale * np.asarray(mass.centre_of_mass_m))
    mass_kg, moments = mass.mass_kg * scale**3, moments * scale**5
    with tempfile.TemporaryDirectory() as folder:
        collision = compound(shapes, scale, Path(folder), client)
        clear_margins(collision, len(shapes), client)
        handle = pybullet.createMultiBody(
            baseMass=mass_kg,
            baseCollisionShapeIndex=collision,
            basePosition=[0.0, 0.0, PARKED_M],
            baseInertialFramePosition=X_AI[:3, 3].tolist(),
            baseInertialFrameOrientation=pose.to_xyzw(quat_wxyz).tolist(),
            useMaximalCoordinates=1,
            physicsClientId=client,
        )
    pybullet.changeDynamics(
        handle,
        -1,
        mass=mass_kg,
        localInertiaDiagonal=moments.tolist(),
        linearDamping=0.0,
        angularDamping=0.0,
        activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
        physicsClientId=client,
    )
    return DynamicBody(handle, X_AI, mass_kg, moments)


def static_body(shapes: Sequence[CollisionShape], scale: float, client: int) -> int:
    """The engine's handle of a body that never moves, `scale` times its true size."""
    with tempfile.TemporaryDirectory() as folder:
        collision = compound(shapes, scale, Path(folder), client)
        clear_margins(collision, len(shapes), client)
        return pybullet.createMultiBody(0.0, collision, useMaximalCoordinates=1, physicsClientId=client)


def scaled(X: FloatArray, scale: float) -> FloatArray:
    """A pose (4, 4) with its lengths `scale` times as large."""
    scaled_pose = np.array(X, dtype=np.float64)
    scaled_pose[:3, 3] *= scale
    return scaled_pose
