"""What a log shows about a place where an effect may act: the declared model and typical magnitudes, SI units.

Members of `sim.effects.effect.Effect` that depend on a log are functions of these classes, one per kind of
measurement. Comments that name a unit are for turning joints; for sliding ones it is m, m/s, kg, N.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.mechanism import MechanismModel
from sim.dynamics.tree import Link, mass_matrix

TOLERANCE = 0.05  # share to which declared numbers are believed; what lies within is a nuisance, not an effect
SUPPORT_PAIR = "body-support"  # the pair of surfaces at which contact effects act
PUSHER_PAIR = "body-pusher"


@dataclass(frozen=True)
class DeclaredJoint:
    """One joint of a declared mechanism.

    row_s   typical time between two rows of the log.
    """

    model: MechanismModel
    joint: int
    row_s: float

    @property
    def link(self) -> Link:
        """The link that the joint moves."""
        return self.model.tree[self.joint]

    @property
    def driven(self) -> bool:
        """Whether the mechanism has a drive."""
        return self.model.drive.type != "none"

    @property
    def friction(self) -> float:
        """Declared dry friction, N m."""
        return float(self.model.friction[self.joint])

    @property
    def damping(self) -> float:
        """Declared viscous friction, N m s/rad."""
        return float(self.model.damping[self.joint])

    @property
    def kp(self) -> float:
        """Declared gain on the position error: effort over effort per unit, per rad; 0 without a position drive."""
        return float(self.model.drive.kp[self.joint]) if self.model.drive.type == "position_pd" else 0.0

    @property
    def kd(self) -> float:
        """Declared gain on the rate, per rad/s; 0 without a position drive."""
        return float(self.model.drive.kd[self.joint]) if self.model.drive.type == "position_pd" else 0.0

    @property
    def inertia_at_zero(self) -> float:
        """Inertia about the joint with all joints at zero, kg m2."""
        return float(mass_matrix(self.model.tree, np.zeros((1, len(self.model.tree))))[0, self.joint, self.joint])

    @property
    def feels_gravity(self) -> bool:
        """Whether gravity has a lever at the joint."""
        return feels_gravity(self.link)

    @property
    def any_feels_gravity(self) -> bool:
        """Whether gravity has a lever at some joint of the mechanism."""
        return any(feels_gravity(link) for link in self.model.tree)


@dataclass(frozen=True)
class JointRanges(DeclaredJoint):
    """Typical magnitudes at one joint of a mechanism over all trials.

    torque, speed, low, high   of the motion: N m, rad/s, positions that were reached (rad).
    inertia, load, effort      about the joint (kg m2), of the bearing (N), commanded (N m).
    side_channels              median of every side channel that all trials have, by its name in the contract.
    step_s                     longest step of roll-outs.
    """

    torque: float
    speed: float
    low: float
    high: float
    inertia: float
    load: float
    effort: float
    side_channels: Mapping[str, float]
    step_s: float

    @property
    def span(self) -> float:
        """Range of positions that was reached, rad."""
        return self.high - self.low


@dataclass(frozen=True)
class LinkageJoint:
    """One joint of a tossed linkage.

    declared      the joint.
    weight_N      of the whole linkage.
    reach_m       of the joint's link; 1 (no unit) for a sliding joint, whose force is the weight itself.
    half_travel   rad.
    """

    declared: DeclaredJoint
    weight_N: float
    reach_m: float
    half_travel: float


@dataclass(frozen=True)
class TossRanges:
    """A tossed body, or one link or joint of a tossed linkage.

    body    the body, or the link, or the base with the mass of the whole linkage.
    speed   typical speed, m/s.
    linked  the body is part of a linkage; `base` says whether it is its measured link.
    joint   the joint in question; None for effects that act elsewhere.
    """

    body: BodyModel
    speed: float
    linked: bool = False
    base: bool = True
    joint: LinkageJoint | None = None

    @property
    def gravity_mps2(self) -> float:
        """Declared, or the standard one where none is declared."""
        return float(np.linalg.norm(self.body.gravity_W)) or GRAVITY_MPS2

    @property
    def weight_N(self) -> float:
        """Weight of the body."""
        return self.body.mass_kg * self.gravity_mps2

    @property
    def fall_s(self) -> float:
        """Time in which the body falls about its own length."""
        return float(np.sqrt(self.size_m / self.gravity_mps2))

    @property
    def size_m(self) -> float:
        """Longest side of the box around the shapes."""
        corners = np.concatenate([_corners(shape) for shape in self.body.shapes])
        return float(np.ptp(corners, axis=0).max())


@dataclass(frozen=True)
class ImpactRanges:
    """A body that hits a support; `has_pose`: its pose before each impact was measured."""

    body: BodyModel
    has_pose: bool


@dataclass(frozen=True)
class PushRanges:
    """A body that is pushed over a support.

    has_force            the pusher's force was measured.
    lever_m              of the moment that resists spinning, under an even pressure.
    reference_friction   of body and support as declared, above 0.
    pusher_friction      declared friction of body and pusher.
    low_m, high_m        (2,) corners of the foot, body frame.
    """

    body: BodyModel
    has_force: bool
    lever_m: float
    reference_friction: float
    pusher_friction: float
    low_m: FloatArray
    high_m: FloatArray


def feels_gravity(link: Link) -> bool:
    """Whether the link has mass and turns."""
    return link.mass_kg > 0.0 and not link.prismatic


def declared_com(body: BodyModel) -> dict[str, float]:
    """The declared mass centre by parameter."""
    return {f"{axis}_m": float(v) for axis, v in zip("xyz", body.com_B, strict=True)}


def _corners(shape: CollisionShape) -> FloatArray:
    """(n, 3) that bound a shape."""
    if shape.points is not None:
        return shape.points
    half = 0.5 * np.array([*shape.size_m, *shape.size_m])[:3]
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    return (signs * half) @ shape.X_AS[:3, :3].T + shape.X_AS[:3, 3]
