"""Data of n scenes with the same objects: the shared rules (`SceneRules`) and the poses in each scene (`BatchPoses`).

Frames: W, A as in `scene_check.model`; U of an owner: its asset frame rotated by yaw alone; S: a stance before yaw.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from shapely import Polygon

from geom.planar import turned
from scene_check import CheckKeepOut, CheckObject, CheckPlace, CheckPrism, CheckReach, CheckRelation, CheckScene
from schemas.arrays import BoolArray, FloatArray, IntArray

WORLD = -1  # the background, as number of an owner


@dataclass(frozen=True)
class StanceGeometry:
    """Geometry of an asset in one stance: prisms in S with heights (m) over the support, front (2,) in S, height of the
    asset origin over the support; `stance` is the number of the stance."""

    prisms: tuple[CheckPrism, ...]
    front: FloatArray
    origin_height_m: float
    stance: int


@dataclass(frozen=True)
class PlaceRule:
    """A place on or in the object of number `owner`; `at` is the place in U of the owner."""

    owner: int
    at: CheckPlace


@dataclass(frozen=True)
class ThingRule:
    """An object, its possible stance geometries, its place by number, and the poses that its program allows in A.

    `fixed_poses` are (x, y, z, yaw, stance); `stances` by number.
    """

    name: str
    forms: tuple[StanceGeometry, ...]
    place: int
    x_m: tuple[float, float] = (-np.inf, np.inf)
    y_m: tuple[float, float] = (-np.inf, np.inf)
    yaw_rad: tuple[float, float] = (-np.pi, np.pi)
    fixed_poses: tuple[tuple[float, float, float, float, int], ...] = ()
    stances: tuple[int, ...] = (0,)


@dataclass(frozen=True)
class RelationRule:
    """A relation between objects by number; `direction` (2,) is given in U of object `frame`."""

    kind: str
    things: tuple[int, ...]
    direction: FloatArray
    frame: int = WORLD
    gap_m: float = 0.0
    tolerance: float = 0.0
    label: str = ""


@dataclass(frozen=True)
class KeepOutRule:
    """No object may be over `polygon` (in A of a place by number) up to `height_m`."""

    place: int
    polygon: Polygon
    height_m: float


@dataclass(frozen=True)
class SceneRules:
    """All rules that n scenes share. The background lies at `origin_m` (3,) in W, rotated by `yaw_rad`."""

    things: tuple[ThingRule, ...]
    places: tuple[PlaceRule, ...]
    origin_m: FloatArray
    yaw_rad: float
    clearance_m: float
    relations: tuple[RelationRule, ...] = ()
    keep_outs: tuple[KeepOutRule, ...] = ()
    reach: CheckReach | None = None


@dataclass(frozen=True)
class BatchPoses:
    """Poses of T objects in n scenes: origin of the asset frame (n, T, 3) and yaw (n, T) in W, index of the
    stance geometry `form` (n, T); `known` (n, T) is False where the orientation belongs to no stance."""

    origin_m: FloatArray
    yaw_rad: FloatArray
    form: IntArray
    known: BoolArray


def scene_at(rules: SceneRules, poses: BatchPoses, k: int) -> CheckScene:
    """Scene k as input of `scene_check.check_scene`. An orientation that belongs to no stance becomes stance -1."""
    origins, yaws = poses.origin_m[k], poses.yaw_rad[k]

    def owner(number: int) -> tuple[FloatArray, float]:
        return (rules.origin_m, rules.yaw_rad) if number == WORLD else (origins[number], float(yaws[number]))

    places = tuple(place_in_world(rule.at, *owner(rule.owner)) for rule in rules.places)
    return CheckScene(
        objects=tuple(
            _object(thing, places[thing.place], origins[i], float(yaws[i]), int(poses.form[k, i]), poses.known[k, i])
            for i, thing in enumerate(rules.things)
        ),
        clearance_m=rules.clearance_m,
        relations=tuple(
            CheckRelation(
                kind=rule.kind,
                objects=tuple(rules.things[i].name for i in rule.things),
                direction=turned(rule.direction[None], owner(rule.frame)[1])[0],
                gap_m=rule.gap_m,
                tolerance=rule.tolerance,
                label=rule.label,
            )
            for rule in rules.relations
        ),
        keep_outs=tuple(CheckKeepOut(places[rule.place], rule.polygon, rule.height_m) for rule in rules.keep_outs),
        reach=rules.reach,
    )


def place_in_world(place: CheckPlace, origin_m: FloatArray, yaw_rad: float) -> CheckPlace:
    """A place given in U of its owner, in W, for an owner at `origin_m` (3,) with `yaw_rad`."""
    shift = turned(place.origin_m[None, :2], yaw_rad)[0]
    at = origin_m + np.array([*shift, place.origin_m[2]])
    return replace(place, origin_m=at, yaw_rad=yaw_rad + place.yaw_rad)


def _object(
    thing: ThingRule, place: CheckPlace, origin_m: FloatArray, yaw_rad: float, number: int, known: bool
) -> CheckObject:
    form = thing.forms[number]
    floor_m = float(origin_m[2]) - form.origin_height_m
    prisms = tuple(
        CheckPrism(turned(p.outline_m, yaw_rad) + origin_m[:2], floor_m + p.low_m, floor_m + p.high_m)
        for p in form.prisms
    )
    spotted = any(spot[4] == form.stance for spot in thing.fixed_poses)
    return CheckObject(
        name=thing.name,
        prisms=prisms,
        origin_m=origin_m,
        yaw_rad=yaw_rad,
        front=turned(form.front[None], yaw_rad)[0],
        place=place,
        x_m=thing.x_m,
        y_m=thing.y_m,
        yaw_range_rad=thing.yaw_rad,
        fixed_poses=tuple(spot[:4] for spot in thing.fixed_poses if spot[4] == form.stance or not spotted),
        stance=form.stance if known else -1,
        stances=tuple(spot[4] for spot in thing.fixed_poses) or thing.stances,
    )
