"""Clips the freedom of cells until relations hold that disjoint rectangles alone do not guarantee.

Each thing may move from its seed pose so far that neither its origin nor, by turning, any point of its footprint moves
farther than a step; that bounds the change of the value of a relation (a distance of two sets changes by at most the
sum of their motions). Frame P, metres, radians.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from scenec.plan.cases.motions import ROUND_M, ROUNDING, Motions, RelativePoses, unevenness
from scenec.plan.cases.pool_model import Layouts, PoolModel, floor_of
from scenec.relations.table import RELATIONS
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import ReachRing, SceneRelation

CLIP_STEPS_M = (
    np.inf,
    0.4,
    0.25,
    0.16,
    0.11,
    0.08,
    0.06,
    0.045,
    0.033,
    0.024,
    0.017,
    0.012,
    0.008,
    0.005,
    0.003,
    0.002,
    0.001,
    0.0,
)


@dataclass
class Freedom:
    """Freedom of motion of things in layouts. By cells: `origin_m` (l, n, 4) boxes and `turn_rad` (l, n, 2) down and up
    from the yaw; `radius_m` (l, n) of footprints about their origins. By relations: at most `step_m` (l, n, 2) along x
    and y, and turns that move no point of the footprint farther than `spin_m` (l, n)."""

    origin_m: FloatArray
    turn_rad: FloatArray
    radius_m: FloatArray
    step_m: FloatArray
    spin_m: FloatArray

    def clipped_boxes(self, layouts: Layouts) -> FloatArray:
        """(l, n, 4) boxes of the origins after clipping."""
        at = layouts.origin_m[..., [0, 0, 1, 1]]
        step = self.step_m[..., [0, 0, 1, 1]]
        return at + np.clip(self.origin_m - at, -step, step)

    def clipped_turns(self) -> FloatArray:
        """(l, n, 2) turns down and up after clipping."""
        return np.minimum(self.turn_rad, (self.spin_m / np.maximum(self.radius_m, 1e-9))[..., None])


def freedom_of(pool: PoolModel, layouts: Layouts, rect_m: FloatArray, free: BoolArray) -> Freedom:
    """The freedom that cells allow to free things; none for the others."""
    count, n = layouts.option.shape
    at = layouts.origin_m[..., [0, 0, 1, 1]]
    origin, turn, radius = at.copy(), np.zeros((count, n, 2)), np.zeros((count, n))
    for i, member in enumerate(pool.members):
        radius[:, i] = np.array([shape.radius_m for shape in member.shapes])[member.stance[layouts.option[:, i]]]
        if member.pinned:
            continue
        yaw = member.yaw_rad[layouts.option[:, i]]
        low, high = member.thing.domain.yaw_rad
        whole = high - low > 2.0 * np.pi - 1e-9
        spans = np.stack([np.full(count, np.pi), np.full(count, np.pi)] if whole else [yaw - low, high - yaw], axis=1)
        stance = member.stance[layouts.option[:, i]]
        least = np.stack([t.extent_m.min(axis=0) for t in (member.yaw_extents[s] for s in sorted(member.yaw_extents))])
        least = least[np.searchsorted(sorted(member.yaw_extents), stance)]
        sign = np.array([1.0, -1.0, 1.0, -1.0])
        box = rect_m[:, i] + sign * least
        box[:, [0, 2]] = np.maximum(box[:, [0, 2]], member.origin_m[[0, 2]])
        box[:, [1, 3]] = np.minimum(box[:, [1, 3]], member.origin_m[[1, 3]])
        origin[:, i] = np.where(free[:, i, None], box, at[:, i])
        turn[:, i] = np.where(free[:, i, None], spans, 0.0)
    return Freedom(origin, turn, radius, np.full((count, n, 2), np.inf), np.full((count, n), np.inf))


def clip_cells(
    pool: PoolModel, layouts: Layouts, freedom: Freedom, reach: ReachRing | None, base_P_m: FloatArray
) -> BoolArray:
    """Shortens steps until every relation and the reach (base (2,) in P) hold for all remaining poses.

    Returns which layouts (l,) can be kept: in the others some relation fails even at the seed pose.
    """
    is_kept = np.ones(len(layouts), dtype=bool)
    for rule in pool.rules:
        meaning, numbers = RELATIONS[rule.kind], [pool.index[name] for name in rule.things]
        if meaning.kept_by_rectangles(rule):
            continue
        uneven = [max(map(unevenness, pool.members[i].shapes)) > ROUND_M for i in numbers]
        spins = [i for k, i in enumerate(numbers) if meaning.turns_matter(rule, k, uneven[k])]
        value = meaning.value(rule, _motions(pool, layouts, freedom, numbers))
        test = partial(_holds, pool, rule, layouts, freedom, numbers, value)
        is_kept &= _lower(freedom, numbers, meaning.clip_axes(rule), spins, test)
    if reach is not None:
        for name in reach.members:
            if name in pool.index:
                i = pool.index[name]
                is_kept &= _lower(
                    freedom, [i], slice(None), [], partial(_reached, layouts, freedom, i, reach, base_P_m)
                )
    return is_kept


def _lower(
    freedom: Freedom, numbers: list[int], axes: slice, spins: list[int], holds: Callable[[], BoolArray]
) -> BoolArray:
    # Sets the largest of CLIP_STEPS_M with which the test holds, row by row; returns whether there is any.
    steps, turns = freedom.step_m[:, numbers].copy(), freedom.spin_m[:, spins].copy()
    best = np.full(len(steps), -1.0)
    for step in CLIP_STEPS_M:
        limited = steps.copy()
        limited[:, :, axes] = np.minimum(steps[:, :, axes], step)
        freedom.step_m[:, numbers] = limited
        freedom.spin_m[:, spins] = np.minimum(turns, step)
        best = np.where((best < 0.0) & holds(), step, best)
        if (best >= 0.0).all():
            break
    steps[:, :, axes] = np.minimum(steps[:, :, axes], np.maximum(best, 0.0)[:, None, None])
    freedom.step_m[:, numbers] = steps
    freedom.spin_m[:, spins] = np.minimum(turns, np.maximum(best, 0.0)[:, None])
    return best >= 0.0


def shift_of(pool: PoolModel, layouts: Layouts, freedom: Freedom, i: int) -> tuple[FloatArray, FloatArray]:
    """(l,) largest shift of the origin, and of any point of the footprint, from the layout, in P."""
    box, at = freedom.clipped_boxes(layouts)[:, i], layouts.origin_m[:, i]
    dx = np.maximum(at[:, 0] - box[:, 0], box[:, 1] - at[:, 0])
    dy = np.maximum(at[:, 1] - box[:, 2], box[:, 3] - at[:, 1])
    origin = np.hypot(dx, dy)
    member = pool.members[i]
    stance = member.stance[layouts.option[:, i]]
    uneven = np.array([unevenness(shape) for shape in member.shapes])[stance]
    turn = np.minimum(freedom.clipped_turns()[:, i].max(axis=1), np.pi)
    return origin, origin + np.minimum(2.0 * freedom.radius_m[:, i] * np.sin(turn / 2.0), uneven)


def _motions(pool: PoolModel, layouts: Layouts, freedom: Freedom, numbers: list[int]) -> Motions:
    # The members' poses in P and their freedom as it is now.
    turns = freedom.clipped_turns().max(axis=2)
    poses = []
    for i in numbers:
        member, option = pool.members[i], layouts.option[:, i]
        at, yaw, stance = layouts.origin_m[:, i], member.yaw_rad[option], member.stance[option]
        shifts = shift_of(pool, layouts, freedom, i)
        poses.append(RelativePoses(at, yaw, stance, floor_of(member, option), *shifts, turns[:, i], member.shapes))
    boxes = freedom.clipped_boxes(layouts)[:, numbers]
    return Motions(tuple(poses), np.zeros(len(layouts)), ROUNDING, ROUNDING / 2, boxes)


def _holds(
    pool: PoolModel, rule: SceneRelation, layouts: Layouts, freedom: Freedom, numbers: list[int], value: FloatArray
) -> BoolArray:
    return RELATIONS[rule.kind].holds_throughout(rule, _motions(pool, layouts, freedom, numbers), value)


def _reached(layouts: Layouts, freedom: Freedom, i: int, reach: ReachRing, base_P_m: FloatArray) -> BoolArray:
    box = freedom.clipped_boxes(layouts)[:, i]
    far_x = np.maximum(np.abs(box[:, 0] - base_P_m[0]), np.abs(box[:, 1] - base_P_m[0]))
    far_y = np.maximum(np.abs(box[:, 2] - base_P_m[1]), np.abs(box[:, 3] - base_P_m[1]))
    near_x = np.maximum(np.maximum(box[:, 0] - base_P_m[0], base_P_m[0] - box[:, 1]), 0.0)
    near_y = np.maximum(np.maximum(box[:, 2] - base_P_m[1], base_P_m[1] - box[:, 3]), 0.0)
    return (np.hypot(far_x, far_y) <= reach.most_m - ROUNDING) & (np.hypot(near_x, near_y) >= reach.least_m + ROUNDING)
