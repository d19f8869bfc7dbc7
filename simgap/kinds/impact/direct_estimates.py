"""Direct estimates from measured impulses, event by event, without an impact law.

Restitution is parting over approaching speed; friction the ratio of impulses where the contact slides all the way;
inertia and mass centre follow from the balance of angular momentum.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from schemas.arrays import BoolArray, FloatArray
from sim.dynamics.body_rollout import BodyModel
from simgap.inference.cluster_regression import Equations, regress
from simgap.kinds.impact.model import Impulses, impulses
from simgap.problem import Candidate, DirectEstimate
from simgap.recording.recording import Impacts

_KEEPS_SLIDING = 0.3  # least share of the slip that is left where friction acted one way all along
_PROBE_M = 1e-4
Row = Callable[[BodyModel, Impacts], Equations]
Estimator = Callable[[Candidate, BodyModel, Sequence[Impacts]], DirectEstimate | None]


def estimate(candidate: Candidate, body: BodyModel, trials: Sequence[Impacts]) -> DirectEstimate | None:
    """The candidate's parameters over all trials; None where no equation holds them."""
    name = candidate.effect.impact.direct
    return ESTIMATORS[name](candidate, body, trials) if name else None


def _by_rows(row: Row) -> Estimator:
    """The estimator whose equations `row` gives for each trial."""

    def estimator(candidate: Candidate, body: BodyModel, trials: Sequence[Impacts]) -> DirectEstimate | None:
        return regress([row(body, t) for t in trials], tuple(candidate.null), candidate.null)

    return estimator


def _ones(y: FloatArray, x: FloatArray) -> Equations:
    """A ratio of means: noise in x does not pull it towards zero."""
    return Equations(y, x[:, None], np.ones((len(y), 1)))


def _restitution(body: BodyModel, events: Impacts) -> Equations:
    seen = impulses(body, events)
    return _ones(seen.approach[:, 1], -seen.approach[:, 0])


def _friction(body: BodyModel, events: Impacts) -> Equations:
    seen = impulses(body, events)
    sliding = slides(seen)
    return _ones((-np.sign(seen.slip[:, 0]) * seen.along)[sliding], seen.normal[sliding])


def slides(seen: Impulses) -> BoolArray:
    """(n,) mask of events that slip one way from beginning to end: there the impulses' ratio is the coefficient."""
    before, after = seen.slip.T
    return (before * after > 0.0) & (np.abs(after) > _KEEPS_SLIDING * np.abs(before)) & (seen.normal > 0.0)


def _inertia(body: BodyModel, events: Impacts) -> Equations:
    seen = impulses(body, events)
    # The lever arm is geometry: it knows nothing of the noise in the velocities.
    return Equations(seen.moment, seen.spin[:, None], seen.normal_arm[:, None])


def _mass_centre(candidate: Candidate, body: BodyModel, trials: Sequence[Impacts]) -> DirectEstimate | None:
    """Newton's steps on the balance of angular momentum, which is nearly linear in the place of the mass centre."""
    estimate: DirectEstimate | None = None
    plane = ("x_m", "y_m")
    for _ in range(2):
        at = {n: float(v) for n, v in zip(plane, body.com_B, strict=False)}
        rows = []
        for events in trials:
            rest = _imbalance(body, events)
            X = np.stack([(_imbalance(_moved(body, n), events) - rest) / _PROBE_M for n in plane], axis=1)
            rows.append(Equations(-rest + X @ np.array(list(at.values())), X, X))
        estimate = regress(rows, plane, candidate.null)
        if estimate is None:
            return None
        body = replace(body, com_B=np.array([*estimate.values.values(), candidate.null["z_m"]]))
    assert estimate is not None
    # Planar impacts say nothing about the height.
    return replace(
        estimate,
        values={**estimate.values, "z_m": candidate.null["z_m"]},
        standard_errors={**estimate.standard_errors, "z_m": 1e-15},
    )


def _moved(body: BodyModel, name: str) -> BodyModel:
    step = _PROBE_M * np.array([name == "x_m", name == "y_m", False])
    return replace(body, com_B=body.com_B + step)


def _imbalance(body: BodyModel, events: Impacts) -> FloatArray:
    seen = impulses(body, events)
    return seen.moment - seen.spin


# By what they read; `ImpactCandidacy.direct` of an effect names one.
ESTIMATORS: dict[str, Estimator] = {
    "parting_over_approach": _by_rows(_restitution),
    "sliding_impulse": _by_rows(_friction),
    "angular_balance": _by_rows(_inertia),
    "mass_centre": _mass_centre,
}
