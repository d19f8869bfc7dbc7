"""Data of the exercise of joints: an articulated object on a fixed base, what is tried on each joint, the outcome.

Everything is in the frame of the object (metres, kilograms, z up) at its rest state; positions of joints in rad or m,
as the mechanism counts them (`schemas.mechanism`). The exercise itself is `sim.port.Simulator.exercise_joints`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from geom.mechanism_pose import joint_positions
from schemas.arrays import FloatArray
from schemas.mechanism import Mechanism, MechanismJoint
from schemas.physics import CollisionShape, RigidBody

ONE_TURN_RAD = 2.0 * math.pi

Actuation = Literal["drive", "push"]
Pace = Literal["slow", "fast"]
ALL_RUNS: tuple[tuple[Actuation, Pace], ...] = (
    ("drive", "slow"),
    ("drive", "fast"),
    ("push", "slow"),
    ("push", "fast"),
)


@dataclass(frozen=True)
class Articulation:
    """An articulated object: the bodies of its links in their own frames, in the order of `mechanism.links`.

    Links that a joint connects do not collide with each other (UsdPhysics: `collisionEnabled` of the joint), nor do
    those of `filtered_pairs`; all others do.
    """

    mechanism: Mechanism
    links: tuple[RigidBody, ...]
    filtered_pairs: tuple[tuple[str, str], ...] = ()

    @property
    def silent_pairs(self) -> frozenset[frozenset[str]]:
        """Pairs of links that do not collide."""
        joined = [frozenset((joint.parent, joint.child)) for joint in self.mechanism.joints]
        return frozenset([*joined, *(frozenset(pair) for pair in self.filtered_pairs)])


@dataclass(frozen=True)
class JointTask:
    """What is tried on one joint.

    contact  (3,) where a hand pushes, on the link that the joint carries.
    probe    a loose ball or box inside that link, which the joint moves to the far end; None without.
    runs     how the joint is moved, each from rest to both ends.
    """

    joint: str
    contact: FloatArray
    probe: CollisionShape | None = None
    runs: tuple[tuple[Actuation, Pace], ...] = ALL_RUNS


@dataclass(frozen=True)
class JointRun:
    """One motion of a joint from rest to both ends of its range, and of a driven one back to rest.

    `lowest`, `highest` are the extreme positions; `left_rest` how far from rest a driven joint ended. `speed_mps` is
    the highest speed of the point farthest from the axis, `bound_mps` the highest that hand or motor and gravity can
    give it; `force_n` is the force of a hand at the contact, None of a drive. `step` is how far the joint went at most
    in one step of the simulation: an engine notices a limit so much too late. `finite` is False when the motion
    diverged; the figures are then those up to there.
    """

    actuation: Actuation
    pace: Pace
    lowest: float
    highest: float
    left_rest: float
    speed_mps: float
    bound_mps: float
    force_n: float | None
    step: float
    finite: bool


@dataclass(frozen=True)
class LinkOverlap:
    """How deep (m) two links reach into each other: at rest; or, at `position` of a joint, beyond what they do at rest.

    collides  whether the package lets the two collide.
    fixed     no joint but the moved one, and those that follow it, lies between the two: no other joint can part them.
    """

    first: str
    second: str
    depth_m: float
    collides: bool
    fixed: bool = False
    position: float | None = None


@dataclass(frozen=True)
class ProbeCarry:
    """A loose probe in a link that its joint moved to the far end of its range.

    `moved_m` is how far the link moved where the probe was; `start`, `end` (3,) where the centre of the probe lay in
    the link before and after, in the frame of the object as if the link were at rest.
    """

    moved_m: float
    start: FloatArray
    end: FloatArray


@dataclass(frozen=True)
class JointExercise:
    """What came of the exercise of one joint.

    reach    least and greatest position that it can have: its limits, narrowed by those of joints that follow it; a
             joint without limits makes one turn either way.
    axis     (3,) the direction in which positions grow, from the poses of its links while it was driven: the axis of
             rotation by the right-hand rule, or the direction of sliding; None where it did not move.
    overlaps the deepest overlap beyond rest of each pair of links that the joint moves against each other, over
             positions all along the reach; pairs below 0.1 mm are left out.
    """

    joint: str
    reach: tuple[float, float]
    axis: FloatArray | None
    runs: tuple[JointRun, ...]
    overlaps: tuple[LinkOverlap, ...]
    probe: ProbeCarry | None = None


@dataclass(frozen=True)
class ArticulationExercise:
    """The exercise of all joints, and the overlaps of links at rest."""

    joints: tuple[JointExercise, ...]
    at_rest: tuple[LinkOverlap, ...]


def followers(mechanism: Mechanism, joint: MechanismJoint) -> tuple[MechanismJoint, ...]:
    """The joints of the tree that follow `joint`, directly or through others."""
    by_name = {j.name: j for j in mechanism.joints}

    def leader(j: MechanismJoint) -> str:
        while j.coupling is not None:
            j = by_name[j.coupling.joint]
        return j.name

    return tuple(j for j in mechanism.tree if j.coupling is not None and leader(j) == joint.name)


def reach_of(mechanism: Mechanism, joint: MechanismJoint) -> tuple[float, float]:
    """The positions that a joint can have: see `JointExercise.reach`. Empty limits of followers are left out."""
    low, high = joint.limits or (joint.rest, joint.rest + ONE_TURN_RAD)
    for other in followers(mechanism, joint):
        offset = joint_positions(mechanism, {joint.name: 0.0})[other.name]
        gain = joint_positions(mechanism, {joint.name: 1.0})[other.name] - offset
        if other.limits is None or gain == 0.0:
            continue
        least, most = sorted((limit - offset) / gain for limit in other.limits)
        if max(low, least) < min(high, most):
            low, high = max(low, least), min(high, most)
    return min(low, joint.rest), max(high, joint.rest)


def moved_links(mechanism: Mechanism, joints: Sequence[MechanismJoint]) -> frozenset[str]:
    """Names of the links that move when these joints do."""
    moved = {joint.child for joint in joints}
    for link in mechanism.links:  # Parents come before children.
        if any(j.child == link.name and j.parent in moved for j in mechanism.tree):
            moved.add(link.name)
    return frozenset(moved)
