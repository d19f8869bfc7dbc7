"""A `push` measurement as a `simgap.problem.Problem`: candidates, residuals, direct estimates, noise.

Poses are known before and after only: short horizon and full roll-out are the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.report import ConventionCheck, RolloutEngine
from sim.dynamics.body_rollout import BodyModel
from simgap.kinds.push.candidates import candidates_of, nuisances_of, ranges_of
from simgap.kinds.push.direct_estimates import estimate
from simgap.kinds.push.footprint import even_points, outlines, vertices_of
from simgap.kinds.push.model import PushModel, changed
from simgap.kinds.push.records import PATH_STEPS, STEADY_FROM_SHARE, Records, end_distance, record, upright
from simgap.kinds.push.sliding import plane_rotations, simulate_pushes
from simgap.problem import Candidate, DirectEstimate, Model, Problem, View
from simgap.recording.read import Measurement
from simgap.recording.reading.contact import with_declared_contact

_LEAST_M, _LEAST_N = 1e-5, 1e-3
_WORKS = 0.8  # least share of pushes whose force must do work
_LEVEL = 0.02  # largest slope of the support, rad
_TILTED = 0.2  # largest tilt of the tracked axes, rad


class PushProblem(Problem):
    """Quasi-static pushing against the pose after and the steady force; direct estimates from forces and moves."""

    horizon_s = 0.0

    def __init__(self, measurement: Measurement) -> None:
        self.measurement = measurement
        self._records = {p.id: record([p]) for p in measurement.pushes}
        whole = record(measurement.pushes)
        self.declared = _declared(measurement, whole)
        self._has_force = bool(np.isfinite(whole.force).any())
        self._floor = self._noise(whole)

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """All pushes, in file order."""
        return tuple(self._records)

    @property
    def convention_checks(self) -> tuple[ConventionCheck, ...]:
        """The check of the forces' sign."""
        return (self._force_check(),)

    def own_rollout(self) -> RolloutEngine:
        """See `simgap.problem.Problem`; no speed enters, so there is no step of time."""
        return RolloutEngine(name="Mana", method="quasi-static pushing on an ellipsoidal limit surface, row by row")

    def channels(self) -> tuple[str, ...]:
        """Move and turn by the push and mean steady force, axes of the body before the push."""
        pose = ("position_x", "position_y", "rotation")
        return (*pose, "force_x", "force_y") if self._has_force else pose

    def channel_units(self) -> tuple[str, ...]:
        """See `simgap.problem.Problem`."""
        return ("m", "m", "rad", "N", "N")[: len(self.channels())]

    def as_events(self) -> PushProblem:
        """See `simgap.problem.Problem`."""
        return self

    def candidates(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`. Without forces the resistance of the support is unknown."""
        return candidates_of(ranges_of(self.declared, self._has_force))

    def nuisances(self) -> tuple[Candidate, ...]:
        """See `simgap.problem.Problem`: the assumed pressure, and the pusher's friction, which is declared nowhere."""
        return nuisances_of(ranges_of(self.declared, self._has_force))

    def residuals(self, model: Model, trials: Sequence[str], view: View) -> list[FloatArray]:
        """See `simgap.problem.Problem`; m, rad and N, one row per push."""
        records = self._joined(trials)
        poses, forces = simulate_pushes(changed(self.declared, model), records.before, records.tips)
        steady = forces[:, round(STEADY_FROM_SHARE * PATH_STEPS) :].mean(axis=1)
        turned = poses[:, -1, 2] - records.before[:, 2]
        simulated = self._in_channels(records, poses[:, -1, :2], turned, steady)
        return list(
            (simulated - self._in_channels(records, records.after[:, :2], records.turned, records.force))[:, None, :]
        )

    def readings(self, trials: Sequence[str]) -> list[FloatArray]:
        """Per trial (1, c) what was measured: move, turn, steady force."""
        records = self._joined(trials)
        return list(self._in_channels(records, records.after[:, :2], records.turned, records.force)[:, None, :])

    def _in_channels(self, records: Records, p: FloatArray, turned: FloatArray, force: FloatArray) -> FloatArray:
        """(n, c) channels, in axes of the body before the push."""
        turn = plane_rotations(records.before[:, 2])
        columns = [np.einsum("nji,nj->ni", turn, p - records.before[:, :2]), turned[:, None]]
        columns += [np.einsum("nji,nj->ni", turn, force)] if self._has_force else []
        return np.concatenate(columns, axis=1)

    def features(self, trials: Sequence[str], view: View) -> list[FloatArray]:
        """Tip at the start and its move in body axes, and no time."""
        records = self._joined(trials)
        turn = plane_rotations(records.before[:, 2])
        start = np.einsum("nji,nj->ni", turn, records.tips[:, 0] - records.before[:, :2])
        move = np.einsum("nji,nj->ni", turn, records.tips[:, -1] - records.tips[:, 0])
        return list(np.concatenate([start, move, np.zeros((len(start), 1))], axis=1)[:, None, :])

    def direct(self, candidate: Candidate, model: Model, trials: Sequence[str]) -> DirectEstimate | None:
        """See `simgap.problem.Problem`."""
        if not self._has_force:
            return None
        return estimate(candidate, changed(self.declared, model), [self._records[t] for t in trials])

    def noise_floor(self, trials: Sequence[str], view: View) -> FloatArray:
        """See `simgap.problem.Problem`: pose noise before and after, ripple of the force."""
        return self._floor

    def slices(self, features: FloatArray) -> dict[str, FloatArray]:
        """(k,) masks by words: where and which way the body was pushed."""
        place = features[:, :2] - self.declared.body.com_B[:2]
        way = features[:, 2:4] / np.maximum(np.linalg.norm(features[:, 2:4], axis=1), 1e-12)[:, None]
        arm = place[:, 0] * way[:, 1] - place[:, 1] * way[:, 0]
        wide = 0.5 * self.declared.lever_m
        return {
            "pushed along the body's x axis": np.abs(way[:, 0]) > np.abs(way[:, 1]),
            "pushed along the body's y axis": np.abs(way[:, 0]) <= np.abs(way[:, 1]),
            f"pushed through the mass centre (within {wide:.2g} m)": np.abs(arm) <= wide,
            f"pushed to turn left (over {wide:.2g} m)": arm > wide,
            f"pushed to turn right (over {wide:.2g} m)": arm < -wide,
        }

    def _force_check(self) -> ConventionCheck:
        """A force on the body that drives it does work along the tip's path; one taken on the tip does the reverse."""
        whole = self._joined(self.trial_ids)
        work = (whole.force * (whole.tips[:, -1] - whole.tips[:, 0])).sum(axis=1)
        seen = np.isfinite(work)
        if not seen.any():
            return ConventionCheck(name="force_sign", status="ok", evidence="no forces were measured")
        share = float((work[seen] > 0.0).mean())
        text = f"in {share:.0%} of the pushes the force on the body does work along the tip's path"
        return ConventionCheck(name="force_sign", status="ok" if share > _WORKS else "suspect", evidence=text)

    def _joined(self, trials: Sequence[str]) -> Records:
        parts = [self._records[t] for t in trials]
        return Records(**{f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Records)})

    def _noise(self, whole: Records) -> FloatArray:
        """(c,) declared pose noise, else from the tip's distance at the end, which geometry fixes."""
        declared_noise = self.measurement.noise
        apart = end_distance(self.declared.outline, whole)
        spread_m = 1.4826 * float(np.median(np.abs(apart - np.median(apart))))
        p = np.sqrt(2.0) * (declared_noise.p_m or max(spread_m, _LEAST_M))
        turn = np.sqrt(2.0) * declared_noise.rotation_rad if declared_noise.rotation_rad else p / self.declared.lever_m
        floor = [p, p, turn]
        if self._has_force:
            ripple = max(float(np.nanmedian(whole.ripple_N)), _LEAST_N)
            floor += [ripple, ripple]
        return np.array(floor)


def _declared(measurement: Measurement, whole: Records) -> PushModel:
    """The declared model. Raises ValueError for a slope and for bodies tilted or without mass or shape."""
    spec = measurement.spec
    subject, gravity = spec.subject, np.array(spec.world.gravity_mps2)
    normal = np.array(spec.world.support.plane.normal if spec.world.support else (0.0, 0.0, 1.0), dtype=float)
    size = np.linalg.norm(gravity)
    if subject.mass_kg is None:
        raise ValueError("the subject declares no mass_kg")
    if size == 0.0 or -gravity[2] < size * np.cos(_LEVEL) or normal[2] < np.linalg.norm(normal) * np.cos(_LEVEL):
        raise ValueError("pushes are explained on a level support, with gravity along -z")
    if min(upright(p.before_quat_wxyz) for p in measurement.pushes) < np.cos(_TILTED):
        raise ValueError("a pushed body must be given with its z axis up")
    outline, foot = outlines(vertices_of(subject, measurement.root))
    body = BodyModel(
        shapes=(),
        mass_kg=subject.mass_kg,
        com_B=np.array(subject.com_m),
        inertia_B=np.eye(3),  # no acceleration, no inertia
        friction=subject.contact.friction,
        gravity_W=gravity,
    )
    standoff = max(float(np.median(end_distance(outline, whole))), 0.0)
    friction = subject.contact.friction
    body = with_declared_contact(body, subject.contact)
    return PushModel(body, outline, even_points(foot), friction, max(friction, 1e-3), standoff)
