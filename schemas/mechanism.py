"""The moving structure of an articulated object: links and joints in one object frame, at one rest state.

The object stands in its rest state: every joint at its `rest`. Anchors and axes are given there, in the frame of the
object (of `Model` or of the asset), so that a joint at position q moves its child, and all below it, by q - rest about
or along its axis. The frame of a link lies at `origin` with the axes of the object frame. SI units but for lengths of
a model in source units.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pydantic import ConfigDict

from schemas.arrays import FloatArray
from schemas.diagnostics import Location

MechanismJointKind = Literal["revolute", "continuous", "prismatic", "ball"]
ANGULAR: tuple[MechanismJointKind, ...] = ("revolute", "continuous", "ball")


@dataclass(frozen=True)
class MechanismLink:
    """One body of the object: `name` is an identifier, unique in its object; meshes refer to it (`Mesh.link`).

    origin   (3,) the origin of its frame at rest: a point of the axis of the joint that carries it.
    members  names of the links of the source that are welded into it.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    name: str
    origin: FloatArray
    members: tuple[str, ...] = ()


@dataclass(frozen=True)
class JointCoupling:
    """A joint follows another one: its position is multiplier * (position of `joint`) + offset."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class MechanismJoint:
    """A joint between two links, by their names; positions in rad or m.

    anchor, axis   (3,) a point of the axis and its unit direction at rest, in the object frame.
    rest           position in the rest state, within the limits.
    limits         least and greatest position; None: it turns without end. `limits_inferred`: not stated.
    effort         largest force or torque of a drive (N, N m); velocity: largest speed; None where not stated.
    damping, friction, armature, stiffness, spring_rest   as in `schemas.robot_description.DescribedJoint`.
    closes_loop    the links are a tree without it; its child is carried by another joint.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    name: str
    kind: MechanismJointKind
    parent: str
    child: str
    anchor: FloatArray
    axis: FloatArray
    rest: float = 0.0
    limits: tuple[float, float] | None = None
    effort: float | None = None
    velocity: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    armature: float = 0.0
    stiffness: float = 0.0
    spring_rest: float = 0.0
    coupling: JointCoupling | None = None
    closes_loop: bool = False
    limits_inferred: bool = False
    source_name: str = ""
    where: Location | None = None

    @property
    def is_angular(self) -> bool:
        """Whether its position is an angle."""
        return self.kind in ANGULAR


@dataclass(frozen=True)
class Mechanism:
    """Links, the root first and parents before children, and joints in the order of the source.

    Joints that do not close a loop carry every link but the root. `fixed_base`: the source holds the root in the world.
    """

    links: tuple[MechanismLink, ...]
    joints: tuple[MechanismJoint, ...]
    fixed_base: bool = False

    @property
    def root(self) -> MechanismLink:
        """The link that no joint carries."""
        return self.links[0]

    @property
    def tree(self) -> tuple[MechanismJoint, ...]:
        """The joints that carry links."""
        return tuple(joint for joint in self.joints if not joint.closes_loop)
