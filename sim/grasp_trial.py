"""Data of a trial in which a gripper takes a body from the ground: the motion of the hand, the task, the outcome.

SI units; frames: W world (z up, ground z = 0), A the body, G the gripper (`geom.grasp.gripper`). The trial itself is
`sim.port.Simulator.grasp`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from geom.grasp.gripper import Gripper
from schemas.arrays import FloatArray

# Of the motion. Lift, hold, shake and drop are those of `grasp_and_lift` of NVIDIA's SimReady runtime benchmark.
STANDOFF_M = 0.12  # from where the hand comes straight in, and to where it goes back
LIFT_M, DROP_M = 0.3, 0.1
SHAKE_HZ, SHAKE_M = 2.0, 0.01
CARRY_RADIUS_M, CARRY_RAD = 0.4, math.radians(60.0)  # as the first joint of an arm turns what it holds before it
PLACE_M = 0.001  # above where it was, so that what slipped is not pressed into the ground
# Of use, with a wrist that turns about the closing axis. A swing of that angle in 2.2 s turns at most as fast as the
# joints of the Franka arm, 2.2 rad/s; a vessel is empty at 100 degrees; a spoon goes round a cup.
TILT_RAD, SWING_RAD = math.radians(100.0), math.radians(90.0)
STIR_HZ, STIR_M = 1.0, 0.03
_POUR_SHARE = 0.2  # of the phase, for which the hand stays tilted


class Phase(StrEnum):
    """What hand and fingers do, one after the other."""

    APPROACH = "approach"
    CLOSE = "close"
    LIFT = "lift"
    HOLD = "hold"
    CARRY = "carry"
    SHAKE = "shake"
    TILT = "tilt"
    SWING = "swing"
    STIR = "stir"
    LOWER = "lower"
    RELEASE = "release"
    RETREAT = "retreat"
    STAY = "stay"


@dataclass(frozen=True)
class HandMotion:
    """Phases in order with their seconds; the hand starts at the grasp, or at a standoff where it is to approach.

    It is lifted by `lift_m`; the wrist turns to positive or negative angles, by the sign `wrist_sense`.
    """

    phases: tuple[tuple[Phase, float], ...]
    lift_m: float = LIFT_M
    wrist_sense: float = 1.0

    @property
    def turns_wrist(self) -> bool:
        """Whether the hand turns about its closing axis."""
        return any(phase in (Phase.TILT, Phase.SWING) for phase, _ in self.phases)

    def ends(self) -> tuple[tuple[Phase, float], ...]:
        """Each phase with the second at which it ends."""
        ends = np.cumsum([seconds for _, seconds in self.phases])
        return tuple((phase, float(end)) for (phase, _), end in zip(self.phases, ends, strict=True))

    def at(self, time_s: float, R_WG: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where the hand is to be (5,), and how fast (5,): x, y, z from the grasp in the world, turn about z, and turn
        of the wrist about the closing axis.
        """
        place, rate = np.zeros(5), np.zeros(5)
        begin_s = 0.0
        for phase, seconds in self.phases:
            share = min(max((time_s - begin_s) / seconds, 0.0), 1.0)
            here, moving = self._part(phase, share, seconds, place[3], R_WG)
            place, rate = place + here, rate + moving
            begin_s += seconds
        return place, rate

    def _part(
        self, phase: Phase, share: float, seconds: float, turn_rad: float, R_WG: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """What a phase adds (5,) after that share of it, and the rate of that (5,); `turn_rad` is the turn so far."""
        way, rate = _smooth(share, seconds)
        straight = {
            Phase.APPROACH: (way - 1.0, STANDOFF_M * R_WG[:, 2]),
            Phase.LIFT: (way, np.array([0.0, 0.0, self.lift_m])),
            Phase.LOWER: (way, np.array([0.0, 0.0, PLACE_M - self.lift_m])),
            Phase.RETREAT: (way, -STANDOFF_M * _turned(R_WG[:, 2], turn_rad)),
        }
        if phase in straight:
            done, whole = straight[phase]
            return _place(done * whole), _place(rate * whole)
        if phase is Phase.CARRY:
            turn, turning = CARRY_RAD * way, CARRY_RAD * rate
            arc = np.array([math.sin(turn), 1.0 - math.cos(turn), 0.0])
            along = np.array([math.cos(turn), math.sin(turn), 0.0])
            return _place(CARRY_RADIUS_M * arc, turn), _place(CARRY_RADIUS_M * turning * along, turning)
        if phase in (Phase.TILT, Phase.SWING):
            angle, stay = (TILT_RAD, _POUR_SHARE) if phase is Phase.TILT else (SWING_RAD, 0.0)
            out, turning = _there_and_back(share, seconds, stay)
            return _place(np.zeros(3), 0.0, self.wrist_sense * angle * out), _place(
                np.zeros(3), 0.0, self.wrist_sense * angle * turning
            )
        if phase in (Phase.SHAKE, Phase.STIR) and 0.0 < share < 1.0:
            frequency, radius = (SHAKE_HZ, SHAKE_M) if phase is Phase.SHAKE else (STIR_HZ, STIR_M)
            circular = 2.0 * math.pi * frequency
            angle = circular * share * seconds
            circle = np.array([math.sin(angle), 1.0 - math.cos(angle), 0.0])
            along = np.array([math.cos(angle), math.sin(angle), 0.0])
            return _place(radius * circle), _place(radius * circular * along)
        return np.zeros(5), np.zeros(5)


def _place(at_m: FloatArray, turn_rad: float = 0.0, wrist_rad: float = 0.0) -> FloatArray:
    return np.array([*at_m, turn_rad, wrist_rad])


def _smooth(share: float, seconds: float) -> tuple[float, float]:
    """From 0 to 1 at rest at both ends, and its rate in 1/s, after a share of the seconds."""
    return share * share * (3.0 - 2.0 * share), 6.0 * share * (1.0 - share) / seconds


def _there_and_back(share: float, seconds: float, stay: float) -> tuple[float, float]:
    """From 0 to 1, there for the share `stay`, and back to 0, and its rate in 1/s."""
    leg = 0.5 * (1.0 - stay)
    if leg < share < 1.0 - leg:
        return 1.0, 0.0
    value, rate = _smooth(min(share, 1.0 - share) / leg, leg * seconds)
    return value, rate if share <= leg else -rate


def _turned(direction: FloatArray, turn_rad: float) -> FloatArray:
    cos, sin = math.cos(turn_rad), math.sin(turn_rad)
    x, y, z = direction
    return np.array([cos * x - sin * y, sin * x + cos * y, z])


GRASP_AND_LIFT = HandMotion(
    (
        (Phase.CLOSE, 0.35),
        (Phase.LIFT, 0.8),
        (Phase.HOLD, 1.0),
        (Phase.SHAKE, 1.5),
        (Phase.RELEASE, 0.35),
    )
)
PICK_AND_PLACE = HandMotion(
    (
        (Phase.APPROACH, 0.6),
        (Phase.CLOSE, 0.35),
        (Phase.LIFT, 0.8),
        (Phase.HOLD, 1.0),
        (Phase.CARRY, 1.2),
        (Phase.SHAKE, 1.5),
        (Phase.LOWER, 1.0),
        (Phase.RELEASE, 0.35),
        (Phase.RETREAT, 0.6),
        (Phase.STAY, 1.0),
    )
)


@dataclass(frozen=True)
class GraspTask:
    """A gripper whose pads are to close on a body: its pose X_AG (4, 4) in the frame of the body, the opening between
    the pads before, the force of each pad, the friction between pads and body, and the step of the engine.

    A trace is taken every `trace_s` seconds; None takes none.
    """

    X_AG: FloatArray
    opening_m: float
    force_n: float
    friction: float
    gripper: Gripper = field(default_factory=Gripper)
    motion: HandMotion = GRASP_AND_LIFT
    step_s: float = 1.0 / 240.0
    trace_s: float | None = None


@dataclass(frozen=True)
class Landing:
    """How a body lies after it was let go: how far its mass centre drifted over the ground and how far it turned since,
    the rms speed of its matter, how deep its exact shapes reach into the ground, and whether the ground carries it.
    """

    drift_m: float
    turn_rad: float
    speed_mps: float
    penetration_m: float
    is_supported: bool


@dataclass(frozen=True)
class GraspTrace:
    """Poses over time for pictures: times_s (k,), the body X_WA (k, 4, 4), and the boxes of left finger, right finger
    and hand X_WB (k, 3, 4, 4) with half edges (3, 3) in metres.
    """

    times_s: FloatArray
    X_WA: FloatArray
    X_WB: FloatArray
    half_m: FloatArray


@dataclass(frozen=True)
class GraspOutcome:
    """Result of a trial. It ends early when the body has fallen.

    lost        the phase in which the pads lost the body; None where they held it until they opened.
    moved_m     how far the hand moved the mass centre before the pads closed.
    slip_m      how far the mass centre moved in the gripper while it was held; infinite when it fell.
    released    whether the body stayed behind when the pads opened.
    landing     how the body lies in the end; None where it was lost, or the motion does not set it down.
    trace       poses over time, if the task has an interval for them.
    """

    lost: Phase | None
    slip_m: float
    released: bool
    moved_m: float = 0.0
    landing: Landing | None = None
    trace: GraspTrace | None = None

    @property
    def held(self) -> bool:
        """Whether the pads held the body until they opened."""
        return self.lost is None
