"""Direct estimates from measured forces and displacements, push by push, without roll-outs or contact solver.

While a body slides, its force lies on the limit surface and its twist along the normal there. The level of the force
gives friction; the direction of the mass centre's move against the force gives its place and the anisotropy; turning
against sliding gives the lever.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from schemas.arrays import FloatArray
from sim.effects.ranges import SUPPORT_PAIR
from simgap.inference.cluster_regression import Equations, regress
from simgap.kinds.push.footprint import nearest
from simgap.kinds.push.model import PushModel
from simgap.kinds.push.records import Records
from simgap.kinds.push.sliding import plane_rotations
from simgap.problem import Candidate, DirectEstimate

_LEAST_MOVE = 0.02  # of the body's lever: less is noise of the poses


@dataclass(frozen=True)
class Moves:
    """Per push, in axes of the body half-way: force (n, 2), move of the origin (n, 2) and turn (n,), contact (n, 2)."""

    force: FloatArray
    move: FloatArray
    turn: FloatArray
    place: FloatArray

    def of_com(self, com: FloatArray) -> FloatArray:
        """(n, 2) move of a point of the body."""
        return self.move + self.turn[:, None] * np.array([-com[1], com[0]])

    def moment(self, com: FloatArray) -> FloatArray:
        """(n,) moment of the force about a point of the body, N m."""
        arm = self.place - com
        return arm[:, 0] * self.force[:, 1] - arm[:, 1] * self.force[:, 0]


def moves(model: PushModel, records: Records) -> Moves:
    """Pushes whose force was measured and that moved the body."""
    half = 0.5 * records.turned
    to_body = plane_rotations(records.before[:, 2] + half).transpose(0, 2, 1)
    shift = np.einsum("nij,nj->ni", to_body, records.after[:, :2] - records.before[:, :2])
    # The chord of the arc that a body turning evenly takes is shorter than the arc.
    arc = half / np.where(np.abs(half) > 1e-9, np.sin(half), 1.0)
    shift = shift * np.where(np.abs(half) > 1e-9, arc, 1.0)[:, None]
    ends = [
        nearest(model.outline, np.einsum("nji,nj->ni", plane_rotations(pose[:, 2]), records.tips[:, k] - pose[:, :2]))[
            1
        ]
        for pose, k in ((records.before, 0), (records.after, -1))
    ]
    # The whole push, so that force and move stand for the same time.
    force = np.einsum("nij,nj->ni", to_body, records.force_all)
    moved = np.linalg.norm(shift, axis=1) + model.lever_m * np.abs(records.turned) > _LEAST_MOVE * model.lever_m
    usable = np.isfinite(force).all(axis=1) & moved
    return Moves(force[usable], shift[usable], records.turned[usable], (0.5 * (ends[0] + ends[1]))[usable])


def estimate(candidate: Candidate, model: PushModel, records: Sequence[Records]) -> DirectEstimate | None:
    """The candidate's parameters over all pushes; None where no equation holds them."""
    name = candidate.effect.push.direct
    if not name or candidate.where.pair not in (None, SUPPORT_PAIR):
        return None
    return ESTIMATORS[name](candidate, model, [moves(model, r) for r in records])


def _level(model: PushModel, seen: Moves) -> FloatArray:
    """(n,) N: size of the wrench on the limit surface of unit size."""
    wrench = np.column_stack([seen.force, seen.moment(model.body.com_B[:2])])
    return np.sqrt(((wrench / model.axes) ** 2).sum(axis=1))


def _friction(candidate: Candidate, model: PushModel, seen: Sequence[Moves]) -> DirectEstimate | None:
    rows = [_mean(_level(model, m) / model.weight_N) for m in seen]
    return regress(rows, ("mu",), candidate.null)


def _mass(candidate: Candidate, model: PushModel, seen: Sequence[Moves]) -> DirectEstimate | None:
    per_kg = model.largest_N / model.body.mass_kg
    rows = [_mean(_level(model, m) / per_kg) for m in seen]
    return regress(rows, ("mass_kg",), candidate.null)


