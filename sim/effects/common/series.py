"""Helpers for effects that map recorded columns: changed columns, held inputs, interpolated motion at times (s)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Series


def with_columns(series: Series, names: Iterable[str], change: Callable[[FloatArray], FloatArray]) -> Series:
    """The series with those of the named columns that exist changed."""
    changed = {name: change(series.columns[name]) for name in names if name in series.columns}
    return replace(series, columns={**series.columns, **changed})


def held_at(t_s: FloatArray, values: FloatArray, when_s: FloatArray) -> FloatArray:
    """Columns (n, k) of a held input at other times: the last row not after each; row 0 before the first.

    Between two rows the share of time that each holds counts, so that a shift by part of a sample is smooth.
    """
    spacing = float(np.median(np.diff(t_s))) if len(t_s) > 1 else 1.0
    row = np.interp(when_s, t_s, np.arange(len(t_s), dtype=float))
    row = np.where(when_s < t_s[0], 0.0, row)
    low = np.floor(row).astype(int)
    high = np.minimum(low + 1, len(t_s) - 1)
    share = (row - low)[:, None] if spacing > 0 else 0.0
    return (1.0 - share) * values[low] + share * values[high]


def read_at(t_s: FloatArray, values: FloatArray, when_s: FloatArray) -> FloatArray:
    """Columns (n, k) of a smooth motion at other times, linear between rows, held beyond the ends."""
    return np.stack([np.interp(when_s, t_s, column) for column in values.T], axis=1)


def low_passed(
    t_s: FloatArray, values: FloatArray, time_constant_s: float, start: FloatArray | None = None
) -> FloatArray:
    """First-order answers (w, k, j) to values that are straight between rows at t_s (w, k).

    time_constant_s * d(answer)/dt = value - answer, solved exactly in each interval, from answers `start` (w, j);
    without a start, the values were on the first straight line all along.
    """
    if time_constant_s <= 0.0 or values.shape[1] < 2:
        return values
    spans = np.diff(t_s)[:, :, None]
    slopes = np.divide(np.diff(values, axis=1), spans, out=np.zeros_like(values[:, 1:]), where=spans > 0.0)
    fades = np.exp(-spans / time_constant_s)
    # On a straight line the answer settles behind it by time constant times slope; what is left of the start fades.
    behind = time_constant_s * slopes
    answers = np.empty_like(values)
    answers[:, 0] = values[:, 0] - behind[:, 0] if start is None else start
    left = answers[:, 0] - values[:, 0] + behind[:, 0]
    for k in range(values.shape[1] - 1):
        left = left + (behind[:, k] - behind[:, k - 1]) if k else left
        left = fades[:, k] * left
        answers[:, k + 1] = left
    answers[:, 1:] += values[:, 1:] - behind
    return answers
