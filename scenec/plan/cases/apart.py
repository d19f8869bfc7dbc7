"""Separation of cells: two are apart when their rectangles are, along x or y, so that any footprints inside are too."""

from __future__ import annotations

import numpy as np

from scenec.plan.cases.pool_model import Layouts, PoolModel
from schemas.arrays import BoolArray, FloatArray

ROUNDING_M = 1e-9


def apart(one_m: FloatArray, two_m: FloatArray, gap_m: FloatArray | float) -> BoolArray:
    """Whether rectangles (..., 4) keep a gap along x or y."""
    gap = np.asarray(gap_m) - ROUNDING_M
    return (
        (one_m[..., 1] + gap <= two_m[..., 0])
        | (two_m[..., 1] + gap <= one_m[..., 0])
        | (one_m[..., 3] + gap <= two_m[..., 2])
        | (two_m[..., 3] + gap <= one_m[..., 2])
    )


def meeting(pool: PoolModel, layouts: Layouts) -> BoolArray:
    """(l, n, n) whether two members have a common height in each layout, and so must be apart."""
    count, n = layouts.option.shape
    if pool.level:
        return np.broadcast_to(~np.eye(n, dtype=bool), (count, n, n))
    low, high = np.empty((count, n)), np.empty((count, n))
    for i, member in enumerate(pool.members):
        low[:, i] = member.base_m[layouts.option[:, i]] + float(member.thing.place.origin_P_m[2])
        high[:, i] = low[:, i] + member.height_m[layouts.option[:, i]]
    meet = np.minimum(high[:, :, None], high[:, None]) - np.maximum(low[:, :, None], low[:, None]) > ROUNDING_M
    meet[:, np.arange(n), np.arange(n)] = False
    # `far_from` is planar and applies at any heights.
    return meet | (pool.least_gap_m > pool.clearance_m)


def clashes(pool: PoolModel, layouts: Layouts) -> BoolArray:
    """(l, n, n) pairs whose rectangles are too close."""
    rect = layouts.rect_m
    return meeting(pool, layouts) & ~apart(rect[:, :, None], rect[:, None], pool.least_gap_m)
