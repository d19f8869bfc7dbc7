"""Concatenates all trials with their offsets, so that a check runs once instead of once per trial."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from schemas.arrays import FloatArray, IntArray
from simgap.recording.recording import Trial


def stacked(trials: Sequence[Trial], values: Callable[[Trial], FloatArray]) -> FloatArray:
    """A column of all trials (N, k)."""
    return np.concatenate([values(trial) for trial in trials])


def owners(trials: Sequence[Trial]) -> IntArray:
    """(N,) index of the trial that a stacked row belongs to."""
    return np.repeat(np.arange(len(trials)), [len(trial) for trial in trials])


def windows(values: FloatArray, owner: IntArray, width: int) -> FloatArray:
    """(m, k, width) all runs of `width` rows of stacked values (N, k) that lie in one trial."""
    if len(values) < width:
        return np.empty((0, *values.shape[1:], width))
    within = owner[width - 1 :] == owner[: len(owner) - width + 1]
    return sliding_window_view(values, width, axis=0)[within]
