"""Many scenes of the same things at once: what never changes, and where everything stands in each of n scenes.

Frames as in `scene_check`; U of an owner: its asset frame turned by yaw alone. S: a form, before yaw.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon

from geom.planar import turned
from scene_check import CheckKeepOut, CheckObject, CheckPlace, CheckPrism, CheckReach, CheckRelation, CheckScene
from scene_check.model import FloatArray

IntArray = NDArray[np.int64]
WORLD = -1  # in place of the number of an owner


@dataclass(frozen=True)
class Form:
    """An asset in one of its stances: pieces in S with heights over the support, front (2,) in S, the height of the
    asset origin over the support; `stance` is its number."""

    prisms: tuple[CheckPrism, ...]
    front: FloatArray
    origin_height_m: float
    stance: int


@dataclass(frozen=True)
class PlaceRule:
    """A place of thing number `owner`; `at` holds it in U of the owner."""

    owner: int
    at: CheckPlace


@dataclass(frozen=True)
class ThingRule:
    """A thing, the forms that it may have, its place by number, and what its program allows in A.

    `spots` are (x, y, z, yaw, stance); `stances` by number.
    """

    name: str
    forms: tuple[Form, ...]
    place: int
    x_m: tuple[float, float] = (-np.inf, np.inf)
    y_m: tuple[float, float] = (-np.inf, np.inf)
    yaw_rad: tuple[float, float] = (-np.pi, np.pi)
    spots: tuple[tuple[float, float, float, float, int], ...] = ()
    stances: tuple[int, ...] = (0,)


@dataclass(frozen=True)
class RelationRule:
    """A relation between things by number; `direction` (2,) counts in U of thing `frame`."""

    kind: str
    things: tuple[int, ...]
    direction: FloatArray
    frame: int = WORLD
    gap_m: float = 0.0
    tolerance: float = 0.0
    label: str = ""


@dataclass(frozen=True)
class KeepOutRule:
    """Nothing is over `polygon` (in A of a place by number) up to `height_m`."""

    place: int
    polygon: Polygon
    height_m: float


@dataclass(frozen=True)
class SceneRules:
    """Everything that n scenes share. The background stands at `origin_m` (3,) in W, turned by `yaw_rad`."""

    things: tuple[ThingRule, ...]
    places: tuple[PlaceRule, ...]
    origin_m: FloatArray
    yaw_rad: float
    clearance_m: float
    relations: tuple[RelationRule, ...] = ()
    keep_outs: tuple[KeepOutRule, ...] = ()
    reach: CheckReach | None = None


@dataclass(frozen=True)
class Stands:
    """Where T things stand in n scenes: origin of the asset frame (n, T, 3) and yaw (n, T) in W, number of the form
    (n, T); `known` (n, T) is False where the orientation is that of no stance."""

    origin_m: FloatArray
    yaw_rad: FloatArray
    form: IntArray
    known: NDArray[np.bool_]


def scene_of(rules: SceneRules, stands: Stands, k: int) -> CheckScene:
    """Scene k as `scene_check.check_scene` takes it. An orientation of no stance becomes stance -1."""
    origins, yaws = stands.origin_m[k], stands.yaw_rad[k]

    def owner(number: int) -> tuple[FloatArray, float]:
        return (rules.origin_m, rules.yaw_rad) if number == WORLD else (origins[number], float(yaws[number]))

    places = tuple(placed(rule.at, *owner(rule.owner)) for rule in rules.places)
    return CheckScene(
        objects=tuple(
            _object(thing, places[thing.place], origins[i], float(yaws[i]), int(stands.form[k, i]), stands.known[k, i])
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


def placed(place: CheckPlace, origin_m: FloatArray, yaw_rad: float) -> CheckPlace:
    """A place known in U of its owner, in W where the owner stands."""
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
    spotted = any(spot[4] == form.stance for spot in thing.spots)
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
        spots=tuple(spot[:4] for spot in thing.spots if spot[4] == form.stance or not spotted),
        stance=form.stance if known else -1,
        stances=tuple(spot[4] for spot in thing.spots) or thing.stances,
    )
