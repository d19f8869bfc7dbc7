"""Lookup tables of a plan: the flat arrays (m, rad) from which the sampler draws. Needs numpy and `schemas` alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from schemas.arrays import FloatArray, IntArray
from schemas.scene.geometry import BACKGROUND
from schemas.scene.runtime_plan import PlanCase, PlanCombination, PlanStance, RuntimePlan

MICRO = 1e-6
BACKGROUND_COLUMN, ABSENT = -1, -2  # in place of the column of an owner
AUTHORED = -1  # in place of the index of a material: as the asset is


@dataclass(frozen=True)
class BodyStances:
    """The stances of all bodies, one after the other: stance s of body b has the index `start[b] + s`."""

    start: IntArray  # (bodies,)
    quat_wxyz: FloatArray  # (4, body stances)
    origin_height_m: FloatArray  # (body stances,)
    corners: tuple[FloatArray, ...]  # convex outline of all pieces of each, (v, 2) in S


@dataclass(frozen=True)
class Outlines:
    """Columns of things whose outlines have about as many corners; shorter outlines repeat their first corner.

    `x_m`, `y_m` are (v, k) for the columns when `fixed`, else (v, body stances).
    """

    columns: IntArray | None  # (k,), None for all
    x_m: FloatArray
    y_m: FloatArray
    fixed: bool


@dataclass(frozen=True)
class Level:
    """Things with the same number of movable owners: their columns, and their owners' (None: the background)."""

    columns: IntArray | None  # (k,), None for all
    owners: IntArray | None  # (k,)


@dataclass(frozen=True)
class MaterialGroup:
    """Materials of which one is drawn. Row 0 is AUTHORED throughout; columns are the objects, then the background."""

    material_of: IntArray  # (m + 1, objects + 1) index of a material, or AUTHORED


@dataclass(frozen=True)
class OptionalObjects:
    """Objects of which `least` to `most` are present: their columns in the samples, and their numbers 0 to n - 1."""

    columns: IntArray
    numbers: IntArray
    least: int
    most: int


@dataclass(frozen=True)
class Pool:
    """Cumulative shares of the cases of a pool, the last exactly 1 (None: equal shares), and their number."""

    cumulative_shares: FloatArray | None
    count: int


@dataclass(frozen=True)
class CombinationTables:
    """One combination of T things. A row is one thing in one case; `first_row[i]` + case is that of thing i.

    `bounds_m` (8, rows): cell and origin box as x low, x high, y low, y high each; `yaw_span_rad` (2, rows): start and
    total length of the yaw intervals; `yaw_gap_at_rad`, `yaw_gap_rad` (k, rows): where along that length a gap between
    two intervals lies, and its width. `height_m` (rows,) is the height of the support point in U of the owner,
    `place_m` (2, T) the origin of the place there.
    """

    things: IntArray  # columns in the samples of the objects among the things
    shown: IntArray | None  # which of the T things are objects, None for all: frames of grids are none
    pools: tuple[Pool, ...]
    pool_of: IntArray  # (T,)
    first_row: IntArray  # (T,)
    bounds_m: FloatArray
    yaw_span_rad: FloatArray
    yaw_gap_at_rad: FloatArray
    yaw_gap_rad: FloatArray
    has_origin_boxes: bool  # whether any origin box bounds more than its cell does
    place_m: FloatArray
    height_m: FloatArray
    stance: IntArray  # (rows,)
    bodies: IntArray  # (T, most bodies of one thing), repeated
    body_row: IntArray  # (T,) where the bodies of each begin, rows of `bodies` laid end to end
    body_count: FloatArray  # (T,)
    fixed_stance: IntArray | None  # (T,) where every thing has one body and stance in all cases, and
    body_stance: IntArray | None  # (T,) the index of both in `BodyStances`
    outlines: tuple[Outlines, ...]
    levels: tuple[Level, ...]
    background: tuple[float, float, float, float, float]  # x, y, z (m), cosine and sine of half its yaw
    support: IntArray  # of each object: column of what it stands on, BACKGROUND for it
    background_body: int  # -1 for none
    all_things: bool  # whether its things are the columns of the samples, one by one
    one_thing_per_pool: bool  # whether pool p is thing p alone
    groups: tuple[MaterialGroup, ...]
    lighting: IntArray  # indices into the plan's
    optional: tuple[OptionalObjects, ...] = ()
    rise_m: float = 0.0  # of the background and all that stands on it, at most


@dataclass(frozen=True)
class DrawLayout:
    """Offset of each draw in the random words of one sample; a sample uses `blocks` of four words."""

    cases: int
    bodies: int
    yaws: int
    xs: int
    ys: int
    materials: int
    lighting: int
    optional: int
    rise: int
    blocks: int


