"""Free-rectangle search: largest first, each thing into a random maximal empty rectangle that takes it (ProcTHOR)."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from scenec.ir.problem import FloatArray
from scenec.plan.cases.slots import Ways

MOST_FREE = 160
LEAN = 3.0  # weight of where relations want a thing, against how well it fits


def free_rectangle(box_m: FloatArray, ways: Ways, gap_m: float, rng: Generator) -> FloatArray | None:
    """Slots (n, 4) in a box (4,), or None where nothing empty takes a thing. Things stand at sides and corners."""
    n = len(ways.least_m)
    free = box_m[None].copy()
    middle, size = (box_m[[0, 2]] + box_m[[1, 3]]) / 2.0, box_m[[1, 3]] - box_m[[0, 2]]
    slots = np.zeros((n, 4))
    area = ways.size_m.prod(axis=-1).min(axis=1)
    for i in np.argsort(-area * (1.0 - 0.3 * rng.random(n))).tolist():
        room = np.stack([free[:, 1] - free[:, 0], free[:, 3] - free[:, 2]], axis=1)
        fits = (ways.size_m[i][None] <= room[:, None] + 1e-9).all(axis=-1)
        if not fits.any():
            return None
        # The tightest of a random few: leaves room for what comes.
        waste = room.prod(axis=1)[:, None] - ways.size_m[i].prod(axis=-1)[None]
        pull = -(free[:, [0, 2]] + room / 2.0 - middle) @ ways.lean[i] / size.max()
        score = np.where(fits, waste / waste.max() * (0.3 + rng.random(fits.shape)) + LEAN * pull[:, None], np.inf)
        k, way = np.unravel_index(int(score.argmin()), score.shape)
        width, depth = ways.size_m[i, way]
        low = rng.random(2) < 0.5 * (1.0 - ways.lean[i])
        x = free[k, 0] if low[0] else free[k, 1] - width
        y = free[k, 2] if low[1] else free[k, 3] - depth
        slots[i] = (x, x + width, y, y + depth)
        free = _without(free, slots[i] + gap_m * np.array([-1.0, 1.0, -1.0, 1.0]))
        if not len(free):
            free = np.zeros((1, 4))
    return slots


def _without(free: FloatArray, taken: FloatArray) -> FloatArray:
    # Maximal empty rectangles after one is taken (Jylanki 2010): those it cuts are split, what others hold is dropped.
    x0, x1, y0, y1 = taken
    cut = (free[:, 0] < x1 - 1e-9) & (free[:, 1] > x0 + 1e-9) & (free[:, 2] < y1 - 1e-9) & (free[:, 3] > y0 + 1e-9)
    parts = [free[~cut]]
    for side, value in ((1, x0), (0, x1), (3, y0), (2, y1)):
        part = free[cut].copy()
        part[:, side] = value
        parts.append(part[(part[:, 1] - part[:, 0] > 5e-3) & (part[:, 3] - part[:, 2] > 5e-3)])
    found = np.concatenate(parts)
    found = found[np.lexsort(found.T)]
    found = found[np.concatenate([[True], (found[1:] != found[:-1]).any(axis=1)])] if len(found) else found
    a, b = found[:, None], found[None]
    held = (a[..., 0] >= b[..., 0]) & (a[..., 1] <= b[..., 1]) & (a[..., 2] >= b[..., 2]) & (a[..., 3] <= b[..., 3])
    np.fill_diagonal(held, False)
    kept = found[~held.any(axis=1)]
    size = (kept[:, 1] - kept[:, 0]) * (kept[:, 3] - kept[:, 2])
    return kept[np.argsort(-size, kind="stable")[:MOST_FREE]]
