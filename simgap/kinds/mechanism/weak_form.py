"""Means of accelerations by parts: from positions and a smooth weight, without an acceleration of any row.

The integral of weight times acceleration is that of the weight's second derivative times position. Local cubics flatten
what they smooth, and what they take off an acceleration repeats from trial to trial and would look like a force; so a
quantity that smoothed positions are compared with is smoothed alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.signal import savgol_coeffs

from schemas.arrays import FloatArray, IntArray
from simgap.kinds.mechanism.time_scale import CUBIC_ORDER

_FEWEST_WEIGHTS = 3  # rows that a second derivative needs


@dataclass(frozen=True)
class WeakMeans:
    """Means over b stretches of the n rows of a trial that overlap by half, with weights sin^4 that fade at both ends.

    mean           (b, n) of a quantity per row, smoothed as positions are.
    acceleration   (b, n) of the second derivative (1/s2) of positions that are smoothed.
    stretches, rows  b and n.
    """

    mean: sparse.csr_array
    acceleration: sparse.csr_array
    stretches: int
    rows: int


def weak_means(t_s: FloatArray, rows: int, smoothed_rows: int) -> WeakMeans:
    """Means of rows stamped t_s (n,), each over so many median intervals; stamps may be uneven.

    Positions were smoothed by local cubics over `smoothed_rows`. There is no stretch where a trial is too short.
    """
    step = float(np.median(np.diff(t_s)))
    even = np.arange(t_s[0], t_s[-1] + 0.01 * step, step)
    cubic = np.asarray(savgol_coeffs(max(smoothed_rows, CUBIC_ORDER + 2) | 1, CUBIC_ORDER))
    rows = max(min(rows, len(even) - len(cubic) + 1), _FEWEST_WEIGHTS)
    phase = np.pi * (np.arange(rows) + 0.5) / rows
    weight = np.sin(phase) ** 4
    curvature = 12.0 * (np.sin(phase) * np.cos(phase)) ** 2 - 4.0 * weight
    curvature -= curvature.mean()  # exact for lines, and below for parabolas
    since_middle_s = (np.arange(rows) - 0.5 * (rows - 1)) * step
    curvature /= max(float(curvature @ since_middle_s**2) / 2.0, 1e-300)
    starts = np.arange(0, len(even) - rows - len(cubic) + 2, max(rows // 2, 1))
    to_even = _interpolation(t_s, even)
    return WeakMeans(
        _stretches(starts, np.convolve(weight / weight.sum(), cubic), len(even)) @ to_even,
        _stretches(starts, np.pad(curvature, len(cubic) // 2), len(even)) @ to_even,
        len(starts),
        len(t_s),
    )


def means(by_trial: Sequence[WeakMeans], values: FloatArray) -> FloatArray:
    """(all b, k) means of values (all n, k) of trials whose rows lie below one another."""
    return np.concatenate([m.mean @ v for m, v in _by_trial(by_trial, values)])


def mean_accelerations(by_trial: Sequence[WeakMeans], positions: FloatArray) -> FloatArray:
    """(all b, k) mean second derivatives of positions (all n, k)."""
    return np.concatenate([m.acceleration @ v for m, v in _by_trial(by_trial, positions)])


def _by_trial(by_trial: Sequence[WeakMeans], values: FloatArray) -> zip[tuple[WeakMeans, FloatArray]]:
    ends = np.cumsum([m.rows for m in by_trial])[:-1]
    return zip(by_trial, np.split(values, ends), strict=True)


def _stretches(starts: IntArray, weights: FloatArray, count: int) -> sparse.csr_array:
    columns = starts[:, None] + np.arange(len(weights))
    ends = np.arange(0, columns.size + 1, len(weights))
    return sparse.csr_array((np.tile(weights, len(starts)), columns.ravel(), ends), shape=(len(starts), count))


def _interpolation(t_s: FloatArray, even: FloatArray) -> sparse.csr_array:
    """(len(even), n) linear interpolation from stamps to even ones."""
    places = np.interp(even, t_s, np.arange(len(t_s)))
    below = np.minimum(places.astype(int), len(t_s) - 2)
    share = places - below
    at = np.arange(len(even))
    entries = np.concatenate([1.0 - share, share]), (np.tile(at, 2), np.concatenate([below, below + 1]))
    return sparse.csr_array(entries, shape=(len(even), len(t_s)))
