"""Measured physics of one rigid body and of joints (SI units), as values that an asset package holds."""

from __future__ import annotations

from dataclasses import dataclass, field

from schemas.asset import Matrix3, Vec3
from schemas.evidence import Evidence


@dataclass(frozen=True)
class MeasuredPhysics:
    """Values with method and 95 % interval (`bounds`), asset frame, SI units; None where the measurement is silent.

    friction, restitution   of the pair body-support.
    urdf_contact            further children of PyBullet's `<contact>`, which USD has no attribute for.
    extension_json          the extension as it was given; it travels with the package.
    """

    extension_json: bytes
    mass_kg: Evidence[float] | None = None
    centre_of_mass_m: Evidence[Vec3] | None = None
    inertia_kgm2: Evidence[Matrix3] | None = None
    friction: Evidence[float] | None = None
    restitution: Evidence[float] | None = None
    urdf_contact: dict[str, float] = field(default_factory=dict[str, float])


@dataclass(frozen=True)
class MeasuredJoint:
    """Measured values of one joint (N m, N m s/rad, rad; N, N s/m, m when it slides); None where not measured."""

    friction: float | None = None
    damping: float | None = None
    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
