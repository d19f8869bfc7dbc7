"""Bounded search over exact feasible regions with conflict-directed backjumping (Prosser 1993).

Each level seats one thing, owners first. A candidate is put into a copy of the assignment, validated by what it
activates, and looked ahead from: a choice that leaves a related thing no place is taken back at once. At a dead end the
search returns to the latest thing that had a part in it. Candidates are samples, so a failed search proves nothing.
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
from scenec.solve.check import Assignment, blockers
from scenec.solve.model import Model, yaw_allowed
from scenec.solve.placed import Placed
from scenec.solve.points import corner, drawn
from scenec.solve.regions import aimed, alone, feasible
from scenec.solve.stacks import levels
from scenec.solve.streams import stream

TRIES = 8  # stances and yaws tried for one thing at one node
COLUMN_TRIES = 4  # of these, straight over the middle of each thing that may carry it
LOOK_AHEAD = 6  # related things looked at after a choice
DENSE = 0.3  # share of the place's area from which on corners are tried before points drawn at random
HOPELESS = 6  # restarts after which a thing that never finds a place by itself ends the search
NODES_BEFORE_RESTART = 40  # times the number of things
PIECES_A_STEP = 4  # of a footprint


@dataclass
class Effort:
    """Steps left, and what is worth telling when they run out: the most things that ever stood, failures by thing.

    A pose of a thing of many pieces takes several steps, so that a budget bounds the time whatever is placed.
    """

    left: int
    taken: int = 0
    stood: dict[str, Placed] = field(default_factory=dict)
    failures: Counter[str] = field(default_factory=Counter)

    def step(self, steps: int = 1) -> bool:
        """Takes steps; False when there is none left."""
        self.taken += steps
        return self.taken <= self.left

    def reached(self, standing: Assignment) -> None:
        """Remembers what stands, if it is more than ever before."""
        if len(standing) > len(self.stood):
            self.stood = dict(standing)


class Regions:
    """Regions of things by themselves, remembered by stance and yaw."""

    def __init__(self, model: Model):
        self.model = model
        self._known: dict[tuple[str, int, float, float], BaseGeometry] = {}

    def alone(self, name: str, stance: int, yaw_rad: float, base_m: float = 0.0) -> BaseGeometry:
        """Where a thing may be at a stance and yaw, `base_m` over its place, when it is by itself."""
        key = (name, stance, yaw_rad, base_m)
        if key not in self._known:
            if len(self._known) > 4096:
                self._known.clear()
            self._known[key] = alone(self.model, name, self.model.shapes[name][stance].turned(yaw_rad), base_m)
        return self._known[key]


def search(
    model: Model, names: Sequence[str], standing: Assignment, seed: int, effort: Effort
) -> dict[str, Placed] | None:
    """Poses for `names` that agree with each other and with what stands; None when the steps ran out or all failed."""
    order, regions, attempt, hopeless = ordered(model, names), Regions(model), 0, 0
    while effort.taken < effort.left and hopeless < HOPELESS:
        nodes = sum(steps_of(model, name) for name in order)
        limit = effort.taken + NODES_BEFORE_RESTART * nodes * (1 + attempt)
        found = _descend(model, order, standing, seed, attempt, effort, limit, regions)
        if isinstance(found, dict):
            return found
        attempt, hopeless = attempt + 1, hopeless + (found == "alone")
        # What failed most goes first next time, as far as owners allow.
        order = ordered(model, names, effort.failures)
    return None


def steps_of(model: Model, name: str) -> int:
    """How many steps a pose of a thing takes: one for most, more where its footprint is of many pieces."""
    return 1 + max((len(shape.pieces) for shape in model.shapes[name]), default=0) // PIECES_A_STEP


def _descend(
    model: Model,
    order: Sequence[str],
    standing: Assignment,
    seed: int,
    attempt: int,
    effort: Effort,
    limit: int,
    regions: Regions,
) -> dict[str, Placed] | Literal["limit", "alone"]:
    # Poses, or why not: the limit of steps was met, or something found no place whatever the others did.
    assignment: dict[str, Placed] = dict(standing)
    culprits: list[set[str]] = [set() for _ in order]
    streams: list[Iterator[tuple[Placed | None, set[str]]]] = []
    level, depth_of = 0, {name: k for k, name in enumerate(order)}
    dense = is_dense(model, order)
    while level < len(order):
        name = order[level]
        if level == len(streams):
            rng = stream(seed, name, attempt, effort.taken)
            culprits[level] = set()
            streams.append(candidates(model, name, assignment, rng, regions, dense or attempt % 2 == 1))
        chosen = None
        for placed, blamed in streams[level]:
            if effort.taken >= min(limit, effort.left):
                return "limit"
            effort.step(steps_of(model, name))
            culprits[level] |= blamed
            if placed is None:
                continue
            trial = {**assignment, name: placed}
            clashes = blockers(model, trial, name)
            if clashes is None:
                starved = _starved(model, name, trial, order[level + 1 :], regions, seed)
                if starved is None:
                    chosen = placed
                    break
                clashes = starved
            culprits[level] |= clashes
        if chosen is not None:
            assignment = {**assignment, name: chosen}
            level += 1
            effort.reached(assignment)
            continue
        effort.failures[name] += 1
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
    model: Model, name: str, assignment: Assignment, rng: Generator, regions: Regions, dense: bool
) -> Iterator[tuple[Placed | None, set[str]]]:
    """Poses worth trying, each with the things that cut its region; None where a stance and yaw had no room."""
    thing = model.things[name]
    if thing.domain.spots:
        yield from _spot_candidates(model, thing, rng)
        return
    if dense:  # a full floor is costly to find full
        yield from _on_contents(model, thing, assignment, rng, regions)
    lean = rng.random() * 2 * pi if not dense else (2 * int(rng.integers(4)) + 1) * pi / 4
    for stance, yaw in poses_to_try(model, thing, rng, dense):
        turned = model.shapes[name][stance].turned(yaw)
        region, blamed = feasible(model, name, turned, assignment, regions.alone(name, stance, yaw))
        if region.is_empty:
            yield None, blamed
            continue
        inner, edge = drawn(region, rng), corner(region, cos(lean), sin(lean))
        for point in (edge, inner) if dense else (inner, edge):
            if point is None:
                continue
            ox, oy = (float(v) for v in thing.place.origin_P_m[:2])
            placed = model.put(name, Placement(point[0] - ox, point[1] - oy, yaw, stance))
            if (toward := aimed(model, placed, assignment)) is not None:
                better = yaw_allowed(toward, thing.domain.yaw_rad)
                if better is not None:
                    yield model.put(name, Placement(point[0] - ox, point[1] - oy, better, stance)), blamed
            yield placed, blamed
    if not dense:
        yield from _on_contents(model, thing, assignment, rng, regions)


def _on_contents(
    model: Model, thing: Thing, assignment: Assignment, rng: Generator, regions: Regions
) -> Iterator[tuple[Placed | None, set[str]]]:
    # Over what lies in its volume: its foot over the middle of one top, which costs little to try; then anywhere.
    ox, oy = (float(v) for v in thing.place.origin_P_m[:2])
    found = levels(model, assignment, thing.name)
    poses = poses_to_try(model, thing, rng, dense=True)[:TRIES] if found else []
    middle_of = {
        pose: model.put(thing.name, Placement(-ox, -oy, pose[1], pose[0])).contact.foot.centroid for pose in poses
    }
    for base, _, middles in found:
        for stance, yaw in poses[:COLUMN_TRIES]:
            own = middle_of[stance, yaw]
            for i in rng.permutation(len(middles)).tolist():
                x, y = middles[i].x - own.x - ox, middles[i].y - own.y - oy
                yield model.put(thing.name, Placement(x, y, yaw, stance, base)), set()
    for base, hull, _ in found:
        for stance, yaw in poses:
            turned = model.shapes[thing.name][stance].turned(yaw)
            alone_m = regions.alone(thing.name, stance, yaw, base)
            region, blamed = feasible(model, thing.name, turned, assignment, alone_m, base)
            own = middle_of[stance, yaw]
            region = region.intersection(translate(hull, -own.x, -own.y))
            if region.is_empty:
                yield None, blamed
                continue
            for point in (drawn(region, rng), drawn(region, rng)):
                if point is not None:
                    yield model.put(thing.name, Placement(point[0] - ox, point[1] - oy, yaw, stance, base)), blamed


def poses_to_try(model: Model, thing: Thing, rng: Generator, dense: bool) -> list[tuple[int, float]]:
    """(stance, yaw) pairs: drawn from the domain and quarter turns, the latter first where room is scarce."""
    stances, (low, high) = model.stances(thing), thing.domain.yaw_rad
    if not stances:
        return []
    quarters = [yaw for k in (0, 1, 2, 3) if (yaw := yaw_allowed(k * pi / 2, (low, high))) is not None]
    if high - low < 1e-12:
        yaws = [low]
    else:
        free = (low + (high - low) * rng.random(TRIES)).tolist()
        straight = [quarters[i] for i in rng.permutation(len(quarters)).tolist()]
        yaws = [*straight, low, high, *free] if dense else [free[0], *straight, *free[1:]]
    picked = [stances[i] for i in rng.permutation(len(stances)).tolist()]
    return [(picked[k % len(picked)], yaws[k % len(yaws)]) for k in range(max(len(yaws), len(picked)))][: 2 * TRIES]


def _spot_candidates(model: Model, thing: Thing, rng: Generator) -> Iterator[tuple[Placed | None, set[str]]]:
    for k in rng.permutation(len(thing.domain.spots)).tolist():
        for placement in spot_placements(model, thing, k):
            yield model.put(thing.name, placement), set()


def spot_placements(model: Model, thing: Thing, number: int) -> list[Placement]:
    """The pose of a spot, in the stance that it asks for; none when that is not allowed."""
    spot, shapes = thing.domain.spots[number], model.shapes[thing.name]
    return [
        Placement(spot.x_m, spot.y_m, spot.yaw_rad, stance, _floor(spot.z_m - shapes[stance].origin_height_m))
        for stance in model.stances(thing)
        if stance == spot.stance
    ]


def _floor(base_m: float) -> float:
    return 0.0 if abs(base_m) < 1e-12 else base_m


def _starved(
    model: Model, name: str, trial: Assignment, later: Sequence[str], regions: Regions, seed: int
) -> set[str] | None:
    # Forward checking: things that must still come and that a rule ties to `name`, or whose own room is small.
    waiting = set(later)
    tied = {n for rule in model.rules_of.get(name, ()) for n in rule.things if n in waiting and n != name}
    for other in sorted(tied)[:LOOK_AHEAD]:
        thing = model.things[other]
        if thing.domain.spots or not set(model.chains[other][:-1]).issubset(trial):
            continue
        blamed: set[str] = set()
        for stance, yaw in poses_to_try(model, thing, stream(seed, "ahead", other), dense=True)[:TRIES]:
            turned = model.shapes[other][stance].turned(yaw)
            region, cut = feasible(model, other, turned, trial, regions.alone(other, stance, yaw))
            if not region.is_empty:
                break
            blamed |= cut
        else:
            return blamed - {name}
    return None


def ordered(model: Model, names: Sequence[str], failures: Counter[str] | None = None) -> list[str]:
    """Owners first; then what failed before, what has few poses or little room, what is large; those that aim at others
    or stand between them last."""
    late = {rule.things[0] for rule in model.rules if rule.kind in ("facing", "between")}

    def key(name: str) -> tuple[float, ...]:
        thing = model.things[name]
        area = max((shape.area_m2 for shape in model.shapes[name]), default=0.0)
        if thing.domain.spots:
            return (-(failures or {}).get(name, 0), name in late, len(thing.domain.spots), -area)
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
    # Area of the range of the origin, infinite for what may be anywhere on its place.
    (xa, xb), (ya, yb) = thing.domain.x_m, thing.domain.y_m
    return (xb - xa) * (yb - ya) if inf not in (xb - xa, yb - ya) else inf


def is_dense(model: Model, names: Sequence[str]) -> bool:
    """Whether footprints take more than a share DENSE of some place."""
    by_site: dict[tuple[str, str], float] = defaultdict(float)
    for name in names:
        thing = model.things[name]
        by_site[thing.parent, thing.place.name] += model.shapes[name][0].area_m2
    return any(area > DENSE * model.sites[key].layers[0][2].area for key, area in by_site.items())
