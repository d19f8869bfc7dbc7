"""Protocols and data of a rigid-body simulator: drops, probes, loads, grasps, joints, resets; SI units, world z up.

Implementations: `sim.bullet.simulator`, and `sim.fake` for tests. Also Froude scaling and tabletop worlds by size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np

from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape, Contact, MassProperties, RigidBody
from sim.grasp_trial import GraspOutcome, GraspTask
from sim.joint_exercise import Articulation, ArticulationExercise, JointTask
from sim.joint_handling import HandlingOutcome, HandlingTask
from sim.loading import LoadOutcome, LoadTask

ROLLING_RESISTANCE = 0.003  # of the size, see `world_for`
SMALLEST_M, LARGEST_M, MODEL_M = 0.02, 5.0, 0.3
Combine = Literal["average", "multiply", "minimum", "maximum"]


@dataclass(frozen=True)
class World:
    """The plane z = 0, gravity, and the step. Two drops in equal worlds are comparable number by number.

    The ground has one friction and one restitution; the rule of the body's `Contact` combines them with its own. The
    ground's rule counts as "average", the weakest one, so the body's always wins (PhysX, `PxCombineMode`).
    `rolling_resistance_m` is the lever arm of the moment that opposes rolling (Coulomb 1785), `turning_loss_per_s` the
    rate at which turning decays; both are 0 for an ideal world, in which round things never come to rest. A slope is
    the same plane under tilted gravity.
    """

    ground_friction: float = 0.5
    ground_restitution: float = 0.0
    rolling_resistance_m: float = 0.0
    turning_loss_per_s: float = 0.0
    gravity_mps2: tuple[float, float, float] = (0.0, 0.0, -GRAVITY_MPS2)
    timestep_s: float = 1.0 / 240.0  # of the model, if the body is simulated as one
    substeps: int = 2


@dataclass(frozen=True)
class Stillness:
    """At rest means: the rms speed of the body's matter stays below its bound for `hold_s`."""

    speed_mps: float
    hold_s: float


@dataclass(frozen=True)
class DropSettings:
    """How long to simulate, and when to stop early: once the body is at rest by the criterion `still`, if any."""

    duration_s: float
    world: World = field(default_factory=World)
    still: Stillness | None = None
    patch_radius_m: float = math.inf


@dataclass(frozen=True)
class DropResult:
    """The recorded motion, one row per step, row 0 the pose as released.

    times_s (k,); positions_m (k, 3) and quats_wxyz (k, 4) of the asset frame in the world; linear_mps (k, 3) of the
    mass centre and angular_radps (k, 3), world axes; speeds_mps (k,), the rms speed of the body's matter
    `sqrt(2 E_kin / m)`, which weighs turning and travelling alike at any size; heights_m (k,) of the lowest point of
    the collision geometry over the ground, computed from the pose and the exact shapes, not from the engine's contacts:
    negative is penetration.
    `contacts` is the engine's number of contact points at the end. `left_patch`: the origin went further from its
    start than `patch_radius_m`. `finite` is False when the motion diverged; rows after that are left out.
    """

    times_s: FloatArray
    positions_m: FloatArray
    quats_wxyz: FloatArray
    linear_mps: FloatArray
    angular_radps: FloatArray
    speeds_mps: FloatArray
    heights_m: FloatArray
    contacts: int
    left_patch: bool
    finite: bool

    @property
    def penetration_m(self) -> float:
        """Deepest penetration into the ground at any time, at least 0."""
        return max(0.0, -float(self.heights_m.min()))

    def touch_s(self, tolerance_m: float) -> float | None:
        """When the body first came within `tolerance_m` of the ground; None if never."""
        touching = np.flatnonzero(self.heights_m <= tolerance_m)
        return float(self.times_s[touching[0]]) if touching.size else None

    def still_since_s(self, still: Stillness) -> float | None:
        """Since when the body has been at rest at the end of the record; None if it is not, or not for `hold_s`."""
        moving = np.flatnonzero(self.speeds_mps > still.speed_mps)
        start = 0 if moving.size == 0 else int(moving[-1]) + 1
        if not self.finite or start >= len(self.times_s):
            return None
        since = float(self.times_s[start])
        return since if self.times_s[-1] - since >= still.hold_s * (1.0 - 1e-9) else None


@dataclass(frozen=True)
class ProbeResult:
    """Final state of loose probes: centres (n, 3), heights (n,) of their lowest points, speeds (n,)."""

    centres_m: FloatArray
    lowest_m: FloatArray
    speeds_mps: FloatArray


@dataclass(frozen=True)
class PlacedBody:
    """A body of a scene at pose X_WA (4, 4); a body that does not move needs shapes and contact alone."""

    body: RigidBody
    X_WA: FloatArray
    moves: bool


