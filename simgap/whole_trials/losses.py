"""Errors of whole trials as losses.

The deviance of a trial is its sum of squared errors in noise levels. Its loss is 2 n log((1 + deviance / n) / 2) for n
rows: near the noise it changes as the deviance does, and a trial that no model follows, such as one that goes over the
top the other way, does not outvote the others. Steps that minimise it have the weights 2 / (1 + deviance / n).
"""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray

_LARGEST_ERROR = 1e8  # noise levels beyond which an error counts no more: what is further off has diverged


def clipped(errors: FloatArray) -> FloatArray:
    """Errors with what diverged held at a large number; NaN, where nothing was measured, stays."""
    return np.clip(errors, -_LARGEST_ERROR, _LARGEST_ERROR)


def deviances(errors: FloatArray) -> FloatArray:
    """(t,) of errors (t, n)."""
    squares: FloatArray = np.where(np.isfinite(errors), errors, 0.0) ** 2
    return squares.sum(axis=1)


def losses(deviance: FloatArray, rows: FloatArray) -> FloatArray:
    """(t,) of deviances (t,) over so many rows (t,)."""
    return 2.0 * rows * np.log(0.5 * (1.0 + deviance / rows))


def weights(deviance: FloatArray, rows: FloatArray) -> FloatArray:
    """(t,) changes of the losses by deviance."""
    return 2.0 / (1.0 + deviance / rows)


def rows_of(errors: FloatArray, starts: int) -> FloatArray:
    """(t,) errors that were measured, less the start values that they determine."""
    return np.maximum(np.isfinite(errors).sum(axis=1) - starts, 1).astype(float)
