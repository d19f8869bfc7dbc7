"""Bounded search over exact feasible regions with conflict-directed backjumping (Prosser 1993).

Each level places one thing, owners first. A candidate pose is added to a copy of the assignment, validated against the
constraints that it completes, and followed by forward checking: a pose that leaves a related thing no region is undone
at once. At a dead end the search returns to the latest thing that contributed to it. Candidates are samples, so a
failed search proves nothing.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush
from math import cos, inf, pi, sin
from typing import Literal

from numpy.random import Generator
from shapely.affinity import translate
from shapely.geometry.base import BaseGeometry

from scenec.ir.problem import Placement, Thing
from scenec.relations.table import RELATIONS
from scenec.solve.check import Assignment, blockers
from scenec.solve.model import SolverModel, yaw_allowed
from scenec.solve.placed import Placed
from scenec.solve.points import extreme_point, sample_point
from scenec.solve.regions import exact_yaw, feasible_region, region_alone
from scenec.solve.stacks import stack_levels
from scenec.solve.streams import stream

POSE_TRIES = 8  # orientations and yaws tried for one thing at one node
COLUMN_TRIES = 4  # of these, straight over the middle of each thing that may support it
LOOK_AHEAD = 6  # related things checked after a choice
DENSE = 0.3  # share of the place's area above which extreme points are tried before random ones
HOPELESS = 6  # restarts that end because a thing has no region whatever the others do
NODES_BEFORE_RESTART = 40  # times the number of things
PIECES_A_STEP = 4  # of a footprint


@dataclass
class SearchBudget:
    """Step budget of a search, with the largest partial assignment so far and the number of failures by thing.

    A pose of a thing of many pieces takes several steps, so that the budget bounds the time for any footprints.
    """

    max_steps: int
    steps_taken: int = 0
    best_assignment: dict[str, Placed] = field(default_factory=dict)
    failures: Counter[str] = field(default_factory=Counter)

    def step(self, steps: int = 1) -> bool:
        """Takes steps; False when the budget is exhausted."""
        self.steps_taken += steps
        return self.steps_taken <= self.max_steps

    def record_best(self, standing: Assignment) -> None:
        """Keeps the assignment if it is larger than the best so far."""
        if len(standing) > len(self.best_assignment):
            self.best_assignment = dict(standing)


class RegionCache:
    """Cache of regions by unary constraints, by thing, orientation, yaw and height."""

    def __init__(self, model: SolverModel):
        self.model = model
        self._known: dict[tuple[str, int, float, float], BaseGeometry] = {}

    def region_alone(self, name: str, stance: int, yaw_rad: float, base_m: float = 0.0) -> BaseGeometry:
        """Region of a thing at an orientation and yaw, `base_m` over its place, by its unary constraints."""
        key = (name, stance, yaw_rad, base_m)
        if key not in self._known:
            if len(self._known) > 4096:
                self._known.clear()
            self._known[key] = region_alone(self.model, name, self.model.shapes[name][stance].turned(yaw_rad), base_m)
        return self._known[key]


def search(
    model: SolverModel, names: Sequence[str], standing: Assignment, seed: int, search_budget: SearchBudget
) -> dict[str, Placed] | None:
    """Consistent poses for `names`, given `standing`; None when the steps ran out or all attempts failed."""
    order, regions, attempt, failed_alone = ordered(model, names), RegionCache(model), 0, 0
    while search_budget.steps_taken < search_budget.max_steps and failed_alone < HOPELESS:
        nodes = sum(steps_of(model, name) for name in order)
        limit = search_budget.steps_taken + NODES_BEFORE_RESTART * nodes * (1 + attempt)
        outcome = _descend(model, order, standing, seed, attempt, search_budget, limit, regions)
        if isinstance(outcome, dict):
            return outcome
        attempt, failed_alone = attempt + 1, failed_alone + (outcome == "alone")
        # Things that failed most come first in the next attempt, after their owners.
        order = ordered(model, names, search_budget.failures)
    return None


def steps_of(model: SolverModel, name: str) -> int:
    """Number of steps of a pose of a thing: one for most, more for footprints of many pieces."""
    return 1 + max((len(shape.pieces) for shape in model.shapes[name]), default=0) // PIECES_A_STEP


def _descend(
    model: SolverModel,
    order: Sequence[str],
    standing: Assignment,
    seed: int,
    attempt: int,
    search_budget: SearchBudget,
    limit: int,
    regions: RegionCache,
) -> dict[str, Placed] | Literal["limit", "alone"]:
    # Poses, or the reason for failure: step limit, or a thing without region whatever the others do.
    assignment: dict[str, Placed] = dict(standing)
    culprits: list[set[str]] = [set() for _ in order]
    streams: list[Iterator[tuple[Placed | None, set[str]]]] = []
    level, depth_of = 0, {name: k for k, name in enumerate(order)}
    dense = is_dense(model, order)
    while level < len(order):
        name = order[level]
        if level == len(streams):
            rng = stream(seed, name, attempt, search_budget.steps_taken)
            culprits[level] = set()
            streams.append(candidates(model, name, assignment, rng, regions, dense or attempt % 2 == 1))
        chosen = None
        for placed, blamed in streams[level]:
            if search_budget.steps_taken >= min(limit, search_budget.max_steps):
                return "limit"
            search_budget.step(steps_of(model, name))
            culprits[level] |= blamed
            if placed is None:
                continue
            trial = {**assignment, name: placed}
            clashes = blockers(model, trial, name)
            if clashes is None:
                blamed_by_look_ahead = _forward_check(model, name, trial, order[level + 1 :], regions, seed)
                if blamed_by_look_ahead is None:
                    chosen = placed
                    break
                clashes = blamed_by_look_ahead
            culprits[level] |= clashes
        if chosen is not None:
            assignment = {**assignment, name: chosen}
            level += 1
            search_budget.record_best(assignment)
            continue
        search_budget.failures[name] += 1
        blamed_levels = [depth_of[c] for c in culprits[level] if c in depth_of and depth_of[c] < level]
        if not blamed_levels:
            return "alone"
        target = max(blamed_levels)
        culprits[target] |= culprits[level] - {order[target]}
        for undone in order[target:level]:
            assignment.pop(undone, None)
        del streams[target + 1 :]
        level = target
    return {name: assignment[name] for name in order}


def candidates(
    model: SolverModel, name: str, assignment: Assignment, rng: Generator, regions: RegionCache, dense: bool
) -> Iterator[tuple[Placed | None, set[str]]]:
    """Candidate poses, each with the things that reduced its region; None where the region was empty."""
    thing = model.things[name]
    if thing.domain.fixed_poses:
        yield from _fixed_pose_candidates(model, thing, rng)
        return
    if dense:  # proving that a full floor has no region is costly
        yield from _on_contents(model, thing, assignment, rng, regions)
    lean = rng.random() * 2 * pi if not dense else (2 * int(rng.integers(4)) + 1) * pi / 4
    for stance, yaw in poses_to_try(model, thing, rng, dense):
        turned = model.shapes[name][stance].turned(yaw)
        region, blamed = feasible_region(model, name, turned, assignment, regions.region_alone(name, stance, yaw))
        if region.is_empty:
            yield None, blamed
            continue
        inner, edge = sample_point(region, rng), extreme_point(region, cos(lean), sin(lean))
        for point in (edge, inner) if dense else (inner, edge):
            if point is None:
                continue
            ox, oy = (float(v) for v in thing.place.origin_P_m[:2])
            placed = model.put(name, Placement(point[0] - ox, point[1] - oy, yaw, stance))
            if (toward := exact_yaw(model, placed, assignment)) is not None:
                better = yaw_allowed(toward, thing.domain.yaw_rad)
                if better is not None:
                    yield model.put(name, Placement(point[0] - ox, point[1] - oy, better, stance)), blamed
            yield placed, blamed
    if not dense:
        yield from _on_contents(model, thing, assignment, rng, regions)


def _on_contents(
    model: SolverModel, thing: Thing, assignment: Assignment, rng: Generator, regions: RegionCache
) -> Iterator[tuple[Placed | None, set[str]]]:
    # Poses on contents of its volume: first its foot over the middle of one top, which is cheap; then anywhere.
    ox, oy = (float(v) for v in thing.place.origin_P_m[:2])
    levels = stack_levels(model, assignment, thing.name)
    poses = poses_to_try(model, thing, rng, dense=True)[:POSE_TRIES] if levels else []
    middle_of = {
        pose: model.put(thing.name, Placement(-ox, -oy, pose[1], pose[0])).contact.foot.centroid for pose in poses
    }
    for base, _, middles in levels:
        for stance, yaw in poses[:COLUMN_TRIES]:
            middle = middle_of[stance, yaw]
            for i in rng.permutation(len(middles)).tolist():
                x, y = middles[i].x - middle.x - ox, middles[i].y - middle.y - oy
                yield model.put(thing.name, Placement(x, y, yaw, stance, base)), set()
    for base, hull, _ in levels:
        for stance, yaw in poses:
            turned = model.shapes[thing.name][stance].turned(yaw)
            unary_region = regions.region_alone(thing.name, stance, yaw, base)
            region, blamed = feasible_region(model, thing.name, turned, assignment, unary_region, base)
            middle = middle_of[stance, yaw]
            region = region.intersection(translate(hull, -middle.x, -middle.y))
            if region.is_empty:
                yield None, blamed
                continue
            for point in (sample_point(region, rng), sample_point(region, rng)):
                if point is not None:
                    yield model.put(thing.name, Placement(point[0] - ox, point[1] - oy, yaw, stance, base)), blamed


def poses_to_try(model: SolverModel, thing: Thing, rng: Generator, dense: bool) -> list[tuple[int, float]]:
    """(orientation index, yaw) pairs: random ones and quarter turns, the latter first in dense scenes."""
    orientations, (low, high) = model.allowed_orientations(thing), thing.domain.yaw_rad
    if not orientations:
        return []
    quarters = [yaw for k in (0, 1, 2, 3) if (yaw := yaw_allowed(k * pi / 2, (low, high))) is not None]
    if high - low < 1e-12:
        yaws = [low]
    else:
        free = (low + (high - low) * rng.random(POSE_TRIES)).tolist()
        straight = [quarters[i] for i in rng.permutation(len(quarters)).tolist()]
        yaws = [*straight, low, high, *free] if dense else [free[0], *straight, *free[1:]]
    picked = [orientations[i] for i in rng.permutation(len(orientations)).tolist()]
    return [(picked[k % len(picked)], yaws[k % len(yaws)]) for k in range(max(len(yaws), len(picked)))][
        : 2 * POSE_TRIES
    ]


def _fixed_pose_candidates(
    model: SolverModel, thing: Thing, rng: Generator
) -> Iterator[tuple[Placed | None, set[str]]]:
    for k in rng.permutation(len(thing.domain.fixed_poses)).tolist():
        for placement in fixed_pose_placements(model, thing, k):
            yield model.put(thing.name, placement), set()


def fixed_pose_placements(model: SolverModel, thing: Thing, number: int) -> list[Placement]:
    """The placement at a fixed pose in its orientation; none when that orientation is not allowed."""
    fixed_pose, shapes = thing.domain.fixed_poses[number], model.shapes[thing.name]
    return [
        Placement(
            fixed_pose.x_m,
            fixed_pose.y_m,
            fixed_pose.yaw_rad,
            stance,
            _floor(fixed_pose.z_m - shapes[stance].origin_height_m),
        )
        for stance in model.allowed_orientations(thing)
        if stance == fixed_pose.stance
    ]


def _floor(base_m: float) -> float:
    return 0.0 if abs(base_m) < 1e-12 else base_m


def _forward_check(
    model: SolverModel, name: str, trial: Assignment, later: Sequence[str], regions: RegionCache, seed: int
) -> set[str] | None:
    # Forward checking of unplaced things that a relation links to `name`: names blamed for an empty region, or None.
    waiting = set(later)
    tied = {n for rule in model.rules_of.get(name, ()) for n in rule.things if n in waiting and n != name}
    for other in sorted(tied)[:LOOK_AHEAD]:
        thing = model.things[other]
        if thing.domain.fixed_poses or not set(model.chains[other][:-1]).issubset(trial):
            continue
        if thing.place.is_volume and any(RELATIONS[r.kind].bounds_heights for r in model.rules_of[other]):
            continue  # it may have to lie on other contents
        blamed: set[str] = set()
        for stance, yaw in poses_to_try(model, thing, stream(seed, "ahead", other), dense=True)[:POSE_TRIES]:
            turned = model.shapes[other][stance].turned(yaw)
            region, cut = feasible_region(model, other, turned, trial, regions.region_alone(other, stance, yaw))
            if not region.is_empty:
                break
            blamed |= cut
        else:
            return blamed - {name}
    return None


def ordered(model: SolverModel, names: Sequence[str], failures: Counter[str] | None = None) -> list[str]:
    """Names in search order: owners first, then by earlier failures, few poses, small range, large area; last those
    that relations place after their mates."""
    late = {name for rule in model.rules for name in RELATIONS[rule.kind].placed_last(rule)}

    def key(name: str) -> tuple[float, ...]:
        thing = model.things[name]
        area = max((shape.area_m2 for shape in model.shapes[name]), default=0.0)
        if thing.domain.fixed_poses:
            return (-(failures or {}).get(name, 0), name in late, len(thing.domain.fixed_poses), -area)
        return (-(failures or {}).get(name, 0), name in late, 1e3 + min(_room(thing), 1e6), -area)

    within = set(names)
    contents: dict[str, list[str]] = defaultdict(list)
    for name in names:
        contents[model.things[name].parent].append(name)
    ready = [(key(name), name) for name in names if model.things[name].parent not in within]
    heapify(ready)
    order: list[str] = []
    while ready:
        _, name = heappop(ready)
        order.append(name)
        for content in contents[name]:
            heappush(ready, (key(content), content))
    return order


def _room(thing: Thing) -> float:
    # Area of the range of the origin, infinite without ranges.
    (xa, xb), (ya, yb) = thing.domain.x_m, thing.domain.y_m
    return (xb - xa) * (yb - ya) if inf not in (xb - xa, yb - ya) else inf


def is_dense(model: SolverModel, names: Sequence[str]) -> bool:
    """Whether footprints cover more than the share DENSE of some place."""
    by_site: dict[tuple[str, str], float] = defaultdict(float)
    for name in names:
        thing = model.things[name]
        by_site[thing.parent, thing.place.name] += model.shapes[name][0].area_m2
    return any(area > DENSE * model.sites[key].layers[0][2].area for key, area in by_site.items())
