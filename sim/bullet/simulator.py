"""The PyBullet implementation of `sim.port.Simulator`: drops, probes, loads, grasps, joints, in private clients.

Traps of PyBullet 3.2.7 that this file works around, each covered by a test:
- a free `btMultiBody`, the default, integrates the gyroscopic moment explicitly: a spinning box gains a fifth of its
  energy in 10 s and a stick of 1:100 flies off; so bodies are `btRigidBody` (`useMaximalCoordinates`), whose implicit
  integration loses energy instead;
- hulls carry a margin of 1 mm outside, and for rigid bodies `collisionMargin=0` changes nothing: it is set through a
  passing multibody that has the same shape;
- `changeDynamics` with a new inertia but no mass sets the mass to 0, and `getDynamicsInfo` returns rubbish for rigid
  bodies: mass and inertia are verified by a push;
- `createCollisionShapeArray` drops all shapes after the 16th silently: all hulls share one OBJ, one `o` group each;
- friction and restitution of a pair are multiplied: the ground has 1, the body the value of the pair;
- damping is 0.04 unless set, and bodies fall asleep;
- files are cached by name across worlds: caching is off.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from geom import pose
from geom.convex.support_function import bounds, diagonal, heights
from geom.mass.principal_axes import principal_axes
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape, RigidBody
from sim.bullet.grasp import grasp
from sim.bullet.joint_exercise import exercise_joints
from sim.bullet.joint_handling import handle_joint
from sim.bullet.loading import load
from sim.bullet.probes import drop_probes
from sim.bullet.shapes import PARKED_M
from sim.bullet.world import dynamic_body, scaled
from sim.grasp_trial import GraspOutcome, GraspTask
from sim.joint_exercise import Articulation, ArticulationExercise, JointTask
from sim.joint_handling import HandlingOutcome, HandlingTask
from sim.loading import LoadOutcome, LoadTask
from sim.port import (
    DropResult,
    DropSettings,
    ProbeResult,
    Stillness,
    World,
    model_scale,
    pair_value,
    rms_speeds,
)

_SINGLE = 1e-6  # relative: the OBJ reader is single precision


@dataclass(frozen=True)
class _Loaded:
    """A body in the engine's world, at `scale` times its true size."""

    body: RigidBody
    world: World
    handle: int
    ground: int
    scale: float
    diagonal_m: float
    X_AI: FloatArray  # inertial frame (mass centre, principal axes) in the asset frame, scaled


