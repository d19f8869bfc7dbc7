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
