"""Simulation of one tossed rigid body (`simgap.kinds.free_body.tossed_body.BodySimulator`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from geom.convex.support_function import heights
from schemas.arrays import FloatArray
from schemas.measurement import SensorNoise
from sim.dynamics.body_rollout import BodyModel, BodyRollout, BodyWindows
from sim.dynamics.hooks import Series
from simgap.kinds.free_body.apply_model import AppliedBody, apply_terms
from simgap.kinds.free_body.candidates import candidates_of, nuisances_of
from simgap.kinds.free_body.direct_estimates import Routes, routes_to
from simgap.kinds.free_body.engine_units import EngineUnits
from simgap.kinds.free_body.toss import Toss, corners
from simgap.kinds.free_body.tossed_body import Columns, DirectEstimator
from simgap.problem import Candidate, Model

_LARGEST = 1e4  # sizes of the body, beyond which a roll-out has diverged
_POSE_NOISE = 1e-3  # sizes of the body and rad, where a measurement has none


class RigidBodySimulator:
    """See `simgap.kinds.free_body.tossed_body.BodySimulator`."""

    state = ("p", "quat_wxyz", "v_W", "w_B")
    read = ("p", "quat_wxyz")
    channels = ("position_x", "position_y", "position_z", "rotation_x", "rotation_y", "rotation_z")
    channel_units = ("m", "m", "m", "rad", "rad", "rad")

    def __init__(self, declared: BodyModel, engine: BodyRollout) -> None:
        self.declared, self.engine = declared, engine
        self.has_support = declared.has_support
        self.size_m = float(np.ptp(corners(declared.shapes), axis=0).max())
        self.units = EngineUnits.of(declared, self.size_m)
        self.gravity_W, self.engine_time_s = declared.gravity_W, self.units.time_s
        self._in_units: tuple[BodyModel, BodyModel] | None = None  # the last body, and in the units of the engine

    def routes(self, candidate: Candidate) -> Routes:
        """See `BodySimulator`."""
        return routes_to(candidate)

    def apply(self, model: Model) -> AppliedBody:
        """See `BodySimulator`."""
        return apply_terms(self.declared, model)

    def rollout(self, applied: AppliedBody, t_s: FloatArray, start: Columns, finer: float) -> Columns:
        """See `BodySimulator`."""
        if self._in_units is None or self._in_units[0] is not applied.body:
            self._in_units = applied.body, self.units.model(applied.body)
        windows, wrenches = self.units.windows(BodyWindows(t_s=t_s, **start)), self.units.wrenches(applied.wrenches)
        motion = self.units.motion(self.engine.rollout(self._in_units[1], windows, wrenches, finer))
        return {name: getattr(motion, name) for name in self.state}

    def errors(self, simulated: Columns, measured: Columns) -> FloatArray:
        """See `BodySimulator`; m and rad."""
        return pose_errors(simulated, measured, self.size_m)

    def gaps(self, series: Series) -> FloatArray:
        """See `BodySimulator`."""
        body = self.declared
        origins, R = level_poses(body, series)
        return heights(body.shapes, origins, R)

    def toss(self, applied: AppliedBody, series: Series) -> Toss:
        """See `BodySimulator`."""
        return Toss(applied, series)

    def candidates(self, series: Sequence[Series], estimate_directly: DirectEstimator) -> tuple[Candidate, ...]:
        """See `BodySimulator`."""
        return candidates_of(self.declared, series, estimate_directly)

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `BodySimulator`."""
        return nuisances_of(self.declared)

    def reading_noise(self, noise: SensorNoise, slope_noise_per_s: float, horizon_s: float) -> FloatArray:
        """See `BodySimulator`: readings twice, and the start's velocity carried along."""
        return pose_noise(noise, slope_noise_per_s, horizon_s, self.size_m)


def level_poses(body: BodyModel, series: Series) -> tuple[FloatArray, FloatArray]:
    """Positions (n, 3) and rotations (n, 3, 3) in the axes of the support, its surface at 0."""
    R = Rotation.from_quat(np.roll(series.columns["quat_wxyz"], -1, axis=1)).as_matrix()
    level = Rotation.align_vectors([[0.0, 0.0, 1.0]], [body.plane_normal_W])[0].as_matrix()
    return series.columns["p"] @ level.T - np.array([0.0, 0.0, body.plane_height_m]), level @ R


def pose_errors(simulated: Columns, measured: Columns, size_m: float) -> FloatArray:
    """(w * k, 6) simulated minus measured, of a body so large; rotation as a vector in world axes."""
    largest_m = _LARGEST * size_m
    position = np.clip(simulated["p"] - measured["p"], -largest_m, largest_m).reshape(-1, 3)
    turned, truth = (
        Rotation.from_quat(np.roll(columns["quat_wxyz"].reshape(-1, 4), -1, axis=1))
        for columns in (simulated, measured)
    )
    return np.concatenate([position, (turned * truth.inv()).as_rotvec()], axis=1)


def pose_noise(noise: SensorNoise, slope_noise_per_s: float, horizon_s: float, size_m: float) -> FloatArray:
    """(6,) mean square errors of position and rotation after `horizon_s`, of a body so large.

    Rates that were not measured have `slope_noise_per_s` times the noise of poses.
    """
    p, turn = noise.p_m or _POSE_NOISE * size_m, noise.rotation_rad or _POSE_NOISE
    v = noise.v_mps or p * slope_noise_per_s
    w = noise.w_radps or turn * slope_noise_per_s
    position = 2.0 * p**2 + (v * horizon_s) ** 2 / 3.0
    rotation = 2.0 * turn**2 + (w * horizon_s) ** 2 / 3.0
    return np.array([position] * 3 + [rotation] * 3)
