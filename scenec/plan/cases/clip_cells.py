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

from geom.planar import inner_radius
from scenec.ir.problem import ReachIR, RelationIR
from scenec.plan.cases.batch_relations import axis_of, wrapped_all
from scenec.plan.cases.pool_model import Layouts, PoolModel
from scenec.plan.cases.rejection import front_of
from scenec.solve.planar import polygon
from scenec.solve.shapes import Shape
from schemas.arrays import BoolArray, FloatArray

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
ROUND_M = 1e-3  # footprints with a boundary in a ring narrower than this may turn freely
ROUNDING = 2e-6  # of values in plans, metres and radians


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
    pool: PoolModel, layouts: Layouts, freedom: Freedom, reach: ReachIR | None, base_P_m: FloatArray
) -> BoolArray:
    """Shortens steps until every relation and the reach (base (2,) in P) hold for all remaining poses.

    Returns which layouts (l,) can be kept: in the others some relation fails even at the seed pose.
    """
    is_kept = np.ones(len(layouts), dtype=bool)
    for rule in pool.rules:
        numbers = [pool.index[name] for name in rule.things]
        if rule.kind == "far_from" or (rule.kind == "before" and axis_of(rule.direction) is not None):
            continue  # guaranteed by the rectangles
        seed = _measure(pool, rule, layouts, numbers)
        spins = [i for i in numbers if _turns_matter(pool, rule, i)]
        test = partial(_holds, pool, rule, layouts, freedom, numbers, seed)
        is_kept &= _lower(freedom, numbers, _axes(rule), spins, test)
    if reach is not None:
        for name in reach.members:
            if name in pool.index:
                i = pool.index[name]
                is_kept &= _lower(
                    freedom, [i], slice(None), [], partial(_reached, layouts, freedom, i, reach, base_P_m)
                )
    return is_kept


def _turns_matter(pool: PoolModel, rule: RelationIR, i: int) -> bool:
    # Whether a relation may be violated by a thing that turns about its origin.
    if rule.kind == "facing":
        return pool.index[rule.things[0]] == i
    return rule.kind in ("near", "before") and max(map(unevenness, pool.members[i].shapes)) > ROUND_M


def _axes(rule: RelationIR) -> slice:
    # The axes along which steps matter: only that across for `aligned` along an axis.
    along = axis_of(rule.direction)
    if rule.kind != "aligned" or along is None:
        return slice(None)
    return slice(1 - along, 2 - along)


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


def unevenness(shape: Shape) -> float:
    """Width of the ring about the origin that contains the boundary of a footprint: its change by any turn."""
    if len(shape.pieces) > 1:
        return np.inf
    inner = inner_radius(shape.hull)
    return shape.radius_m - inner if inner > 0.0 else np.inf


def _measure(pool: PoolModel, rule: RelationIR, layouts: Layouts, numbers: list[int]) -> FloatArray:
    # Value of a relation at the seed poses, (l,): distance of footprints, or the gap before the second begins.
    if rule.kind == "near":
        return np.array([_apart(pool, layouts, k, *numbers) for k in range(len(layouts))])
    if rule.kind == "before":
        d = np.asarray(rule.direction)
        ends = [[(_hull(pool, layouts, k, i) @ d) for i in numbers] for k in range(len(layouts))]
        return np.array([float(two.min() - one.max()) for one, two in ends])
    return np.zeros(len(layouts))


def _hull(pool: PoolModel, layouts: Layouts, k: int, i: int) -> FloatArray:
    member, option = pool.members[i], int(layouts.option[k, i])
    turned = member.shapes[int(member.stance[option])].turned(float(member.yaw_rad[option]))
    return turned.hull + layouts.origin_m[k, i]


def _apart(pool: PoolModel, layouts: Layouts, k: int, i: int, j: int) -> float:
    pieces = []
    for number in (i, j):
        member, option = pool.members[number], int(layouts.option[k, number])
        turned = member.shapes[int(member.stance[option])].turned(float(member.yaw_rad[option]))
        pieces.append([polygon(piece + layouts.origin_m[k, number]) for piece in turned.pieces])
    return min(one.distance(two) for one in pieces[0] for two in pieces[1])


