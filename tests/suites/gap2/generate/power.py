"""How large a hidden cause is: the believed model restarted from the true readings, never the finder's own fit.

The miss is RMS(truth - prediction) / (sqrt(2) sigma) over the rows of all windows, whose starts are the noise-free
readings; the whole-trial miss has one window per trial.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.plant import Hidden, Plant, Segment, Trial, observe, read_segments

LEVELS = {"medium": 0.48, "large": 1.33, "gross": 6.6}
NEAR = 0.05  # relative miss of the level that is good enough
_ROUNDS = 16

Readings = Sequence[tuple[Array, Array]]


def miss(
    plant: Plant, readings: Readings, trials: Sequence[Trial], sigma: float, horizon_s: float, step_s: float
) -> float:
    """The believed model's error in noise levels when restarted every `horizon_s`; `inf` means once per trial."""
    return float(np.sqrt(np.mean(np.concatenate(_squares(plant, readings, trials, sigma, horizon_s, step_s)))))


def miss_by_trial(
    plant: Plant, readings: Readings, trials: Sequence[Trial], sigma: float, horizon_s: float, step_s: float
) -> Array:
    """(trials,) sums of squares of the same errors."""
    return np.array([s.sum() for s in _squares(plant, readings, trials, sigma, horizon_s, step_s)])


def _squares(
    plant: Plant, readings: Readings, trials: Sequence[Trial], sigma: float, horizon_s: float, step_s: float
) -> list[Array]:
    """Squared errors by trial, in units of 2 sigma^2."""
    segments = []
    for i, ((q, v), trial) in enumerate(zip(readings, trials, strict=True)):
        t = trial.stamps_s
        marks = np.arange(t[0], t[-1], horizon_s) if np.isfinite(horizon_s) else t[:1]
        rows = np.unique(np.searchsorted(t, marks - 1e-9))
        for first, last in zip(rows, [*rows[1:], len(t) - 1], strict=True):
            # The last row of a window is the first of the next: it is predicted, then replaced.
            segments.append(
                Segment(i, first, min(last + 1, len(t)), np.concatenate([q[first], v[first]]), float(t[first]))
            )
    predicted = read_segments(plant, Hidden(), trials, segments, step_s)
    squares: list[list[Array]] = [[] for _ in trials]
    for s, (p, _) in zip(segments, predicted, strict=True):
        error = (p - readings[s.trial][0][s.first : s.last])[1:] / sigma
        squares[s.trial].append(0.5 * error.ravel() ** 2)
    return [np.concatenate(each) for each in squares]


def strength_for(miss_at: Callable[[float], float], level: float, least: float, most: float) -> tuple[float, bool]:
    """(strength, level reached): a miss grows about in proportion, so a secant on logarithms within a bracket."""
    top = miss_at(most)
    if top < level * (1.0 - NEAR):
        return most, False
    low, high, below, above = np.log(least), np.log(most), None, np.log(min(top, 1e12)) - np.log(level)
    at, miss_now = high, above
    for _ in range(_ROUNDS):
        slope = 1.0 if below is None else max((above - below) / (high - low), 1e-3)
        at = float(np.clip(at - miss_now / slope, low + 0.02 * (high - low), high - 0.02 * (high - low)))
        if below is not None and abs(above - below) > 8.0:
            at = 0.5 * (low + high)
        value = miss_at(float(np.exp(at)))
        miss_now = float(np.log(np.clip(value, 1e-9, 1e12)) - np.log(level)) if np.isfinite(value) else 20.0
        if abs(np.expm1(miss_now)) < NEAR:
            return float(np.exp(at)), True
        if miss_now < 0.0:
            low, below = at, miss_now
        else:
            high, above = at, miss_now
    return float(np.exp(at)), False


def misses(
    plant: Plant, hidden: Hidden, trials: Sequence[Trial], sigma: float, horizon_s: float, step_s: float
) -> tuple[float, float]:
    """(restarts, whole trials) of a hidden cause."""
    readings = observe(plant, hidden, trials, step_s)
    return (
        miss(plant, readings, trials, sigma, horizon_s, step_s),
        miss(plant, readings, trials, sigma, float("inf"), step_s),
    )
