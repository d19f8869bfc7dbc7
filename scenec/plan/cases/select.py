"""Selects the cases of a pool: none below a quality floor, then quality balanced against distance (paper:
selection)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scenec.plan.cases.pool_model import PoolModel
from schemas.arrays import FloatArray, IntArray
from schemas.scene.runtime_plan import PlanCase

FLOOR = 0.35  # of the best quality
FEW = 16  # things up to which coverage counts most; with more, yaw freedom is scarce and quality counts more
BALANCE_OF_FEW, BALANCE = 0.95, 0.7  # weight of distance, in diagonals of the support, against quality from 0 to 1
TOPOLOGY = 0.25  # weight of a different order of things in the distance


def selected(pool: PoolModel, cases: Sequence[PlanCase], case_count: int) -> list[PlanCase]:
    """At most `case_count` cases: the best one, then repeatedly the one with the best weighted sum of quality and
    distance to the cases already chosen. The order of the given cases does not matter except between equals."""
    if not cases:
        return []
    best = max(case.quality for case in cases)
    good = [case for case in cases if case.quality >= FLOOR * best]
    if len(good) <= case_count:
        return good
    centre = _centres(pool, good)
    order = _topology(centre)
    value = np.array([case.quality for case in good])
    chosen = [int(value.argmax())]
    balance = BALANCE_OF_FEW if len(pool.members) <= FEW else BALANCE
    far = np.full(len(good), np.inf)
    while len(chosen) < case_count:
        last = chosen[-1]
        step = centre - centre[last]
        moved = np.sqrt(np.einsum("cnd,cnd->cn", step, step)).mean(axis=1)
        far = np.minimum(far, moved + TOPOLOGY * (order != order[last]).mean(axis=1))
        score = balance * far + (1.0 - balance) * value
        score[chosen] = -np.inf
        chosen.append(int(score.argmax()))
    return [good[k] for k in sorted(chosen)]


def _centres(pool: PoolModel, cases: Sequence[PlanCase]) -> FloatArray:
    # (c, n, 2) middles of cells in diagonals of the support.
    x0, x1, y0, y1 = next(iter(pool.members[0].room.values())).box_m
    cells = np.array([case.cells_um for case in cases], dtype=np.float64) * 1e-6
    middle = np.stack([cells[..., :2].mean(axis=-1), cells[..., 2:].mean(axis=-1)], axis=-1)
    return middle / max(float(np.hypot(x1 - x0, y1 - y0)), 1e-9)


def _topology(centre: FloatArray) -> IntArray:
    # (c, 2 n) the order of things from left to right and from front to back: how the layout is partitioned.
    return np.argsort(centre, axis=1, kind="stable").reshape(len(centre), -1)
