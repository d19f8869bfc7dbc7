"""Analytic simulator for tests of callers: free fall (m, s), then at once rest on the nearest stable face."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from geom.convex.placement import moved_shape
from geom.convex.support_function import centre_heights, facet_directions, heights, support, surface
from geom.mesh.rays import Rays
from geom.pose import quat_of, shortest_rotation
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape, RigidBody
from sim.grasp_trial import GraspOutcome, GraspTask, Landing, Phase
from sim.joint_exercise import Articulation, ArticulationExercise, JointExercise, JointRun, JointTask, reach_of
from sim.joint_handling import HandlingOutcome, HandlingTask
from sim.loading import LoadOutcome, LoadTask
from sim.port import DropResult, DropSettings, ProbeResult, World

_NUDGE_RAD = 1e-4


class FakeSimulator:
    """Deterministic: the fall is an exact parabola, and the body at rest touches the ground exactly.

    No bounce, no sliding, no tumbling: when the lowest point touches, the body rests on the face of its convex hull
    that carries the mass centre and is nearest to facing down; a body without such a face stays as it touched.
    """

    name = "fake 1"

    def drop(self, body: RigidBody, X_WA: FloatArray, settings: DropSettings) -> DropResult:
        """See `sim.port.Simulator`; only the vertical part of gravity acts."""
        world = settings.world
        times_s = np.arange(math.ceil(settings.duration_s / world.timestep_s - 1e-9) + 1, dtype=np.float64)
        times_s *= world.timestep_s
        gravity = -world.gravity_mps2[2]
        R_WA, p_WA = np.asarray(X_WA)[:3, :3], np.asarray(X_WA)[:3, 3]
        clearance = max(0.0, float(heights(body.shapes, p_WA[None], R_WA[None])[0]))
        falling = 0.5 * gravity * times_s**2 < clearance

        down_A = _resting_direction(body, -R_WA[2])
        R_WR = shortest_rotation(R_WA @ down_A, np.array([0.0, 0.0, -1.0])) @ R_WA
        rest = np.array([p_WA[0], p_WA[1], support(body.shapes, down_A[None])[0]])

        fallen = p_WA - 0.5 * gravity * times_s[:, None] ** 2 * np.array([0.0, 0.0, 1.0])
        positions = np.where(falling[:, None], fallen, rest)
        orientations = np.where(falling[:, None, None], R_WA, R_WR)
        linear = np.where(falling[:, None], -gravity * times_s[:, None] * np.array([0.0, 0.0, 1.0]), 0.0)
        return DropResult(
            times_s=times_s,
            positions_m=positions,
            quats_wxyz=quat_of(orientations),
            linear_mps=linear,
            angular_radps=np.zeros_like(linear),
            speeds_mps=np.linalg.norm(linear, axis=1),
            heights_m=heights(body.shapes, positions, orientations),
            contacts=0 if falling[-1] else 4,
            left_patch=False,
            finite=True,
        )

    def drop_many(
        self, body: RigidBody, poses_WA: Sequence[FloatArray], settings: DropSettings
    ) -> tuple[DropResult, ...]:
        """See `sim.port.Simulator`."""
        return tuple(self.drop(body, X_WA, settings) for X_WA in poses_WA)

    def grasp(self, body: RigidBody, X_WA: FloatArray, task: GraspTask) -> GraspOutcome:
        """See `sim.port.Simulator`: friction of both pads against the weight, no torques; what is held is let go."""
        if 2.0 * task.friction * task.force_n < body.mass.mass_kg * -World().gravity_mps2[2]:
            return GraspOutcome(Phase.LIFT, math.inf, released=False)
        lands = Phase.STAY in {phase for phase, _ in task.motion.phases}
        landing = Landing(0.0, 0.0, 0.0, 0.0, is_supported=True) if lands else None
        return GraspOutcome(None, 0.0, released=True, landing=landing)

    def load(self, body: RigidBody, task: LoadTask) -> LoadOutcome:
        """See `sim.port.Simulator`: the body stays where it is, probes come to rest on it as `drop_probes` has it."""
        X_WP = np.array([probe.shape.X_AS for probe in task.probes]).reshape(-1, 4, 4)
        fixed = [moved_shape(shape, task.X_WA) for shape in body.shapes]
        ended = X_WP.copy()
        ended[:, :3, 3] = self.drop_probes(fixed, [probe.shape for probe in task.probes], task.duration_s).centres_m
        times_s = np.array([0.0, task.duration_s])
        return LoadOutcome(times_s, np.stack([task.X_WA, task.X_WA]), np.stack([X_WP, ended]))

    def exercise_joints(self, articulation: Articulation, tasks: Sequence[JointTask]) -> ArticulationExercise:
        """See `sim.port.Simulator`: every joint moves exactly over its range, nothing is in its way or inside it."""
        mechanism = articulation.mechanism
        joints = {joint.name: joint for joint in mechanism.tree}
        exercises: list[JointExercise] = []
        for task in tasks:
            low, high = reach_of(mechanism, joints[task.joint])
            runs = tuple(JointRun(kind, pace, low, high, 0.0, 0.0, 1.0, None, 0.0, True) for kind, pace in task.runs)
            exercises.append(JointExercise(task.joint, (low, high), joints[task.joint].axis, runs, ()))
        return ArticulationExercise(tuple(exercises), ())

    def handle_joint(self, articulation: Articulation, task: HandlingTask) -> HandlingOutcome:
        """See `sim.port.Simulator`: the joint follows the hand exactly, as far as it can move."""
        mechanism = articulation.mechanism
        low, high = reach_of(mechanism, next(j for j in mechanism.tree if j.name == task.joint))
        reached = min(max(task.end, low), high)
        return HandlingOutcome(
            task.start, reached, task.start if task.comes_back else reached, 1.0, 0.0, 1.0, finite=True
        )

    def drop_probes(
        self, fixed: Sequence[CollisionShape], probes: Sequence[CollisionShape], duration_s: float
    ) -> ProbeResult:
        """See `sim.port.Simulator`: each probe comes to rest with its lowest point straight below its centre."""
        centres = np.array([probe.X_AS[:3, 3] for probe in probes]).reshape(-1, 3)
        below = np.array([support([probe], -np.eye(3)[2:])[0] for probe in probes]) + centres[:, 2]
        surfaces = [surface(shape) for shape in fixed]
        firsts = np.cumsum([0, *(len(points) for points, _ in surfaces)])[:-1]
        triangles = np.concatenate([faces + first for (_, faces), first in zip(surfaces, firsts, strict=True)])
        fall = (
            Rays(np.concatenate([points for points, _ in surfaces]), triangles).hit_distances(centres, -np.eye(3)[2])
            - below
        )
        free_m = 0.5 * -World().gravity_mps2[2] * duration_s**2
        caught = fall < free_m
        rest = centres - np.where(caught, fall, free_m)[:, None] * np.eye(3)[2]
        return ProbeResult(rest, rest[:, 2] - below, np.where(caught, 0.0, 2.0 * free_m / duration_s))


def _resting_direction(body: RigidBody, down_A: FloatArray) -> FloatArray:
    """The stable facet direction (3,) nearest to `down_A`, or `down_A` itself when there is none.

    A facet is stable when tipping the body over any of its edges lifts the mass centre.
    """
    facets = facet_directions(body.shapes)
    stable = [facet for facet in facets if _lifts_when_tipped(body, facet)]
    return max(stable, key=lambda facet: float(facet @ down_A)) if stable else down_A


def _lifts_when_tipped(body: RigidBody, facet: FloatArray) -> bool:
    angles = np.arange(16) * (2.0 * np.pi / 16)
    across = shortest_rotation(np.array([0.0, 0.0, 1.0]), facet)[:, :2]
    tipped = facet + _NUDGE_RAD * (np.cos(angles)[:, None] * across[:, 0] + np.sin(angles)[:, None] * across[:, 1])
    tipped /= np.linalg.norm(tipped, axis=1)[:, None]
    centre = np.asarray(body.mass.centre_of_mass_m)
    here = centre_heights(body.shapes, centre, facet[None])[0]
    return bool(np.all(centre_heights(body.shapes, centre, tipped) > here))
