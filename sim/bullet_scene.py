"""A whole scene let go at once in PyBullet: does everything stay where it was put?"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from geom import pose
from geom.principal_axes import principal_axes
from geom.support import diagonal
from schemas.model import FloatArray
from sim.bullet_shapes import clear_margins, compound
from sim.port import GRAVITY_MPS2, ROLLING_RESISTANCE, Standing

# The smallest thing is simulated as a model of this diagonal (Froude similarity, see `sim.port.model_scale`), because
# the engine's tolerances are absolute.
MODEL_M, LARGEST_SCALE, STEP_S = 0.15, 10.0, 1.0 / 480.0
# Lever arm, as a share of the size, of the moment that opposes turning on the spot: two thirds of the radius of a patch
# (Coulomb), here of 1.5 % of the size. Without it the few points to which the engine reduces a flat foot let it creep.
TURNING_RESISTANCE = 0.01


def settle_scene(things: Sequence[Standing], duration_s: float) -> FloatArray:
    """X_WA (n, 4, 4) of all things after `duration_s`, released at rest where they are posed.

    The engine multiplies the friction of both sides, so each has the root of its dynamic coefficient: a pair has the
    geometric mean. Nothing bounces. Equal calls give equal results. Raises RuntimeError when the engine did not build
    what was asked for.
    """
    loose = [diagonal(thing.body.shapes) for thing in things if thing.moves]
    scale = min(max(MODEL_M / min(loose, default=MODEL_M), 1.0), LARGEST_SCALE)
    client = pybullet.connect(pybullet.DIRECT)
    if client < 0:
        raise RuntimeError("PyBullet has no free client; at most 1024 exist per process")
    try:
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=STEP_S,
            numSolverIterations=100,
            enableFileCaching=0,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )
        pybullet.setGravity(0.0, 0.0, -GRAVITY_MPS2, physicsClientId=client)
        handles = [_build(thing, scale, client) for thing in things]
        for _ in range(math.ceil(duration_s * math.sqrt(scale) / STEP_S)):
            pybullet.stepSimulation(physicsClientId=client)
        return np.stack([_where(thing, handle, scale, client) for thing, handle in zip(things, handles, strict=True)])
    finally:
        pybullet.disconnect(physicsClientId=client)


def _build(thing: Standing, scale: float, client: int) -> int:
    """The engine's handle of one thing, `scale` times its true size."""
    body, X_AI, moments = thing.body, np.eye(4), np.zeros(3)
    mass_kg = body.mass.mass_kg * scale**3 if thing.moves else 0.0
    if thing.moves:
        moments, quat_wxyz = principal_axes(body.mass.inertia_kgm2)
        X_AI = pose.pose_from_quat(quat_wxyz, scale * np.asarray(body.mass.centre_of_mass_m))
    X_WI = _scaled(thing.X_WA, scale) @ X_AI
    with tempfile.TemporaryDirectory() as folder:
        collision = compound(body.shapes, scale, Path(folder), client)
        clear_margins(collision, len(body.shapes), client)
        handle = pybullet.createMultiBody(
            baseMass=mass_kg,
            baseCollisionShapeIndex=collision,
            baseInertialFramePosition=X_AI[:3, 3].tolist(),
            baseInertialFrameOrientation=Rotation.from_matrix(X_AI[:3, :3]).as_quat().tolist(),
            useMaximalCoordinates=1,
            physicsClientId=client,
        )
    quat_xyzw = Rotation.from_matrix(X_WI[:3, :3]).as_quat().tolist()
    pybullet.resetBasePositionAndOrientation(handle, X_WI[:3, 3].tolist(), quat_xyzw, physicsClientId=client)
    if thing.moves:
        pybullet.changeDynamics(
            handle,
            -1,
            mass=mass_kg,
            localInertiaDiagonal=(moments * scale**5).tolist(),
            linearDamping=0.0,
            angularDamping=0.0,
            activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=client,
        )
    size = scale * diagonal(body.shapes)
    pybullet.changeDynamics(
        handle,
        -1,
        lateralFriction=math.sqrt(body.contact.dynamic_friction),
        rollingFriction=ROLLING_RESISTANCE * size if thing.moves else 1.0,
        spinningFriction=TURNING_RESISTANCE * size if thing.moves else 1.0,
        restitution=0.0,
        physicsClientId=client,
    )
    return handle


def _where(thing: Standing, handle: int, scale: float, client: int) -> FloatArray:
    """X_WA (4, 4) at true size."""
    if not thing.moves:
        return np.array(thing.X_WA)
    position, quat_xyzw = pybullet.getBasePositionAndOrientation(handle, physicsClientId=client)
    X_WI = pose.pose(Rotation.from_quat(quat_xyzw).as_matrix(), position)
    _, quat_wxyz = principal_axes(thing.body.mass.inertia_kgm2)
    X_AI = pose.pose_from_quat(quat_wxyz, scale * np.asarray(thing.body.mass.centre_of_mass_m))
    return _scaled(X_WI @ pose.inverse(X_AI), 1.0 / scale)


def _scaled(X: FloatArray, scale: float) -> FloatArray:
    made = np.array(X, dtype=np.float64)
    made[:3, 3] *= scale
    return made
