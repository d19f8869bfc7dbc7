"""Shelf family: rows of slots, first fit by decreasing depth with noise (Coffman et al. 1980), then rows shuffled."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from scenec.plan.cases.slots import SlotOptions, ordered_by_bias
from schemas.arrays import FloatArray

NOISE = 0.15


def shelf(box_m: FloatArray, slot_options: SlotOptions, gap_m: float, rng: Generator) -> FloatArray | None:
    """Slots (n, 4) in a box (4,), or None where the rows do not fit."""
    x0, x1, y0, y1 = box_m.tolist()
    size, n = slot_options.least_m, len(slot_options.least_m)
    order = np.argsort(-size[:, 1] * (1.0 - NOISE * rng.random() * rng.random(n)))
    rows: list[list[int]] = []
    used: list[float] = []
    depth: list[float] = []
    for i in order.tolist():
        width, deep = size[i].tolist()
        home = next((r for r in range(len(rows)) if used[r] + width <= x1 - x0 and deep <= depth[r]), None)
        if home is None:
            home = len(rows)
            rows.append([])
            used.append(0.0)
            depth.append(deep)
        rows[home].append(i)
        used[home] += width + gap_m
    spare = y1 - y0 - sum(depth) - gap_m * (len(rows) - 1)
    if spare < 0.0 or max(used) - gap_m > x1 - x0:
        return None
    slots = np.zeros((n, 4))
    more = _shares(len(rows), rng) * spare
    y = y0
    bias = [float(slot_options.bias[row, 1].mean()) for row in rows]
    for r in np.argsort(np.array(bias) + 0.1 * rng.standard_normal(len(rows))).tolist():
        members = ordered_by_bias(slot_options, np.array(rows[r]), 0, rng).tolist()
        wider = _shares(len(members), rng) * (x1 - x0 - used[r] + gap_m)
        x, high = x0, y + depth[r] + float(more[r])
        for i, extra in zip(members, wider.tolist(), strict=True):
            slots[i] = (x, x + float(size[i, 0]) + extra, y, high)
            x = slots[i, 1] + gap_m
        y = high + gap_m
    return slots


def _shares(count: int, rng: Generator) -> FloatArray:
    # Random shares of what is left over.
    return rng.dirichlet(np.full(count, 2.0))
