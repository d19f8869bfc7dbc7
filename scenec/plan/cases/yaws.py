"""Yaw intervals at which a footprint fits a cell: unions of small intervals with upper bounds of its extents."""

from __future__ import annotations

from math import ceil, floor

import numpy as np

from scenec.plan.cases.pool_model import GRAIN_RAD, YawExtents
from schemas.arrays import BoolArray, FloatArray

MOST_INTERVALS = 4
LEAST_RAD = 1e-3  # narrower intervals are dropped
TURN = 2.0 * np.pi


def fitting(yaw_extents: YawExtents, rect_m: FloatArray, origin_m: FloatArray) -> BoolArray:
    """(m, k) whether the footprint fits rectangles (m, 4), its origin in boxes (m, 4), throughout each yaw interval."""
    left, right, front, back = yaw_extents.most_m.T
    x0, x1, y0, y1 = (v[:, None] for v in rect_m.T)
    ox0, ox1, oy0, oy1 = (v[:, None] for v in origin_m.T)
    return (
        (left + right <= x1 - x0)
        & (front + back <= y1 - y0)
        & (x0 + left <= ox1)
        & (x1 - right >= ox0)
        & (y0 + front <= oy1)
        & (y1 - back >= oy0)
    )


def intervals(yaw_extents: YawExtents, fits: BoolArray, window_rad: tuple[float, float]) -> list[tuple[float, float]]:
    """The longest runs of fitting intervals (k,) within a window, as (low, high) on whole microradians; maybe none."""
    edges = yaw_extents.edges
    change = [0, len(fits)]  # the usual case first: all of them fit
    if not fits.all():
        change = np.flatnonzero(np.diff(np.concatenate([[False], fits, [False]]).astype(np.int8))).tolist()
    runs = [(float(edges[a]), float(edges[b])) for a, b in zip(change[::2], change[1::2], strict=True)]
    if edges[-1] - edges[0] > TURN - 1e-9 and len(runs) > 1 and fits[0] and fits[-1]:
        (first, *rest) = runs
        runs = [*rest[:-1], (rest[-1][0], first[1] + TURN)]
    low, high = window_rad
    cut = []
    for begin, end in runs:
        for turn in (-TURN, 0.0, TURN) if high - low < TURN - 1e-9 else (0.0,):
            a, b = max(begin + turn, low), min(end + turn, high)
            if high - low >= TURN - 1e-9:
                a, b = begin, end
            a, b = ceil(a / GRAIN_RAD) * GRAIN_RAD, floor(b / GRAIN_RAD) * GRAIN_RAD
            if b - a >= LEAST_RAD:
                cut.append((a, b))
    return sorted(sorted(cut, key=lambda run: (run[0] - run[1], run[0]))[:MOST_INTERVALS])
