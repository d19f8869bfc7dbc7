"""Evaluates cross-owner relations on many layouts at once: do they hold for all poses that the freedom of things
allows?

Poses are relative to a *base*: the innermost owner that carries all things of a relation, so that common motion does
not count. A thing on a tray moves as far as the tray, additionally by its distance from the tray's origin times the
turn of the tray, and by its own freedom on the tray. Metres, radians.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from scenec.ir.problem import WORLD_PARENT, RelationIR
from scenec.plan.cases.clip_cells import ROUND_M, ROUNDING, Freedom, between_kept, facing_kept, shift_of, unevenness
from scenec.plan.cases.pool_model import Layouts, PoolModel
from scenec.solve.model import SolverModel
from scenec.solve.shapes import Shape
from schemas.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class OwnerLayouts:
    """Things of one owner in l layouts, with their freedom (None: fixed)."""

    pool: PoolModel
    layouts: Layouts
    freedom: Freedom | None = None


@dataclass(frozen=True)
class RelativePoses:
    """Poses of a thing relative to a base: `at_m` (l, 2) and `yaw_rad` (l,) in the layouts; bounds (l,) on the motion
    of its origin, of any point of its footprint, and of its yaw."""

    at_m: FloatArray
    yaw_rad: FloatArray
    stance: IntArray
    origin_m: FloatArray
    outline_m: FloatArray
    turn_rad: FloatArray
    shapes: tuple[Shape, ...] = ()


@dataclass(frozen=True)
class CrossOwnerRelation:
    """A relation, its base, and the links that it depends on: things between the base and its members or its frame.
    `turning` are those whose yaw matters."""

    rule: RelationIR
    base: str
    links: tuple[str, ...]
    turning: tuple[str, ...]


def cross_owner_relation(model: SolverModel, rule: RelationIR) -> CrossOwnerRelation:
    """Base and links of a relation across owners."""
    chains = [model.chains[name] for name in rule.things]
    if rule.kind in ("before", "aligned"):
        chains.append(() if rule.frame == WORLD_PARENT else model.chains[rule.frame])
    depth = 0
    while all(len(chain) > depth for chain in chains) and len({chain[depth] for chain in chains}) == 1:
        depth += 1
    base = chains[0][depth - 1] if depth else WORLD_PARENT
    links = tuple(sorted({link for chain in chains for link in chain[depth:]}))
    turning = {name for chain in chains for name, _ in pairwise(chain[depth:])}  # owners on the way
    turning |= set(chains[-1][depth:]) if len(chains) > len(rule.things) else set()
    if rule.kind == "facing":
        turning |= {rule.things[0]}
    elif rule.kind in ("near", "far_from", "before"):
        turning |= {name for name in rule.things if max(map(unevenness, model.shapes[name])) > ROUND_M}
    return CrossOwnerRelation(rule, base, links, tuple(sorted(turning & set(links))))


def holds_across_owners(
    relation: CrossOwnerRelation, parts: Mapping[str, OwnerLayouts], values: FloatArray
) -> BoolArray:
    """(l,) whether a relation holds for every allowed pose of its links; `values` from `relation_values`."""
    rule = relation.rule
    poses = _member_poses(relation, parts)
    if rule.kind in ("near", "far_from", "before"):
        moved = poses[0].outline_m + poses[1].outline_m + len(relation.links) * ROUNDING
        if rule.kind == "near":
            return values + moved <= rule.gap_m
        if rule.kind == "before":
            span = np.hypot(*(poses[1].at_m - poses[0].at_m).T) + sum(_radius(one) + one.outline_m for one in poses[:2])
            moved = moved + _sway(poses[-1].turn_rad) * span
        return values - moved >= rule.gap_m
    at = np.stack([one.at_m for one in poses[: len(rule.things)]], axis=1)
    moved = [one.origin_m + len(relation.links) * ROUNDING for one in poses[: len(rule.things)]]
    if rule.kind == "facing":
        front = np.array([shape.front_rad for shape in poses[0].shapes])[poses[0].stance]
        return facing_kept(at, poses[0].yaw_rad + front, moved[0] + moved[1], poses[0].turn_rad, rule.tolerance)
    if rule.kind == "between":
        return between_kept(at, moved, rule.tolerance)
    dx, dy = rule.direction
    across = -dy * at[..., 0] + dx * at[..., 1]
    most = np.max(moved, axis=0)
    middle = at.mean(axis=1, keepdims=True)
    span = 2.0 * (np.hypot(*np.moveaxis(at - middle, -1, 0)).max(axis=1) + most)
    return np.ptp(across, axis=1) + 2.0 * most + _sway(poses[-1].turn_rad) * span <= rule.tolerance


def relation_values(relation: CrossOwnerRelation, parts: Mapping[str, OwnerLayouts]) -> FloatArray:
    """Value of a relation in each layout (l,): distance of footprints, or gap before the second begins; 0 for relations
    that depend on origins and yaws alone."""
    rule = relation.rule
    poses = _member_poses(relation, parts)
    if rule.kind == "before":
        ends = [_hull_along(one, rule.direction) for one in poses[:2]]
        return ends[1].min(axis=1) - ends[0].max(axis=1)
    if rule.kind in ("near", "far_from"):
        gap = np.hypot(*(poses[1].at_m - poses[0].at_m).T) - _radius(poses[0]) - _radius(poses[1])
        rows = np.flatnonzero(gap <= rule.gap_m) if rule.kind == "near" else np.arange(len(gap))
        # Footprints whose bounding circles are too far apart are skipped.
        pieces = [_pieces(one, rows) for one in poses[:2]]
        gaps = [shapely.distance(one, two) for one in pieces[0] for two in pieces[1]]
        gap[rows] = np.nanmin(np.stack(gaps), axis=0)
        return gap
    return np.zeros(len(poses[0].yaw_rad))


def _member_poses(relation: CrossOwnerRelation, parts: Mapping[str, OwnerLayouts]) -> list[RelativePoses]:
    # Poses of the members along the axes of the relation's frame, then that of the frame.
    rule, known = relation.rule, dict[str, RelativePoses]()
    frame = rule.frame if rule.kind in ("before", "aligned") and rule.frame != WORLD_PARENT else relation.base
    axes = _relative_poses(frame, relation.base, parts, known)
    c, s = np.cos(axes.yaw_rad), np.sin(axes.yaw_rad)
    members = []
    for name in rule.things:
        one = _relative_poses(name, relation.base, parts, known)
        x, y = one.at_m.T
        at = np.stack([c * x + s * y, c * y - s * x], axis=1)
        shapes = _shapes(name, relation, parts)
        stance = one.stance
        members.append(
            RelativePoses(at, one.yaw_rad - axes.yaw_rad, stance, one.origin_m, one.outline_m, one.turn_rad, shapes)
        )
    return [*members, axes]


def _shapes(name: str, relation: CrossOwnerRelation, parts: Mapping[str, OwnerLayouts]) -> tuple[Shape, ...]:
    # Of a base only the upright shape: it carries the others and defines the axes.
    shapes = next(iter(parts.values())).pool.model.shapes[name]
    return shapes if name != relation.base else tuple(shape for shape in shapes if shape.upright)


def _relative_poses(
    name: str, base: str, parts: Mapping[str, OwnerLayouts], known: dict[str, RelativePoses]
) -> RelativePoses:
    if name in known:
        return known[name]
    if name == base:
        count = len(next(iter(parts.values())).layouts)
        none = np.zeros(count)
        known[name] = RelativePoses(np.zeros((count, 2)), none, np.zeros(count, dtype=np.int64), none, none, none)
        return known[name]
    part = parts[name]
    i = part.pool.index[name]
    member, option, p = part.pool.members[i], part.layouts.option[:, i], part.layouts.origin_m[:, i]
    owner = _relative_poses(member.thing.parent, base, parts, known)
    c, s = np.cos(owner.yaw_rad), np.sin(owner.yaw_rad)
    at = owner.at_m + np.stack([c * p[:, 0] - s * p[:, 1], s * p[:, 0] + c * p[:, 1]], axis=1)
    radius = np.array([shape.radius_m for shape in member.shapes])[member.stance[option]]
    origin_shift, outline_shift, turn = (np.zeros(len(at)),) * 3
    if part.freedom is not None:
        origin_shift, outline_shift = shift_of(part.pool, part.layouts, part.freedom, i)
        turn = part.freedom.clipped_turns()[:, i].max(axis=1)
    sway, out = _sway(owner.turn_rad), np.hypot(*p.T)
    known[name] = RelativePoses(
        at,
        owner.yaw_rad + member.yaw_rad[option],
        member.stance[option],
        owner.origin_m + sway * out + origin_shift,
        owner.origin_m + sway * (out + radius) + outline_shift,
        owner.turn_rad + turn,
    )
    return known[name]


def _sway(turn_rad: FloatArray) -> FloatArray:
    # Motion of a point at 1 m from the origin of a turning owner.
    return 2.0 * np.sin(np.minimum(turn_rad, np.pi) / 2.0)


def _radius(one: RelativePoses) -> FloatArray:
    return np.array([shape.radius_m for shape in one.shapes])[one.stance]


def _hull_along(one: RelativePoses, direction: tuple[float, float]) -> FloatArray:
    # (l, v) corners of the footprint's hull along a direction; repeated where a stance has fewer.
    most = max(len(shape.hull) for shape in one.shapes)
    hulls = np.stack([np.resize(shape.hull, (most, 2)) for shape in one.shapes])[one.stance]
    dx, dy = direction
    c, s = np.cos(one.yaw_rad), np.sin(one.yaw_rad)
    along_x, along_y = (c * dx + s * dy)[:, None], (c * dy - s * dx)[:, None]
    return along_x * hulls[..., 0] + along_y * hulls[..., 1] + (one.at_m @ np.array(direction))[:, None]


def _pieces(one: RelativePoses, rows: IntArray) -> Sequence[np.ndarray]:
    # Polygons in some layouts (r,), an array for each piece that any stance has; None where a stance has fewer.
    most = max(len(shape.pieces) for shape in one.shapes)
    polygons = [np.full(len(rows), None, dtype=object) for _ in range(most)]
    for stance, shape in enumerate(one.shapes):
        mine = np.flatnonzero(one.stance[rows] == stance)
        yaw, at = one.yaw_rad[rows[mine]], one.at_m[rows[mine]]
        c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
        for polygons_of_piece, piece in zip(polygons, shape.pieces, strict=False):
            x, y = piece.T
            if len(mine):
                polygons_of_piece[mine] = shapely.polygons(
                    np.stack([c * x - s * y, s * x + c * y], axis=-1) + at[:, None]
                )
    return polygons