class Simulator(Protocol):
    """Drops rigid bodies. Equal calls give equal results, whatever was simulated before."""

    @property
    def name(self) -> str:
        """Engine and version, as written to records."""
        ...

    def drop(self, body: RigidBody, X_WA: FloatArray, settings: DropSettings) -> DropResult:
        """The motion of `body` released at rest in pose `X_WA` (4, 4)."""
        ...

    def drop_many(
        self, body: RigidBody, poses_WA: Sequence[FloatArray], settings: DropSettings
    ) -> tuple[DropResult, ...]:
        """Independent drops: element i equals `drop(body, poses_WA[i], settings)`."""
        ...

    def drop_probes(
        self, fixed: Sequence[CollisionShape], probes: Sequence[CollisionShape], duration_s: float
    ) -> ProbeResult:
        """Boxes and spheres released at rest where they are posed, over the `fixed` shapes, without any ground.

        Probes do not collide with one another. All share one frame, z up; friction is 0.5, nothing bounces.
        """
        ...

    def load(self, body: RigidBody, task: LoadTask) -> LoadOutcome:
        """The motion of `body` and of loose probes, from the moment when the probes are released."""
        ...

    def grasp(self, body: RigidBody, X_WA: FloatArray, task: GraspTask) -> GraspOutcome:
        """A gripper takes `body`, at rest on the ground in pose `X_WA`, through the motion of the task."""
        ...

    def exercise_joints(self, articulation: Articulation, tasks: Sequence[JointTask]) -> ArticulationExercise:
        """Move the joints of an articulated object whose base is fixed, one task at a time, and look at what happens.

        Each joint is driven and pushed from rest to both ends of its range while the others are held at rest; joints
        that follow it move with it, and joints that close a loop are left out. Overlaps of links are measured at rest
        and along the range. With a probe in its link the joint is moved to its far end once more, slowly.
        """
        ...

    def handle_joint(self, articulation: Articulation, task: HandlingTask) -> HandlingOutcome:
        """A gripper takes or pushes a link of an articulated object, whose base is fixed, along the path of a joint."""
        ...


class ResetWorld(Protocol):
    """A world whose bodies stay while their poses and materials change."""

    def add(self, body: RigidBody, moves: bool) -> int:
        """Build a body, out of reach of all others; returns its number."""
        ...

    def set_pose(self, number: int, X_WA: FloatArray | None) -> None:
        """Put a body at rest at X_WA (4, 4); None takes it out of the scene."""
        ...

    def set_material(self, number: int, mass: MassProperties, contact: Contact) -> None:
        """Set the mass properties of a body, about the same mass centre, and its contact values."""
        ...


def pair_value(body: float, ground: float, rule: Combine) -> float:
    """Friction or restitution of a contact, from the values of both sides and the rule that combines them."""
    if rule == "average":
        return 0.5 * (body + ground)
    if rule == "multiply":
        return body * ground
    return min(body, ground) if rule == "minimum" else max(body, ground)


def natural_time_s(diagonal_m: float) -> float:
    """The time in which gravity moves a body by about its own size, `sqrt(L / g)`: the unit of every duration."""
    return math.sqrt(diagonal_m / GRAVITY_MPS2)


def model_scale(diagonal_m: float) -> float:
    """How many times its size a body is simulated at: 1 from 2 cm to 5 m, else for a model of 0.3 m or of 5 m.

    Engines are made for things of hand to door size. By Froude similarity (equal g, equal densities), exact for rigid
    bodies, the model moves alike: lengths x s, times and speeds x sqrt(s), turning rates / sqrt(s), masses x s^3,
    inertia x s^5, friction and restitution as they are.
    """
    if diagonal_m < SMALLEST_M:
        return MODEL_M / diagonal_m
    return min(1.0, LARGEST_M / diagonal_m)  # A smaller model would sink in deeper: tolerances grow with the true size.


def world_for(diagonal_m: float) -> World:
    """A tabletop for a body of that size, alike at every size.

    Rolling resistance is 0.3 % of the size (a hard ball on a table) and turning decays by 15 % in one natural time, so
    that round things come to rest; steps are at most 1/80 of the natural time (1 to 8 substeps).
    """
    natural_s = natural_time_s(diagonal_m)
    model_s = natural_time_s(diagonal_m * model_scale(diagonal_m))
    return World(
        rolling_resistance_m=ROLLING_RESISTANCE * diagonal_m,
        turning_loss_per_s=0.15 / natural_s,
        substeps=min(max(math.ceil(World.timestep_s * 80.0 / model_s), 1), 8),
    )


def stillness_for(diagonal_m: float) -> Stillness:
    """Rest for a body of that size: half a percent of its natural speed `sqrt(g L)` for three natural times.

    A body that tips off an edge doubles its speed about every natural time, so it cannot hide.
    """
    natural_s = natural_time_s(diagonal_m)
    return Stillness(speed_mps=0.005 * diagonal_m / natural_s, hold_s=3.0 * natural_s)


def rms_speeds(mass: MassProperties, R_WA: FloatArray, linear_mps: FloatArray, angular_radps: FloatArray) -> FloatArray:
    """`sqrt(2 E_kin / m)` (k,) for orientations (k, 3, 3), mass-centre velocities and turning rates (k, 3) in W."""
    angular_A = np.einsum("kji,kj->ki", R_WA, angular_radps)
    turning = np.einsum("ki,ij,kj->k", angular_A, mass.inertia_kgm2, angular_A) / mass.mass_kg
    return np.sqrt((linear_mps**2).sum(axis=1) + np.maximum(turning, 0.0))
