"""An `impact` measurement as a `simgap.problem.Problem`: candidates, residuals, direct estimates, noise.

Events have no duration: short horizon and full roll-out are the same. Neighbouring events count as one trial, so that a
camera that was moved between sessions is not a thousand independent witnesses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np
from scipy.spatial import KDTree

from schemas.arrays import FloatArray, IntArray
from schemas.sim_gap.report import ConventionCheck, RolloutEngine
from sim.dynamics.body_rollout import BodyModel
from sim.effects.ranges import ImpactRanges
from simgap.kinds.impact.candidates import candidates_of, nuisances_of
from simgap.kinds.impact.direct_estimates import estimate
from simgap.kinds.impact.jacobian_signs import oriented
from simgap.kinds.impact.model import build_body, changed, predicted
from simgap.problem import Candidate, DirectEstimate, Model, Problem, View
from simgap.recording.read import Measurement
from simgap.recording.recording import Impacts
from simgap.recording.train_test_split import Trials

_MOST_TRIALS = 60
_NEIGHBOURS = 10


class ImpactProblem(Problem):
    """A rigid impact law against velocities after the impact; direct estimates from impulses."""

    horizon_s = 0.0

    def __init__(self, measurement: Measurement, events_split: Trials) -> None:
        if measurement.impacts is None:
            raise ValueError("the measurement holds no impacts")
        self.measurement = measurement
        self.declared: BodyModel = build_body(measurement.spec)
        self.events, self.convention_check = oriented(self.declared, measurement.impacts)
        size = -(-len(self.events) // _MOST_TRIALS)
        train, test = (_grouped(self.events, ids, size) for ids in (events_split.train, events_split.test))
        self.trials = Trials(tuple(train), tuple(test))
        self._groups = train | test
        self._floor = _noise(measurement, self.events)

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """Groups of neighbouring events, those that teach first."""
        return tuple(self._groups)

    @property
    def convention_checks(self) -> tuple[ConventionCheck, ...]:
        """The check of the Jacobians' signs."""
        return (self.convention_check,)

    def own_rollout(self) -> RolloutEngine:
        """See `simgap.problem.Problem`."""
        return RolloutEngine(name="Mana", method="law of rigid impacts in closed form, without steps")

    def channels(self) -> tuple[str, ...]:
        """Velocity of the tracked point and turning rate after the impact."""
        return ("velocity_x", "velocity_y", "rate")

    def channel_units(self) -> tuple[str, ...]:
        """See `simgap.problem.Problem`."""
        return ("m/s", "m/s", "rad/s")

    def as_events(self) -> ImpactProblem:
        """See `simgap.problem.Problem`."""
        return self

    def candidates(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`. Mass leaves no trace: only its ratio to the inertia acts in an impact."""
        has_pose = bool(np.isfinite(self.events.pose_before[:, 2]).all())
        return candidates_of(ImpactRanges(self.declared, has_pose))

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`."""
        return nuisances_of(self.declared)

    def residuals(self, model: Model, trials: Sequence[str], view: View) -> list[FloatArray]:
        """See `simgap.problem.Problem`; m/s and rad/s, a row per event."""
        body = changed(self.declared, model)
        groups = [self._groups[t] for t in trials]
        after = predicted(body, _joined(groups)) - np.concatenate([g.velocity_after for g in groups])
        return np.split(after, np.cumsum([len(g) for g in groups])[:-1])

    def readings(self, trials: Sequence[str]) -> list[FloatArray]:
        """Per trial (k, 3) velocities after the impact."""
        return [self._groups[t].velocity_after for t in trials]

    def features(self, trials: Sequence[str], view: View) -> list[FloatArray]:
        """Approach and slip before, turning rate before, both lever arms, and no time."""
        return [_features(self._groups[t]) for t in trials]

    def direct(self, candidate: Candidate, model: Model, trials: Sequence[str]) -> DirectEstimate | None:
        """See `simgap.problem.Problem`."""
        return estimate(candidate, changed(self.declared, model), [self._groups[t] for t in trials])

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """See `simgap.problem.Problem`: declared noise of both states, else what neighbours in state differ by."""
        return self._floor

    def slices(self, features: FloatArray) -> dict[str, FloatArray]:
        """(k,) masks by words: how the contact was met."""
        slip, rate, arm = features[:, 1], features[:, 2], features[:, 3]
        wide, fast = np.quantile(np.abs(arm), 2.0 / 3.0), np.quantile(np.abs(slip), 2.0 / 3.0)
        spin = np.quantile(np.abs(rate), 2.0 / 3.0)
        return {
            f"contact behind the mass centre (over {wide:.2g} m)": arm < -wide,
            f"contact ahead of the mass centre (over {wide:.2g} m)": arm > wide,
            f"contact under the mass centre (within {wide:.2g} m)": np.abs(arm) <= wide,
            f"fast slip before (over {fast:.2g} m/s)": np.abs(slip) > fast,
            f"slow slip before (under {fast:.2g} m/s)": np.abs(slip) <= fast,
            f"fast spin before (over {spin:.2g} rad/s)": np.abs(rate) > spin,
        }


def _grouped(events: Impacts, ids: Sequence[str], size: int) -> dict[str, Impacts]:
    """Neighbouring events in groups of about `size`, by name."""
    at = {i: k for k, i in enumerate(events.ids)}
    groups = np.array_split([at[i] for i in ids], max(1, -(-len(ids) // size)))
    return {f"events {events.ids[g[0]]} to {events.ids[g[-1]]}": _rows(events, g) for g in groups}


def _rows(events: Impacts, rows: IntArray) -> Impacts:
    arrays = {f.name: getattr(events, f.name)[rows] for f in fields(events) if f.name != "ids"}
    return replace(events, ids=tuple(events.ids[k] for k in rows), **arrays)


def _joined(groups: Sequence[Impacts]) -> Impacts:
    arrays = {f.name: np.concatenate([getattr(g, f.name) for g in groups]) for f in fields(Impacts) if f.name != "ids"}
    return Impacts(ids=tuple(i for g in groups for i in g.ids), **arrays)


def _features(events: Impacts) -> FloatArray:
    v = events.velocity_before
    approach, slip = (np.einsum("ni,ni->n", J, v) for J in (events.normal, events.tangent))
    nothing = np.zeros(len(events))
    return np.stack([approach, slip, v[:, 2], events.normal[:, 2], events.tangent[:, 2], nothing], axis=1)


def _noise(measurement: Measurement, events: Impacts) -> FloatArray:
    """(3,) noise of a predicted velocity: declared, else by the Gamma test.

    Events with equal states before must have equal states after; the squared difference of neighbours, extrapolated to
    distance zero, is twice the noise variance (Koncar, PhD thesis, Imperial College 1997).
    """
    v, w = measurement.noise.v_mps, measurement.noise.w_radps
    least = 1e-3 * np.sqrt((events.velocity_after**2).mean(axis=0)) + 1e-9
    declared = np.array([v or 0.0, v or 0.0, w or 0.0]) * np.sqrt(2.0)
    near = min(_NEIGHBOURS, len(events) - 1)
    if declared.all() or near < 3:
        return np.maximum(declared, least)
    state = _features(events)[:, :-1]
    scaled = (state - state.mean(axis=0)) / (state.std(axis=0) + 1e-12)
    distance, index = KDTree(scaled).query(scaled, k=near + 1)
    delta = np.median(distance[:, 1:] ** 2, axis=0)
    # Medians, because a few events are tracked wrongly; half of a squared normal difference is 0.4549 variances.
    apart = events.velocity_after[index[:, 1:]] - events.velocity_after[:, None]
    gamma = np.median(apart**2, axis=0) / (2.0 * 0.4549)
    basis = np.stack([np.ones_like(delta), delta], axis=1)
    intercept = np.linalg.lstsq(basis, gamma, rcond=None)[0][0]
    estimated = np.sqrt(np.clip(intercept, 0.01 * gamma[0], gamma[0]))
    return np.maximum(np.where(declared > 0.0, declared, estimated), least)
