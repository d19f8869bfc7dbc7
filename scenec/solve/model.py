"""Solver model of a problem: shapes by resting orientation (bottom-up), places in their owner's frame P, relations by
thing.

Things are kept in the order of their names, so that the order in the program never matters.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import NamedTuple, cast

import numpy as np
import shapely
from shapely import Polygon

from scenec.ir.problem import Placement, Problem, Thing
from scenec.relations.table import RELATIONS
from scenec.solve.keep_clear import keep_clear_rules, keep_outs_of
from scenec.solve.placed import Placed
from scenec.solve.planar import SLACK_M, polygon
from scenec.solve.shapes import Shape, carried_prisms, shape_of, tallest
from schemas.scene.geometry import BACKGROUND, ScenePlace, SceneRelation


class Site:
    """One place in its owner's frame P: layers (low, high, polygon) to stay on, obstacles above it, keep-outs."""

    def __init__(self, parent: str, place: ScenePlace, problem: Problem):
        self.parent, self.place = parent, place
        ox, oy, oz = (float(v) for v in place.origin_P_m)
        layers = place.layers or ((0.0, place.height_m, place.polygon),)
        self.layers = tuple((low, high, _shifted(area, ox, oy)) for low, high, area in layers)
        shift = np.array([ox, oy])
        self.above = tuple((polygon(s.outline_m + shift), s.low_m + oz, s.high_m + oz) for s in place.above)
        # Keep-outs count for all that the owner carries: (polygon, low, high).
        self.keep_outs = (
            *(
                (_shifted(keep.polygon, x, y), z, z + keep.height_m)
                for keep in problem.keep_outs
                if keep.parent == parent
                for x, y, z in [tuple(float(v) for v in keep.place.origin_P_m)]
            ),
            *keep_outs_of(problem, parent, place),
        )
        self.origin_P_m, self.base_P_m = place.origin_P_m, oz
        self.top_m = place.height_m
        self.is_surface = not place.is_volume
        self.bounds: tuple[float, ...] = tuple(shapely.total_bounds([a for _, _, a in self.layers]).tolist())  # of all
        self.is_box = all(is_box(area) for _, _, area in self.layers)

    @cached_property
    def grown_layers(self) -> tuple[Polygon, ...]:
        """The layers' polygons grown by SLACK_M against rounding, prepared."""
        grown = tuple(area.buffer(SLACK_M, join_style="mitre") for _, _, area in self.layers)
        for area in grown:
            shapely.prepare(area)
        return grown


def _shifted(area: Polygon, x_m: float, y_m: float) -> Polygon:
    if x_m == y_m == 0.0:
        return area
    return cast(Polygon, shapely.transform(area, lambda points: np.add(points, (x_m, y_m))))


def is_box(area: Polygon) -> bool:
    """Whether a polygon is its own bounding box."""
    x0, y0, x1, y1 = area.bounds
    return abs((x1 - x0) * (y1 - y0) - area.area) <= 1e-12


class Limit(NamedTuple):
    """The footprint ends before `end_m` along (dx, dy) in the frame P of the owner."""

    dx: float
    dy: float
    end_m: float