@dataclass(frozen=True)
class PlanTables:
    """All combinations. `names` are the columns of samples: every thing of any combination, in order."""

    names: tuple[str, ...]
    cumulative_shares: FloatArray  # (combinations,) the last exactly 1
    combinations: tuple[CombinationTables, ...]
    body_stances: BodyStances
    layout: DrawLayout
    channels: FloatArray  # (lighting, 4, 2) bounds; NaN where a lighting leaves a channel alone


def tables_of(plan: RuntimePlan) -> PlanTables:
    """The arrays of a consistent plan."""
    names = tuple(dict.fromkeys(thing.id for combination in plan.combinations for thing in combination.objects))
    body_stances = _body_stances(plan)
    combinations = tuple(
        _combination_tables(plan, combination, names, body_stances) for combination in plan.combinations
    )
    channels = [
        [
            bounds or (np.nan, np.nan)
            for bounds in (light.intensity, light.exposure, light.temperature_K, light.rotation)
        ]
        for light in plan.lighting
    ]
    return PlanTables(
        names,
        _cumulative_shares([combination.weight for combination in plan.combinations]),
        combinations,
        body_stances,
        _layout(combinations),
        np.array(channels, dtype=np.float64).reshape(-1, 4, 2),
    )


def _layout(combinations: Sequence[CombinationTables]) -> DrawLayout:
    """The same for all combinations, so that a sample's words depend on seed and index alone."""
    most_things = max(len(combination.first_row) for combination in combinations)
    several = any((combination.body_count > 1).any() for combination in combinations)
    cases = 1
    bodies = cases + max(len(combination.pools) for combination in combinations)
    yaws = bodies + (most_things if several else 0)
    xs, ys, materials = yaws + most_things, yaws + 2 * most_things, yaws + 3 * most_things
    lighting = materials + max(len(combination.groups) for combination in combinations)
    optional = lighting + 5
    rise = optional + 2 * max(len(combination.optional) for combination in combinations)
    words = rise + any(combination.rise_m > 0.0 for combination in combinations)
    return DrawLayout(cases, bodies, yaws, xs, ys, materials, lighting, optional, rise, -(-words // 4))


def _body_stances(plan: RuntimePlan) -> BodyStances:
    stances = [stance for body in plan.bodies for stance in body.stances]
    start = np.cumsum([0, *(len(body.stances) for body in plan.bodies)])[:-1]
    return BodyStances(
        start,
        np.array([stance.quat_wxyz for stance in stances], dtype=np.float64).reshape(-1, 4).T.copy(),
        np.array([stance.origin_height_m for stance in stances], dtype=np.float64),
        tuple(_outline(stance) for stance in stances),
    )


def _outline(stance: PlanStance) -> FloatArray:
    """Convex hull (v, 2) of all pieces, counter-clockwise (Andrew's monotone chain)."""
    points = sorted({(x, y) for prism in stance.prisms for x, y in prism.outline_m.tolist()})
    chains: list[list[tuple[float, float]]] = []
    for run in (points, points[::-1]):
        chain: list[tuple[float, float]] = []
        for x, y in run:
            while len(chain) > 1 and _turns_right(chain[-2], chain[-1], (x, y)):
                chain.pop()
            chain.append((x, y))
        chains.append(chain[:-1] or chain)
    return np.array(list(dict.fromkeys((*chains[0], *chains[1]))), dtype=np.float64)


def _turns_right(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) <= (b[1] - a[1]) * (c[0] - a[0])


def _cumulative_shares(weights: Sequence[float]) -> FloatArray:
    added = np.cumsum(np.array(weights, dtype=np.float64))
    cumulative_shares = added / added[-1]
    cumulative_shares[-1] = 1.0
    return cumulative_shares


def _combination_tables(
    plan: RuntimePlan, combination: PlanCombination, names: tuple[str, ...], body_stances: BodyStances
) -> CombinationTables:
    column = {name: index for index, name in enumerate(names)}
    local = {thing.id: index for index, thing in enumerate(combination.things)}
    pool_and_place = {name: (p, k) for p, pool in enumerate(combination.pools) for k, name in enumerate(pool.things)}
    thing_cases: list[tuple[PlanCase, int, int]] = []  # case, place within it, thing
    first_row = np.zeros(len(combination.things), dtype=np.int64)
    for index, thing in enumerate(combination.things):
        p, k = pool_and_place[thing.id]
        first_row[index] = len(thing_cases)
        thing_cases += [(case, k, index) for case in combination.pools[p].cases]
    stance = np.array([case.stances[k] for case, k, _ in thing_cases], dtype=np.int64)
    most_bodies = max((len(thing.bodies) for thing in combination.things), default=1)
    bodies = np.array(
        [(thing.bodies * most_bodies)[:most_bodies] for thing in combination.things], dtype=np.int64
    ).reshape(-1, most_bodies)
    yaw_gap_at_rad, yaw_gap_rad, yaw_span_rad = _yaw_intervals([case.yaws_urad[k] for case, k, _ in thing_cases])
    open_box = (-np.inf, np.inf, -np.inf, np.inf)
    bounds = [(*case.cells_um[k], *(case.origins_um[k] or open_box)) for case, k, _ in thing_cases]
    origins = [combination.places[thing.place][1].origin_m for thing in combination.things]
    possible = [sorted({int(s) for s in stance[first : first + _count(combination, pool_and_place, thing.id)]})
                for thing, first in zip(combination.things, first_row, strict=True)]  # fmt: skip
    choices = [
        sorted({int(body_stances.start[body]) + s for body in thing.bodies for s in stances})
        for thing, stances in zip(combination.things, possible, strict=True)
    ]
    fixed = all(len(indices) == 1 for indices in choices)
    shown = [index for index, thing in enumerate(combination.things) if not thing.is_frame]
    X_WB = np.array(combination.X_WB, dtype=np.float64)
    return CombinationTables(
        things=np.array([column[thing.id] for thing in combination.objects], dtype=np.int64),
        shown=None if len(shown) == len(combination.things) else np.array(shown, dtype=np.int64),
        pools=tuple(_pool([case.weight for case in pool.cases]) for pool in combination.pools),
        pool_of=np.array([pool_and_place[thing.id][0] for thing in combination.things], dtype=np.int64),
        first_row=first_row,
        bounds_m=MICRO * np.array(bounds, dtype=np.float64).reshape(-1, 8).T,
        yaw_span_rad=yaw_span_rad,
        yaw_gap_at_rad=yaw_gap_at_rad,
        yaw_gap_rad=yaw_gap_rad,
        has_origin_boxes=any(case.origins_um[k] is not None for case, k, _ in thing_cases),
        place_m=np.array([origin[:2] for origin in origins], dtype=np.float64).reshape(-1, 2).T.copy(),
        height_m=np.array([origins[t][2] + MICRO * case.base_um[k] for case, k, t in thing_cases], dtype=np.float64),
        stance=stance,
        bodies=bodies,
        body_row=most_bodies * np.arange(len(combination.things)),
        body_count=np.array([len(thing.bodies) for thing in combination.things], dtype=np.float64),
        fixed_stance=np.array([indices[0] for indices in possible], dtype=np.int64) if fixed else None,
        body_stance=np.array([indices[0] for indices in choices], dtype=np.int64) if fixed else None,
        outlines=_outlines(choices, body_stances),
        levels=_levels([thing.parent for thing in combination.things], local),
        background=(*X_WB[:3, 3].tolist(), *_half_turn(float(X_WB[0, 0]), float(X_WB[1, 0]))),
        support=np.array(
            [column.get(combination.standing_on(thing)[0], BACKGROUND_COLUMN) for thing in combination.objects],
            dtype=np.int64,
        ),
        background_body=-1 if combination.background is None else combination.background,
        all_things=tuple(thing.id for thing in combination.objects) == names,
        one_thing_per_pool=tuple(pool.things for pool in combination.pools)
        == tuple((thing.id,) for thing in combination.things),
        groups=_groups(plan, combination, {thing.id: k for k, thing in enumerate(combination.objects)}),
        lighting=np.array([_index(plan.lighting, name) for name in combination.lighting], dtype=np.int64),
        optional=tuple(
            OptionalObjects(
                np.array([column[name] for name in entry.things], dtype=np.int64),
                np.arange(len(entry.things)),
                entry.least,
                entry.most,
            )
            for entry in combination.distractors
        ),
        rise_m=combination.rise_m,
    )


def _half_turn(cosine: float, sine: float) -> tuple[float, float]:
    """Cosine and sine of half an angle; by square roots, which round alike on every machine."""
    if cosine >= 0.0:
        half = ((1.0 + cosine) / 2.0) ** 0.5
        return half, sine / (2.0 * half)
    half = ((1.0 - cosine) / 2.0) ** 0.5
    return abs(sine) / (2.0 * half), half if sine >= 0.0 else -half


def _count(combination: PlanCombination, pool_and_place: dict[str, tuple[int, int]], name: str) -> int:
    return len(combination.pools[pool_and_place[name][0]].cases)


def _pool(weights: Sequence[float]) -> Pool:
    equal = all(weight == weights[0] for weight in weights)
    return Pool(None if equal else _cumulative_shares(weights), len(weights))


def _yaw_intervals(intervals: Sequence[Sequence[tuple[int, int]]]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """`yaw_gap_at_rad`, `yaw_gap_rad` (k, rows) and `yaw_span_rad` (2, rows) of yaw intervals in microradians."""
    most_intervals = max((len(yaws) for yaws in intervals), default=1)
    gap_at_rad = np.full((most_intervals - 1, len(intervals)), np.inf)
    gap_rad = np.zeros((most_intervals - 1, len(intervals)))
    span_rad = np.zeros((2, len(intervals)))
    for row, yaws in enumerate(intervals):
        added = 0
        for k, ((low, high), (following, _)) in enumerate(pairwise(yaws)):
            added += high - low
            gap_at_rad[k, row], gap_rad[k, row] = MICRO * added, MICRO * (following - high)
        span_rad[:, row] = MICRO * yaws[0][0], MICRO * (added + yaws[-1][1] - yaws[-1][0])
    return gap_at_rad, gap_rad, span_rad


def _outlines(choices: Sequence[Sequence[int]], body_stances: BodyStances) -> tuple[Outlines, ...]:
    """Things by number of corners, rounded up to a power of two; those with several body stances look theirs up."""
    sizes: dict[tuple[bool, int], list[int]] = {}
    for index, possible in enumerate(choices):
        corners = max(len(body_stances.corners[body_stance]) for body_stance in possible)
        sizes.setdefault((len(possible) == 1, max(2, (corners - 1).bit_length())), []).append(index)
    outlines: list[Outlines] = []
    for (fixed, _), columns in sorted(sizes.items(), reverse=True):
        used = [choices[c][0] for c in columns] if fixed else range(len(body_stances.corners))
        used_by_columns = {body_stance for c in columns for body_stance in choices[c]}
        most_corners = max(len(body_stances.corners[body_stance]) for body_stance in used_by_columns)
        x_m, y_m = np.zeros((most_corners, len(used))), np.zeros((most_corners, len(used)))
        for k, body_stance in enumerate(used):
            if body_stance in used_by_columns:
                outline = body_stances.corners[body_stance]
                x_m[:, k], y_m[:, k] = outline[0]
                x_m[: len(outline), k], y_m[: len(outline), k] = outline.T
        everything = len(columns) == len(choices)
        outlines.append(Outlines(None if everything else np.array(columns, dtype=np.int64), x_m, y_m, fixed))
    return tuple(outlines)


def _levels(parents: Sequence[str], local: dict[str, int]) -> tuple[Level, ...]:
    """Things by their number of movable owners, those without first."""
    depth: list[int] = []
    for parent in parents:  # owners come before what they own
        depth.append(depth[local[parent]] + 1 if parent in local else 0)
    levels: list[Level] = []
    for level in sorted(set(depth)):
        columns = [index for index, deep in enumerate(depth) if deep == level]
        owners = np.array([local[parents[c]] for c in columns], dtype=np.int64) if level else None
        levels.append(Level(None if len(columns) == len(depth) else np.array(columns, dtype=np.int64), owners))
    return tuple(levels)


def _groups(plan: RuntimePlan, combination: PlanCombination, local: dict[str, int]) -> tuple[MaterialGroup, ...]:
    """Materials that share a thing exclude combination another; of each such group combination is drawn, or none."""
    offered = [(_index(plan.materials, name), set(plan.materials[_index(plan.materials, name)].objects))
               for name in combination.materials]  # fmt: skip
    groups: list[tuple[list[int], set[str]]] = []
    for index, things in offered:
        joined, covered = [index], set(things)
        rest: list[tuple[list[int], set[str]]] = []
        for members, known in groups:
            if known & covered:
                joined, covered = members + joined, covered | known
            else:
                rest.append((members, known))
        groups = [*rest, (joined, covered)]
    material_groups: list[MaterialGroup] = []
    columns = local | {BACKGROUND: len(local)}
    for members in sorted(sorted(members) for members, _ in groups):
        material_of = np.full((len(members) + 1, len(columns)), AUTHORED, dtype=np.int64)
        for row, index in enumerate(members, start=1):
            material_of[row, [columns[name] for name in plan.materials[index].objects if name in columns]] = index
        material_groups.append(MaterialGroup(material_of))
    return tuple(material_groups)


def _index(named: Sequence[object], name: str) -> int:
    return [getattr(item, "id", None) for item in named].index(name)
