"""Units in which an engine rolls out a body: its size, weight and mass are the same whatever the body's are.

Engines have thresholds and tolerances in SI (margins of contacts, speeds below which nothing bounces). In units of the
body's own size, of its fall over that size and of its mass, a roll-out is the same for all bodies of one shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geom.convex.scaling import scaled
from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from sim.dynamics.body_rollout import BodyModel, BodyMotion, BodyWindows
from sim.dynamics.hooks import BodyState, BodyWrench, Params

_ENGINE_SIZE_M = 0.1  # greatest extent in the engine: what its tolerances are made for


@dataclass(frozen=True)
class EngineUnits:
    """One unit of the engine in SI: length_m, time_s, mass_kg."""

    length_m: float
    time_s: float
    mass_kg: float

    @staticmethod
    def of(body: BodyModel, size_m: float) -> EngineUnits:
        """Units in which the greatest extent and gravity are usual ones; time as it is where nothing falls."""
        length_m, gravity_mps2 = size_m / _ENGINE_SIZE_M, float(np.linalg.norm(body.gravity_W))
        time_s = float(np.sqrt(length_m * GRAVITY_MPS2 / gravity_mps2)) if gravity_mps2 > 0.0 else 1.0
        return EngineUnits(length_m, time_s, body.mass_kg)

    @property
    def force_N(self) -> float:
        """One unit of force."""
        return self.mass_kg * self.length_m / self.time_s**2

    def model(self, body: BodyModel) -> BodyModel:
        """The body in these units."""
        stiffness_Npm, damping_Nspm = self.force_N / self.length_m, self.force_N * self.time_s / self.length_m
        return replace(
            body,
            shapes=tuple(scaled(shape, 1.0 / self.length_m) for shape in body.shapes),
            mass_kg=body.mass_kg / self.mass_kg,
            com_B=body.com_B / self.length_m,
            inertia_B=body.inertia_B / (self.mass_kg * self.length_m**2),
            rolling_friction_m=body.rolling_friction_m / self.length_m,
            spinning_friction_m=body.spinning_friction_m / self.length_m,
            stiffness_Npm=None if body.stiffness_Npm is None else body.stiffness_Npm / stiffness_Npm,
            damping_Nspm=None if body.damping_Nspm is None else body.damping_Nspm / damping_Nspm,
            gravity_W=body.gravity_W * self.time_s**2 / self.length_m,
            plane_height_m=body.plane_height_m / self.length_m,
        )

    def windows(self, windows: BodyWindows) -> BodyWindows:
        """Stamps and starts in these units."""
        return BodyWindows(
            t_s=windows.t_s / self.time_s,
            p=windows.p / self.length_m,
            quat_wxyz=windows.quat_wxyz,
            v_W=windows.v_W * self.time_s / self.length_m,
            w_B=windows.w_B * self.time_s,
        )

    def motion(self, motion: BodyMotion) -> BodyMotion:
        """What the engine returns, in SI."""
        return BodyMotion(
            p=motion.p * self.length_m,
            quat_wxyz=motion.quat_wxyz,
            v_W=motion.v_W * self.length_m / self.time_s,
            w_B=motion.w_B / self.time_s,
        )

    def wrenches(self, wrenches: Sequence[tuple[BodyWrench, Params]]) -> tuple[tuple[BodyWrench, Params], ...]:
        """Laws of forces that read and give these units."""
        return tuple((BodyWrench(self._law(hook)), params) for hook, params in wrenches)

    def _law(self, hook: BodyWrench):
        def wrench(state: BodyState, params: Params) -> tuple[FloatArray, FloatArray]:
            force, torque = hook.wrench(
                BodyState(
                    state.t_s * self.time_s,
                    state.p * self.length_m,
                    state.quat_wxyz,
                    state.v * self.length_m / self.time_s,
                    state.w_W / self.time_s,
                ),
                params,
            )
            return force / self.force_N, torque / (self.force_N * self.length_m)

        return wrench
