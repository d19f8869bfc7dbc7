"""Random layouts by rejection, many at once: the family closest to the uniform distribution.

With one try per thing this is plain rejection: accepted layouts have the exact conditional distribution (of footprints
with disjoint bounding rectangles). With more tries, things are placed one after another, the largest first (random
sequential addition), in crowded scenes at yaws with a small bounding rectangle.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np
from numpy.random import Generator

from scenec.plan.cases.apart import apart
from scenec.plan.cases.pool_model import Layouts, Member, MemberBatch, PoolModel, around, joined
from scenec.relations.table import RELATIONS
from schemas.arrays import FloatArray, IntArray

LOT = 4096  # layouts or candidates evaluated at once
MOST_LOTS = 48
SHARE_M2 = 0.38  # share of a place covered by rectangles above which yaws are restricted
CANDIDATE_TRIES = 96
REJECTION_ROUNDS = 4


def rejection_layouts(pool: PoolModel, layout_count: int, rng: Generator, tries: int) -> Layouts:
    """Up to `layout_count` random layouts whose rectangles are valid, each thing drawn `tries` times."""
    order = largest_first(pool)
    allowed = [_compact_options(member, _yaw_freedom(pool)) for member in pool.members]
    lots_found: list[Layouts] = []
    count, lots = 0, 0
    lot = LOT if tries == 1 else max(64, LOT // tries)
    while count < layout_count and lots < MOST_LOTS:
        part = _lot(pool, order, allowed, lot, rng, tries)
        lots += 1
        if len(part):
            lots_found.append(part)
            count += len(part)
        if lots == 4 and count * MOST_LOTS / lots < layout_count / 8:
            break
    return _first(pool, lots_found, layout_count)


def _first(pool: PoolModel, lots_found: list[Layouts], layout_count: int) -> Layouts:
    n = len(pool.members)
    none = Layouts(np.zeros((0, n), dtype=np.int64), np.zeros((0, n, 2)), np.zeros((0, n, 4)), [])
    if not lots_found:
        return none
    whole = joined(lots_found)
    return whole.take(np.arange(min(layout_count, len(whole))))


def largest_first(pool: PoolModel) -> list[int]:
    """Indices of the members: those with fixed poses first, then the largest."""
    return sorted(
        range(len(pool.members)),
        key=lambda i: (not pool.members[i].pinned, -float(pool.members[i].footprint_m2.min())),
    )


def _yaw_freedom(pool: PoolModel) -> float:
    # 1 where any yaw may be drawn, towards 0 as rectangles at random yaws would cover more than SHARE_M2 of the area.
    free = [m for m in pool.members if not m.pinned]
    if not free:
        return 1.0
    gap = pool.clearance_m
    room = float(np.prod(_size(free[0])))
    least = sum((float(np.sqrt(m.footprint_m2.min())) + gap) ** 2 for m in free) / max(room, 1e-9)
    usual = sum((float(np.sqrt(m.footprint_m2.mean())) + gap) ** 2 for m in free) / max(room, 1e-9)
    return float(np.clip((SHARE_M2 - least) / max(usual - least, 1e-9), 0.0, 1.0))


def _size(member: Member) -> FloatArray:
    x0, x1, y0, y1 = next(iter(member.room.values())).box_m
    return np.array([x1 - x0, y1 - y0])


def _compact_options(member: Member, yaw_freedom: float) -> IntArray:
    # Options whose rectangle is small enough; all of them when there is room.
    area = member.footprint_m2
    if member.pinned or yaw_freedom >= 1.0:
        return np.arange(member.grid)
    area = area[: member.grid]
    stance = member.stance[: member.grid]
    least, most = np.empty(len(area)), np.empty(len(area))
    for s in set(stance.tolist()):
        least[stance == s], most[stance == s] = area[stance == s].min(), area[stance == s].max()
    return np.flatnonzero(area <= least + yaw_freedom * (most - least) + 1e-12)


def _lot(
    pool: PoolModel, order: Sequence[int], allowed: list[IntArray], count: int, rng: Generator, tries: int
) -> Layouts:
    n = len(pool.members)
    option = np.zeros((count, n), dtype=np.int64)
    origin, rect = np.zeros((count, n, 2)), np.zeros((count, n, 4))
    placed: list[int] = []
    for i in order:
        pending = np.arange(len(option))
        seated = np.zeros(len(option), dtype=bool)
        rounds = 1 if tries == 1 else REJECTION_ROUNDS
        for _ in range(rounds):
            step = max(1, ceil(2 * LOT * CANDIDATE_TRIES / max(tries * (len(placed) + 1), 1)))
            for begin in range(0, len(pending), step):
                rows = pending[begin : begin + step]
                picked, at, around_m, good = _candidates(
                    pool, i, placed, (option, origin, rect), rows, allowed, rng, tries
                )
                first = good.argmax(axis=1)
                won = good[np.arange(len(rows)), first]
                to, pick = rows[won], (np.flatnonzero(won), first[won])
                option[to, i], origin[to, i], rect[to, i] = picked[pick], at[pick], around_m[pick]
                seated[to] = True
            pending = pending[~seated[pending]]
            if not len(pending):
                break
        option, origin, rect = option[seated], origin[seated], rect[seated]
        placed.append(i)
        if not len(option):
            break
    return Layouts(option, origin, rect, ["seeded"] * len(option))


def _candidates(
    pool: PoolModel,
    i: int,
    placed: list[int],
    state: tuple[IntArray, FloatArray, FloatArray],
    rows: IntArray,
    allowed: list[IntArray],
    rng: Generator,
    tries: int,
) -> tuple[IntArray, FloatArray, FloatArray, np.ndarray]:
    # Options, origins, rectangles (r, tries, ...) drawn for member i in some layouts, and which of them are good.
    option, origin, rect = state
    member = pool.members[i]
    picked = allowed[i][rng.integers(len(allowed[i]), size=(len(rows), tries))]
    at = sample_origins(member, picked, rng)
    around_m = around(member, picked.ravel(), at.reshape(-1, 2)).reshape(len(rows), tries, 4)
    good = inside(member, picked, at, around_m)
    level = pool.level
    for j in placed:
        clear = apart(around_m, rect[rows, j][:, None], pool.least_gap_m[i, j])
        if not level and pool.least_gap_m[i, j] <= pool.clearance_m:
            other = pool.members[j]
            low = member.base_m[picked] + float(member.thing.place.origin_P_m[2])
            base = (other.base_m[option[rows, j]] + float(other.thing.place.origin_P_m[2]))[:, None]
            top = base + other.height_m[option[rows, j]][:, None]
            clear |= (low >= top - 1e-9) | (low + member.height_m[picked] <= base + 1e-9)
        good &= clear
    known = {*placed, i}
    for rule in pool.rules:
        meaning = RELATIONS[rule.kind]
        numbers = [pool.index[name] for name in rule.things]
        there = [n for n, k in enumerate(numbers) if k in known]
        if i not in numbers or len(there) < (2 if meaning.constrains_early else len(numbers)):
            continue
        numbers = [numbers[n] for n in there]
        shape = (len(rows), tries)
        batch = MemberBatch(
            [pool.members[k] for k in numbers],
            there,
            [picked if k == i else np.broadcast_to(option[rows, k][:, None], shape) for k in numbers],
            [around_m if k == i else np.broadcast_to(rect[rows, k][:, None], (*shape, 4)) for k in numbers],
            [at if k == i else np.broadcast_to(origin[rows, k][:, None], (*shape, 2)) for k in numbers],
        )
        good &= meaning.may_hold(rule, batch)
    return picked, at, around_m, good


def sample_origins(member: Member, option: IntArray, rng: Generator) -> FloatArray:
    """Origins (..., 2) in P for options (...): fixed poses, or uniform over the box of the place and the range."""
    share = rng.random((*option.shape, 2))
    if member.pinned:
        return member.at_m[option]
    box = np.stack([member.room[s].box_m if s in member.room else np.zeros(4) for s in range(len(member.shapes))])
    place, reach = box[member.stance[option]], member.extent_m[option]
    low = np.maximum(place[..., [0, 2]] + reach[..., [0, 2]], member.origin_m[[0, 2]])
    high = np.minimum(place[..., [1, 3]] - reach[..., [1, 3]], member.origin_m[[1, 3]])
    return low + share * (high - low)


def inside(member: Member, option: IntArray, origin_m: FloatArray, rect_m: FloatArray) -> np.ndarray:
    """Whether candidates (...) lie in the place and their origins in range; fixed poses are accepted as authored."""
    if member.pinned:
        return np.ones(option.shape, dtype=bool)
    good = np.ones(option.size, dtype=bool)
    flat, stance = rect_m.reshape(-1, 4), member.stance[option].ravel()
    for s, room in member.room.items():
        rows = np.flatnonzero(stance == s) if len(member.room) > 1 else slice(None)
        good[rows] = room.holds(flat[rows])
    x, y = origin_m[..., 0], origin_m[..., 1]
    x0, x1, y0, y1 = member.origin_m
    within = (x >= x0 - 1e-9) & (x <= x1 + 1e-9) & (y >= y0 - 1e-9) & (y <= y1 + 1e-9)
    return good.reshape(option.shape) & within
