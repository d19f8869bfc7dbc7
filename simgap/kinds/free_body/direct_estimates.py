"""Direct estimates without an engine, from normal equations of single tosses; errors by jackknife over tosses.

A toss gives normal equations `H x = g` of least squares about the parameters (and sometimes a nuisance behind them):
one that shows only some directions adds only those. No toss counts more than a few others, and tosses that disagree
with the rest count less (Cauchy's weights).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy import stats

from schemas.arrays import FloatArray
from simgap.kinds.free_body import contact, flight, readings
from simgap.kinds.free_body.normal_equations import NormalEquations
from simgap.kinds.free_body.toss import Toss
from simgap.problem import Candidate, DirectEstimate

Estimator = Callable[[Toss], "NormalEquations | None"]
Routes = tuple[Estimator, ...]
_LEAST_EQUATIONS = 3
_HEAVIEST = 3.0  # times the median toss
_ROUNDS = 5
_BLIND = 1e-6
_KNOWN = 0.003  # share to which lengths, masses and shapes are what their file says
_ONE_ERRORS = 3.0  # errors within which readings of one number agree

# By what they read off a toss; `TossCandidacy.direct` of an effect names them.
ESTIMATORS: Mapping[str, Estimator] = {
    "slowing_of_slides": contact.friction,
    "speeds_about_impacts": contact.restitution,
    "turn_of_slides": contact.anisotropy,
    "wobble_in_flight": flight.com_offset,
    "turn_in_impacts": contact.inertia,
    "height_at_rest": contact.size,
    "rate_of_falls": flight.gravity,
    "drift_of_falls": flight.tilt,
    "drag_in_flight": flight.linear_drag,
    "quadratic_drag_in_flight": flight.quadratic_drag,
    "force_in_flight": flight.force,
    "length_of_falls": flight.length_scale,
    "pace_of_falls": flight.clock,
    "tilt_at_rest": readings.frame_rotation,
    "rates_behind_path": readings.velocity_age,
}


def routes_to(candidate: Candidate) -> Routes:
    """The estimators that read the candidate off a toss of a single body."""
    return tuple(ESTIMATORS[name] for name in candidate.effect.free_body.direct)


def estimate(
    candidate: Candidate,
    tosses: Sequence[Toss],
    biases: Sequence[FloatArray] | None = None,
    routes: Routes | None = None,
) -> DirectEstimate | None:
    """The candidate's parameters over all tosses; None where no estimator is or fewer than three tosses give a value.

    `biases` (see `biases_of`) are part of the errors; `routes` are those of a single body when left out.
    """
    estimators, names = routes_to(candidate) if routes is None else routes, list(candidate.null)
    pools = []
    for estimator, bias in zip(estimators, biases or [np.zeros(len(names))] * len(estimators), strict=True):
        pooled_estimate = pooled(estimator, tosses)
        if pooled_estimate is not None:
            values, errors, n = (pooled_estimate[0][: len(names)], pooled_estimate[1][: len(names)], pooled_estimate[2])
            pools.append((values, np.hypot(errors, bias), n))
    if not pools:
        return None
    null = np.array(list(candidate.null.values()))
    apart = [_estimate(names, values, errors, n, _p_value(values, errors, null, n)) for values, errors, n in pools]
    if len(pools) == 1:
        return apart[0]
    p = min(one.p_value for one in apart) * len(pools)
    values, errors, trials = pools[0]
    for other, error, n in pools[1:]:
        # Two routes to one number: their mean, with their disagreement as part of its error.
        total = 1.0 / errors**2 + 1.0 / error**2
        middle = (values / errors**2 + other / error**2) / total
        errors = np.sqrt(1.0 / total + np.maximum(0.25 * (values - other) ** 2 - 0.25 * (errors**2 + error**2), 0.0))
        values, trials = middle, min(trials, n)
    return replace(_estimate(names, values, errors, trials, p), separate_readings=tuple(apart))


def agree_on_one_value(readings: Sequence[DirectEstimate]) -> bool:
    """Whether readings of one number agree within their errors and the tolerance `_KNOWN` of declared values."""
    return all(
        abs(one.values[n] - other.values[n])
        <= _ONE_ERRORS * np.hypot(one.standard_errors[n], other.standard_errors[n]) + _KNOWN * abs(one.values[n])
        for one, other in combinations(readings, 2)
        for n in one.values
    )


def _estimate(names: Sequence[str], values: FloatArray, errors: FloatArray, trials: int, p: float) -> DirectEstimate:
    named, spread = (dict(zip(names, v.tolist(), strict=True)) for v in (values, errors))
    return DirectEstimate(named, spread, min(p, 1.0), trials)


def biases_of(
    candidate: Candidate, simulated: Sequence[Sequence[Toss]], routes: Routes | None = None
) -> tuple[FloatArray, ...]:
    """(k,) per estimator: what it reads, all the same, off motions in which nothing is hidden.

    `simulated`: roll-outs of the declared model, one sequence per step size; the worst of them counts. Where they do
    not show the number, 0.
    """
    null = np.array(list(candidate.null.values()))
    out = []
    for estimator in routes_to(candidate) if routes is None else routes:
        read = [r[0][: len(null)] - null for tosses in simulated if (r := pooled(estimator, tosses)) is not None]
        out.append(np.abs(read).max(axis=0) if read else np.zeros(len(null)))
    return tuple(out)


def _p_value(values: FloatArray, errors: FloatArray, null: FloatArray, trials: int) -> float:
    """Two-sided, that all numbers are as without effect (Bonferroni); what is declared is known to `_KNOWN` only."""
    offset = (values - null) / np.hypot(errors, _KNOWN * np.abs(null))
    return float(np.min(2.0 * stats.t.sf(np.abs(offset), trials - 1)) * len(null))


def pooled(estimator: Estimator, tosses: Sequence[Toss]) -> tuple[FloatArray, FloatArray, int] | None:
    """Values, standard errors (jackknife over tosses) and the number of tosses."""
    equations = [e for toss in tosses if (e := estimator(toss)) is not None]
    if len(equations) < _LEAST_EQUATIONS:
        return None
    H, g = np.stack([e.H for e in equations]), np.stack([e.g for e in equations])
    n, everyone = len(equations), np.arange(len(equations))
    x = _agreed(H, g)
    # Weights are found anew without each toss: with those of all, what disagrees would look better known than it is.
    without = [v for k in everyone if (v := _agreed(H[everyone != k], g[everyone != k])) is not None]
    if x is None or len(without) < n:
        return None
    left = np.stack(without)
    error = np.sqrt((n - 1) / n * ((left - left.mean(axis=0)) ** 2).sum(axis=0)) + 1e-15
    return equations[0].origin + x, error, n


def _agreed(H: FloatArray, g: FloatArray) -> FloatArray | None:
    """Numbers (k,) on which normal equations (n, k, k), (n, k) agree best; None where a direction is not seen."""
    size = np.trace(H, axis1=1, axis2=2)
    share = np.minimum(1.0, _HEAVIEST * np.median(size) / np.maximum(size, 1e-300))
    weight = share
    x = _solved(np.einsum("n,nij->ij", weight, H), weight @ g)
    for _ in range(_ROUNDS):
        if x is None:
            return None
        apart = np.linalg.norm(g - H @ x, axis=1) / size
        weight = share / (1.0 + (apart / (3.0 * np.median(apart) + 1e-300)) ** 2)
        x = _solved(np.einsum("n,nij->ij", weight, H), weight @ g)
    return x


def _solved(H: FloatArray, g: FloatArray) -> FloatArray | None:
    """H^-1 g; None where a direction is not seen."""
    root = np.sqrt(np.maximum(np.diag(H), 1e-300))
    scaled = H / np.outer(root, root)
    if np.linalg.eigvalsh(scaled)[0] < _BLIND:
        return None
    return np.linalg.solve(scaled, g / root) / root
