"""Roll-outs of a free body in PyBullet (`BodyRollout`); `sim.bullet.simulator` lists the engine's traps.

The support is a plane along the given normal. Between windows the body is parked far away for one step, which empties
the contact caches, so that no window depends on the one before.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pybullet

from schemas.arrays import FloatArray
from schemas.physics import MassProperties
from sim.bullet.shapes import PARKED_M
from sim.bullet.windows import (
    HOLD_S,
    WindowsClient,
    contact_parameters,
    empty_world,
    hold_last_valid,
    measured_motion,
    start_states,
    steps_for,
)
from sim.bullet.world import dynamic_body
from sim.dynamics.body_rollout import BodyModel, BodyMotion, BodyWindows
from sim.dynamics.hooks import BodyState, BodyWrench, Params


class BulletBodyRollout(WindowsClient):
    """One private DIRECT client; close it, or use it as a context manager."""

    _loaded: tuple[BodyModel, float] | None = None

    def rollout(
        self,
        model: BodyModel,
        windows: BodyWindows,
        wrenches: Sequence[tuple[BodyWrench, Params]] = (),
        finer: float = 1.0,
    ) -> BodyMotion:
        """See `sim.dynamics.body_rollout.BodyRollout`."""
        if self._loaded is None or model is not self._loaded[0] or finer != self._loaded[1]:
            self._largest_step_s = self._usual_step_s / finer
            self._load(model)
            self._loaded = model, finer
        worlds, stamps = windows.t_s.shape
        starts = start_states(windows, self._X_BI)
        spans = windows.t_s[:, 1:2] - windows.t_s[:, :1]
        # The engine moves a body by its speed at the end of a step; from half a step earlier its fall is exact.
        half_step = 0.5 * model.gravity_W * (spans / steps_for(spans, self._largest_step_s))
        starts[:, 7:10] -= half_step
        out = np.empty((worlds, stamps, 13))
        for w in range(worlds):
            self._start(starts[w])
            out[w, 0] = self._row()
            for k in range(1, stamps):
                span = float(windows.t_s[w, k] - windows.t_s[w, k - 1])
                self._advance(model, span, float(windows.t_s[w, k - 1]), wrenches)
                out[w, k] = self._row()
        out[:, :, 7:10] += half_step[:, None]
        return measured_motion(hold_last_valid(out), self._X_BI)

    def _load(self, model: BodyModel) -> None:
        """Build an empty world with the body and the support, with the model's parameters."""
        client = self._client
        empty_world(model, self._largest_step_s, client)
        mass = MassProperties(model.mass_kg, model.com_B, model.inertia_B)
        dynamic = dynamic_body(model.shapes, mass, 1.0, client)
        self._handle, self._X_BI = dynamic.handle, dynamic.X_AI
        pybullet.changeDynamics(self._handle, -1, **contact_parameters(model), physicsClientId=client)

    def _start(self, row: FloatArray) -> None:
        """Park for one step, then place the body and set its velocity."""
        at, quat_xyzw, v_W, w_W = row[:3].tolist(), row[3:7].tolist(), row[7:10].tolist(), row[10:].tolist()
        self._place([0.0, 0.0, PARKED_M], quat_xyzw, [0.0] * 3, [0.0] * 3)
        pybullet.setTimeStep(self._largest_step_s, physicsClientId=self._client)
        pybullet.stepSimulation(physicsClientId=self._client)
        self._place(at, quat_xyzw, v_W, w_W)

    def _place(self, at: list[float], quat_xyzw: list[float], v_W: list[float], w_W: list[float]) -> None:
        pybullet.resetBasePositionAndOrientation(self._handle, at, quat_xyzw, physicsClientId=self._client)
        pybullet.resetBaseVelocity(self._handle, v_W, w_W, physicsClientId=self._client)

    def _advance(
        self, model: BodyModel, span_s: float, t_s: float, wrenches: Sequence[tuple[BodyWrench, Params]]
    ) -> None:
        """Equal steps over `span_s`, with wrenches that are held for a few of them."""
        steps = int(steps_for(span_s, self._largest_step_s))
        if span_s <= 0.0:
            return
        pybullet.setTimeStep(span_s / steps, physicsClientId=self._client)
        held = max(1, int(HOLD_S * steps / span_s))
        torque: list[float] | None = None
        for s in range(steps):
            if wrenches and s % held == 0:
                torque = self._pull(model, t_s + s * span_s / steps, wrenches)
            if torque is not None:
                pybullet.applyExternalTorque(self._handle, -1, torque, pybullet.WORLD_FRAME, self._client)
            pybullet.stepSimulation(physicsClientId=self._client)
        if wrenches:
            pybullet.setGravity(*model.gravity_W.tolist(), physicsClientId=self._client)

    def _pull(self, model: BodyModel, t_s: float, wrenches: Sequence[tuple[BodyWrench, Params]]) -> list[float] | None:
        """Apply the summed forces as gravity, since they act on the mass centre; returns the summed torques, if any."""
        at, (x, y, z, w) = pybullet.getBasePositionAndOrientation(self._handle, physicsClientId=self._client)
        v_W, w_W = pybullet.getBaseVelocity(self._handle, physicsClientId=self._client)
        state = BodyState(*(np.array([row]) for row in ((t_s,), at, (w, x, y, z), v_W, w_W)))
        pull, torque = model.gravity_W, np.zeros(3)
        for hook, params in wrenches:
            forces, torques = hook.wrench(state, params)
            pull, torque = pull + forces[0] / model.mass_kg, torque + torques[0]
        pybullet.setGravity(*pull.tolist(), physicsClientId=self._client)
        return torque.tolist() if torque.any() else None

    def _row(self) -> FloatArray:
        """(13,) mass centre, quaternion xyzw of the inertial frame, its velocity, turning rate; world axes."""
        at = pybullet.getBasePositionAndOrientation(self._handle, physicsClientId=self._client)
        speed = pybullet.getBaseVelocity(self._handle, physicsClientId=self._client)
        return np.array([*at[0], *at[1], *speed[0], *speed[1]])