class BulletSimulator:
    """Rigid bodies on a plane. Close it, or use it as a context manager.

    Repeated calls are bit-equal, also between processes and whatever was dropped before: between drops the body is
    parked far above the ground for one step, which empties all contact caches, and then placed anew.

    Very small and very large bodies are simulated as models, see `sim.port.model_scale`, and the results converted
    back: Bullet's tolerances are absolute (slop 10 um, restitution from 0.2 m/s on).

    Friction is right to a few percent. Restitution is not: Bullet takes the last gap before an impact from the rebound,
    so that measured rebounds from 1 m scatter around `e^2` by 0.1 m and more, and vary with the step.
    """

    def __init__(self) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        if self._client < 0:
            raise RuntimeError("PyBullet has no free client; at most 1024 exist per process")
        self._loaded: _Loaded | None = None

    @property
    def name(self) -> str:
        """Engine and version."""
        return f"pybullet {version('pybullet')}"

    def close(self) -> None:
        """Free the engine's world; the object cannot be used afterwards."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client, self._loaded = -1, None

    def __enter__(self) -> BulletSimulator:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def drop(self, body: RigidBody, X_WA: FloatArray, settings: DropSettings) -> DropResult:
        """See `sim.port.Simulator`. Raises RuntimeError when the engine did not build the given body."""
        loaded = self._loaded
        if loaded is None or loaded.body is not body or loaded.world != settings.world:
            loaded = self._load(body, settings.world)
        rows, finite = self._simulate(loaded, X_WA, settings)
        points = pybullet.getContactPoints(loaded.handle, loaded.ground, physicsClientId=self._client)
        return _result(loaded, rows, settings, len(points), finite)

    def drop_many(
        self, body: RigidBody, poses_WA: Sequence[FloatArray], settings: DropSettings
    ) -> tuple[DropResult, ...]:
        """See `sim.port.Simulator`. One after another in one world.

        Many bodies side by side in one world cost the same, and there the result of each depends on its neighbours
        through the order in which the solver visits contacts.
        """
        return tuple(self.drop(body, X_WA, settings) for X_WA in poses_WA)

    def drop_probes(
        self, fixed: Sequence[CollisionShape], probes: Sequence[CollisionShape], duration_s: float
    ) -> ProbeResult:
        """See `sim.port.Simulator`."""
        return drop_probes(fixed, probes, duration_s)

    def load(self, body: RigidBody, task: LoadTask) -> LoadOutcome:
        """See `sim.port.Simulator`."""
        return load(body, task)

    def grasp(self, body: RigidBody, X_WA: FloatArray, task: GraspTask) -> GraspOutcome:
        """See `sim.port.Simulator`."""
        return grasp(body, X_WA, task)

    def exercise_joints(self, articulation: Articulation, tasks: Sequence[JointTask]) -> ArticulationExercise:
        """See `sim.port.Simulator`."""
        return exercise_joints(articulation, tasks)

    def handle_joint(self, articulation: Articulation, task: HandlingTask) -> HandlingOutcome:
        """See `sim.port.Simulator`."""
        return handle_joint(articulation, task)

    def _load(self, body: RigidBody, world: World) -> _Loaded:
        """Build ground and body in an empty world, and verify the engine's copy of the body."""
        client = self._client
        self._loaded = None
        size = diagonal(body.shapes)
        scale = model_scale(size)
        pybullet.resetSimulation(physicsClientId=client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=world.timestep_s,
            numSubSteps=world.substeps,
            enableFileCaching=0,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )
        pybullet.setGravity(*world.gravity_mps2, physicsClientId=client)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
        ground = pybullet.createMultiBody(0, plane, useMaximalCoordinates=1, physicsClientId=client)
        pybullet.changeDynamics(ground, -1, lateralFriction=1.0, restitution=1.0, physicsClientId=client)

        dynamic = dynamic_body(body.shapes, body.mass, scale, client)
        handle = dynamic.handle
        loaded = _Loaded(body, world, handle, ground, scale, size * scale, dynamic.X_AI)
        self._verify_body(loaded, dynamic.mass_kg, dynamic.moments_kgm2)
        contact = body.contact
        pybullet.changeDynamics(
            handle,
            -1,
            # Bullet has one coefficient; the dynamic one is the safe side for an object that must come to rest.
            lateralFriction=pair_value(contact.dynamic_friction, world.ground_friction, contact.combine),
            restitution=pair_value(contact.restitution, world.ground_restitution, contact.combine),
            spinningFriction=0.0,
            rollingFriction=world.rolling_resistance_m * scale,
            angularDamping=1.0 - math.exp(-world.turning_loss_per_s / math.sqrt(scale)),  # the share lost in a second
            physicsClientId=client,
        )
        self._loaded = loaded
        return loaded

    def _verify_body(self, loaded: _Loaded, mass_kg: float, moments: FloatArray) -> None:
        """Raise RuntimeError unless mass frame, extent of the shapes, mass and moments are those of the body.

        One push far above the ground: a force of m N and moments of I Nm about the principal axes, times 1e-3 lest the
        gyroscopic moment shows, change each speed by 1e-3 units per second.
        """
        client, handle, name = self._client, loaded.handle, loaded.body.name
        position, quat_xyzw = pybullet.getBasePositionAndOrientation(handle, physicsClientId=client)
        offset = np.abs(position - loaded.X_AI[:3, 3] - [0.0, 0.0, PARKED_M]).max()
        turned = pose.angle_between(pose.quat_of(loaded.X_AI[:3, :3]), pose.to_wxyz(np.asarray(quat_xyzw)))
        if offset > 1e-9 or turned > 1e-6:
            raise RuntimeError(f"{name}: the engine's mass frame is {position}, {quat_xyzw}, not {loaded.X_AI}")
        low, high = (np.asarray(c) for c in pybullet.getAABB(handle, -1, physicsClientId=client))
        exact = bounds(loaded.body.shapes) * loaded.scale + [0.0, 0.0, PARKED_M]
        slack = _SINGLE * loaded.diagonal_m + 1e-9
        if np.any(low > exact[0] + slack) or np.any(high < exact[1] - slack):
            raise RuntimeError(f"{name}: the engine's box {low}, {high} misses part of {exact}")

        self._place(handle, pose.pose(None, (0.0, 0.0, PARKED_M)))
        pybullet.stepSimulation(physicsClientId=client)  # Only a step makes the engine use the inertia it was given.
        self._place(handle, pose.pose(None, (0.0, 0.0, PARKED_M)))
        frame = {"flags": pybullet.WORLD_FRAME, "physicsClientId": client}
        pybullet.applyExternalForce(handle, -1, [1e-3 * mass_kg, 0.0, 0.0], [0.0, 0.0, PARKED_M], **frame)
        pybullet.applyExternalTorque(handle, -1, (1e-3 * moments).tolist(), **frame)
        pybullet.stepSimulation(physicsClientId=client)
        linear, angular = pybullet.getBaseVelocity(handle, physicsClientId=client)
        step_s = loaded.world.timestep_s
        speed_ratios = np.array([linear[0] - loaded.world.gravity_mps2[0] * step_s, *angular]) / (1e-3 * step_s)
        if not np.allclose(speed_ratios, 1.0, rtol=1e-3):
            raise RuntimeError(f"{name}: a push gives {speed_ratios} of the speeds that mass and inertia call for")

    def _simulate(self, loaded: _Loaded, X_WA: FloatArray, settings: DropSettings) -> tuple[list[Any], bool]:
        """Rows (position, quaternion xyzw, linear, angular) of the inertial frame in the model's units, and whether
        the motion stayed finite.
        """
        client, handle = self._client, loaded.handle
        root = math.sqrt(loaded.scale)
        X_WI = scaled(X_WA, loaded.scale) @ loaded.X_AI
        self._place(handle, pose.pose(X_WI[:3, :3], (0.0, 0.0, PARKED_M)))
        pybullet.stepSimulation(physicsClientId=client)
        self._place(handle, X_WI)

        still = settings.still or Stillness(0.0, math.inf)
        steps = math.ceil(settings.duration_s * root / settings.world.timestep_s - 1e-9)
        hold = max(1, math.ceil(still.hold_s * root / settings.world.timestep_s)) if settings.still else steps + 1
        speed, gyration = (still.speed_mps * root) ** 2, _largest_gyration_m2(loaded)
        far_m = PARKED_M * max(1.0, loaded.diagonal_m)
        rows, quiet, finite = [self._state(handle)], 0, True
        for _ in range(steps):
            pybullet.stepSimulation(physicsClientId=client)
            row = self._state(handle)
            (x, y, z), (vx, vy, vz), (wx, wy, wz) = row[0], row[2], row[3]
            if not abs(x) + abs(y) + abs(z) < far_m:  # also true of NaN
                finite = False
                break
            rows.append(row)
            is_still = vx * vx + vy * vy + vz * vz + gyration * (wx * wx + wy * wy + wz * wz) <= speed
            quiet = quiet + 1 if is_still else 0
            if quiet > hold:
                break
        return rows, finite

    def _place(self, handle: int, X_WI: FloatArray) -> None:
        quat_xyzw = Rotation.from_matrix(X_WI[:3, :3]).as_quat().tolist()
        pybullet.resetBasePositionAndOrientation(handle, X_WI[:3, 3].tolist(), quat_xyzw, physicsClientId=self._client)
        pybullet.resetBaseVelocity(handle, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], physicsClientId=self._client)

    def _state(self, handle: int) -> tuple[Any, ...]:
        placement = pybullet.getBasePositionAndOrientation(handle, physicsClientId=self._client)
        return (*placement, *pybullet.getBaseVelocity(handle, physicsClientId=self._client))


