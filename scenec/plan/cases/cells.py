"""Converts layouts to cases: cells grown, clipped by relations, with the yaw intervals at which footprints fit them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from scenec.plan.cases.apart import clashes
from scenec.plan.cases.clip_cells import Freedom, clip_cells, freedom_of
from scenec.plan.cases.grow_cells import grow_cells
from scenec.plan.cases.pool_model import GRAIN_M, Layouts, Member, PoolModel
from scenec.plan.cases.yaws import fitting, intervals
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.scene.geometry import ReachRing
from schemas.scene.runtime_plan import Bounds_um, Interval_urad, PlanCase

SPARE_M = 3 * GRAIN_M  # margin around pinned footprints, so that rounding never empties their cells


@dataclass(frozen=True)
class GrownCells:
    """Layouts with cells `rect_m` (l, n, 4), which things are `free` (l, n) to move, and their freedom."""

    pool: PoolModel
    layouts: Layouts
    free: BoolArray
    rect_m: FloatArray
    freedom: Freedom


def cases_of(
    pool: PoolModel,
    layouts: Layouts,
    rng: Generator,
    reach: ReachRing | None = None,
    base_P_m: FloatArray | None = None,
    sure: int = 0,
) -> list[PlanCase]:
    """A case for each layout that satisfies its relations, in order; the first `sure` are known to be valid and are
    kept where no other is.

    A thing that cannot have a cell of its own (it meets another's rectangle, or fills a round place) is pinned at its
    pose in the layout; such a layout must be known to be valid.
    """
    cells = grown_cells(pool, layouts, rng)
    is_kept = clip_cells(pool, layouts, cells.freedom, reach, np.zeros(2) if base_P_m is None else base_P_m)
    # A relation that a layout just meets leaves no slack, and none is needed where all is pinned.
    if not is_kept.any():
        is_kept[:sure] = True
    return plan_cases(cells, is_kept)


def grown_cells(pool: PoolModel, layouts: Layouts, rng: Generator) -> GrownCells:
    """The layouts with cells as large as possible, before relations limit poses inside."""
    free = _free(pool, layouts)
    rect = grow_cells(pool, layouts, free, rng)
    return GrownCells(pool, layouts, free, rect, freedom_of(pool, layouts, rect, free))


def plan_cases(cells: GrownCells, is_kept: BoolArray) -> list[PlanCase]:
    """A case for each of the kept layouts (l,), with the poses that its freedom allows."""
    pool, layouts, free = cells.pool, cells.layouts, cells.free
    columns = [_cells(m, i, layouts, cells.rect_m, cells.freedom, free) for i, m in enumerate(pool.members)]
    return [
        PlanCase(
            family="point" if not free[k].any() else layouts.family[k],  # pyright: ignore[reportArgumentType]
            cells_um=tuple(column[k][0] for column in columns),
            origins_um=tuple(column[k][1] for column in columns),
            yaws_urad=tuple(column[k][2] for column in columns),
            stances=tuple(int(m.stance[layouts.option[k, i]]) for i, m in enumerate(pool.members)),
            base_um=tuple(_um(float(m.base_m[layouts.option[k, i]])) for i, m in enumerate(pool.members)),
        )
        for k in np.flatnonzero(is_kept).tolist()
    ]


def _free(pool: PoolModel, layouts: Layouts) -> BoolArray:
    # (l, n) things that may have a cell of their own.
    free = np.logical_not(np.asarray(clashes(pool, layouts)).any(axis=2))
    for i, member in enumerate(pool.members):
        stance = member.stance[layouts.option[:, i]]
        for s, room in member.room.items():
            rows = stance == s
            free[rows, i] &= room.holds(layouts.rect_m[rows, i])
        free[:, i] &= (not member.pinned) & (member.base_m[layouts.option[:, i]] == 0.0)
    return free


def _cells(
    member: Member, i: int, layouts: Layouts, rect_m: FloatArray, freedom: Freedom, free: BoolArray
) -> list[tuple[Bounds_um, Bounds_um | None, tuple[Interval_urad, ...]]]:
    # (cell, origins, yaws) of one member in each layout, in A.
    option, shift = layouts.option[:, i], np.asarray(member.thing.place.origin_P_m[:2], dtype=np.float64)
    stance, yaw = member.stance[option], member.yaw_rad[option]
    turns_left = freedom.clipped_turns()[:, i]
    clipped = np.any(turns_left < freedom.turn_rad[:, i], axis=1)
    cell = _inward(rect_m[:, i] - shift[[0, 0, 1, 1]])
    box = _inward(freedom.clipped_boxes(layouts)[:, i] - shift[[0, 0, 1, 1]])
    at = np.round((layouts.origin_m[:, i] - shift) / GRAIN_M).astype(np.int64)
    for low, high, axis in ((0, 1, 0), (2, 3, 1)):
        crossed = box[:, low] > box[:, high]
        box[crossed, low] = box[crossed, high] = at[crossed, axis]
    limited = np.any(np.isfinite(freedom.step_m[:, i]), axis=1)
    ranged = bool(np.isfinite(member.origin_m).any())
    fits = {
        s: fitting(turns, cell * GRAIN_M + shift[[0, 0, 1, 1]], box * GRAIN_M + shift[[0, 0, 1, 1]])
        for s, turns in member.yaw_extents.items()
    }
    out = np.round(member.overhang_m / GRAIN_M + 0.499).astype(np.int64)
    columns = []
    for k in range(len(layouts)):
        s, turned = int(stance[k]), round(float(yaw[k]) / GRAIN_M)
        if not free[k, i]:
            columns.append((_outward(layouts.rect_m[k, i] - shift[[0, 0, 1, 1]]), _point(at[k]), ((turned, turned),)))
            continue
        low, high = member.thing.domain.yaw_rad
        if clipped[k]:
            low, high = float(yaw[k] - turns_left[k, 0]), float(yaw[k] + turns_left[k, 1])
        runs = intervals(member.yaw_extents[s], fits[s][k], (low, high))
        yaws = tuple((round(a / GRAIN_M), round(b / GRAIN_M)) for a, b in runs) or ((turned, turned),)
        x0, x1, y0, y1 = (int(v) for v in cell[k] + np.array([1, -1, 1, -1]) * out[s])
        origins = tuple(int(v) for v in box[k]) if ranged or limited[k] else None
        if yaws == ((turned, turned),) and origins is not None:
            px, _, py, _ = _point(at[k])
            origins = (min(origins[0], px), max(origins[1], px), min(origins[2], py), max(origins[3], py))
        columns.append(((x0, x1, y0, y1), origins, yaws))
    return columns


def _inward(rect_m: FloatArray) -> IntArray:
    # Rectangles (m, 4) on whole micrometres, never larger.
    low = np.ceil(rect_m[:, [0, 2]] / GRAIN_M - 1e-3)
    high = np.floor(rect_m[:, [1, 3]] / GRAIN_M + 1e-3)
    return np.stack([low[:, 0], high[:, 0], low[:, 1], high[:, 1]], axis=1).astype(np.int64)


def _outward(rect_m: FloatArray) -> Bounds_um:
    # A rectangle (4,) on whole micrometres with a margin of SPARE_M.
    low = np.floor((rect_m[[0, 2]] - SPARE_M) / GRAIN_M)
    high = np.ceil((rect_m[[1, 3]] + SPARE_M) / GRAIN_M)
    return int(low[0]), int(high[0]), int(low[1]), int(high[1])


def _point(at_um: IntArray) -> Bounds_um:
    x, y = (int(v) for v in at_um)
    return x, x, y, y


def _um(length_m: float) -> int:
    return round(length_m / GRAIN_M)
