"""Drop loose probes over a fixed body in PyBullet, to find where things that are set down come to rest."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from geom.convex.support_function import diagonal
from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape
from sim.bullet.shapes import clear_margins, compound
from sim.bullet.world import STEP_S, private_client
from sim.port import ProbeResult

# Everything is simulated as a model of this diagonal (Froude similarity, see `sim.port.model_scale`), so that an
# outcome does not depend on size.
FIXED_MODEL_M = 1.0
FRICTION = math.sqrt(0.5)  # The engine multiplies both sides.
ROLLING, DAMPING = 0.02, 0.2  # lever arm as a share of the probe's size; share of the speed lost in a second
_FIXED_GROUP, _PROBE_GROUP = 1, 2


def drop_probes(fixed: Sequence[CollisionShape], probes: Sequence[CollisionShape], duration_s: float) -> ProbeResult:
    """See `sim.port.Simulator`. All probes fall in one world, filtered so that they only touch the fixed body."""
    if not probes:
        return ProbeResult(np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    scale = FIXED_MODEL_M / diagonal(fixed)
    with private_client() as client:
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=STEP_S, enableFileCaching=0, deterministicOverlappingPairs=1, physicsClientId=client
        )
        pybullet.setGravity(0.0, 0.0, -GRAVITY_MPS2, physicsClientId=client)
        _build_fixed(fixed, scale, client)
        handles = [_build_probe(probe, scale, client) for probe in probes]
        for _ in range(math.ceil(duration_s * math.sqrt(scale) / STEP_S)):
            pybullet.stepSimulation(physicsClientId=client)
        places = [pybullet.getBasePositionAndOrientation(handle, physicsClientId=client) for handle in handles]
        moving = [pybullet.getBaseVelocity(handle, physicsClientId=client)[0] for handle in handles]
    centres = np.array([place for place, _ in places]) / scale
    R_WP = Rotation.from_quat([quat_xyzw for _, quat_xyzw in places]).as_matrix()
    below = np.array([_below(probe, R) for probe, R in zip(probes, R_WP, strict=True)])
    return ProbeResult(centres, centres[:, 2] - below, np.linalg.norm(moving, axis=1) / math.sqrt(scale))


def _build_fixed(shapes: Sequence[CollisionShape], scale: float, client: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        collision = compound(shapes, scale, Path(folder), client)
        clear_margins(collision, len(shapes), client)
        body = pybullet.createMultiBody(0.0, collision, physicsClientId=client)
    pybullet.changeDynamics(body, -1, lateralFriction=FRICTION, rollingFriction=1.0, physicsClientId=client)
    pybullet.setCollisionFilterGroupMask(body, -1, _FIXED_GROUP, _PROBE_GROUP, physicsClientId=client)


def build_loose(probe: CollisionShape, scale: float, mass_kg: float, client: int) -> int:
    """The engine's handle of a loose box or ball of that mass at model size; it collides with everything."""
    size = [float(s) * scale for s in probe.size_m]
    form = {"halfExtents": [s / 2.0 for s in size]} if probe.kind == "box" else {"radius": size[0]}
    kind = pybullet.GEOM_BOX if probe.kind == "box" else pybullet.GEOM_SPHERE
    body = pybullet.createMultiBody(
        mass_kg,
        pybullet.createCollisionShape(kind, **form, physicsClientId=client),
        basePosition=(scale * probe.X_AS[:3, 3]).tolist(),
        baseOrientation=Rotation.from_matrix(probe.X_AS[:3, :3]).as_quat().tolist(),
        useMaximalCoordinates=1,
        physicsClientId=client,
    )
    pybullet.changeDynamics(
        body,
        -1,
        lateralFriction=FRICTION,
        rollingFriction=ROLLING * size[0],
        linearDamping=DAMPING,
        angularDamping=DAMPING,
        physicsClientId=client,
    )
    return body


def _build_probe(probe: CollisionShape, scale: float, client: int) -> int:
    """The engine's handle of a probe of 1 kg, which only touches the fixed body."""
    body = build_loose(probe, scale, 1.0, client)
    pybullet.setCollisionFilterGroupMask(body, -1, _PROBE_GROUP, _FIXED_GROUP, physicsClientId=client)
    return body


def _below(probe: CollisionShape, R_WP: FloatArray) -> float:
    """How far the lowest point of a turned probe lies below its centre, in metres."""
    if probe.kind == "sphere":
        return probe.size_m[0]
    return float(np.abs(R_WP[2]) @ np.asarray(probe.size_m) / 2.0)
