"""Settle a whole scene in PyBullet: poses X_WA of all bodies some time after they were released at rest together."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from geom import pose
from geom.convex.support_function import diagonal
from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from sim.bullet.world import STEP_S, DynamicBody, dynamic_body, private_client, scaled, static_body
from sim.port import ROLLING_RESISTANCE, PlacedBody

# The smallest thing is simulated as a model of this diagonal (Froude similarity, see `sim.port.model_scale`), because
# the engine's tolerances are absolute.
SMALLEST_MODEL_M, LARGEST_SCALE = 0.15, 10.0
# Lever arm, as a share of the size, of the moment that opposes turning on the spot: two thirds of the radius of a patch
# (Coulomb), here of 1.5 % of the size. Without it the few points to which the engine reduces a flat foot let it creep.
SPINNING_RESISTANCE = 0.01


def settle_scene(things: Sequence[PlacedBody], duration_s: float) -> FloatArray:
    """X_WA (n, 4, 4) of all bodies after `duration_s`, released at rest at their poses.

    The engine multiplies the friction of both sides, so each has the root of its dynamic coefficient: a pair has the
    geometric mean. Nothing bounces. Equal calls give equal results. Raises RuntimeError when PyBullet has no client.
    """
    dynamic = [diagonal(thing.body.shapes) for thing in things if thing.moves]
    scale = min(max(SMALLEST_MODEL_M / min(dynamic, default=SMALLEST_MODEL_M), 1.0), LARGEST_SCALE)
    with private_client() as client:
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=STEP_S,
            numSolverIterations=100,
            enableFileCaching=0,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )
        pybullet.setGravity(0.0, 0.0, -GRAVITY_MPS2, physicsClientId=client)
        built = [_build(thing, scale, client) for thing in things]
        for _ in range(math.ceil(duration_s * math.sqrt(scale) / STEP_S)):
            pybullet.stepSimulation(physicsClientId=client)
        return np.stack([_where(thing, body, scale, client) for thing, body in zip(things, built, strict=True)])


def _build(thing: PlacedBody, scale: float, client: int) -> DynamicBody | None:
    """The engine's body of one thing, `scale` times its true size; None for a body that does not move."""
    dynamic = dynamic_body(thing.body.shapes, thing.body.mass, scale, client) if thing.moves else None
    handle = dynamic.handle if dynamic else static_body(thing.body.shapes, scale, client)
    X_WI = scaled(thing.X_WA, scale) @ (dynamic.X_AI if dynamic else np.eye(4))
    quat_xyzw = Rotation.from_matrix(X_WI[:3, :3]).as_quat().tolist()
    pybullet.resetBasePositionAndOrientation(handle, X_WI[:3, 3].tolist(), quat_xyzw, physicsClientId=client)
    size = scale * diagonal(thing.body.shapes)
    pybullet.changeDynamics(
        handle,
        -1,
        lateralFriction=math.sqrt(thing.body.contact.dynamic_friction),
        rollingFriction=ROLLING_RESISTANCE * size if dynamic else 1.0,
        spinningFriction=SPINNING_RESISTANCE * size if dynamic else 1.0,
        restitution=0.0,
        physicsClientId=client,
    )
    return dynamic


def _where(thing: PlacedBody, dynamic: DynamicBody | None, scale: float, client: int) -> FloatArray:
    """X_WA (4, 4) at true size."""
    if dynamic is None:
        return np.array(thing.X_WA)
    position, quat_xyzw = pybullet.getBasePositionAndOrientation(dynamic.handle, physicsClientId=client)
    X_WI = pose.pose(Rotation.from_quat(quat_xyzw).as_matrix(), position)
    return scaled(X_WI @ pose.inverse(dynamic.X_AI), 1.0 / scale)
