"""Guillotine partitioning: the place is cut recursively, each part at least as large as its things need.

Which things go to which side, and the axis of each cut, are drawn top-down as if areas were shared out. The least size
of each part follows bottom-up, so that a partition fails only if the whole place is too small (slicing trees, Otten
1982).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from scenec.plan.cases.slots import SlotOptions, ordered_by_bias
from schemas.arrays import FloatArray, IntArray

ASKEW = 0.3  # largest random shift of a cut away from the share of the areas
SQUARE = 0.8  # chance that the longer side is cut


@dataclass(frozen=True)
class SlicingTree:
    """A slicing tree: the slot of member `number`, or two halves one after the other along axis `along`.

    `least_m` (2,) is its least size; `share` of the length goes to the first half if both have room then.
    """

    least_m: FloatArray
    number: int = -1
    along: int = 0
    share: float = 0.0
    halves: tuple[SlicingTree, ...] = ()


def guillotine(box_m: FloatArray, slot_options: SlotOptions, gap_m: float, rng: Generator) -> FloatArray | None:
    """Slots (n, 4) in a box (4,), or None where a partition needs more than the box."""
    n = len(slot_options.least_m)
    area = (slot_options.size_m + gap_m).prod(axis=-1).min(axis=1)
    size = box_m[[1, 3]] - box_m[[0, 2]]
    whole = _cut(slot_options, rng.permutation(n), size, area, gap_m, rng)
    if (whole.least_m > size + 1e-9).any():
        return None
    slots = np.zeros((n, 4))
    waiting = [(whole, box_m)]
    while waiting:
        part, box = waiting.pop()
        if not part.halves:
            slots[part.number] = box
            continue
        low, high = box[2 * part.along], box[2 * part.along + 1]
        least, last = (half.least_m[part.along] for half in part.halves)
        cut = np.clip(low + part.share * (high - low - gap_m), low + least, max(high - last - gap_m, low + least))
        first, second = box.copy(), box.copy()
        first[2 * part.along + 1], second[2 * part.along] = cut, cut + gap_m
        waiting += zip(part.halves, (first, second), strict=True)
    return slots


def _cut(
    slot_options: SlotOptions, members: IntArray, size_m: FloatArray, area_m2: FloatArray, gap_m: float, rng: Generator
) -> SlicingTree:
    # A random partition among some members of about this size (2,).
    if len(members) == 1:
        i = int(members[0])
        tight = (slot_options.size_m[i] / np.maximum(size_m, 1e-9)).max(axis=1)
        return SlicingTree(slot_options.size_m[i, int(tight.argmin())], i)
    along = 0 if (size_m[0] > size_m[1]) == (rng.random() < SQUARE) else 1
    members = ordered_by_bias(slot_options, members, along, rng)
    at = int(rng.integers(max(1, len(members) // 3), len(members) - len(members) // 3 + (len(members) < 3)))
    at = min(max(at, 1), len(members) - 1)
    share = float(area_m2[members[:at]].sum() / area_m2[members].sum())
    share += ASKEW * share * (1.0 - share) * (2.0 * rng.random() - 1.0)
    one, two = size_m.copy(), size_m.copy()
    one[along], two[along] = share * (size_m[along] - gap_m), (1.0 - share) * (size_m[along] - gap_m)
    halves = (
        _cut(slot_options, members[:at], one, area_m2, gap_m, rng),
        _cut(slot_options, members[at:], two, area_m2, gap_m, rng),
    )
    least = np.maximum(halves[0].least_m, halves[1].least_m)
    least[along] = halves[0].least_m[along] + gap_m + halves[1].least_m[along]
    return SlicingTree(least, along=along, share=share, halves=halves)
