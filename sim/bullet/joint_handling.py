"""Simulate a gripper that moves a joint in PyBullet: it takes a link, or pushes it, along the path of the joint.

The object and its joints are those of the exercise (`sim.bullet.joint_exercise`): base fixed, gravity on, other joints
held, friction, damping and springs as the package has them. The motion of the hand is prescribed, its contacts are not;
its force is limited, so that a joint that is stuck stays where it is. There is no ground.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np
import pybullet

from geom.grasp.gripper import boxes
from geom.mechanism_pose import joint_positions
from geom.pose import rotation_about
from schemas.arrays import FloatArray
from schemas.mechanism import MechanismJoint
from sim.bullet.articulation import BuiltArticulation, build
from sim.bullet.gripper import BulletGripper
from sim.bullet.joint_motors import drive_followers, hold_joints
from sim.bullet.joint_stroke import Stroke, stroke_of
from sim.bullet.world import private_client, scaled
from sim.gripper_description import LINK_KG
from sim.joint_exercise import Articulation, followers, moved_links
from sim.joint_handling import (
    APPROACH_M,
    FORCE_WINDOW_S,
    TURN_LENGTH_M,
    HandlingOutcome,
    HandlingPhase,
    HandlingTask,
    HandlingTrace,
    hand_path,
    smooth_step,
)

# A lever of 5 g between fingers of 0.5 kg each: with the 100 of the exercise friction stays far below its limit.
HANDLING_ITERATIONS = 400
YIELDING = 0.5  # of the force of a pad
HAND_MPS2 = 2.0  # acceleration of the hand that its motors can give beside its force on the link
TOUCHING_M = 0.001  # One pad may carry all that moves the joint, while the other follows.
_MOUNT_LINKS = 7  # that the mount moves at most
_OBJECT_GROUP, _GRIPPER_GROUP = 1, 2
_NEXT = 1e-4  # of the way: step of the numerical derivative of the path
_ASTRAY = 100.0  # ways beyond the end: the motion diverged
_MOVING = (HandlingPhase.MOVE, HandlingPhase.BACK)
_CLOSED = (HandlingPhase.CLOSE, HandlingPhase.MOVE, HandlingPhase.BACK)


def handle_joint(articulation: Articulation, task: HandlingTask) -> HandlingOutcome:
    """See `sim.port.Simulator.handle_joint`."""
    with private_client() as client:
        return _Handling(build(articulation, client), task).run()


@dataclass
class _Seen:
    """What is looked at in each step of the moving hand."""

    steps: int = 0
    touching: int = 0
    force_n: float = 0.0
    fastest: float = 0.0
    recent: deque[float] = field(default_factory=deque[float])


class _Handling:
    """One object and one gripper in the world of `built`, both `built.scale` times as large as they are."""

    def __init__(self, built: BuiltArticulation, task: HandlingTask) -> None:
        self._built, self._task, self._client = built, task, built.client
        mechanism = built.articulation.mechanism
        self._joint: MechanismJoint = next(j for j in mechanism.tree if j.name == task.joint)
        self._followers = followers(mechanism, self._joint)
        self._scale, self._root = built.scale, math.sqrt(built.scale)
        moved = moved_links(mechanism, (self._joint, *self._followers))
        self._moved = {built.index[name] for name in moved}
        self._strokes = {j.name: stroke_of(built, j) for j in mechanism.tree if j.kind != "ball"}
        pybullet.setPhysicsEngineParameter(numSolverIterations=HANDLING_ITERATIONS, physicsClientId=self._client)
        pybullet.setTimeStep(task.step_s, physicsClientId=self._client)
        built.set_positions(joint_positions(mechanism, {task.joint: task.start}))
        hold_joints(built, self._strokes, (self._joint, *self._followers), self._root)
        for link in range(-1, len(built.index) - 1):
            pybullet.setCollisionFilterGroupMask(
                built.handle, link, _OBJECT_GROUP, _OBJECT_GROUP | _GRIPPER_GROUP, physicsClientId=self._client
            )
        self._gripper = BulletGripper(
            self._client,
            task,
            scaled(task.X_AG, self._scale),
            self._scale,
            np.asarray(self._joint.axis),
        )
        self._gripper.scale_mass(self._scale**3)
        contact = next(body.contact for body in built.articulation.links if body.name == self._joint.child)
        self._gripper.set_friction(task.friction / math.sqrt(max(contact.dynamic_friction, 1e-6)))
        strong = (task.hand_n + _MOUNT_LINKS * LINK_KG * HAND_MPS2) * self._scale**3
        self._efforts = strong * np.array([1.0, 1.0, 1.0, TURN_LENGTH_M * self._scale])
        self._shift_A = np.zeros(3)
        self._steps, self._finite, self._seen = 0, True, _Seen()
        self._trace: list[tuple[float, float, FloatArray]] = []

    def run(self) -> HandlingOutcome:
        """All phases; it ends early when the motion diverges."""
        task = self._task
        self._gripper.place(self._model(self._hand(HandlingPhase.APPROACH, 0.0)))
        began = reached = back = task.start
        begin_s = 0.0
        for phase, seconds in task.phases(self._joint):
            self._move_fingers(phase)
            self._step_through(phase, begin_s, seconds)
            begin_s += seconds
            if phase is HandlingPhase.CLOSE:
                self._shift_A = self._gripper.mount()[:3] / self._scale
            position = self._built.state(self._joint)[0]
            if phase in (HandlingPhase.APPROACH, HandlingPhase.CLOSE):
                began = position
            if phase is HandlingPhase.MOVE:
                reached = position
            if phase is (HandlingPhase.BACK if task.takes else HandlingPhase.RETREAT):
                back = position
            if not self._finite:
                break
        seen, path_rate = self._seen, 1.5 * abs(task.end - task.start) / task.move_s(self._joint)
        return HandlingOutcome(
            began,
            reached,
            back,
            seen.touching / max(seen.steps, 1),
            seen.force_n / self._scale**3,
            seen.fastest / max(path_rate, 1e-12),
            self._finite,
            self._traced(),
        )

    def _move_fingers(self, phase: HandlingPhase) -> None:
        """They close with the force of the task, open with as much as it takes, and else stay."""
        task = self._task
        closing = 0.0 if not task.takes else 1.0 if phase in _CLOSED else -float(phase is HandlingPhase.RELEASE)
        force = task.force_n * self._scale**3 if closing > 0.0 else float(self._efforts[0])
        self._gripper.move_fingers(closing * task.gripper.speed_mps * self._root, force)

    def _step_through(self, phase: HandlingPhase, begin_s: float, seconds: float) -> None:
        step_s = self._task.step_s
        while self._steps * step_s < (begin_s + seconds) * self._root - 1e-9 and self._finite:
            self._steps += 1
            time_s = self._steps * step_s / self._root
            share, rate = smooth_step((time_s - begin_s) / seconds, seconds)
            place, ahead = self._hand(phase, share), self._hand(phase, share + _NEXT)
            velocity = (ahead - place) / _NEXT * rate
            self._gripper.drive(self._model(place), self._model(velocity) / self._root, self._strength(phase))
            self._gripper.carry_weight()
            self._step_joint()
            if phase in _MOVING:
                self._look((ahead - place) / _NEXT)
            if self._task.trace_s is not None and time_s >= len(self._trace) * self._task.trace_s:
                self._trace.append((time_s, self._built.state(self._joint)[0], self._gripper.boxes()))

    def _strength(self, phase: HandlingPhase) -> FloatArray:
        """(4,) efforts of the mount. While the pads close it gives way to them, so that both come to lie on a link that
        does not; the hand then goes on from there.
        """
        if phase is not HandlingPhase.CLOSE:
            return self._efforts
        yielding = np.minimum(self._efforts, YIELDING * self._task.force_n * self._scale**3)
        return np.append(yielding[:3], self._efforts[3])

    def _step_joint(self) -> None:
        """A step with what resists or drives the joint, and its followers."""
        built, joint = self._built, self._joint
        stroke = self._strokes[joint.name]
        position, rate = built.state(joint)
        state = (position - joint.rest) * built.unit(joint), rate
        self._resist(stroke, *state)
        seconds = stroke.seconds("slow", self._root)
        drive_followers(built, self._strokes, joint, self._followers, state, seconds, self._task.step_s)
        pybullet.stepSimulation(physicsClientId=self._client)
        position = built.state(joint)[0]
        way = abs(self._task.end - self._task.start)
        self._finite = math.isfinite(position) and abs(position - self._task.start) <= _ASTRAY * way

    def _resist(self, stroke: Stroke, q: float, qd: float) -> None:
        """Friction, damping and spring as a motor whose effort is limited to theirs, in units of the model.

        The solver then weighs them against hand and limits, however light the link; an explicit force throws it about,
        and one that is implicit for the link alone gives way to the hand.
        """
        resisting = stroke.friction + stroke.damping * abs(qd)
        way = (stroke.joint.spring_rest - stroke.joint.rest) * self._built.unit(stroke.joint) - q
        spring = stroke.stiffness * way
        target = 0.0
        if qd * spring < 0.0:
            target, resisting = way / self._task.step_s, abs(spring) + resisting
        elif abs(spring) > resisting:
            target, resisting = way / self._task.step_s, abs(spring) - resisting
        pybullet.setJointMotorControl2(
            self._built.handle,
            self._built.joint_index(stroke.joint),
            pybullet.VELOCITY_CONTROL,
            targetVelocity=target,
            velocityGain=1.0,
            force=resisting,
            physicsClientId=self._client,
        )

    def _hand(self, phase: HandlingPhase, share: float) -> FloatArray:
        """(4,) where the mount is to be after that share of a phase, true lengths."""
        task, joint = self._task, self._joint
        along = {HandlingPhase.MOVE: share, HandlingPhase.BACK: 1.0 - share}.get(phase)
        if along is None:
            left = phase in (HandlingPhase.RELEASE, HandlingPhase.RETREAT) and not task.comes_back
            along = 1.0 if left else 0.0
        place = hand_path(task, joint, task.start + along * (task.end - task.start), self._shift_A)
        away = {HandlingPhase.APPROACH: 1.0 - share, HandlingPhase.RETREAT: share}.get(phase, 0.0)
        z_A = rotation_about(np.asarray(joint.axis), float(place[3])) @ task.X_AG[:3, 2]
        return place - np.append(away * APPROACH_M * z_A, 0.0)

    def _model(self, mount: FloatArray) -> FloatArray:
        return mount * [self._scale, self._scale, self._scale, 1.0]

    def _look(self, tangent: FloatArray) -> None:
        """Contacts of the gripper, its force along the path and the speed of the joint in this step."""
        gripper, seen = self._gripper, self._seen
        points = pybullet.getContactPoints(gripper.handle, self._built.handle, physicsClientId=self._client)
        near = TOUCHING_M * self._scale
        touched = {point[3] for point in points if point[4] in self._moved and point[8] <= near}
        seen.steps += 1
        seen.touching += {gripper.left, gripper.right} <= touched if self._task.takes else bool(touched)
        seen.recent.append(self._hand_force(tangent))
        window = max(1, round(FORCE_WINDOW_S * self._root / self._task.step_s))
        if len(seen.recent) > window:
            seen.recent.popleft()
        if len(seen.recent) == window:
            seen.force_n = max(seen.force_n, abs(sum(seen.recent)) / window)
        rate = abs(self._built.state(self._joint)[1]) / self._built.unit(self._joint) * self._root
        seen.fastest = max(seen.fastest, rate)

    def _hand_force(self, tangent: FloatArray) -> float:
        """Force of the motors of the mount along the path, where `tangent` (4,) is how
        the mount moves per whole path; model newtons.
        """
        task = self._task
        way = abs(task.end - task.start) * (task.arm_m(self._joint) if self._joint.is_angular else 1.0)
        return float(self._gripper.mount_efforts() @ self._model(tangent)) / (way * self._scale)

    def _traced(self) -> HandlingTrace | None:
        if self._task.trace_s is None:
            return None
        times, positions, grippers = (np.array(rows) for rows in zip(*self._trace, strict=True))
        grippers[:, :, :3, 3] /= self._scale
        _, half = boxes(self._task.gripper, np.array([self._task.opening_m]))
        return HandlingTrace(self._task.joint, times, positions, grippers, half[0])
