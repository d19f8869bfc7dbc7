"""Data of n scenes with the same objects: the shared rules (`SceneRules`) and the poses in each scene (`BatchPoses`).

Frames: W, A, P (an asset frame turned by yaw alone) and S as in `schemas.scene.geometry`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from geom.planar import front_of, turned
from scene_check.model import CheckObject, CheckScene, PosedGrid, PosedPlace, SweptSpace
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.scene.geometry import (
    BACKGROUND,
    Domain,
    KeepClear,
    KeepOutVolume,
    Prism,
    ReachRing,
    ScenePlace,
    SceneRelation,
    Stance,
)


@dataclass(frozen=True)
class ThingRule:
    """An object: its `forms` (number and geometry of every stance of every body that it may have), the owner and
    geometry of its place, and the poses that its program allows there."""

    name: str
    forms: tuple[tuple[int, Stance], ...]
    owner: str
    place: ScenePlace
    domain: Domain = field(default_factory=Domain)


@dataclass(frozen=True)
class GridRule:
    """Objects in rows and columns: `offsets_m` (n, 2) of their origins in the frame of the grid, the place of the grid,
    and the poses of that frame there."""

    name: str
    members: tuple[str, ...]
    offsets_m: FloatArray
    owner: str
    place: ScenePlace
    domain: Domain


@dataclass(frozen=True)
class SceneRules:
    """All rules that n scenes share. The background lies at `origin_m` (3,) in W, rotated by `yaw_rad`."""

    things: tuple[ThingRule, ...]
    origin_m: FloatArray
    yaw_rad: float
    clearance_m: float
    relations: tuple[SceneRelation, ...] = ()
    keep_outs: tuple[KeepOutVolume, ...] = ()
    reach: ReachRing | None = None
    keep_clear: tuple[KeepClear, ...] = ()
    stacks: tuple[tuple[str, ...], ...] = ()
    grids: tuple[GridRule, ...] = ()

    @cached_property
    def number(self) -> dict[str, int]:
        """Numbers of the objects by name."""
        return {thing.name: i for i, thing in enumerate(self.things)}


@dataclass(frozen=True)
class BatchPoses:
    """Poses of T objects in n scenes: origin of the asset frame (n, T, 3) and yaw (n, T) in W, index
    `form` (n, T) of the stance; `known` (n, T) is False where the orientation belongs to no stance."""

    origin_m: FloatArray
    yaw_rad: FloatArray
    form: IntArray
    known: BoolArray


def scene_at(rules: SceneRules, poses: BatchPoses, k: int) -> CheckScene:
    """Scene k as input of `scene_check.check_scene`. An orientation that belongs to no stance becomes stance -1."""
    origins, yaws = poses.origin_m[k], poses.yaw_rad[k]

    def owner(name: str) -> tuple[FloatArray, float]:
        if name == BACKGROUND:
            return rules.origin_m, rules.yaw_rad
        return origins[rules.number[name]], float(yaws[rules.number[name]])

    def place(name: str, geometry: ScenePlace) -> PosedPlace:
        return place_in_world(name, geometry, *owner(name))

    places = {(t.owner, id(t.place)): place(t.owner, t.place) for t in rules.things}
    objects: list[CheckObject] = []
    for i, thing in enumerate(rules.things):
        stance, geometry = thing.forms[int(poses.form[k, i])]
        posed = places[thing.owner, id(thing.place)]
        placed = object_in_world(thing.name, stance, geometry, thing.domain, posed, origins[i], float(yaws[i]))
        objects.append(placed if poses.known[k, i] else replace(placed, is_known=False))
    return CheckScene(
        objects=tuple(objects),
        clearance_m=rules.clearance_m,
        relations=tuple(relation_in_world(rule, owner(rule.frame)[1]) for rule in rules.relations),
        keep_outs=tuple((place(rule.parent, rule.place), rule) for rule in rules.keep_outs),
        reach=rules.reach,
        keep_clear=tuple(SweptSpace(space, *owner(space.owner)) for space in rules.keep_clear),
        stacks=rules.stacks,
        grids=tuple(
            PosedGrid(rule.name, rule.members, rule.offsets_m, place(rule.owner, rule.place), rule.domain)
            for rule in rules.grids
        ),
    )


def place_in_world(owner: str, place: ScenePlace, origin_m: FloatArray, yaw_rad: float) -> PosedPlace:
    """A place in W, for an owner whose asset frame is at `origin_m` (3,) with `yaw_rad`."""
    shift = turned(place.origin_P_m[None, :2], yaw_rad)[0]
    return PosedPlace(owner, place, origin_m + np.array([*shift, place.origin_P_m[2]]), yaw_rad)


def relation_in_world(relation: SceneRelation, yaw_rad: float) -> SceneRelation:
    """A relation with its direction in W, for an owner of its frame with `yaw_rad`."""
    x, y = turned(np.array([relation.direction]), yaw_rad)[0].tolist()
    return replace(relation, direction=(x, y))


def object_in_world(
    name: str, number: int, stance: Stance, domain: Domain, place: PosedPlace, origin_m: FloatArray, yaw_rad: float
) -> CheckObject:
    """An object in W, in a stance of that number, with its asset frame at `origin_m` (3,) and `yaw_rad`."""
    floor_m = float(origin_m[2]) - stance.origin_height_m
    prisms = tuple(
        Prism(turned(prism.outline_m, yaw_rad) + origin_m[:2], floor_m + prism.low_m, floor_m + prism.high_m)
        for prism in stance.prisms
    )
    front = turned(front_of(stance.quat_wxyz)[None], yaw_rad)[0]
    return CheckObject(name, prisms, origin_m, yaw_rad, front, place, domain, number)
