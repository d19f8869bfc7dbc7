"""Physics of an asset for simulators: convex collision shapes, mass properties, contact material (SI, asset frame)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pydantic import BaseModel, ConfigDict

from schemas.arrays import FloatArray, IntArray

ShapeKind = Literal["box", "sphere", "capsule", "cylinder", "hull"]


@dataclass(frozen=True)
class CollisionShape:
    """One convex collision shape, posed in the asset frame (metres).

    size_m   box: full edge lengths (x, y, z); sphere: (radius,); capsule and cylinder: (radius, height) along local
             z, a capsule's height without its caps; hull: ().
    X_AS     (4, 4) pose of the shape in the asset frame; identity for hulls.
    points, triangles  hulls only: (n, 3) float64 and (m, 3) int32, closed, outward, n <= 64.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    kind: ShapeKind
    size_m: tuple[float, ...]
    X_AS: FloatArray
    points: FloatArray | None = None
    triangles: IntArray | None = None


@dataclass(frozen=True)
class MassProperties:
    """Mass, mass centre and inertia about the mass centre, axes of the asset frame.

    `inertia_kgm2` is (3, 3) symmetric positive definite and fulfils the triangle inequality of its eigenvalues.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    mass_kg: float
    centre_of_mass_m: FloatArray
    inertia_kgm2: FloatArray


@dataclass(frozen=True)
class VolumeProperties:
    """Volume, centre and second moment of a region of space without density, in axes of the asset frame.

    `second_moment_m5` (3, 3) is the integral of |r|^2 1 - r r^T over the region, r from its centre: its inertia per
    density.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    volume_m3: float
    centre_m: FloatArray
    second_moment_m5: FloatArray

    def filled(self, density_kgm3: float) -> MassProperties:
        """The mass properties of the region filled evenly."""
        return MassProperties(self.volume_m3 * density_kgm3, self.centre_m, self.second_moment_m5 * density_kgm3)

    def share(self, share: float) -> VolumeProperties:
        """`share` of the region, taken evenly from everywhere in it."""
        return VolumeProperties(self.volume_m3 * share, self.centre_m, self.second_moment_m5 * share)


class Contact(BaseModel):
    """Contact parameters of one body against a class of counterparts (`any` = all others)."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    counterpart: str = "any"
    static_friction: float
    dynamic_friction: float
    restitution: float
    combine: Literal["average", "multiply", "minimum", "maximum"] = "average"


@dataclass(frozen=True)
class SurfaceMaterial:
    """What something is made of where it touches: class in the material table, density, contact against any other."""

    label: str
    density_kgm3: float
    contact: Contact


class Fidelity(BaseModel):
    """How well a set of collision shapes represents the solid; distances are fractions of the box diagonal.

    `outside_p95` measures collider surface -> solid, `missing_p95` solid surface -> collider union.
    `volume_ratio` is union of shapes / solid, None where the solid has no volume of its own. `settings` names library,
    version, parameters and seed of a decomposition. `cavity_open`: a ball goes into every opening, and by a second way
    out where there is one; `cavity_kept`: and it stays in as it does in the solid. None without an opening.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    method: str
    shapes: int
    vertices: int
    volume_ratio: float | None
    outside_p95: float
    outside_max: float
    missing_p95: float
    missing_max: float
    cavity_kept: bool | None
    accepted: bool
    cavity_open: bool | None = None
    reason: str = ""
    settings: str = ""


@dataclass(frozen=True)
class Solid:
    """The physical surface of an asset (metres, asset frame), on which mass and collision are based.

    kind  `closed`: watertight, outward, overlaps united, inner cavities kept as inward shells.
          `shell`: an open sheet with a significant opening; `wall_thickness_m` is the assumed thickness.
          `hull`: neither; the convex hull replaces it, with low confidence.
    walls `closed` only: volume of the walls of `wall_thickness_m` that were grown from sheets beside the closed
          bodies, without what these contain already. None without any.
    core  volume inside inner shells that are wound like the surface around them: taken as filled, but they may be
          cavities whose winding was lost. None without any.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    points: FloatArray  # (n, 3) float64
    triangles: IntArray  # (m, 3) int32
    kind: Literal["closed", "shell", "hull"]
    wall_thickness_m: float | None = None
    core: VolumeProperties | None = None
    walls: VolumeProperties | None = None


@dataclass(frozen=True)
class RigidBody:
    """One rigid body as a simulator takes it; everything in the asset frame, metres and kilograms."""

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    name: str
    shapes: tuple[CollisionShape, ...]
    mass: MassProperties
    contact: Contact
