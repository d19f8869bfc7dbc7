"""Exercise of the joints of an articulated object in PyBullet: driven and pushed over their range, with a probe inside.

The base is fixed, gravity acts, and the other joints are held at rest by motors; joints that follow the exercised one
move with it. A drive is a position motor whose target runs a little past both ends of the range. A push is a force of a
hand at the contact, along its path and at most at the speed of the pace, as the effort that it has about the axis: a
motor takes it in the engine, because an explicit force throws light links to and fro. The hand never holds back. Both
are three times as strong as it takes to bring the moved mass, at most all of it at the far end of the colliders, to
its speed in a tenth of the stroke against gravity, friction, damping and spring: a joint that this does not move is
stuck, or its links are heavier to turn than anything of their size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from geom import pose
from geom.mechanism_pose import joint_positions
from schemas.arrays import FloatArray
from sim.bullet.articulation import JOINT_STEP_S, BuiltArticulation, build
from sim.bullet.joint_motors import apply_passive, drive_followers, drive_joint, hold_joints
from sim.bullet.joint_overlaps import overlaps_along, overlaps_at_rest
from sim.bullet.joint_stroke import Stroke, stroke_of
from sim.bullet.probes import FRICTION, build_loose
from sim.bullet.world import private_client
from sim.joint_exercise import (
    Actuation,
    Articulation,
    ArticulationExercise,
    JointExercise,
    JointRun,
    JointTask,
    Pace,
    ProbeCarry,
    followers,
    moved_links,
)

BEYOND = 0.03  # of the range: how far past an end a drive's target runs; further, and motor and limit share the way
PATIENCE = 1.5  # times the seconds of a stroke, until a push counts as blocked
SETTLING_S, SETTLING_SHARE = 0.15, 0.1  # at each end, seconds or of a stroke, in which a slam rings out
ARRIVED = 0.002  # of the range: a push is over
PRESSING = 5.0  # times what stops the joint from its speed in one step
LOOK_STEPS = 16  # between two looks at the poses of links
FINE_STEP_S = 0.5 * JOINT_STEP_S  # A limit stops a joint within one step: of those that may slam.
DIVERGED = 100.0  # ranges
SPEED_SLACK = 3.0  # over the speed of the stroke and of a free fall
AXIS_ANGLE_RAD = 0.5  # turn after which the axis is read off the poses of links


def exercise_joints(articulation: Articulation, tasks: Sequence[JointTask]) -> ArticulationExercise:
    """See `sim.port.Simulator.exercise_joints`."""
    with private_client() as client:
        built = build(articulation, client)
        at_rest = overlaps_at_rest(built)
        strokes = {j.name: stroke_of(built, j) for j in articulation.mechanism.tree if j.kind != "ball"}
        exercises = tuple(_Exercise(built, strokes, task).run() for task in tasks)
    return ArticulationExercise(exercises, at_rest)


class _Exercise:
    """The exercise of one joint in the world of `built`."""

    def __init__(self, built: BuiltArticulation, strokes: Mapping[str, Stroke], task: JointTask) -> None:
        self.built, self.strokes, self.task = built, strokes, task
        mechanism = built.articulation.mechanism
        self.joint = next(j for j in mechanism.tree if j.name == task.joint)
        self.followers = followers(mechanism, self.joint)
        self.moved = moved_links(mechanism, (self.joint, *self.followers))
        self.unit = built.unit(self.joint)
        self.number = built.joint_index(self.joint)
        self.root = math.sqrt(built.scale)
        self.stroke = strokes[self.joint.name]

    def run(self) -> JointExercise:
        axis: FloatArray | None = None
        runs: list[JointRun] = []
        for actuation, pace in self.task.runs:
            run, measured_axis = self._run(actuation, pace)
            runs.append(run)
            axis = measured_axis if axis is None else axis
        overlaps = overlaps_along(self.built, self.joint, self.moved, self.stroke.reach)
        probe = self._carry() if self.task.probe is not None else None
        return JointExercise(self.joint.name, self.stroke.reach, axis, tuple(runs), overlaps, probe)

    def _reset(self, fine: bool) -> float:
        """All joints at rest; motors hold the others there, of the exercised one and its followers they are off.

        Returns the time step (s, of the model).
        """
        built = self.built
        mechanism = built.articulation.mechanism
        # Before the motors: the engine turns their limits of effort into impulses when they are set.
        step_s = FINE_STEP_S if fine else JOINT_STEP_S
        pybullet.setTimeStep(step_s, physicsClientId=built.client)
        built.set_positions(joint_positions(mechanism, {}))
        hold_joints(built, self.strokes, (self.joint, *self.followers), self.root)
        return step_s

    def _run(self, actuation: Actuation, pace: Pace) -> tuple[JointRun, FloatArray | None]:
        motion = _Motion(self, pace, self._reset(fine=(actuation, pace) != ("drive", "slow")))
        ends = [self.stroke.high, self.stroke.low]
        for end in ends:
            if actuation == "drive":
                motion.drive(end + math.copysign(BEYOND * self.stroke.span, end - (sum(ends) - end)))
            else:
                motion.push(end, sum(ends) - end)
        left_rest = 0.0
        if actuation == "drive":
            motion.drive(0.0)
            left_rest = abs(motion.q) / self.unit
        run = JointRun(
            actuation,
            pace,
            motion.lowest / self.unit + self.joint.rest,
            motion.highest / self.unit + self.joint.rest,
            left_rest,
            motion.fastest * self.stroke.arm / self.root,
            SPEED_SLACK * (motion.rate * self.stroke.arm + self.stroke.fall_mps) / self.root,
            self._force_n(motion.strength) if actuation == "push" else None,
            motion.fastest * motion.step_s / self.unit,
            motion.finite,
        )
        return run, motion.axis

    def _force_n(self, effort: float) -> float:
        """The force (true N) at the contact that has this effort (model) about the axis."""
        if not self.joint.is_angular:
            return effort / self.built.scale**3
        arm = float(np.linalg.norm(np.cross(np.asarray(self.task.contact) - self.joint.anchor, self.joint.axis)))
        return effort / self.built.scale**4 / arm if arm > 0.0 else math.inf

    def _carry(self) -> ProbeCarry:
        """The probe set down in the link at rest, and the link driven slowly to its far end."""
        built, probe = self.built, self.task.probe
        assert probe is not None
        step_s = self._reset(fine=False)
        body = next(b for b in built.articulation.links if b.name == self.joint.child)
        mass_kg = 0.05 * max(body.mass.mass_kg, 1e-6) * built.scale**3
        handle = build_loose(probe, built.scale, mass_kg, built.client)
        pybullet.changeDynamics(handle, -1, lateralFriction=FRICTION, physicsClientId=built.client)
        motion = _Motion(self, "slow", step_s)
        motion.hold(2.0 * SETTLING_S * self.root)
        X_WL, start = built.link_pose(self.joint.child), _centre(handle, built.client)
        far = self.stroke.high if self.stroke.high >= -self.stroke.low else self.stroke.low
        motion.drive(far)
        X_WL_end, end = built.link_pose(self.joint.child), _centre(handle, built.client)
        pybullet.removeBody(handle, physicsClientId=built.client)
        back = X_WL @ pose.inverse(X_WL_end)
        carried = pose.apply(pose.inverse(back), start[None])[0]
        moved = float(np.linalg.norm(carried - start)) / built.scale
        return ProbeCarry(moved, start / built.scale, pose.apply(back, end[None])[0] / built.scale)


class _Motion:
    """A joint in motion, in units of the model: its position from rest, extremes, and the axis once it has moved."""

    def __init__(self, exercise: _Exercise, pace: Pace, step_s: float) -> None:
        self.exercise, self.built, self.stroke = exercise, exercise.built, exercise.stroke
        self.seconds = self.stroke.seconds(pace, exercise.root)
        self.rate = self.stroke.span / self.seconds
        self.step_s = step_s
        self.q = self.qd = self.lowest = self.highest = self.fastest = 0.0
        self.finite = True
        self.axis: FloatArray | None = None
        self._axis_travel = 0.0
        joint = exercise.joint
        self._inertia = max(self.built.effective_inertia(joint), 1e-12)
        self.strength = self.stroke.strength(self.rate, self._inertia)
        self._parent, self._child = (self.built.link_pose(name) for name in (joint.parent, joint.child))
        self._settling = max(SETTLING_S * exercise.root, SETTLING_SHARE * self.seconds)
        self._steps = 0

    def hold(self, seconds: float) -> None:
        """The joint held at rest for a while."""
        self._motor(0.0, 0.0)
        for _ in range(math.ceil(seconds / self.step_s)):
            self._step()

    def drive(self, target: float) -> None:
        """The motor's target moves to `target` at the rate of the pace, and waits there."""
        start = self.q
        travel = target - start
        moving = max(1, math.ceil(abs(travel) / self.rate / self.step_s))
        for k in range(moving + math.ceil(self._settling / self.step_s)):
            share = min((k + 1) / moving, 1.0)
            self._motor(start + share * travel, math.copysign(self.rate, travel) if share < 1.0 else 0.0)
            self._passive()
            if not self._step():
                return

    def push(self, end: float, other_end: float) -> None:
        """A hand pushes towards `end`, until the joint rests there or a stroke and a half have passed."""
        towards = 1.0 if end >= other_end else -1.0
        steps = math.ceil((PATIENCE * abs(end - self.q) / self.rate + self._settling) / self.step_s)
        ringing = math.ceil(self._settling / self.step_s)
        for _ in range(steps):
            arrived = towards * (self.q - end) >= -ARRIVED * self.stroke.span
            pushing = towards * self.qd <= 1.01 * self.rate  # What falls ahead of the hand meets friction alone.
            effort = max(self.strength - self.stroke.friction, 0.0) if pushing else self.stroke.friction
            effort = min(effort, self._light()) if arrived else effort
            pybullet.setJointMotorControl2(
                self.built.handle,
                self.exercise.number,
                pybullet.VELOCITY_CONTROL,
                targetVelocity=towards * self.rate if pushing else 0.0,
                velocityGain=1.0,
                force=effort,
                physicsClientId=self.built.client,
            )
            self._passive()
            self._follow()
            if not self._step():
                return
            ringing -= arrived
            if ringing <= 0:
                return

    def _light(self) -> float:
        """The effort that presses against an end: the engine lets strong motors and limits share the way."""
        return min(PRESSING * self._inertia * self.rate / self.step_s, self.strength)

    def _motor(self, position: float, velocity: float) -> None:
        pressing = self.stroke.joint.limits is not None and not self.stroke.low <= position <= self.stroke.high
        there = not self.stroke.low < self.q < self.stroke.high
        effort = self._light() if pressing and there else self.strength
        drive_joint(self.built, self.exercise.number, position, velocity, effort, self.seconds / self.step_s)
        self._follow(position, velocity)

    def _follow(self, position: float | None = None, velocity: float | None = None) -> None:
        """Motors of the joints that follow this one, to where it is or is driven to."""
        exercise = self.exercise
        state = self.q if position is None else position, self.qd if velocity is None else velocity
        drive_followers(
            self.built, exercise.strokes, exercise.joint, exercise.followers, state, self.seconds, self.step_s
        )

    def _passive(self) -> None:
        apply_passive(self.built, self.stroke, (self.q, self.qd), self._inertia, self.step_s)

    def _step(self) -> bool:
        """One step; False once the motion has diverged."""
        pybullet.stepSimulation(physicsClientId=self.built.client)
        state = pybullet.getJointState(self.built.handle, self.exercise.number, physicsClientId=self.built.client)
        q, qd = state[0], state[1]
        if not (math.isfinite(q) and math.isfinite(qd)) or abs(q) > DIVERGED * self.stroke.span:
            self.finite = False
            return False
        self.q, self.qd = q, qd
        self.lowest, self.highest = min(self.lowest, q), max(self.highest, q)
        self.fastest = max(self.fastest, abs(qd))
        self._steps += 1
        if self._steps % LOOK_STEPS == 0:
            self._observe_axis()
        return True

    def _observe_axis(self) -> None:
        """The axis from the poses of both links, at the largest travel up to a turn that is still unambiguous."""
        joint = self.exercise.joint
        most = AXIS_ANGLE_RAD if joint.is_angular else math.inf
        if not 1.05 * self._axis_travel < abs(self.q) <= most:
            return
        parent, child = (self.built.link_pose(name) for name in (joint.parent, joint.child))
        moved = pose.inverse(parent) @ child @ pose.inverse(pose.inverse(self._parent) @ self._child)
        step = Rotation.from_matrix(moved[:3, :3]).as_rotvec() if joint.is_angular else moved[:3, 3]
        step = self._parent[:3, :3] @ step * math.copysign(1.0, self.q)
        length = float(np.linalg.norm(step))
        if length > 0.0:
            self.axis, self._axis_travel = step / length, abs(self.q)


def _centre(handle: int, client: int) -> FloatArray:
    return np.asarray(pybullet.getBasePositionAndOrientation(handle, physicsClientId=client)[0])
