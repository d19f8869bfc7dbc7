"""Simulation of one tossed linkage (`simgap.kinds.free_body.tossed_body.BodySimulator`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geom.convex.support_function import heights
from schemas.arrays import FloatArray
from schemas.measurement import SensorNoise
from sim.dynamics.body_rollout import BodyWindows
from sim.dynamics.hooks import Series
from sim.dynamics.linkage_rollout import LinkageModel, LinkageRollout, LinkageWindows, link_body, link_poses
from simgap.kinds.free_body.apply_model import AppliedBody
from simgap.kinds.free_body.candidates import nuisances_of
from simgap.kinds.free_body.direct_estimates import Routes
from simgap.kinds.free_body.rigid import RigidBodySimulator, level_poses, pose_errors, pose_noise
from simgap.kinds.free_body.toss import Toss
from simgap.kinds.free_body.tossed_body import Columns, DirectEstimator
from simgap.kinds.linkage.apply_model import AppliedLinkage, apply_terms
from simgap.kinds.linkage.candidates import candidates_of, size_m_of
from simgap.kinds.linkage.direct_estimates import routes_to
from simgap.kinds.linkage.toss import LinkageToss
from simgap.problem import Candidate, Model

_NOISE_RAD, _LARGEST_JOINT_ERROR = 1e-3, 1e3


class LinkageSimulator:
    """See `simgap.kinds.free_body.tossed_body.BodySimulator`."""

    state = (*RigidBodySimulator.state, "q", "qd")
    read = (*RigidBodySimulator.read, "q")
    engine_time_s = 1.0

    def __init__(self, declared: LinkageModel, engine: LinkageRollout) -> None:
        self.declared, self.engine = declared, engine
        self.has_support, self.gravity_W = declared.base.has_support, declared.base.gravity_W
        tree = declared.joints.tree
        self.channels = (*RigidBodySimulator.channels, *(f"q_{link.name}" for link in tree))
        self.channel_units = (*RigidBodySimulator.channel_units, *("m" if link.prismatic else "rad" for link in tree))
        self.size_m = size_m_of(declared)

    def routes(self, candidate: Candidate) -> Routes:
        """See `BodySimulator`."""
        return routes_to(candidate)

    def apply(self, model: Model) -> AppliedLinkage:
        """See `BodySimulator`."""
        return apply_terms(self.declared, model)

    def rollout(self, applied: AppliedBody, t_s: FloatArray, start: Columns, finer: float) -> Columns:
        """See `BodySimulator`."""
        assert isinstance(applied, AppliedLinkage)
        base = BodyWindows(t_s=t_s, **{name: start[name] for name in RigidBodySimulator.state})
        windows = LinkageWindows(base, start["q"], start["qd"])
        motion = self.engine.rollout(applied.linkage, windows, applied.wrenches, applied.laws, finer)
        return {n: getattr(motion.base, n) for n in RigidBodySimulator.state} | {"q": motion.q, "qd": motion.qd}

    def errors(self, simulated: Columns, measured: Columns) -> FloatArray:
        """See `BodySimulator`; joints by the shorter way round."""
        turning = np.array([not link.prismatic for link in self.declared.joints.tree])
        apart = np.clip(
            (simulated["q"] - measured["q"]).reshape(-1, len(turning)), -_LARGEST_JOINT_ERROR, _LARGEST_JOINT_ERROR
        )
        apart[:, turning] = (apart[:, turning] + np.pi) % (2.0 * np.pi) - np.pi
        return np.concatenate([pose_errors(simulated, measured, self.size_m), apart], axis=1)

    def gaps(self, series: Series) -> FloatArray:
        """See `BodySimulator`."""
        origins, R = level_poses(self.declared.base, series)
        lowest = []
        for name, (R_BL, p_BL) in zip(self.declared.names, link_poses(self.declared, series.columns["q"]), strict=True):
            shapes = link_body(self.declared, name).shapes
            if shapes:
                lowest.append(heights(shapes, origins + np.einsum("nab,nb->na", R, p_BL), R @ R_BL))
        return np.min(lowest, axis=0)

    def toss(self, applied: AppliedBody, series: Series) -> Toss:
        """See `BodySimulator`."""
        assert isinstance(applied, AppliedLinkage)
        return LinkageToss(applied, series)

    def candidates(self, series: Sequence[Series], estimate_directly: DirectEstimator) -> tuple[Candidate, ...]:
        """See `BodySimulator`."""
        return candidates_of(self.declared, series, estimate_directly)

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `BodySimulator`."""
        return nuisances_of(self.declared.base)

    def reading_noise(self, noise: SensorNoise, slope_noise_per_s: float, horizon_s: float) -> FloatArray:
        """See `BodySimulator`."""
        q = noise.q or _NOISE_RAD
        qd = noise.qd or q * slope_noise_per_s
        joint = 2.0 * q**2 + (qd * horizon_s) ** 2 / 3.0
        return np.concatenate(
            [pose_noise(noise, slope_noise_per_s, horizon_s, self.size_m), np.full(len(self.channels) - 6, joint)]
        )
