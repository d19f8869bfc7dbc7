"""Means over the blocks of the balance, and medians of one quantity in bins of another."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from simgap.kinds.mechanism.logs import Log

_BINS = 40
_FEWEST = 3  # values of a bin


def block_means(log: Log, values: FloatArray) -> FloatArray:
    """Means over the blocks that `equation_error.balance` uses."""
    m = log.margin
    inner = values if len(values) < 4 * m else values[m:-m]
    starts = np.arange(0, max(len(inner) - log.block // 2, 1), log.block)
    return np.add.reduceat(inner, starts) / np.diff(np.append(starts, len(inner)))


def binned_medians(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Medians in bins of equal width that hold enough points."""
    low, high = np.quantile(x, [0.002, 0.998])
    edges = np.linspace(low, high, _BINS + 1)
    which = np.digitize(x, edges) - 1
    full = [b for b in range(_BINS) if (which == b).sum() >= _FEWEST]
    return np.array([np.median(x[which == b]) for b in full]), np.array([np.median(y[which == b]) for b in full])
