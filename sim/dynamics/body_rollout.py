"""Protocol and data of free-body roll-outs from measured states (SI units). Implementation: `sim.bullet.body`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape
from sim.dynamics.hooks import BodyWrench, Params


@dataclass(frozen=True)
class BodyModel:
    """Parameters of a rigid body over a half space; B is the measured body frame, SI units.

    shapes               convex shapes, posed in B.
    com_B, inertia_B     mass centre (3,) in B; inertia (3, 3) about it, axes of B.
    friction, restitution   of the pair body-support.
    rolling_friction_m, spinning_friction_m   lever arms of the moments that oppose rolling and spinning.
    friction_ratio_B     (3,) friction along each axis of B over `friction`.
    stiffness_Npm, damping_Nspm   of the contact; None: as stiff as the engine allows.
    plane_normal_W (3,), plane_height_m   the support: the plane `normal . x = height`.
    """

    shapes: tuple[CollisionShape, ...]
    mass_kg: float
    com_B: FloatArray
    inertia_B: FloatArray
    friction: float = 0.5
    restitution: float = 0.0
    rolling_friction_m: float = 0.0
    spinning_friction_m: float = 0.0
    friction_ratio_B: FloatArray = field(default_factory=lambda: np.ones(3))
    stiffness_Npm: float | None = None
    damping_Nspm: float | None = None
    gravity_W: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, -GRAVITY_MPS2]))
    plane_normal_W: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    plane_height_m: float = 0.0
    has_support: bool = True


@dataclass(frozen=True)
class BodyWindows:
    """Where roll-outs start: stamps t_s (w, k); p, v_W (w, 3) of the origin of B; quat_wxyz (w, 4); w_B (w, 3)."""

    t_s: FloatArray
    p: FloatArray
    quat_wxyz: FloatArray
    v_W: FloatArray
    w_B: FloatArray


@dataclass(frozen=True)
class BodyMotion:
    """Simulated motion at the stamps: p (w, k, 3), quat_wxyz (w, k, 4), v_W and w_B (w, k, 3); row 0 is the start."""

    p: FloatArray
    quat_wxyz: FloatArray
    v_W: FloatArray
    w_B: FloatArray


class BodyRollout(Protocol):
    """Simulates windows one by one; equal calls give equal results, whatever was simulated before."""

    def rollout(
        self,
        model: BodyModel,
        windows: BodyWindows,
        wrenches: Sequence[tuple[BodyWrench, Params]] = (),
        finer: float = 1.0,
    ) -> BodyMotion:
        """The motion from each start, with steps divided by `finer`. A window that diverges keeps its last state."""
        ...

    def close(self) -> None:
        """Free the engine's world; the object cannot be used afterwards."""
        ...
