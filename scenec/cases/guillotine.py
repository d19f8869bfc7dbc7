"""Guillotine partitioning: the place is cut across again and again, each half as large as what it must hold."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from scenec.cases.slots import Ways, leaning
from scenec.ir import FloatArray

ASKEW = 0.3  # how much chance moves a cut away from the share of the areas
SQUARE = 0.8  # chance that the longer side is cut


def guillotine(box_m: FloatArray, ways: Ways, gap_m: float, rng: Generator) -> FloatArray | None:
    """Slots (n, 4) in a box (4,), or None where a thing does not fit what was cut for it."""
    n = len(ways.least_m)
    area = (ways.size_m + gap_m).prod(axis=-1).min(axis=1)
    slots = np.zeros((n, 4))
    waiting = [(rng.permutation(n), box_m.copy())]
    while waiting:
        members, box = waiting.pop()
        if len(members) == 1:
            i, room = int(members[0]), np.array([box[1] - box[0], box[3] - box[2]])
            if not (ways.size_m[i] <= room + 1e-9).all(axis=-1).any():
                return None
            slots[i] = box
            continue
        along = 0 if (box[1] - box[0] > box[3] - box[2]) == (rng.random() < SQUARE) else 1
        members = leaning(ways, members, along, rng)
        at = int(rng.integers(max(1, len(members) // 3), len(members) - len(members) // 3 + (len(members) < 3)))
        at = min(max(at, 1), len(members) - 1)
        share = float(area[members[:at]].sum() / area[members].sum())
        share += ASKEW * share * (1.0 - share) * (2.0 * rng.random() - 1.0)
        low, high = float(box[2 * along]), float(box[2 * along + 1])
        cut = low + share * (high - low - gap_m)
        first, second = box.copy(), box.copy()
        first[2 * along + 1], second[2 * along] = cut, cut + gap_m
        waiting += [(members[:at], first), (members[at:], second)]
    return slots
