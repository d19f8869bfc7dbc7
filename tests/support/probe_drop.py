"""Drop a ball into an opening of fixed collision shapes, in PyBullet, and see whether it stays there."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pybullet

from geom.convex.support_function import diagonal
from geom.features.cavities import Cavity
from schemas.physics import CollisionShape
from sim.bullet.shapes import clear_margins, compound

MODEL_M, STEP_S, GRAVITY = 0.5, 1.0 / 480.0, 9.81
SETTLE_S, TILT_S, TILT = 1.5, 0.4, 0.2


def stays_inside(shapes: Sequence[CollisionShape], cavity: Cavity) -> bool:
    """Whether the cavity's probe ball, let go above the rim, goes in and is still in after tilting by 11 degrees to
    four sides: its lowest point below the rim by most of what the solid allows, and not below the ground.

    Scaled to half a metre, gravity into the opening.
    """
    scale = MODEL_M / diagonal(shapes)
    radius = cavity.probe_m * scale
    out = cavity.direction
    across = np.linalg.svd(out[None])[2][1:]
    rim = cavity.opening_m * scale
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setPhysicsEngineParameter(fixedTimeStep=STEP_S, enableFileCaching=0, physicsClientId=client)
        with tempfile.TemporaryDirectory() as folder:
            handle = compound(shapes, scale, Path(folder), client)
            clear_margins(handle, len(shapes), client)
            pybullet.createMultiBody(0.0, handle, physicsClientId=client)
        ball = pybullet.createMultiBody(
            1.0,
            pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=radius, physicsClientId=client),
            basePosition=(rim + 1.05 * radius * out).tolist(),
            physicsClientId=client,
        )
        pybullet.changeDynamics(ball, -1, rollingFriction=0.01 * radius, linearDamping=0.2, physicsClientId=client)
        sides = [np.zeros(3), *(TILT * sign * axis for axis in across for sign in (1.0, -1.0))]
        for side in sides:
            pull = -out + side
            gravity = GRAVITY * pull / np.linalg.norm(pull)
            pybullet.setGravity(*gravity.tolist(), physicsClientId=client)
            for _ in range(int((TILT_S if side.any() else SETTLE_S) / STEP_S)):
                pybullet.stepSimulation(physicsClientId=client)
        centre = np.array(pybullet.getBasePositionAndOrientation(ball, physicsClientId=client)[0])
    finally:
        pybullet.disconnect(physicsClientId=client)
    depth = float((rim - centre) @ out) + radius
    return 0.6 * cavity.reach_m <= depth / scale <= 1.05 * cavity.depth_m
