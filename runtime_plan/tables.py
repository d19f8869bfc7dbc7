"""A plan as flat arrays, made once: what a draw looks up, in metres and radians. Needs numpy and `schemas` alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from schemas.scene.runtime_plan import PlanCase, PlanCombination, PlanStance, RuntimePlan

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
MICRO = 1e-6
BACKGROUND = "background"  # the owner of what stands on nothing that moves
BACKGROUND_COLUMN, ABSENT = -1, -2  # in place of the column of an owner
AUTHORED = -1  # in place of the index of a material: as the asset is


@dataclass(frozen=True)
class BodyStances:
    """Every way in which any body stands: form of body b in stance s is `start[b] + s`."""

    start: IntArray  # (bodies,)
    quat_wxyz: FloatArray  # (4, forms)
    origin_height_m: FloatArray  # (forms,)
    corners: tuple[FloatArray, ...]  # convex outline of all pieces of each form, (v, 2) in S


@dataclass(frozen=True)
class Outlines:
    """Columns of things whose outlines have about as many corners; shorter outlines repeat their first corner.

    `x_m`, `y_m` are (v, k) for the columns when `forms` is None, else (v, forms).
    """

    columns: IntArray | None  # (k,), None for all
    x_m: FloatArray
    y_m: FloatArray
    fixed: bool


@dataclass(frozen=True)
class Level:
    """Things as deep as one another: their columns, and the columns of their owners (None: the background)."""

    columns: IntArray | None  # (k,), None for all
    owners: IntArray | None  # (k,)


@dataclass(frozen=True)
class MaterialGroup:
    """Materials of which one is drawn: what each of T things and then the background wears, AUTHORED in row 0."""

    material_of: IntArray  # (m + 1, T + 1)


@dataclass(frozen=True)
class Pool:
    """Shares of its cases added up, the last exactly 1 (None: equal shares), and how many there are."""

    cumulative_shares: FloatArray | None
    count: int


@dataclass(frozen=True)
class CombinationTables:
    """One combination of T things. A row is one thing in one case; `first_row[i]` + case is that of thing i.

    `bounds_m` (8, rows): cell and origin box as x low, x high, y low, y high each; `turn` (2, rows): start and total
    length of the yaw intervals; `turn_past`, `turn_jump` (k, rows): where along that length the next interval begins,
    and how far its start lies beyond. `height_m` (rows,) is that of the support point in U of the owner, `place_m`
    (2, T) the origin of the place there.
    """

    things: IntArray  # (T,) columns in the samples
    pools: tuple[Pool, ...]
    pool_of: IntArray  # (T,)
    first_row: IntArray  # (T,)
    bounds_m: FloatArray
    turn: FloatArray
    yaw_gap_at_rad: FloatArray
    yaw_gap_rad: FloatArray
    has_origin_boxes: bool  # whether any origin box bounds more than its cell does
    place_m: FloatArray
    height_m: FloatArray
    stance: IntArray  # (rows,)
    bodies: IntArray  # (T, most bodies of one thing), repeated
    body_row: IntArray  # (T,) where the bodies of each begin, rows of `bodies` laid end to end
    body_count: FloatArray  # (T,)
    fixed_stance: IntArray | None  # (T,) where every thing has one form in all cases, and
    body_stance: IntArray | None  # (T,) that form
    outlines: tuple[Outlines, ...]
    levels: tuple[Level, ...]
    background: tuple[float, float, float, float, float]  # x, y, z (m), cosine and sine of half its yaw
    support: IntArray  # (T,) column of the owner, BACKGROUND for it
    background_body: int  # -1 for none
    all_things: bool  # whether its things are the columns of the samples, one by one
    one_thing_per_pool: bool  # whether pool p is thing p alone
    groups: tuple[MaterialGroup, ...]
    lighting: IntArray  # indices into the plan's


@dataclass(frozen=True)
class DrawLayout:
    """Where in the words of one sample each draw lies; `blocks` of four words a sample."""

    cases: int
    bodies: int
    yaws: int
    xs: int
    ys: int
    materials: int
    lighting: int
    blocks: int


@dataclass(frozen=True)
class PlanTables:
    """All combinations. `names` are the columns of samples: every thing of any combination, in order."""

    names: tuple[str, ...]
    cumulative_shares: FloatArray  # (combinations,) added up, the last exactly 1
    combinations: tuple[CombinationTables, ...]
    body_stances: BodyStances
    layout: DrawLayout
    channels: FloatArray  # (lighting, 4, 2) bounds; NaN where a lighting leaves a channel alone


def tables_of(plan: RuntimePlan) -> PlanTables:
    """The arrays of a consistent plan."""
    names = tuple(dict.fromkeys(thing.id for one in plan.combinations for thing in one.things))
    body_stances = _forms(plan)
    combinations = tuple(_tables(plan, one, names, body_stances) for one in plan.combinations)
    channels = [
        [
            bounds or (np.nan, np.nan)
            for bounds in (light.intensity, light.exposure, light.temperature_K, light.rotation)
        ]
        for light in plan.lighting
    ]
    return PlanTables(
        names,
        _cumulative_shares([one.weight for one in plan.combinations]),
        combinations,
        body_stances,
        _layout(combinations),
        np.array(channels, dtype=np.float64).reshape(-1, 4, 2),
    )


def _layout(combinations: Sequence[CombinationTables]) -> DrawLayout:
    """The same for all combinations, so that a sample's words depend on seed and index alone."""
    most_bodies = max(len(one.things) for one in combinations)
    several = any((one.body_count > 1).any() for one in combinations)
    cases = 1
    bodies = cases + max(len(one.pools) for one in combinations)
    yaws = bodies + (most_bodies if several else 0)
    xs, ys, materials = yaws + most_bodies, yaws + 2 * most_bodies, yaws + 3 * most_bodies
    lighting = materials + max(len(one.groups) for one in combinations)
    return DrawLayout(cases, bodies, yaws, xs, ys, materials, lighting, -(-(lighting + 5) // 4))


def _forms(plan: RuntimePlan) -> BodyStances:
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
    points = sorted({point for prism in stance.prisms for point in prism.outline_m})
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


def _tables(plan: RuntimePlan, one: PlanCombination, names: tuple[str, ...], body_stances: BodyStances) -> CombinationTables:
    column = {name: index for index, name in enumerate(names)}
    local = {thing.id: index for index, thing in enumerate(one.things)}
    where = {name: (p, k) for p, pool in enumerate(one.pools) for k, name in enumerate(pool.things)}
    rows: list[tuple[PlanCase, int, int]] = []  # case, place within it, thing
    first_row = np.zeros(len(one.things), dtype=np.int64)
    for index, thing in enumerate(one.things):
        p, k = where[thing.id]
        first_row[index] = len(rows)
        rows += [(case, k, index) for case in one.pools[p].cases]
    stance = np.array([case.stances[k] for case, k, _ in rows], dtype=np.int64)
    most_bodies = max((len(thing.bodies) for thing in one.things), default=1)
    bodies = np.array([(thing.bodies * most_bodies)[:most_bodies] for thing in one.things], dtype=np.int64).reshape(-1, most_bodies)
    past, jump, turn = _turns([case.yaws_urad[k] for case, k, _ in rows])
    open_box = (-np.inf, np.inf, -np.inf, np.inf)
    bounds = [(*case.cells_um[k], *(case.origins_um[k] or open_box)) for case, k, _ in rows]
    origins = [one.places[thing.place][1].origin_m for thing in one.things]
    possible = [sorted({int(s) for s in stance[first : first + _count(one, where, thing.id)]})
                for thing, first in zip(one.things, first_row, strict=True)]  # fmt: skip
    choices = [
        sorted({int(body_stances.start[body]) + s for body in thing.bodies for s in stances})
        for thing, stances in zip(one.things, possible, strict=True)
    ]
    fixed = all(len(indices) == 1 for indices in choices)
    X_WB = np.array(one.X_WB, dtype=np.float64)
    return CombinationTables(
        things=np.array([column[thing.id] for thing in one.things], dtype=np.int64),
        pools=tuple(_pool([case.weight for case in pool.cases]) for pool in one.pools),
        pool_of=np.array([where[thing.id][0] for thing in one.things], dtype=np.int64),
        first_row=first_row,
        bounds_m=MICRO * np.array(bounds, dtype=np.float64).reshape(-1, 8).T,
        turn=turn,
        yaw_gap_at_rad=past,
        yaw_gap_rad=jump,
        has_origin_boxes=any(case.origins_um[k] is not None for case, k, _ in rows),
        place_m=np.array([origin[:2] for origin in origins], dtype=np.float64).reshape(-1, 2).T.copy(),
        height_m=np.array([origins[t][2] + MICRO * case.base_um[k] for case, k, t in rows], dtype=np.float64),
        stance=stance,
        bodies=bodies,
        body_row=most_bodies * np.arange(len(one.things)),
        body_count=np.array([len(thing.bodies) for thing in one.things], dtype=np.float64),
        fixed_stance=np.array([indices[0] for indices in possible], dtype=np.int64) if fixed else None,
        body_stance=np.array([indices[0] for indices in choices], dtype=np.int64) if fixed else None,
        outlines=_outlines(choices, body_stances),
        levels=_levels([thing.parent for thing in one.things], local),
        background=(*X_WB[:3, 3].tolist(), *_half_turn(float(X_WB[0, 0]), float(X_WB[1, 0]))),
        support=np.array([column.get(thing.parent, BACKGROUND_COLUMN) for thing in one.things], dtype=np.int64),
        background_body=-1 if one.background is None else one.background,
        all_things=tuple(thing.id for thing in one.things) == names,
        one_thing_per_pool=tuple(pool.things for pool in one.pools) == tuple((thing.id,) for thing in one.things),
        groups=_groups(plan, one, local),
        lighting=np.array([_index(plan.lighting, name) for name in one.lighting], dtype=np.int64),
    )


def _half_turn(cosine: float, sine: float) -> tuple[float, float]:
    """Cosine and sine of half an angle; by square roots, which round alike on every machine."""
    if cosine >= 0.0:
        half = ((1.0 + cosine) / 2.0) ** 0.5
        return half, sine / (2.0 * half)
    half = ((1.0 - cosine) / 2.0) ** 0.5
    return abs(sine) / (2.0 * half), half if sine >= 0.0 else -half


def _count(one: PlanCombination, where: dict[str, tuple[int, int]], name: str) -> int:
    return len(one.pools[where[name][0]].cases)


def _pool(weights: Sequence[float]) -> Pool:
    equal = all(weight == weights[0] for weight in weights)
    return Pool(None if equal else _cumulative_shares(weights), len(weights))


def _turns(intervals: Sequence[Sequence[tuple[int, int]]]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """`turn_past`, `turn_jump` (k, rows) and `turn` (2, rows) of yaw intervals in microradians."""
    most_bodies = max((len(found) for found in intervals), default=1)
    past = np.full((most_bodies - 1, len(intervals)), np.inf)
    jump = np.zeros((most_bodies - 1, len(intervals)))
    turn = np.zeros((2, len(intervals)))
    for row, found in enumerate(intervals):
        added = 0
        for k, ((low, high), (following, _)) in enumerate(pairwise(found)):
            added += high - low
            past[k, row], jump[k, row] = MICRO * added, MICRO * (following - high)
        turn[:, row] = MICRO * found[0][0], MICRO * (added + found[-1][1] - found[-1][0])
    return past, jump, turn


def _outlines(choices: Sequence[Sequence[int]], body_stances: BodyStances) -> tuple[Outlines, ...]:
    """Things by number of corners, rounded up to a power of two; those with several forms look theirs up."""
    sizes: dict[tuple[bool, int], list[int]] = {}
    for index, found in enumerate(choices):
        corners = max(len(body_stances.corners[body_stance]) for body_stance in found)
        sizes.setdefault((len(found) == 1, max(2, (corners - 1).bit_length())), []).append(index)
    outlines = []
    for (fixed, _), columns in sorted(sizes.items(), reverse=True):
        used = [choices[c][0] for c in columns] if fixed else range(len(body_stances.corners))
        wanted = {body_stance for c in columns for body_stance in choices[c]}
        most_bodies = max(len(body_stances.corners[body_stance]) for body_stance in wanted)
        x_m, y_m = np.zeros((most_bodies, len(used))), np.zeros((most_bodies, len(used)))
        for k, body_stance in enumerate(used):
            if body_stance in wanted:
                outline = body_stances.corners[body_stance]
                x_m[:, k], y_m[:, k] = outline[0]
                x_m[: len(outline), k], y_m[: len(outline), k] = outline.T
        everything = len(columns) == len(choices)
        outlines.append(Outlines(None if everything else np.array(columns, dtype=np.int64), x_m, y_m, fixed))
    return tuple(outlines)


def _levels(parents: Sequence[str], local: dict[str, int]) -> tuple[Level, ...]:
    """Things by their number of movable owners, those without first."""
    depth: list[int] = []
    for parent in parents:  # owners stand before what they own
        depth.append(depth[local[parent]] + 1 if parent in local else 0)
    levels = []
    for level in sorted(set(depth)):
        columns = [index for index, deep in enumerate(depth) if deep == level]
        owners = np.array([local[parents[c]] for c in columns], dtype=np.int64) if level else None
        levels.append(Level(None if len(columns) == len(depth) else np.array(columns, dtype=np.int64), owners))
    return tuple(levels)


def _groups(plan: RuntimePlan, one: PlanCombination, local: dict[str, int]) -> tuple[MaterialGroup, ...]:
    """Materials that share a thing exclude one another; of each such group one is drawn, or none."""
    offered = [(_index(plan.materials, name), set(plan.materials[_index(plan.materials, name)].objects))
               for name in one.materials]  # fmt: skip
    groups: list[tuple[list[int], set[str]]] = []
    for index, things in offered:
        joined, covered = [index], set(things)
        rest = []
        for members, known in groups:
            if known & covered:
                joined, covered = members + joined, covered | known
            else:
                rest.append((members, known))
        groups = [*rest, (joined, covered)]
    material_groups = []
    columns = local | {BACKGROUND: len(local)}
    for members in sorted(sorted(members) for members, _ in groups):
        material_of = np.full((len(members) + 1, len(columns)), AUTHORED, dtype=np.int64)
        for row, index in enumerate(members, start=1):
            material_of[row, [columns[name] for name in plan.materials[index].objects if name in columns]] = index
        material_groups.append(MaterialGroup(material_of))
    return tuple(material_groups)


def _index(named: Sequence[object], name: str) -> int:
    return [getattr(item, "id", None) for item in named].index(name)