def _holds(
    pool: PoolModel, rule: RelationIR, layouts: Layouts, freedom: Freedom, numbers: list[int], seed: FloatArray
) -> BoolArray:
    shifts = [shift_of(pool, layouts, freedom, i) for i in numbers]
    if rule.kind in ("near", "before"):
        moved = shifts[0][1] + shifts[1][1] + ROUNDING
        return seed + moved <= rule.gap_m if rule.kind == "near" else seed - moved >= rule.gap_m
    boxes = freedom.clipped_boxes(layouts)[:, numbers]
    if rule.kind == "aligned":
        dx, dy = rule.direction
        low = np.minimum(-dy * boxes[..., 0], -dy * boxes[..., 1]) + np.minimum(dx * boxes[..., 2], dx * boxes[..., 3])
        high = np.maximum(-dy * boxes[..., 0], -dy * boxes[..., 1]) + np.maximum(dx * boxes[..., 2], dx * boxes[..., 3])
        return high.max(axis=1) - low.min(axis=1) <= rule.tolerance
    at = layouts.origin_m[:, numbers]
    origins = [shift[0] + ROUNDING / 2 for shift in shifts]
    if rule.kind == "facing":
        turn = freedom.clipped_turns()[:, numbers[0]].max(axis=1)
        heading = front_of(pool.members[numbers[0]], layouts.option[:, numbers[0]])
        return facing_kept(at, heading, origins[0] + origins[1], turn, rule.tolerance)
    return between_kept(at, origins, rule.tolerance)


def facing_kept(
    at_m: FloatArray, heading_rad: FloatArray, moved_m: FloatArray, turn_rad: FloatArray, tolerance_rad: float
) -> BoolArray:
    """(l,) whether the first of origins (l, 2, 2) faces the second for all their joint motion and turns of the
    first."""
    toward = at_m[:, 1] - at_m[:, 0]
    length = np.hypot(*toward.T)
    away = np.abs(wrapped_all(np.arctan2(toward[:, 1], toward[:, 0]) - heading_rad))
    sway = np.arcsin(np.clip(moved_m / np.maximum(length, 1e-9), 0.0, 1.0))
    return (away + sway + turn_rad + ROUNDING <= tolerance_rad) & (moved_m < length)


def between_kept(at_m: FloatArray, moved_m: list[FloatArray], tolerance_m: float) -> BoolArray:
    """(l,) whether the first of origins (l, 3, 2) stays between the others for all given motion of each.

    Uses that the foot of the perpendicular keeps its share of the line, and bounds the rest by the motion of the ends.
    """
    line, step = at_m[:, 2] - at_m[:, 1], at_m[:, 0] - at_m[:, 1]
    length = np.maximum(np.hypot(*line.T), 1e-9)
    along, beside = (
        (step * line).sum(axis=1) / length,
        np.abs(step[:, 0] * line[:, 1] - step[:, 1] * line[:, 0]) / length,
    )
    moved = moved_m[0] + np.maximum(moved_m[1], moved_m[2])
    spread = moved_m[1] + moved_m[2]
    lean = np.clip(spread / np.maximum(length - spread, 1e-9), 0.0, 1.0)
    rest = np.minimum(along, length - along) * np.maximum(1.0 - spread / length, 0.0)
    return (beside + moved <= tolerance_m) & (rest >= moved + beside * lean)


def _reached(layouts: Layouts, freedom: Freedom, i: int, reach: ReachIR, base_P_m: FloatArray) -> BoolArray:
    box = freedom.clipped_boxes(layouts)[:, i]
    far_x = np.maximum(np.abs(box[:, 0] - base_P_m[0]), np.abs(box[:, 1] - base_P_m[0]))
    far_y = np.maximum(np.abs(box[:, 2] - base_P_m[1]), np.abs(box[:, 3] - base_P_m[1]))
    near_x = np.maximum(np.maximum(box[:, 0] - base_P_m[0], base_P_m[0] - box[:, 1]), 0.0)
    near_y = np.maximum(np.maximum(box[:, 2] - base_P_m[1], base_P_m[1] - box[:, 3]), 0.0)
    return (np.hypot(far_x, far_y) <= reach.most_m - ROUNDING) & (np.hypot(near_x, near_y) >= reach.least_m + ROUNDING)
