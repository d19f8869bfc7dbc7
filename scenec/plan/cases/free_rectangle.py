"""Free-rectangle family: largest first, each thing into a random maximal empty rectangle that fits it (ProcTHOR)."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from scenec.plan.cases.slots import SlotOptions
from schemas.arrays import FloatArray

MOST_FREE = 160
LEAN = 3.0  # weight of the bias by relations against the fit


def free_rectangle(box_m: FloatArray, slot_options: SlotOptions, gap_m: float, rng: Generator) -> FloatArray | None:
    """Slots (n, 4) in a box (4,), or None where no empty rectangle fits a thing. Slots are at sides and corners."""
    n = len(slot_options.least_m)
    free = box_m[None].copy()
    middle, size = (box_m[[0, 2]] + box_m[[1, 3]]) / 2.0, box_m[[1, 3]] - box_m[[0, 2]]
    slots = np.zeros((n, 4))
    area = slot_options.size_m.prod(axis=-1).min(axis=1)
    for i in np.argsort(-area * (1.0 - 0.3 * rng.random(n))).tolist():
        room = np.stack([free[:, 1] - free[:, 0], free[:, 3] - free[:, 2]], axis=1)
        fits = (slot_options.size_m[i][None] <= room[:, None] + 1e-9).all(axis=-1)
        if not fits.any():
            return None
        # Tight fits with random weights leave room for later things.
        waste = room.prod(axis=1)[:, None] - slot_options.size_m[i].prod(axis=-1)[None]
        pull = -(free[:, [0, 2]] + room / 2.0 - middle) @ slot_options.bias[i] / size.max()
        score = np.where(fits, waste / waste.max() * (0.3 + rng.random(fits.shape)) + LEAN * pull[:, None], np.inf)
        k, way = np.unravel_index(int(score.argmin()), score.shape)
        width, depth = slot_options.size_m[i, way]
        low = rng.random(2) < 0.5 * (1.0 - slot_options.bias[i])
        x = free[k, 0] if low[0] else free[k, 1] - width
        y = free[k, 2] if low[1] else free[k, 3] - depth
        slots[i] = (x, x + width, y, y + depth)
        free = _without(free, slots[i] + gap_m * np.array([-1.0, 1.0, -1.0, 1.0]))
        if not len(free):
            free = np.zeros((1, 4))
    return slots


def _without(free: FloatArray, taken: FloatArray) -> FloatArray:
    # Maximal empty rectangles after one is taken (Jylanki 2010): intersected ones are split, contained ones dropped.
    x0, x1, y0, y1 = taken
    cut = (free[:, 0] < x1 - 1e-9) & (free[:, 1] > x0 + 1e-9) & (free[:, 2] < y1 - 1e-9) & (free[:, 3] > y0 + 1e-9)
    parts = [free[~cut]]
    for side, value in ((1, x0), (0, x1), (3, y0), (2, y1)):
        part = free[cut].copy()
        part[:, side] = value
        parts.append(part[(part[:, 1] - part[:, 0] > 5e-3) & (part[:, 3] - part[:, 2] > 5e-3)])
    candidates = np.concatenate(parts)
    candidates = candidates[np.lexsort(candidates.T)]
    candidates = (
        candidates[np.concatenate([[True], (candidates[1:] != candidates[:-1]).any(axis=1)])]
        if len(candidates)
        else candidates
    )
    a, b = candidates[:, None], candidates[None]
    is_covered = (
        (a[..., 0] >= b[..., 0]) & (a[..., 1] <= b[..., 1]) & (a[..., 2] >= b[..., 2]) & (a[..., 3] <= b[..., 3])
    )
    np.fill_diagonal(is_covered, False)
    maximal = candidates[~is_covered.any(axis=1)]
    size = (maximal[:, 1] - maximal[:, 0]) * (maximal[:, 3] - maximal[:, 2])
    return maximal[np.argsort(-size, kind="stable")[:MOST_FREE]]
