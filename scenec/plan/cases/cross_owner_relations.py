"""Evaluates cross-owner relations on many layouts at once: do they hold for all poses that the freedom of things
allows?

Poses are relative to a *base*: the innermost owner that carries all things of a relation, so that common motion does
not count. A thing on a tray moves as far as the tray, additionally by its distance from the tray's origin times the
turn of the tray, and by its own freedom on the tray. Metres, radians.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from scenec.plan.cases.clip_cells import Freedom, shift_of
from scenec.plan.cases.motions import ROUND_M, ROUNDING, Motions, RelativePoses, sway, unevenness
from scenec.plan.cases.pool_model import Layouts, PoolModel, floor_of
from scenec.relations.table import RELATIONS
from scenec.solve.model import SolverModel
from scenec.solve.shapes import Shape
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import BACKGROUND, SceneRelation


@dataclass(frozen=True)
class OwnerLayouts:
    """Things of one owner in l layouts, with their freedom (None: fixed)."""

    pool: PoolModel
    layouts: Layouts
    freedom: Freedom | None = None


@dataclass(frozen=True)
class CrossOwnerRelation:
    """A relation, its base, and the links that it depends on: things between the base and its members or its frame.
    `turning` are those whose yaw matters."""

    rule: SceneRelation
    base: str
    links: tuple[str, ...]
    turning: tuple[str, ...]


def cross_owner_relation(model: SolverModel, rule: SceneRelation) -> CrossOwnerRelation:
    """Base and links of a relation across owners."""
    chains = [model.chains[name] for name in rule.things]
    meaning = RELATIONS[rule.kind]
    if meaning.frame_dependent:
        chains.append(() if rule.frame == BACKGROUND else model.chains[rule.frame])
    depth = 0
    while all(len(chain) > depth for chain in chains) and len({chain[depth] for chain in chains}) == 1:
        depth += 1
    base = chains[0][depth - 1] if depth else BACKGROUND
    links = tuple(sorted({link for chain in chains for link in chain[depth:]}))
    turning = {name for chain in chains for name, _ in pairwise(chain[depth:])}  # owners on the way
    turning |= set(chains[-1][depth:]) if len(chains) > len(rule.things) else set()
    for k, name in enumerate(rule.things):
        if meaning.turns_matter(rule, k, max(map(unevenness, model.shapes[name])) > ROUND_M):
            turning.add(name)
    return CrossOwnerRelation(rule, base, links, tuple(sorted(turning & set(links))))


def holds_across_owners(
    relation: CrossOwnerRelation, parts: Mapping[str, OwnerLayouts], values: FloatArray
) -> BoolArray:
    """(l,) whether a relation holds for every allowed pose of its links; `values` from `relation_values`."""
    return RELATIONS[relation.rule.kind].holds_throughout(relation.rule, _motions(relation, parts), values)


def relation_values(relation: CrossOwnerRelation, parts: Mapping[str, OwnerLayouts]) -> FloatArray:
    """Value (l,) of a relation in each layout, as its meaning measures it."""
    return RELATIONS[relation.rule.kind].value(relation.rule, _motions(relation, parts))


def _motions(relation: CrossOwnerRelation, parts: Mapping[str, OwnerLayouts]) -> Motions:
    # Poses of the members along the axes of the relation's frame, and the turn of that frame.
    rule, known = relation.rule, dict[str, RelativePoses]()
    has_frame = RELATIONS[rule.kind].frame_dependent and rule.frame != BACKGROUND
    axes = _relative_poses(rule.frame if has_frame else relation.base, relation.base, parts, known)
    c, s = np.cos(axes.yaw_rad), np.sin(axes.yaw_rad)
    members = []
    for name in rule.things:
        one = _relative_poses(name, relation.base, parts, known)
        x, y = one.at_m.T
        at = np.stack([c * x + s * y, c * y - s * x], axis=1)
        shapes = _shapes(name, relation, parts)
        members.append(replace(one, at_m=at, yaw_rad=one.yaw_rad - axes.yaw_rad, shapes=shapes))
    rounding_m = len(relation.links) * ROUNDING
    return Motions(tuple(members), axes.turn_rad, rounding_m, rounding_m)


def _shapes(name: str, relation: CrossOwnerRelation, parts: Mapping[str, OwnerLayouts]) -> tuple[Shape, ...]:
    # Of a base only the upright shape: it carries the others and defines the axes.
    shapes = next(iter(parts.values())).pool.model.shapes[name]
    return shapes if name != relation.base else _upright(shapes)


def _upright(shapes: tuple[Shape, ...]) -> tuple[Shape, ...]:
    return tuple(shape for shape in shapes if shape.upright)


def _origin_height(name: str, base: str, parts: Mapping[str, OwnerLayouts], poses: RelativePoses) -> FloatArray:
    # Height (l,) of the origin of an owner over that of the base.
    if name == base:
        return np.zeros(len(poses.floor_m))
    part = parts[name]
    member = part.pool.members[part.pool.index[name]]
    heights = np.array([shape.origin_height_m for shape in member.shapes])
    return poses.floor_m + heights[poses.stance]


def _relative_poses(
    name: str, base: str, parts: Mapping[str, OwnerLayouts], known: dict[str, RelativePoses]
) -> RelativePoses:
    if name in known:
        return known[name]
    if name == base:
        count = len(next(iter(parts.values())).layouts)
        none, stance = np.zeros(count), np.zeros(count, dtype=np.int64)
        model = next(iter(parts.values())).pool.model
        floor = none if name == BACKGROUND else none - _upright(model.shapes[name])[0].origin_height_m
        known[name] = RelativePoses(np.zeros((count, 2)), none, stance, floor, none, none, none)
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
    swing, out = sway(owner.turn_rad), np.hypot(*p.T)
    known[name] = RelativePoses(
        at,
        owner.yaw_rad + member.yaw_rad[option],
        member.stance[option],
        _origin_height(member.thing.parent, base, parts, owner) + floor_of(member, option),
        owner.origin_m + swing * out + origin_shift,
        owner.origin_m + swing * (out + radius) + outline_shift,
        owner.turn_rad + turn,
    )
    return known[name]
