"""Quality of a case from 0 to 1: area, shape and gaps of its cells, less its pinned things (paper: case selection)."""

from __future__ import annotations

import numpy as np

from scenec.plan.cases.pool_model import PoolModel
from schemas.arrays import FloatArray
from schemas.scene.runtime_plan import PlanCase

SHORT_EDGE_M = 0.02  # room beside a footprint that counts as plenty
GAP_M = 0.02
FREE_YAW_RAD = np.pi


def quality(pool: PoolModel, case: PlanCase) -> float:
    """Between 0 (everything pinned) and 1, the mean of six terms between 0 and 1.

    Share of the place that cells cover; least area and mean aspect of cells; least short edge and mean yaw freedom
    beyond what the footprint takes; least gap. Pinned things (point fallback) count against it in each.
    """
    cells = np.array(case.cells_um, dtype=np.float64) * 1e-6
    size = np.stack([cells[:, 1] - cells[:, 0], cells[:, 3] - cells[:, 2]], axis=1)
    place = next(iter(pool.members[0].room.values())).box_m
    room = float((place[1] - place[0]) * (place[3] - place[2]))
    least = np.array([m.footprint_m2.min() for m in pool.members])
    area = size.prod(axis=1)
    turn = np.array([sum(b - a for a, b in yaws) * 1e-6 for yaws in case.yaws_urad])
    pinned = (turn == 0.0) & np.array([o is not None and o[0] == o[1] and o[2] == o[3] for o in case.origins_um])
    aspect = size.min(axis=1) / np.maximum(size.max(axis=1), 1e-9)
    spare = np.sqrt(area) - np.sqrt(least)
    terms = (
        min(1.0, float(area.sum()) / max(room, 1e-9)),
        float(np.clip(1.0 - (least / np.maximum(area, 1e-12)).max(), 0.0, 1.0)),
        float(aspect.mean()),
        float(np.clip(spare.min() / SHORT_EDGE_M, 0.0, 1.0)),
        float(np.minimum(turn / FREE_YAW_RAD, 1.0).mean()),
        float(np.clip(_least_gap(cells) / GAP_M, 0.0, 1.0)),
    )
    return round(float(np.mean(terms)) * (1.0 - float(pinned.mean())), 4)


def _least_gap(cells_m: FloatArray) -> float:
    if len(cells_m) < 2:
        return GAP_M
    one, two = cells_m[:, None], cells_m[None]
    dx = np.maximum(two[..., 0] - one[..., 1], one[..., 0] - two[..., 1])
    dy = np.maximum(two[..., 2] - one[..., 3], one[..., 2] - two[..., 3])
    gap = np.maximum(dx, dy)
    np.fill_diagonal(gap, np.inf)
    return float(gap.min())
