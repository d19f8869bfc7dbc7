"""Structured layouts: a family partitions the place into one slot per thing; here things are placed in these slots.

Things lie in their slots at quarter turns (or the yaw of least area in each). Slots are exchanged while directional
relations are violated, and further afterwards, so that one partition gives many arrangements. Frame P, metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from scenec.plan.cases.apart import clashes
from scenec.plan.cases.pool_model import GRAIN_M, Layouts, MemberBatch, PoolModel, around
from scenec.plan.cases.rejection import inside
from scenec.relations.table import RELATIONS
from schemas.arrays import BoolArray, FloatArray, IntArray

WAYS = 4  # options per thing at least: two for each stance
SWAY = 0.4  # standard deviation of the noise on the order by bias
REPAIRS = 2000  # exchanges tried while relations are violated
MIXING = 3  # exchanges tried for each thing once they hold


@dataclass(frozen=True)
class SlotOptions:
    """`option` (n, w): options of small area of each thing; `size_m` (n, w, 2): sizes of their bounding rectangles.

    `bias` (n, 2) is the side that directional relations favour: negative low x or y, positive high, 0 none.
    """

    option: IntArray
    size_m: FloatArray
    bias: FloatArray

    @property
    def least_m(self) -> FloatArray:
        """(n, 2) size of the first option of each thing, that of least depth."""
        return self.size_m[:, 0]


def slot_options_of(pool: PoolModel) -> SlotOptions:
    """For each member the options of least area in each quarter turn, the least deep first."""
    options, sizes = [], []
    width = max(WAYS, *(2 * len(set(member.stance[: member.grid].tolist())) for member in pool.members))
    for member in pool.members:
        area = member.footprint_m2[: member.grid]
        chosen: list[int] = []
        for stance in sorted(set(member.stance[: member.grid].tolist())):
            for quarter in (0, 1):
                of = np.floor((member.yaw_rad[: member.grid] + np.pi / 4) / (np.pi / 2)).astype(int) % 2 == quarter
                rows = np.flatnonzero(of & (member.stance[: member.grid] == stance))
                if len(rows):
                    chosen.append(int(rows[area[rows].argmin()]))
        chosen = (chosen * width)[:width]
        reach = member.extent_m[chosen] + GRAIN_M
        size = np.stack([reach[:, 0] + reach[:, 1], reach[:, 2] + reach[:, 3]], axis=1)
        order = np.argsort(size[:, 1], kind="stable")
        options.append(np.array(chosen)[order])
        sizes.append(size[order])
    bias = np.zeros((len(options), 2))
    for first, second, along in _axial(pool)[:, :3].astype(np.int64).tolist():
        bias[first, along] -= 1.0
        bias[second, along] += 1.0
    return SlotOptions(np.array(options), np.array(sizes), bias)


def ordered_by_bias(slot_options: SlotOptions, members: IntArray, along: int, rng: Generator) -> IntArray:
    """Members in a random order in which those with a bias to low values tend to come first."""
    return members[
        np.argsort(slot_options.bias[members, along] + SWAY * rng.standard_normal(len(members)), kind="stable")
    ]


def layouts_in_slots(
    pool: PoolModel, slot_options: SlotOptions, slots_m: FloatArray, family: str, rng: Generator
) -> Layouts:
    """Valid layouts from slots (l, n, 4): slot i belongs to member i at first and must fit it."""
    slots = slots_m.copy()
    _exchange(pool, slot_options, slots, rng)
    count, n = slots.shape[:2]
    option, origin, rect = np.zeros((count, n), dtype=np.int64), np.zeros((count, n, 2)), np.zeros((count, n, 4))
    good = np.ones(count, dtype=bool)
    for i, member in enumerate(pool.members):
        if member.pinned:
            option[:, i], origin[:, i] = 0, member.at_m[0]
            rect[:, i] = around(member, option[:, i], origin[:, i])
            continue
        fits = _fits(slot_options.size_m[i][None], _size(slots[:, i])[:, None])
        option[:, i] = slot_options.option[i][(fits * (1.0 + rng.random(fits.shape))).argmax(axis=1)]
        reach = member.extent_m[option[:, i]]
        low = np.maximum(slots[:, i][:, [0, 2]] + reach[:, [0, 2]], member.origin_m[[0, 2]])
        high = np.minimum(slots[:, i][:, [1, 3]] - reach[:, [1, 3]], member.origin_m[[1, 3]])
        good &= fits.any(axis=1) & (low <= high + 1e-9).all(axis=1)
        origin[:, i] = low + rng.random((count, 2)) * np.maximum(high - low, 0.0)
        rect[:, i] = around(member, option[:, i], origin[:, i])
        good &= inside(member, option[:, i], origin[:, i], rect[:, i])
    layouts = Layouts(option, origin, rect, [family] * count)
    good &= np.logical_not(np.asarray(clashes(pool, layouts)).any(axis=(1, 2)))
    for rule in pool.rules:
        numbers = [pool.index[name] for name in rule.things]
        batch = MemberBatch(
            [pool.members[k] for k in numbers],
            range(len(numbers)),
            [option[:, k] for k in numbers],
            [rect[:, k] for k in numbers],
            [origin[:, k] for k in numbers],
        )
        good &= RELATIONS[rule.kind].may_hold(rule, batch)
    return layouts.take(good)


def _exchange(pool: PoolModel, slot_options: SlotOptions, slots: FloatArray, rng: Generator) -> None:
    # Exchanges slots in place: first those of violated directional relations, then any that violate none.
    count, n = slots.shape[:2]
    rules = _axial(pool)
    is_free = np.array([not member.pinned for member in pool.members])
    free = np.flatnonzero(is_free)
    if len(free) < 2 or not count:
        return
    rows = np.arange(count)
    seat = np.tile(np.arange(n), (count, 1))  # the slot of each member, by its number at first
    fits = np.asarray(
        _fits(slot_options.size_m[:, None], _size(slots)[:, None, :, None]).any(axis=-1)
    )  # (l, member, slot)
    broken = _broken(slots, seat, rules)
    cost = broken.sum(axis=1)
    for step in range((REPAIRS if len(rules) else 0) + MIXING * len(free)):
        i, j = free[rng.integers(len(free), size=(2, count))]
        if len(rules) and step < REPAIRS:
            if not cost.any():
                continue
            rng.random(broken.shape)  # unused: it keeps the plans of earlier versions
            pick = rng.random(broken.shape) * (broken > 0.0)
            ends = rules[pick.argmax(axis=1), rng.integers(2, size=count)].astype(np.int64)
            i = np.where((cost > 0.0) & is_free[ends], ends, i)
        one, two = seat[rows, i], seat[rows, j]
        may = (i != j) & fits[rows, i, two] & fits[rows, j, one]
        if not may.any():
            continue
        trial = seat.copy()
        trial[rows, i], trial[rows, j] = two, one
        then = _broken(slots, trial, rules)
        now = then.sum(axis=1)
        may &= now <= cost + 1e-12
        seat[may], broken[may], cost[may] = trial[may], then[may], now[may]
    slots[:] = slots[rows[:, None], seat]


def _axial(pool: PoolModel) -> FloatArray:
    # (r, 4) rows of `scenec.plan.cases.rectangles.AxisOrder`.
    return np.array(pool.axis_orders).reshape(-1, 4)


def _broken(slots: FloatArray, seat: IntArray, rules: FloatArray) -> FloatArray:
    # (l, r) violation of each relation with members in these slots (l, n).
    first, second, along = rules[:, :3].astype(np.int64).T
    rows = np.arange(len(slots))[:, None]
    ends, begins = slots[rows, seat[:, first], 2 * along + 1], slots[rows, seat[:, second], 2 * along]
    return np.maximum(ends + rules[:, 3] - begins, 0.0)


def _fits(size_m: FloatArray, room_m: FloatArray) -> BoolArray:
    return np.asarray((size_m <= room_m + 1e-9).all(axis=-1))


def _size(rect_m: FloatArray) -> FloatArray:
    return np.stack([rect_m[..., 1] - rect_m[..., 0], rect_m[..., 3] - rect_m[..., 2]], axis=-1)