@dataclass
class SolverModel:
    """See the module. `rules` are the relations to satisfy, `limits` half-planes by name of thing; the solver may
    replace the program's relations by stricter ones."""

    problem: Problem
    things: dict[str, Thing]
    shapes: dict[str, tuple[Shape, ...]]
    sites: dict[tuple[str, str], Site]
    rules: tuple[SceneRelation, ...]
    limits: dict[str, tuple[Limit, ...]]

    @cached_property
    def rules_of(self) -> dict[str, tuple[SceneRelation, ...]]:
        """Relations that depend on the pose of a thing, by name: as member, as frame, or as an owner of these."""
        rules_by_name: dict[str, list[SceneRelation]] = defaultdict(list)
        for rule in self.rules:
            for name in self.depends_on(rule):
                rules_by_name[name].append(rule)
        return {name: tuple(rules) for name, rules in rules_by_name.items()}

    def in_one_frame(self, rule: SceneRelation) -> bool:
        """Whether a relation can be evaluated in the frame of one owner that carries all its members."""
        owners = {self.things[name].parent for name in rule.things}
        return len(owners) == 1 and (not RELATIONS[rule.kind].frame_dependent or rule.frame in owners)

    def depends_on(self, rule: SceneRelation) -> set[str]:
        """Names of the things on whose poses a relation depends."""
        if self.in_one_frame(rule):
            return set(rule.things)
        names = (*rule.things, rule.frame)
        return {link for name in names if name != BACKGROUND for link in self.chains[name]}

    @cached_property
    def chains(self) -> dict[str, tuple[str, ...]]:
        """Each thing's movable owners, outermost first, and itself."""
        chains: dict[str, tuple[str, ...]] = {}
        for name in self.rank:
            chains[name] = (*chains.get(self.things[name].parent, ()), name)
        return chains

    @cached_property
    def rank(self) -> dict[str, int]:
        """Index of each thing in an order with owners first."""
        return {name: k for k, name in enumerate(owner_first(self.things))}

    @cached_property
    def carriers(self) -> frozenset[str]:
        """Owners of other things."""
        return frozenset(thing.parent for thing in self.things.values())

    def site(self, thing: Thing) -> Site:
        """The place a thing stands on."""
        return self.sites[thing.parent, thing.place.name]

    def allowed_orientations(self, thing: Thing) -> tuple[int, ...]:
        """Orientation indices that a thing may take: those of its domain; upright ones only where it carries others."""
        carries, shapes = thing.name in self.carriers, self.shapes[thing.name]
        return tuple(
            s for s in thing.domain.orientation_indices if s < len(shapes) and (shapes[s].upright or not carries)
        )

    def put(self, name: str, placement: Placement) -> Placed:
        """The thing at a pose."""
        thing = self.things[name]
        turned = self.shapes[name][placement.stance].turned(placement.yaw_rad)
        return Placed(name, thing.parent, thing.place.name, placement, turned, thing.place.origin_P_m)


def model_of(problem: Problem) -> SolverModel:
    """The model of a problem: rules are the program's own relations, and those of spaces kept clear."""
    things = {thing.name: thing for thing in sorted(problem.things, key=lambda t: t.name)}
    children: dict[str, list[Thing]] = defaultdict(list)
    for thing in things.values():
        children[thing.parent].append(thing)
    shapes: dict[str, tuple[Shape, ...]] = {}
    for name in reversed(owner_first(things)):
        loads: dict[str, tuple[ScenePlace, float]] = {}
        for child in children[name]:
            height = max(tallest(child, shapes[child.name]), loads.get(child.place.name, (None, 0.0))[1])
            loads[child.place.name] = (child.place, height)
        loads = {
            place: (where, _stacked_height_m(height, where, children[name], shapes))
            for place, (where, height) in loads.items()
        }
        shapes[name] = tuple(
            shape_of(stance, carried_prisms(stance, tuple(loads.values())) if loads else ())
            for stance in things[name].body.resting_orientations
        )
    places = {(thing.parent, thing.place.name): thing.place for thing in things.values()}
    sites = {key: Site(key[0], place, problem) for key, place in places.items()}
    rules = (*problem.relations, *keep_clear_rules(problem, things))
    return SolverModel(problem, things, shapes, sites, rules, {})


def _stacked_height_m(
    height_m: float, place: ScenePlace, children: Sequence[Thing], shapes: Mapping[str, tuple[Shape, ...]]
) -> float:
    # Largest height of contents of a volume when they are stacked, at most that of the rim.
    if not place.is_volume:
        return height_m
    inside = [child for child in children if child.place.name == place.name and not child.domain.fixed_poses]
    total = sum(max(shape.height_m for shape in shapes[child.name]) for child in inside)
    return max(height_m, min(total, place.height_m))


def owner_first(things: dict[str, Thing]) -> list[str]:
    """Names so that owners come before what they carry, else in the order of `things`."""
    order: list[str] = []
    seen: set[str] = set()

    def visit(name: str, above: tuple[str, ...]) -> None:
        if name in seen or name not in things or name in above:
            return
        visit(things[name].parent, (*above, name))
        seen.add(name)
        order.append(name)

    for name in things:
        visit(name, ())
    return order


def yaw_allowed(yaw_rad: float, span_rad: tuple[float, float]) -> float | None:
    """The yaw shifted by whole turns into a range (low, high), or None where that is impossible."""
    low, high = span_rad
    turns = -(-(low - SLACK_M - yaw_rad) // (2 * pi))
    moved = yaw_rad + turns * 2 * pi
    return min(max(moved, low), high) if moved <= high + SLACK_M else None
