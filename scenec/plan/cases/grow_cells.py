"""Grows cells from the rectangles of layouts: all sides of all cells in turn, in decreasing steps, until they meet
others.

Every intermediate state keeps cells disjoint, inside their places, and satisfies directional relations; frame P,
metres.
"""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from scenec.plan.cases.apart import meeting
from scenec.plan.cases.pool_model import Layouts, PoolModel
from schemas.arrays import BoolArray, FloatArray

GROW_STEPS_M = (0.04, 0.04, 0.02, 0.02, 0.01, 0.01, 0.005, np.inf)  # the last one closes the remaining gaps


def grow_cells(pool: PoolModel, layouts: Layouts, free: BoolArray, rng: Generator) -> FloatArray:
    """Rectangles (l, n, 4) around those of the layouts; only those that are `free` (l, n) grow."""
    rect = layouts.rect_m.copy()
    meet, bounds = meeting(pool, layouts), _orders_by_side(pool)
    turns = [(i, side) for i in range(len(pool.members)) for side in range(4) if free[:, i].any()]
    for step in GROW_STEPS_M:
        for turn in rng.permutation(len(turns)).tolist():
            i, side = turns[turn]
            out = _limit(pool, layouts, rect, meet, i, side)
            for j, along, gap in bounds.get((i, side), ()):
                bound = rect[:, j, 2 * along] - gap if side % 2 else rect[:, j, 2 * along + 1] + gap
                out = np.minimum(out, bound) if side % 2 else np.maximum(out, bound)
            now = rect[:, i, side]
            new = (
                np.minimum(now + step, np.maximum(out, now))
                if side % 2
                else np.maximum(now - step, np.minimum(out, now))
            )
            rect[:, i, side] = np.where(free[:, i], new, now)
    return rect


def _limit(pool: PoolModel, layouts: Layouts, rect: FloatArray, meet: BoolArray, i: int, side: int) -> FloatArray:
    # (l,) how far a side of member i may be moved out before it meets its place, its range, or another cell.
    member, along, high = pool.members[i], side // 2, side % 2 == 1
    mine = rect[:, i]
    out = np.empty(len(rect))
    stance = member.stance[layouts.option[:, i]]
    for s, room in member.room.items():
        rows = stance == s
        out[rows] = room.limit(mine[rows], side)
    if not member.pinned:
        most = max(float(t.most_m[:, side].max()) for t in member.yaw_extents.values())
        reach = member.origin_m[side] + (most if high else -most)
        out = np.minimum(out, reach) if high else np.maximum(out, reach)
    gap = pool.least_gap_m[i][None]
    low_m, high_m = mine[:, None, 2 - 2 * along], mine[:, None, 3 - 2 * along]
    beside = (
        meet[:, i]
        & (rect[:, :, 2 - 2 * along] < high_m + gap - 1e-9)
        & (low_m < rect[:, :, 3 - 2 * along] + gap - 1e-9)
    )
    if high:
        edge = rect[:, :, 2 * along] - gap
        return np.minimum(out, np.where(beside & (edge >= mine[:, None, side] - 1e-9), edge, np.inf).min(axis=1))
    edge = rect[:, :, 2 * along + 1] + gap
    return np.maximum(out, np.where(beside & (edge <= mine[:, None, side] + 1e-9), edge, -np.inf).max(axis=1))


def _orders_by_side(pool: PoolModel) -> dict[tuple[int, int], list[tuple[int, int, float]]]:
    # For (member, side): members that a directional relation along an axis keeps beyond that side, axis and gap.
    orders: dict[tuple[int, int], list[tuple[int, int, float]]] = {}
    for first, second, along, gap_m in pool.axis_orders:
        orders.setdefault((first, 2 * along + 1), []).append((second, along, gap_m))
        orders.setdefault((second, 2 * along), []).append((first, along, gap_m))
    return orders