def _mass_centre(candidate: Candidate, model: PushModel, seen: Sequence[Moves]) -> DirectEstimate | None:
    """The point of the body that moves along the (compliant) force: linear in its place."""
    ease = model.axes[:2] ** -2
    rows = []
    for m in seen:
        way = m.force * ease
        X = m.turn[:, None] * way
        rows.append(Equations(-(way[:, 0] * m.move[:, 1] - way[:, 1] * m.move[:, 0]), X, X))
    estimate = regress(rows, ("x_m", "y_m"), candidate.null)
    if estimate is None:
        return None
    return replace(
        estimate,
        values={**estimate.values, "z_m": candidate.null["z_m"]},
        standard_errors={**estimate.standard_errors, "z_m": 1e-15},
    )


def _anisotropy(candidate: Candidate, model: PushModel, seen: Sequence[Moves]) -> DirectEstimate | None:
    """The mass centre moves along (force_x / ratio^2, force_y): linear in 1 / ratio^2."""
    rows = []
    for m in seen:
        v = m.of_com(model.body.com_B[:2])
        # What an isotropic body would do: it moves with the regressor, without the noise of the poses.
        Z = (m.force[:, 0] * m.force[:, 1])[:, None]
        rows.append(Equations(v[:, 0] * m.force[:, 1], (v[:, 1] * m.force[:, 0])[:, None], Z))
    return _transformed(regress(rows, ("ratio",), candidate.null), candidate, lambda k: k**-0.5)


def _spinning(candidate: Candidate, model: PushModel, seen: Sequence[Moves]) -> DirectEstimate | None:
    """Turn over move grows with moment over force as 1 / lever^2."""
    com, ease, mu = model.body.com_B[:2], model.axes[:2] ** -2, model.reference_friction
    rows = []
    for m in seen:
        way, moment = m.force * ease, m.moment(com)
        turn, slide = m.turn * (way**2).sum(axis=1), (m.of_com(com) * way).sum(axis=1) * moment
        # Errors grow with the push: long ones must neither rule nor be left out.
        size = np.hypot(turn, slide / model.lever_m**2) + 1e-15
        arm = moment / (np.linalg.norm(way, axis=1) * model.lever_m + 1e-15)
        rows.append(Equations(turn / size, (slide / size)[:, None], arm[:, None]))
    none = {"lever_m": (candidate.null["lever_m"] / mu) ** -2}
    return _transformed(regress(rows, ("lever_m",), none), candidate, lambda k: mu * k**-0.5)


def _mean(values: FloatArray) -> Equations:
    ones = np.ones((len(values), 1))
    return Equations(values, ones, ones)


def _transformed(
    estimate: DirectEstimate | None, candidate: Candidate, map: Callable[[float], float]
) -> DirectEstimate | None:
    """An estimate of k as one of the parameter map(k), tested on its logarithm; None where k is not positive."""
    (name, null), *_ = candidate.null.items()
    if estimate is None or estimate.values[name] <= 0.0:
        return None
    k, error = estimate.values[name], estimate.standard_errors[name]
    value = map(k)
    width = abs(map(1.001 * k) - map(0.999 * k)) / (0.002 * k) * error + 1e-15
    p = float(2.0 * stats.t.sf(abs(np.log(value / null)) * value / width, estimate.trials - 1))
    return replace(estimate, values={name: value}, standard_errors={name: width}, p_value=p)


# By what they read; `PushCandidacy.direct` of an effect names one.
ESTIMATORS: dict[str, Callable[[Candidate, PushModel, Sequence[Moves]], DirectEstimate | None]] = {
    "level_of_force": _friction,
    "move_across_force": _anisotropy,
    "turn_over_slide": _spinning,
    "mass_centre": _mass_centre,
    "mass": _mass,
}
