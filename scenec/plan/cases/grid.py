"""Grid family: rows and columns of random sizes, things assigned at random to cells that are large enough."""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.random import Generator

from scenec.plan.cases.slots import SlotOptions
from schemas.arrays import FloatArray

UNEVEN = 0.5  # share of the even size that is distributed at random


def grid(box_m: FloatArray, slot_options: SlotOptions, gap_m: float, rng: Generator) -> FloatArray | None:
    """Slots (n, 4) in a box (4,), or None where no grid holds all things."""
    x0, x1, y0, y1 = box_m.tolist()
    n = len(slot_options.least_m)
    shapes = [(c, ceil(n / c)) for c in range(1, n + 1)]
    fitting = [
        (c, r)
        for c, r in shapes
        if _places(slot_options, (x1 - x0 - gap_m * (c - 1)) / c, (y1 - y0 - gap_m * (r - 1)) / r)
    ]
    if not fitting:
        return None
    columns, rows = fitting[int(rng.integers(len(fitting)))]
    xs = _borders(x0, x1, columns, gap_m, float(slot_options.size_m[..., 0].min(axis=1).max()), rng)
    ys = _borders(y0, y1, rows, gap_m, float(slot_options.size_m[..., 1].min(axis=1).max()), rng)
    chosen = rng.permutation(columns * rows)[:n]
    column, row = chosen % columns, chosen // columns
    return np.stack([xs[column, 0], xs[column, 1], ys[row, 0], ys[row, 1]], axis=1)


def _places(slot_options: SlotOptions, width: float, depth: float) -> bool:
    return bool((slot_options.size_m <= np.array([width, depth]) + 1e-9).all(axis=-1).any(axis=-1).all())


def _borders(low: float, high: float, count: int, gap_m: float, least: float, rng: Generator) -> FloatArray:
    # (count, 2) stretches with gaps between, none narrower than `least`.
    even = (high - low - gap_m * (count - 1)) / count
    base = min(even, max(least, (1.0 - UNEVEN) * even))
    width = base + rng.dirichlet(np.full(count, 2.0)) * (even - base) * count
    begin = low + np.concatenate([[0.0], np.cumsum(width[:-1] + gap_m)])
    return np.stack([begin, begin + width], axis=1)
