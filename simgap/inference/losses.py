"""Robust losses per trial from residuals, and paired tests between two models over the same trials.

A trial is the unit: samples within one are not independent. Large residuals count by their logarithm (Cauchy's loss),
so that one toss that lands on another face does not outvote fifty that do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from schemas.arrays import BoolArray, FloatArray
from schemas.sim_gap.extension import Interval
from simgap.inference.robust_least_squares import mean_loss

_DRAWS = 2000
_LITTLE = 0.1  # of the largest change of a trial's loss, as its logarithm: other parameters move along a little
_LARGEST_LOG_CHANGE = 2.0  # change of a trial's loss, as its logarithm, beyond which one that changes more says no more
_FEWEST_CHANGED = 3
_TINY = 1e-12


def trial_losses(residuals: Sequence[FloatArray], scale: FloatArray) -> FloatArray:
    """(n,) mean loss per trial of residuals (k, c) divided by `scale` (c,); rows without a number are left out."""
    return np.array([mean_loss(r / scale) for r in residuals])


@dataclass(frozen=True)
class Comparison:
    """Model b against model a over the same trials.

    gain      1 - loss(b) / loss(a), of the sums over trials; `ci95` by bootstrap over trials.
    p_value   one-sided, that b is not better (paired over trials, on log losses).
    """

    gain: float
    ci95: Interval
    p_value: float


def compare(before: FloatArray, after: FloatArray, seed: int = 0) -> Comparison:
    """How much better `after` is than `before`, both (n,) losses of the same trials."""
    gain = _gain(before.sum(), after.sum())
    if len(before) < 2:
        return Comparison(gain, (-np.inf, 1.0), 1.0)
    draws = np.random.default_rng(seed).integers(0, len(before), (_DRAWS, len(before)))
    gains = [_gain(a, b) for a, b in zip(before[draws].sum(axis=1), after[draws].sum(axis=1), strict=True)]
    low, high = np.quantile(gains, [0.025, 0.975])
    return Comparison(gain, (float(low), float(high)), paired_p(before, after))


def _gain(before: float, after: float) -> float:
    return float(1.0 - after / before) if before > 0.0 else 0.0


def paired_p(before: FloatArray, after: FloatArray) -> float:
    """One-sided p-value that `after` is not smaller: Student's test on the log ratios of the trials.

    Logarithms make trials of different violence comparable; rank tests give no p-value below one in 2^n.
    """
    tiny = 1e-12 + 1e-9 * before.mean()
    ratios = np.log((before + tiny) / (after + tiny))
    if np.ptp(ratios) <= 1e-12:
        return 1.0
    return float(np.asarray(stats.ttest_1samp(ratios, 0.0, alternative="greater")[1]))


def _affected_trials(before: FloatArray, after: FloatArray) -> BoolArray:
    """(n,) trials whose losses differ by no small part of the largest difference: those that meet a threshold."""
    size = np.abs(np.log((before + _TINY) / (after + _TINY)))
    return size > _LITTLE * min(float(size.max()), _LARGEST_LOG_CHANGE)


def paired_p_where_affected(before: FloatArray, after: FloatArray) -> float:
    """`paired_p` over the trials that `after` changes, for better or worse; 1 where those are fewer than three.

    Trials that stay away from a threshold carry no information on it, and their number would hide its effect on the
    others. The choice of trials does not depend on which model does better in them.
    """
    changed = _affected_trials(before, after)
    return paired_p(before[changed], after[changed]) if changed.sum() >= _FEWEST_CHANGED else 1.0


def holm_adjusted(p_values: Sequence[float]) -> FloatArray:
    """Holm's step-down adjustment: the chance of one false name among all hypotheses stays below the level."""
    p = np.asarray(p_values, dtype=float)
    order = np.argsort(p)
    raised = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    out = np.empty_like(p)
    out[order] = np.minimum(raised, 1.0)
    return out
