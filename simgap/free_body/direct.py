"""Direct estimates without an engine: free flight as parabolas, and sliding, impacts and rest as they come.

Each estimator gives one value per trial; trials are independent, so their scatter is the error of the mean.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy import stats

from schemas.model import FloatArray
from sim.effects.effect import Series
from simgap.free_body.terms import AppliedBody
from simgap.problem import Candidate, DirectEstimate

Estimator = Callable[[AppliedBody, Series, FloatArray], "dict[str, float] | None"]
_CLEAR_M = 0.004  # lowest point over the support, from which on a body surely flies
_LEAST_ROWS = 7


def estimate(
    candidate: Candidate, applied: AppliedBody, series: Sequence[Series], gaps: Sequence[FloatArray]
) -> DirectEstimate | None:
    """The candidate's parameters as the mean over trials; None where no estimator or fewer than three trials."""
    estimator = ESTIMATORS.get(candidate.effect.name)
    if estimator is None:
        return None
    found = [v for s, g in zip(series, gaps, strict=True) if (v := estimator(applied, s, g)) is not None]
    if len(found) < 3:
        return None
    names = list(candidate.null)
    table = np.array([[v[n] for n in names] for v in found])
    middle = stats.trim_mean(table, 0.1, axis=0)
    error = table.std(axis=0, ddof=1) / np.sqrt(len(table)) + 1e-15
    offset = (middle - [candidate.null[n] for n in names]) / error
    p = float(np.min(2.0 * stats.t.sf(np.abs(offset), len(table) - 1)) * len(names))
    return DirectEstimate(
        dict(zip(names, middle.tolist(), strict=True)),
        dict(zip(names, error.tolist(), strict=True)),
        min(p, 1.0),
        len(table),
    )


def flights(gap: FloatArray) -> list[slice]:
    """Stretches of at least seven rows in which the body touches nothing."""
    free = np.concatenate([[False], gap > _CLEAR_M, [False]])
    edges = np.flatnonzero(free[1:] != free[:-1])
    return [slice(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= _LEAST_ROWS]


def flight_acceleration(series: Series, gap: FloatArray) -> FloatArray | None:
    """(3,) mean acceleration in flight: parabolas through positions, weighted by the fourth power of their length."""
    total, weight = np.zeros(3), 0.0
    for part in flights(gap):
        t = series.t_s[part] - series.t_s[part].mean()
        basis = np.stack([np.ones_like(t), t, 0.5 * t**2], axis=1)
        acceleration = np.linalg.lstsq(basis, series.columns["p"][part], rcond=None)[0][2]
        w = float(((t**2 - (t**2).mean()) ** 2).sum())
        total, weight = total + w * acceleration, weight + w
    return total / weight if weight > 0.0 else None


def _gravity(applied: AppliedBody, series: Series, gap: FloatArray) -> dict[str, float] | None:
    acceleration = flight_acceleration(series, gap)
    if acceleration is None:
        return None
    down = applied.body.gravity_W / np.linalg.norm(applied.body.gravity_W)
    return {"gravity_mps2": float(acceleration @ down)}


def _tilt(applied: AppliedBody, series: Series, gap: FloatArray) -> dict[str, float] | None:
    acceleration = flight_acceleration(series, gap)
    if acceleration is None:
        return None
    g = float(np.linalg.norm(applied.body.gravity_W))
    aside = acceleration - applied.body.gravity_W
    return {"about_x_rad": float(aside[1] / g), "about_y_rad": float(-aside[0] / g)}


def _force(applied: AppliedBody, series: Series, gap: FloatArray) -> dict[str, float] | None:
    acceleration = flight_acceleration(series, gap)
    if acceleration is None:
        return None
    force = applied.body.mass_kg * (acceleration - applied.body.gravity_W)
    return {"x_N": float(force[0]), "y_N": float(force[1]), "z_N": float(force[2])}


def _length_scale(applied: AppliedBody, series: Series, gap: FloatArray) -> dict[str, float] | None:
    acceleration = flight_acceleration(series, gap)
    if acceleration is None:
        return None
    g = applied.body.gravity_W
    return {"factor": float(acceleration @ g / (g @ g))}


ESTIMATORS: dict[str, Estimator] = {
    "world.gravity_magnitude": _gravity,
    "world.gravity_tilt": _tilt,
    "world.constant_force": _force,
    "sensor.scale": _length_scale,
}
