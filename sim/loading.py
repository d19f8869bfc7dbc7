"""Data of a trial in which loose probes are put on, into or against a body: the task, and the motion that follows.

SI units; frames: W world (z up, ground z = 0), A the body, P a probe. The trial itself is `sim.port.Simulator.load`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape

LOAD_FRICTION = 0.5  # of ground and probes, as of the worlds of `sim.port`
Velocity = tuple[float, float, float]


@dataclass(frozen=True)
class LooseProbe:
    """A box or ball, posed in the world, with its mass and how fast it moves at first."""

    shape: CollisionShape
    mass_kg: float
    velocity_mps: Velocity = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class LoadTask:
    """A body at rest in pose X_WA (4, 4), and probes that are released together.

    `is_fixed`: the body does not move, there is no ground, and probes touch the body alone, so that each is a trial of
    its own. Else the body stands loose on the ground, and probes also touch the ground and one another.
    Gravity may be tilted: level ground is then a slope. `step_s` is that of the engine.
    """

    X_WA: FloatArray
    probes: tuple[LooseProbe, ...]
    duration_s: float
    is_fixed: bool = False
    gravity_mps2: Velocity = (0.0, 0.0, -GRAVITY_MPS2)
    step_s: float = 1.0 / 240.0


@dataclass(frozen=True)
class LoadOutcome:
    """Poses over time: times_s (k,), the body X_WA (k, 4, 4), the probes X_WP (k, n, 4, 4); row 0 as released.

    Rows after the motion diverged are left out, and `finite` is False then.
    """

    times_s: FloatArray
    X_WA: FloatArray
    X_WP: FloatArray
    finite: bool = True

    def turn_rad(self) -> float:
        """By how much the upward direction of the body turned from its start to the end."""
        first, last = self.X_WA[0, :3, 2], self.X_WA[-1, :3, 2]
        return float(np.arctan2(np.linalg.norm(np.cross(first, last)), first @ last))

    def probes_in_body(self) -> FloatArray:
        """X_AP (k, n, 4, 4)."""
        return np.linalg.inv(self.X_WA)[:, None] @ self.X_WP
