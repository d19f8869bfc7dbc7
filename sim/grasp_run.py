"""The course of a grasp trial, for any engine: it drives the gripper of a `GraspWorld` through the motion of a task and
judges what becomes of the body. All quantities have their true size, whatever scale the engine works at.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from geom import pose
from geom.convex.support_function import heights
from geom.grasp.gripper import boxes
from schemas.arrays import FloatArray
from schemas.physics import RigidBody
from sim.grasp_trial import DROP_M, GraspOutcome, GraspTask, GraspTrace, Landing, Phase
from sim.port import rms_speeds

REST_S = 0.05  # before the motion begins
# With both pads on the body at their end.
_CARRIED = (Phase.LIFT, Phase.HOLD, Phase.CARRY, Phase.SHAKE, Phase.TILT, Phase.SWING, Phase.STIR)
_CLOSED = (Phase.CLOSE, *_CARRIED, Phase.LOWER)


class GraspWorld(Protocol):
    """A body on the ground and a gripper (`sim.gripper_description`) in an engine; SI units, world axes z up."""

    @property
    def time_s(self) -> float:
        """Seconds since the start."""
        ...

    def place_mount(self, positions: FloatArray) -> None:
        """Put the mount (5,) there at once, at rest."""
        ...

    def drive_mount(self, positions: FloatArray, rates: FloatArray) -> None:
        """Motors of the mount towards positions (5,) at rates (5,), strong enough to carry hand and body."""
        ...

    def drive_fingers(self, closing: float) -> None:
        """Fingers close with the force of the task (1), hold still (0) or open (-1), at the speed of the gripper."""
        ...

    def step(self) -> None:
        """One step of the engine."""
        ...

    def body_pose(self) -> FloatArray:
        """X_WA (4, 4)."""
        ...

    def body_velocity(self) -> tuple[FloatArray, FloatArray]:
        """Velocity of the mass centre (3,) and turning rate (3,)."""
        ...

    def gripper_poses(self) -> FloatArray:
        """X_WB (3, 4, 4) of the boxes of left finger, right finger and hand, in axes of the gripper."""
        ...

    def finger_touches(self) -> tuple[bool, bool]:
        """Whether the left and the right finger touch the body."""
        ...

    def hand_touches(self) -> bool:
        """Whether any part of the gripper touches the body."""
        ...

    def is_supported(self) -> bool:
        """Whether the body touches the ground."""
        ...


def run_grasp(world: GraspWorld, body: RigidBody, X_WA: FloatArray, task: GraspTask) -> GraspOutcome:
    """The outcome of the task on `body`, which lies at X_WA (4, 4) in the world; it ends early when the body falls."""
    return _Run(world, body, (X_WA @ task.X_AG)[:3, :3], task).run()


class _Run:
    def __init__(self, world: GraspWorld, body: RigidBody, R_WG: FloatArray, task: GraspTask) -> None:
        self._world, self._body, self._R_WG, self._task = world, body, R_WG, task
        self._centre_A = np.asarray(body.mass.centre_of_mass_m)
        self._trace: list[tuple[float, FloatArray, FloatArray]] = []

    def run(self) -> GraspOutcome:
        start, _ = self._task.motion.at(0.0, self._R_WG)
        self._world.place_mount(start)
        self._step_until(REST_S, 0.0)
        before = self._centre()
        moved_m, slip_m, released = 0.0, 0.0, False
        closed = let_go = self._in_gripper()
        set_down = self._world.body_pose()
        for phase, end_s in self._task.motion.ends():
            if phase is Phase.CLOSE:
                moved_m = float(np.linalg.norm(self._centre() - before))
            if phase is Phase.RELEASE:
                let_go, set_down = self._in_gripper(), self._world.body_pose()
                slip_m = float(np.linalg.norm(let_go - closed))
            closing = 1.0 if phase in _CLOSED else -1.0 if phase is Phase.RELEASE else 0.0
            self._step_until(REST_S + end_s, closing)
            if phase is Phase.CLOSE:
                closed = self._in_gripper()
            if phase in _CARRIED and not self._is_carried(closed):
                return GraspOutcome(phase, math.inf, released=False, moved_m=moved_m, trace=self._traced())
            if phase in (Phase.RELEASE, Phase.RETREAT):
                apart = float(np.linalg.norm(self._in_gripper() - let_go)) > DROP_M
                released = apart and not self._world.hand_touches()
        lands = Phase.STAY in {phase for phase, _ in self._task.motion.phases}
        landing = self._landing(set_down) if lands else None
        return GraspOutcome(None, slip_m, released, moved_m, landing, self._traced())

    def _is_carried(self, closed: FloatArray) -> bool:
        """Whether the body has not fallen in the gripper and both fingers touch it; false of NaN."""
        fallen = (self._hand()[:3, :3] @ (closed - self._in_gripper()))[2]
        return bool(fallen <= DROP_M) and all(self._world.finger_touches())

    def _step_until(self, end_s: float, closing: float) -> None:
        self._world.drive_fingers(closing)
        while self._world.time_s < end_s - 1e-9:
            ahead_s = self._world.time_s + self._task.step_s - REST_S
            self._world.drive_mount(*self._task.motion.at(ahead_s, self._R_WG))
            self._world.step()
            if self._task.trace_s is not None and self._world.time_s >= len(self._trace) * self._task.trace_s:
                self._trace.append((self._world.time_s, self._world.body_pose(), self._world.gripper_poses()))

    def _hand(self) -> FloatArray:
        return self._world.gripper_poses()[2]

    def _centre(self) -> FloatArray:
        return pose.apply(self._world.body_pose(), self._centre_A[None])[0]

    def _in_gripper(self) -> FloatArray:
        """(3,) mass centre in the axes of the gripper, from the hand."""
        X_WH = self._hand()
        return (self._centre() - X_WH[:3, 3]) @ X_WH[:3, :3]

    def _landing(self, set_down: FloatArray) -> Landing:
        """How the body lies now, against its pose X_WA when the pads began to open."""
        X_WA = self._world.body_pose()
        ends = pose.apply(X_WA, self._centre_A[None])[0], pose.apply(set_down, self._centre_A[None])[0]
        linear, angular = self._world.body_velocity()
        lowest = heights(self._body.shapes, X_WA[None, :3, 3], X_WA[None, :3, :3])
        return Landing(
            drift_m=float(np.linalg.norm((ends[0] - ends[1])[:2])),
            turn_rad=float(pose.angle_between(pose.quat_of(X_WA[:3, :3]), pose.quat_of(set_down[:3, :3]))),
            speed_mps=float(rms_speeds(self._body.mass, X_WA[None, :3, :3], linear[None], angular[None])[0]),
            penetration_m=max(0.0, -float(lowest[0])),
            is_supported=self._world.is_supported(),
        )

    def _traced(self) -> GraspTrace | None:
        if self._task.trace_s is None:
            return None
        times, bodies, grippers = (np.array(rows) for rows in zip(*self._trace, strict=True))
        _, half = boxes(self._task.gripper, np.array([self._task.opening_m]))
        return GraspTrace(times, bodies, grippers, half[0])
