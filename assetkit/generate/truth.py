"""What the generator of an object knows about it, exactly: links, joints, insides, holes, clearances (`truth.json`).

All in the asset frame at rest: z up, front +x, origin at the bottom centre of the bounding box. SI units; positions of
joints in m or rad.
"""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from schemas.anchors import Point3
from schemas.mechanism import MechanismJointKind

TRUTH_FILE = "truth.json"  # beside the sources that a generator writes


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class TrueLink(_Model):
    """One rigid body: volume of its material, mass, mass centre, and inertia about it in axes of the asset frame."""

    name: str
    volume_m3: float
    mass_kg: float
    centre_of_mass_m: Point3
    inertia_kgm2: tuple[Point3, Point3, Point3]


class TrueJoint(_Model):
    """A joint, its zero at rest. `axis` is the unit vector about or along which positive positions move the child.

    `limits` are None for a joint without end. `stiffness` is that of a spring which rests at `spring_rest`.
    """

    name: str
    kind: MechanismJointKind
    parent: str
    child: str
    anchor_m: Point3
    axis: Point3
    limits: tuple[float, float] | None
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    spring_rest: float = 0.0


class TrueInterior(_Model):
    """A space inside a link that is open along `direction`: what it holds up to its lowest rim, and its box."""

    name: str
    link: str
    volume_m3: float
    low_m: Point3
    high_m: Point3
    direction: Point3 = (0.0, 0.0, 1.0)


class TrueHole(_Model):
    """A hole or recess that something goes into: centre of its mouth, direction out of it, least width across.

    `depth_m` is None where it goes through the link.
    """

    name: str
    link: str
    centre_m: Point3
    axis: Point3
    width_m: float
    depth_m: float | None = None


class TrueClearance(_Model):
    """How much room one thing leaves another: width of the hole less width of what goes in, or the gap between two."""

    name: str
    inner: str
    outer: str
    clearance_m: float = Field(gt=0.0)


class TrueObject(_Model):
    """One object: one source file, which becomes one package."""

    name: str
    file: str
    links: tuple[TrueLink, ...]
    joints: tuple[TrueJoint, ...] = ()
    interiors: tuple[TrueInterior, ...] = ()
    holes: tuple[TrueHole, ...] = ()


class TrueParameter(_Model):
    """A parameter as it was used."""

    value: float | int | str
    unit: str


class GeneratedTruth(_Model):
    """The file `truth.json`: the objects of one run, and the room that they leave each other."""

    schema_version: Literal[1] = 1
    generator: str
    parameters: dict[str, TrueParameter]
    objects: tuple[TrueObject, ...]
    clearances: tuple[TrueClearance, ...] = ()
