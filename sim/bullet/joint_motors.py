"""Motors of the joints of a built articulation: others held at rest, followers taken along, springs and damping.

All numbers are in units of the model (`sim.port.model_scale`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import pybullet

from geom.mechanism_pose import joint_positions
from schemas.mechanism import MechanismJoint
from sim.bullet.articulation import BuiltArticulation
from sim.bullet.joint_stroke import Stroke

GAIN = 40.0  # of the position motor, per stroke: an error of 2 % of the range is braked with what strength there is
HOLDING = 10.0  # strength of the motors of other joints, over that of the exercised one at its own job


def hold_joints(
    built: BuiltArticulation, strokes: Mapping[str, Stroke], free: Collection[MechanismJoint], root: float
) -> None:
    """Motors that hold all joints at rest but those that are `free`, whose motors are off."""
    for joint in built.articulation.mechanism.tree:
        if joint.kind == "ball":
            continue
        stroke = strokes[joint.name]
        effort = HOLDING * stroke.strength(stroke.span / stroke.seconds("fast", root), stroke.inertia)
        pybullet.setJointMotorControl2(
            built.handle,
            built.joint_index(joint),
            pybullet.POSITION_CONTROL,
            targetPosition=0.0,
            targetVelocity=0.0,
            positionGain=0.3,
            velocityGain=1.0,
            force=0.0 if joint in free else effort,
            physicsClientId=built.client,
        )


def drive_joint(
    built: BuiltArticulation, number: int, position: float, velocity: float, effort: float, stroke_steps: float
) -> None:
    """A position motor, where a stroke takes that many steps."""
    pybullet.setJointMotorControl2(
        built.handle,
        number,
        pybullet.POSITION_CONTROL,
        targetPosition=position,
        targetVelocity=velocity,
        positionGain=min(GAIN / stroke_steps, 1.0),
        velocityGain=1.0,
        force=effort,
        physicsClientId=built.client,
    )


def drive_followers(
    built: BuiltArticulation,
    strokes: Mapping[str, Stroke],
    joint: MechanismJoint,
    followers: Sequence[MechanismJoint],
    state: tuple[float, float],
    seconds: float,
    step_s: float,
) -> None:
    """Motors of the joints that follow `joint`, to where its position from rest and its rate (`state`) put them; a
    stroke of it takes `seconds`.
    """
    if not followers:
        return
    (q, qd), unit, mechanism = state, built.unit(joint), built.articulation.mechanism
    at = joint_positions(mechanism, {joint.name: q / unit + joint.rest})
    ahead = joint_positions(mechanism, {joint.name: (q + qd) / unit + joint.rest})
    for other in followers:
        its_unit = built.unit(other)
        target, speed = (at[other.name] - other.rest) * its_unit, (ahead[other.name] - at[other.name]) * its_unit
        stroke = strokes[other.name]
        effort = HOLDING * stroke.strength(max(abs(speed), stroke.span / seconds), stroke.inertia)
        drive_joint(built, built.joint_index(other), target, speed, effort, seconds / step_s)


def apply_passive(
    built: BuiltArticulation, stroke: Stroke, state: tuple[float, float], inertia: float, step_s: float
) -> None:
    """Spring and damping of a joint, implicitly: the effort that they have at the end of the step."""
    damping, stiffness = stroke.damping, stroke.stiffness
    if damping == 0.0 and stiffness == 0.0:
        return
    (q, qd), joint = state, stroke.joint
    spring_rest = (joint.spring_rest - joint.rest) * built.unit(joint)
    force = -stiffness * (q + qd * step_s - spring_rest) - damping * qd
    effort = force / (1.0 + (damping + stiffness * step_s) * step_s / inertia)
    pybullet.setJointMotorControl2(
        built.handle,
        built.joint_index(joint),
        pybullet.TORQUE_CONTROL,
        force=effort,
        physicsClientId=built.client,
    )
