"""Data of a trial in which a gripper moves a joint of an articulated object: the task, the motion of the hand, what
comes of it.

Everything is in the frame A of the object, whose base is fixed (metres, z up), positions of joints in rad or m as the
mechanism counts them. The trial itself is `sim.port.Simulator.handle_joint`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from geom.grasp.gripper import Gripper
from geom.mechanism_pose import joint_motion
from geom.pose import inverse
from schemas.arrays import FloatArray
from schemas.mechanism import MechanismJoint

HAND_MPS = 0.3  # at most, of the grip centre along its path: an arm that opens a door
LEAST_MOVE_S, MOST_MOVE_S = 0.6, 2.5
APPROACH_M, APPROACH_S = 0.06, 0.4
GRIP_S = 0.35  # in which the fingers close or open
TURN_LENGTH_M = 0.1  # per radian that the hand turns, where the grip centre is nearer to the axis


class HandlingPhase(StrEnum):
    """What hand and fingers do, one after the other."""

    APPROACH = "approach"
    CLOSE = "close"
    MOVE = "move"
    BACK = "back"
    RELEASE = "release"
    RETREAT = "retreat"


@dataclass(frozen=True)
class HandlingTask:
    """A hand that takes a link or lays closed fingers against it, and moves along the path that the joint prescribes.

    joint        carries the link; the others are held at rest, those that follow it move with it.
    start, end   its positions at the beginning, and where the hand moves it.
    X_AG         (4, 4) the gripper at the link with the joint at `start`.
    opening_m    between the pads before they close; 0 where closed fingers push.
    takes        whether the pads close on the link.
    comes_back   whether the hand moves back to `start` before it lets go.
    force_n      of each pad; `hand_n` the force that the hand can give along its path.
    friction     between pads and link.
    A trace is taken every `trace_s` seconds; None takes none.
    """

    joint: str
    start: float
    end: float
    X_AG: FloatArray
    opening_m: float
    takes: bool
    comes_back: bool
    force_n: float
    hand_n: float
    friction: float
    gripper: Gripper = field(default_factory=Gripper)
    step_s: float = 1.0 / 240.0
    trace_s: float | None = None

    def phases(self, joint: MechanismJoint) -> tuple[tuple[HandlingPhase, float], ...]:
        """Each phase with its seconds."""
        move_s = self.move_s(joint)
        steps = [
            (HandlingPhase.APPROACH, APPROACH_S, True),
            (HandlingPhase.CLOSE, GRIP_S, self.takes),
            (HandlingPhase.MOVE, move_s, True),
            (HandlingPhase.BACK, move_s, self.comes_back),
            (HandlingPhase.RELEASE, GRIP_S, self.takes),
            (HandlingPhase.RETREAT, APPROACH_S, True),
        ]
        return tuple((phase, seconds) for phase, seconds, takes_part in steps if takes_part)

    def arm_m(self, joint: MechanismJoint) -> float:
        """From the axis of a turning joint to the grip, at least `TURN_LENGTH_M`."""
        arm = float(np.linalg.norm(np.cross(self.X_AG[:3, 3] - joint.anchor, joint.axis)))
        return max(arm, TURN_LENGTH_M)

    def move_s(self, joint: MechanismJoint) -> float:
        """Seconds from `start` to `end`, at most at `HAND_MPS`."""
        way = abs(self.end - self.start)
        if joint.is_angular:
            way *= self.arm_m(joint)
        # A smooth step is half as fast again in its middle.
        return min(max(1.5 * way / HAND_MPS, LEAST_MOVE_S), MOST_MOVE_S)


def hand_path(task: HandlingTask, joint: MechanismJoint, position: float, shift_A: FloatArray) -> FloatArray:
    """(4,) where the mount of the hand is with the joint at `position`: x, y, z from its grip, and the turn about the
    axis of the joint. The hand begins `shift_A` (3,) beside the grip.
    """
    carried = carry(joint, task.start, position)
    grip = task.X_AG[:3, 3]
    moved = carried[:3, :3] @ (grip + shift_A) + carried[:3, 3] - grip
    return np.append(moved, position - task.start if joint.is_angular else 0.0)


def carry(joint: MechanismJoint, start: float, position: float) -> FloatArray:
    """(4, 4) what the joint does to the points of its child, in A, from one position to another."""
    return joint_motion(joint, position - joint.rest) @ inverse(joint_motion(joint, start - joint.rest))


@dataclass(frozen=True)
class HandlingTrace:
    """States over time for pictures: times_s (k,), positions (k,) of the joint, and the boxes of left finger, right
    finger and hand X_AB (k, 3, 4, 4) with half edges (3, 3) in metres.
    """

    joint: str
    times_s: FloatArray
    positions: FloatArray
    X_AB: FloatArray
    half_m: FloatArray


@dataclass(frozen=True)
class HandlingOutcome:
    """What came of a trial.

    began        position of the joint when the hand begins to move it, `reached` at the end of the move, and `back` at
                 the end of the way back; where the pads do not hold it, at the end of all.
    kept         share of the time of moving in which the pads, or the fingers that push, were within a
                 millimetre of the moved links.
    force_n      largest force between hand and link along the path, as a mean over `FORCE_WINDOW_S`; of a turning joint
                 the moment about its axis over `HandlingTask.arm_m`.
    fastest      highest rate of the joint over the highest that the path has.
    finite       False when the motion diverged; the figures are then those up to there.
    """

    began: float
    reached: float
    back: float
    kept: float
    force_n: float
    fastest: float
    finite: bool
    trace: HandlingTrace | None = None


FORCE_WINDOW_S = 0.05


def smooth_step(share: float, seconds: float) -> tuple[float, float]:
    """A way from 0 to 1 that starts and ends at rest, after a share of `seconds`, and its rate per second."""
    share = min(max(share, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share), 6.0 * share * (1.0 - share) / seconds
