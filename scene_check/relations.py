"""The judge's predicates of relations, one for each kind of `schemas.scene.relations`: `PREDICATES` is the whole table.

`measure` judges one scene exactly. `proven` bounds many scenes at once, one-sided: where it is True the exact predicate
holds. Metres and radians in the world W; the compiler has predicates of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
import shapely

from geom.polygon_measures import distances
from scene_check.measures import polygons
from scene_check.model import TOLERANCE_M, CheckObject, Violation
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import SceneRelation

SLACK_M = 0.5 * TOLERANCE_M  # of bounds, so that rounding cannot pass a scene that the exact predicate rejects
LEAST_LINE_M = 2.0 * TOLERANCE_M  # two points closer than this may define no direction


class Measured(NamedTuple):
    """A measured value, its bound, whether the relation holds, and the unit of both numbers."""

    value: float
    bound: float
    holds: bool
    unit: str = "m"


@dataclass(frozen=True)
class BatchMembers:
    """The members of a relation in n scenes: corners (n, v, 2) of the hull, lowest and highest z (n,), origin (n, 2) of
    each, and its front (n, 2) by `front_of`. `along` (n, 2) is the direction of the relation; `is_hull` whether every
    footprint is its hull. `pieces_near` gives some pieces of the footprint of a member, corners (n, v, 2) of each: in
    every scene those that are nearest to a point (n, 2), roughly, the nearest first."""

    hulls: Sequence[FloatArray]
    low_m: Sequence[FloatArray]
    high_m: Sequence[FloatArray]
    origins: Sequence[FloatArray]
    front_of: Callable[[int], FloatArray]
    along: FloatArray
    is_hull: bool
    pieces_near: Callable[[int, FloatArray], Sequence[FloatArray]]


@dataclass(frozen=True)
class RelationPredicate:
    """Both forms of the predicate of one kind."""

    measure: Callable[[SceneRelation, list[CheckObject]], Measured]
    proven: Callable[[SceneRelation, BatchMembers], BoolArray]


def broken_relation(relation: SceneRelation, items: list[CheckObject]) -> Iterator[Violation]:
    """A violation with the measured value where the relation does not hold."""
    measured = PREDICATES[relation.kind].measure(relation, items)
    if not measured.holds:
        label = relation.word or relation.kind
        yield Violation("relation", relation.things, measured.value, measured.bound, measured.unit, label)


def _origins(items: list[CheckObject]) -> FloatArray:
    return np.array([item.origin_m[:2] for item in items])


def _before(relation: SceneRelation, items: list[CheckObject]) -> Measured:
    along = np.asarray(relation.direction)
    end = max(float((prism.outline_m @ along).max()) for prism in items[0].prisms)
    begin = min(float((prism.outline_m @ along).min()) for prism in items[1].prisms)
    return Measured(begin - end, relation.gap_m, begin - end >= relation.gap_m - TOLERANCE_M)


def _before_proven(relation: SceneRelation, members: BatchMembers) -> BoolArray:
    first, second = (np.einsum("nvd,nd->nv", hull, members.along) for hull in members.hulls)
    return second.min(axis=1) - first.max(axis=1) >= relation.gap_m - SLACK_M


def _distance(items: list[CheckObject]) -> float:
    area_a, area_b = (shapely.union_all(polygons([p.outline_m for p in item.prisms])) for item in items)
    return float(area_a.distance(area_b))


def _hull_distance(members: BatchMembers) -> FloatArray:
    outline_a, outline_b = (shapely.polygons(hull) for hull in members.hulls)
    return distances(outline_a, outline_b)


def _near(relation: SceneRelation, items: list[CheckObject]) -> Measured:
    distance = _distance(items)
    return Measured(distance, relation.gap_m, distance - relation.gap_m <= TOLERANCE_M)


def _near_proven(relation: SceneRelation, members: BatchMembers) -> BoolArray:
    if members.is_hull:
        return _hull_distance(members) <= relation.gap_m + SLACK_M
    # Pieces are parts of the footprints, which are as near as any two of them.
    middles = [hull.mean(axis=1) for hull in members.hulls]
    near = np.zeros(len(members.along), dtype=bool)
    for piece_a, piece_b in product(members.pieces_near(0, middles[1]), members.pieces_near(1, middles[0])):
        left = np.flatnonzero(~near)
        outline_a, outline_b = shapely.polygons(piece_a[left]), shapely.polygons(piece_b[left])
        near[left] = distances(outline_a, outline_b) <= relation.gap_m + SLACK_M
    return near


def _far_from(relation: SceneRelation, items: list[CheckObject]) -> Measured:
    distance = _distance(items)
    return Measured(distance, relation.gap_m, relation.gap_m - distance <= TOLERANCE_M)


def _far_from_proven(relation: SceneRelation, members: BatchMembers) -> BoolArray:
    return _hull_distance(members) >= relation.gap_m - SLACK_M


def _aligned(relation: SceneRelation, items: list[CheckObject]) -> Measured:
    across = np.array([-relation.direction[1], relation.direction[0]])
    offset = float(np.ptp(_origins(items) @ across))
    return Measured(offset, relation.tolerance, offset <= relation.tolerance + TOLERANCE_M)


def _aligned_proven(relation: SceneRelation, members: BatchMembers) -> BoolArray:
    across = np.stack([-members.along[:, 1], members.along[:, 0]], axis=1)
    offsets = np.stack([np.einsum("nd,nd->n", at, across) for at in members.origins])
    return np.ptp(offsets, axis=0) <= relation.tolerance + SLACK_M


def _turned_by_part(relation: SceneRelation, fronts: FloatArray) -> FloatArray:
    """(n, 2) directions of the part that faces the other, from the fronts; the fronts where no part is named."""
    if relation.angle_rad is None:
        return fronts
    cos, sin = np.cos(relation.angle_rad[0]), np.sin(relation.angle_rad[0])
    return np.stack([cos * fronts[:, 0] - sin * fronts[:, 1], sin * fronts[:, 0] + cos * fronts[:, 1]], axis=1)


def _facing(relation: SceneRelation, items: list[CheckObject]) -> Measured:
    origins, front = _origins(items), _turned_by_part(relation, items[0].front[None])[0]
    toward = origins[1] - origins[0]
    angle = float(abs(np.arctan2(front[0] * toward[1] - front[1] * toward[0], front @ toward)))
    has_direction = bool(min(np.hypot(*toward), np.hypot(*front)) > TOLERANCE_M)
    return Measured(angle, relation.tolerance, has_direction and angle <= relation.tolerance + TOLERANCE_M, "rad")


def _facing_proven(relation: SceneRelation, members: BatchMembers) -> BoolArray:
    front, toward = _turned_by_part(relation, members.front_of(0)), members.origins[1] - members.origins[0]
    cross = front[:, 0] * toward[:, 1] - front[:, 1] * toward[:, 0]
    angle = np.abs(np.arctan2(cross, np.einsum("nd,nd->n", front, toward)))
    has_direction = np.minimum(np.hypot(*toward.T), np.hypot(*front.T)) > LEAST_LINE_M
    return has_direction & (angle <= relation.tolerance + SLACK_M)


def _between(relation: SceneRelation, items: list[CheckObject]) -> Measured:
    origins = _origins(items)
    line = origins[2] - origins[1]
    length = float(np.hypot(*line))
    if length <= TOLERANCE_M:
        return Measured(0.0, relation.tolerance, False)
    step = origins[0] - origins[1]
    past, beside = float(step @ line) / length, abs(float(step[0] * line[1] - step[1] * line[0])) / length
    beyond = max(-past, past - length, 0.0)
    inside = beyond <= TOLERANCE_M and beside <= relation.tolerance + TOLERANCE_M
    return Measured(max(beyond, beside), relation.tolerance, inside)


def _between_proven(relation: SceneRelation, members: BatchMembers) -> BoolArray:
    origins = members.origins
    line, step = origins[2] - origins[1], origins[0] - origins[1]
    length = np.hypot(*line.T)
    safe = np.where(length > LEAST_LINE_M, length, 1.0)
    past = np.einsum("nd,nd->n", step, line) / safe
    beside = np.abs(step[:, 0] * line[:, 1] - step[:, 1] * line[:, 0]) / safe
    inside = (past >= -SLACK_M) & (past <= length + SLACK_M) & (beside <= relation.tolerance + SLACK_M)
    return inside & (length > LEAST_LINE_M)


def _above(relation: SceneRelation, items: list[CheckObject]) -> Measured:
    rise = items[0].low_m - items[1].high_m
    return Measured(rise, relation.gap_m, rise >= relation.gap_m - TOLERANCE_M)


def _above_proven(relation: SceneRelation, members: BatchMembers) -> BoolArray:
    return members.low_m[0] - members.high_m[1] >= relation.gap_m - SLACK_M


def _angles_between(centre: FloatArray, others: FloatArray) -> FloatArray:
    """Angles (..., k) between neighbours, of points (..., k, 2) about centres (..., 2)."""
    steps = others - centre[..., None, :]
    headings = np.sort(np.arctan2(steps[..., 1], steps[..., 0]), axis=-1)
    last = headings[..., :1] + 2.0 * np.pi - headings[..., -1:]
    return np.concatenate([np.diff(headings, axis=-1), last], axis=-1)


def _surrounding(relation: SceneRelation, items: list[CheckObject]) -> Measured:
    least, most = relation.angle_rad or (0.0, 2.0 * np.pi)
    origins = _origins(items)
    angles = _angles_between(origins[0], origins[1:])
    narrowest, widest = float(angles.min()), float(angles.max())
    has_directions = bool(np.hypot(*(origins[1:] - origins[0]).T).min() > TOLERANCE_M)
    holds = has_directions and narrowest >= least - TOLERANCE_M and widest <= most + TOLERANCE_M
    value, bound = (narrowest, least) if least - narrowest >= widest - most else (widest, most)
    return Measured(value, bound, holds, "rad")


def _surrounding_proven(relation: SceneRelation, members: BatchMembers) -> BoolArray:
    least, most = relation.angle_rad or (0.0, 2.0 * np.pi)
    centre, others = members.origins[0], np.stack(members.origins[1:], axis=1)
    angles = _angles_between(centre, others)
    has_directions = np.hypot(*np.moveaxis(others - centre[:, None], -1, 0)).min(axis=1) > LEAST_LINE_M
    return has_directions & (angles.min(axis=1) >= least - SLACK_M) & (angles.max(axis=1) <= most + SLACK_M)


def _in_line(relation: SceneRelation, items: list[CheckObject]) -> Measured:
    along = np.asarray(relation.direction)
    origins, across = _origins(items), np.array([-along[1], along[0]])
    aside, steps = float(np.ptp(origins @ across)), np.diff(origins @ along)
    if relation.gap_m > 0.0:
        value = max(aside, float(np.abs(steps - relation.gap_m).max()))
        return Measured(value, relation.tolerance, value <= relation.tolerance + TOLERANCE_M)
    if (least := float(steps.min())) < -TOLERANCE_M:
        return Measured(least, 0.0, False)
    return Measured(aside, relation.tolerance, aside <= relation.tolerance + TOLERANCE_M)


def _in_line_proven(relation: SceneRelation, members: BatchMembers) -> BoolArray:
    across = np.stack([-members.along[:, 1], members.along[:, 0]], axis=1)
    aside = np.stack([np.einsum("nd,nd->n", at, across) for at in members.origins])
    along = np.stack([np.einsum("nd,nd->n", at, members.along) for at in members.origins])
    steps = along[1:] - along[:-1]
    off = np.abs(steps - relation.gap_m) - relation.tolerance if relation.gap_m > 0.0 else -steps
    return (np.ptp(aside, axis=0) <= relation.tolerance + SLACK_M) & (off <= SLACK_M).all(axis=0)


PREDICATES = {
    "before": RelationPredicate(_before, _before_proven),
    "near": RelationPredicate(_near, _near_proven),
    "far_from": RelationPredicate(_far_from, _far_from_proven),
    "aligned": RelationPredicate(_aligned, _aligned_proven),
    "facing": RelationPredicate(_facing, _facing_proven),
    "between": RelationPredicate(_between, _between_proven),
    "above": RelationPredicate(_above, _above_proven),
    "surrounding": RelationPredicate(_surrounding, _surrounding_proven),
    "in_line": RelationPredicate(_in_line, _in_line_proven),
}