def _largest_gyration_m2(loaded: _Loaded) -> float:
    """The largest principal moment over the mass: bounds the rms speed of turning from above."""
    moments, _ = principal_axes(loaded.body.mass.inertia_kgm2)
    return float(moments.max()) / loaded.body.mass.mass_kg * loaded.scale**2


def _result(loaded: _Loaded, rows: list[Any], settings: DropSettings, contacts: int, finite: bool) -> DropResult:
    """The recorded rows of the inertial frame, as motion of the asset frame at true size."""
    positions, quats_xyzw, linear, angular = (np.array([row[i] for row in rows]) for i in range(4))
    scale, root = loaded.scale, math.sqrt(loaded.scale)
    X_IA = pose.inverse(loaded.X_AI)
    R_WI = Rotation.from_quat(quats_xyzw).as_matrix()
    R_WA = R_WI @ X_IA[:3, :3]
    origins = (positions + R_WI @ X_IA[:3, 3]) / scale
    return DropResult(
        times_s=np.arange(len(rows), dtype=np.float64) * (settings.world.timestep_s / root),
        positions_m=origins,
        quats_wxyz=pose.quat_of(R_WA),
        linear_mps=linear / root,
        angular_radps=angular * root,
        speeds_mps=rms_speeds(loaded.body.mass, R_WA, linear / root, angular * root),
        heights_m=heights(loaded.body.shapes, origins, R_WA),
        contacts=contacts,
        left_patch=bool(np.linalg.norm(origins[:, :2] - origins[0, :2], axis=1).max() > settings.patch_radius_m),
        finite=finite,
    )
