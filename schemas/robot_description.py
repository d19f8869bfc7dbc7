"""A robot or mechanism as a description file (URDF, MJCF) states it: links, joints, shapes, and unread elements.

SI units (m, rad, kg, s). Frames: L link (of MJCF: a body), P parent link, C child link, I inertial frame (origin in
the mass centre), S shape. All arrays are read-only. Every element keeps its file and line.

Several joints may carry one child (MJCF). They act in their order: with every joint at its `reference` the child is
at X_PC; at positions q it is at X_PC M_1(q_1) M_2(q_2) ..., M_i the motion about or along `axis_C` through `anchor_C`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from schemas.arrays import FloatArray, IntArray
from schemas.diagnostics import Diagnostic, Location

DescriptionFormat = Literal["urdf", "mjcf", "usd"]
JointKind = Literal["fixed", "revolute", "continuous", "prismatic", "ball", "planar", "floating"]
DescribedShapeKind = Literal[
    "box", "sphere", "cylinder", "capsule", "ellipsoid", "plane", "mesh", "heightfield", "fitted", "unknown"
]
InertiaSource = Literal["declared", "shapes", "missing"]
WORLD_LINK = "world"  # name of the first link of an MJCF model, which is its `<worldbody>`


class SourceLine(NamedTuple):
    """File, relative to the root that no reference may leave, and line of an element; line 0 where there is none."""

    file: str
    line: int = 0

    @property
    def location(self) -> Location:
        """The same for a diagnostic."""
        return Location(file=self.file, line=self.line or None)


NOWHERE = SourceLine("")


def _identity() -> FloatArray:
    return np.eye(4)


def _origin() -> FloatArray:
    return np.zeros(3)


@dataclass(frozen=True)
class MeshReference:
    """The mesh of a shape, as written and as found.

    uri         as written (`package://arm/hand.obj`, `../hand.stl`); of MJCF with the mesh folder in front. "" where
                the vertices are in the description itself.
    path        of the file, relative to the root ("" where it is absent or refused: then `problem` says why).
    scale       (x, y, z) factors on the vertices of the file; a negative one mirrors.
    reference_position_m, reference_quat_wxyz
                MuJoCo's refpos and refquat: a vertex v of the file is at scale * R^T (v - p) in the frame S.
    vertices, triangles  of a mesh that is written in the description: (n, 3) and (m, 3), before the three above.
    name        of the mesh asset (MJCF); "" in URDF.
    """

    uri: str
    path: str = ""
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    reference_position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    reference_quat_wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    vertices: FloatArray | None = None
    triangles: IntArray | None = None
    name: str = ""
    problem: Diagnostic | None = None
    source: SourceLine = NOWHERE


@dataclass(frozen=True)
class DescribedMaterial:
    """Colour (sRGB and opacity, 0..1; None: not stated) and texture file (as written, "" for none) of a shape.

    The numbers are MJCF's, 0..1, None where the file leaves them out: `shininess` times 128 is a Blinn-Phong exponent,
    `emission` a factor on the colour. `layers` are further texture files by role (MJCF `<layer>`), `unread` attributes
    as written that no field holds.
    """

    name: str
    rgba: tuple[float, float, float, float] | None = None
    texture: str = ""
    source: SourceLine = NOWHERE
    metallic: float | None = None
    roughness: float | None = None
    specular: float | None = None
    shininess: float | None = None
    emission: float | None = None
    layers: tuple[tuple[str, str], ...] = ()
    unread: tuple[tuple[str, str], ...] = ()


class ShapeFriction(NamedTuple):
    """Static and dynamic friction of one shape (URDF: `drake:proximity_properties`; MJCF: equal, the sliding one)."""

    static: float
    dynamic: float


@dataclass(frozen=True)
class DescribedShape:
    """One shape of a link at X_LS (4, 4).

    size_m   box: full edge lengths; sphere: (radius,); cylinder and capsule: (radius, height) along z, a capsule's
             without its caps; ellipsoid: the three half axes; plane: full lengths in x and y, 0 without end; of meshes
             and unknown kinds: ().
    collides, drawn  whether it takes part in contacts, and whether it is a picture. In MJCF every geom is drawn.
    mass_kg, density_kgm3  stated for the shape itself (MJCF), used where the link states no inertia; None where the
             shape does not count.
    problem  why the shape cannot be used; None where it can.
    """

    name: str
    kind: DescribedShapeKind
    size_m: tuple[float, ...]
    X_LS: FloatArray
    collides: bool
    drawn: bool
    mesh: MeshReference | None = None
    material: DescribedMaterial | None = None
    friction: ShapeFriction | None = None
    mass_kg: float | None = None
    density_kgm3: float | None = None
    group: int = 0
    problem: Diagnostic | None = None
    source: SourceLine = NOWHERE


@dataclass(frozen=True)
class Inertial:
    """Mass, and inertia (3, 3) about the mass centre in the axes of frame I, at X_LI (4, 4) in the link.

    `inertia_kgm2` is None where only the mass is stated.
    """

    mass_kg: float
    X_LI: FloatArray
    inertia_kgm2: FloatArray | None
    source: SourceLine = NOWHERE


@dataclass(frozen=True)
class DescribedCamera:
    """A camera at X_LC (4, 4) that looks along its -z; `fixed` to the link or following something."""

    name: str
    X_LC: FloatArray
    fovy_rad: float
    fixed: bool = True
    source: SourceLine = NOWHERE


@dataclass(frozen=True)
class DescribedLink:
    """A rigid body. `inertia_source` says what its mass comes from: its own statement, its shapes, or nothing.

    contact  numbers of PyBullet's `<contact>` by name (`lateral_friction`, `restitution`, ...), in the file's order.
    mocap    MuJoCo: something outside the model moves it.
    """

    name: str
    shapes: tuple[DescribedShape, ...] = ()
    inertial: Inertial | None = None
    inertia_source: InertiaSource = "missing"
    contact: Mapping[str, float] = field(default_factory=dict[str, float])
    cameras: tuple[DescribedCamera, ...] = ()
    mocap: bool = False
    source: SourceLine = NOWHERE


class JointLimits(NamedTuple):
    """Least and greatest position (rad, m), as stated: `lower` may exceed `upper`."""

    lower: float
    upper: float


class Mimic(NamedTuple):
    """The joint's position is multiplier * (position of `joint`) + offset."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class DescribedJoint:
    """A joint between two links, by their names.

    X_PC       (4, 4) child in parent with all joints of the child at their `reference`.
    axis_C     (3,) unit vector: of turning or sliding; of `planar` the normal. z for fixed, ball and floating ones.
    anchor_C   (3,) a point of the axis of turning; zero in URDF.
    reference  position at which the child is at X_PC (MuJoCo's `ref`).
    limits     None: the joint has none. effort (N, N m) and velocity (m/s, rad/s): None where not stated.
    damping (N s/m, N m s/rad), friction (N, N m), armature (kg, kg m2), stiffness (N/m, N m/rad) of a spring that
    rests at `spring_reference`.
    stated     whether the file has an element for it: a body of MJCF without joints is welded to its parent.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    X_PC: FloatArray = field(default_factory=_identity)
    axis_C: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    anchor_C: FloatArray = field(default_factory=_origin)
    reference: float = 0.0
    limits: JointLimits | None = None
    effort: float | None = None
    velocity: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    armature: float = 0.0
    stiffness: float = 0.0
    spring_reference: float = 0.0
    mimic: Mimic | None = None
    stated: bool = True
    source: SourceLine = NOWHERE

    @property
    def moves(self) -> bool:
        """Whether the joint lets its child move."""
        return self.kind != "fixed"


@dataclass(frozen=True)
class UnreadElement:
    """An element that the model above has no place for: its tag, its text in the file, and the element it lies in.

    `changes_bodies`: it makes bodies, joints or shapes, so the description is not whole without it.
    """

    tag: str
    text: str
    inside: str
    source: SourceLine
    changes_bodies: bool = False


@dataclass(frozen=True)
class RobotDescription:
    """A whole description: links and joints in the order of the file; the links form one tree below `root`.

    notes     findings that did not stop the reading, each with its place.
    unread    what was not understood (transmissions, tendons, sensors, ...).
    settings  attributes of MuJoCo's `<compiler>` as written, which say how the file was read; {} for URDF.
    """

    name: str
    format: DescriptionFormat
    links: tuple[DescribedLink, ...]
    joints: tuple[DescribedJoint, ...]
    root: str
    unread: tuple[UnreadElement, ...] = ()
    notes: tuple[Diagnostic, ...] = ()
    settings: Mapping[str, str] = field(default_factory=dict[str, str])
    source: SourceLine = NOWHERE
