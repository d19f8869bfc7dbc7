"""Cases of things of several owners that cross-owner relations link: all of them are sampled jointly.

The things of each owner are laid out at random as in a pool of their own. Layouts of the owners are combined at random;
combinations in which every cross-owner relation holds are kept, and their freedom is clipped until each relation holds
for all remaining poses (see `scenec.plan.cases.cross_owner_relations`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.random import Generator

from scenec.plan.cases.cells import GrownCells, grown_cells, plan_cases
from scenec.plan.cases.clip_cells import CLIP_STEPS_M, clip_cells
from scenec.plan.cases.cross_owner_relations import (
    CrossOwnerRelation,
    OwnerLayouts,
    cross_owner_relation,
    holds_across_owners,
    relation_values,
)
from scenec.plan.cases.pool import SURPLUS, PoolRequest, reach_P, solved_layout
from scenec.plan.cases.pool_model import Layouts, PoolModel, joined, pool_model_of
from scenec.plan.cases.quality import quality
from scenec.plan.cases.rejection import CANDIDATE_TRIES, LOT, rejection_layouts
from scenec.plan.cases.select import selected
from scenec.plan.cases.signature import distinct
from scenec.relations.table import RELATIONS
from scenec.solve.model import SolverModel
from scenec.solve.streams import stream
from schemas.arrays import BoolArray, FloatArray
from schemas.scene.geometry import SceneRelation
from schemas.scene.runtime_plan import PlanCase

MOST_CROSS_OWNER_LOTS = 24


def cross_owner_cases(
    model: SolverModel, request: PoolRequest, groups: Sequence[Sequence[str]], rules: Sequence[SceneRelation]
) -> list[PlanCase]:
    """Cases for all things of the groups, each of one owner, in the order of their names; none where no layout
    satisfies the cross-owner `rules`."""
    rng = stream(request.seed, "tied", *request.names)
    pools = [pool_model_of(model, names, request.frozen, request.solved) for names in groups]
    fast_first = sorted(rules, key=lambda rule: RELATIONS[rule.kind].slow_to_measure)
    relations = [cross_owner_relation(model, rule) for rule in fast_first]
    layouts = _together(pools, relations, request, rng)
    cells_by_owner = [grown_cells(pool, part, rng) for pool, part in zip(pools, layouts, strict=True)]
    is_kept = np.ones(len(layouts[0]), dtype=bool)
    for one in cells_by_owner:
        is_kept &= clip_cells(one.pool, one.layouts, one.freedom, *reach_P(model, one.pool))
    parts = {
        name: OwnerLayouts(one.pool, one.layouts, one.freedom) for one in cells_by_owner for name in one.pool.names
    }
    for relation in relations:
        is_kept &= _shortened(relation, parts)
    cases = distinct(request.names, _merged(request.names, cells_by_owner, is_kept))
    members = sorted((member for pool in pools for member in pool.members), key=lambda member: member.name)
    whole = PoolModel(tuple(members), pools[0].clearance_m, (), model)
    return selected(whole, cases, request.count)


def _together(
    pools: Sequence[PoolModel], relations: Sequence[CrossOwnerRelation], request: PoolRequest, rng: Generator
) -> list[Layouts]:
    """Layouts of each pool that satisfy all relations row by row, the solved ones first."""
    solved = [solved_layout(pool, request.solved) for pool in pools]
    candidates_of_owner = [joined([one, _random(pool, rng)]) for pool, one in zip(pools, solved, strict=True)]
    layout_count = int(SURPLUS * request.count)
    layouts_by_owner = [[one] for one in solved]
    count = 1
    for number in range(MOST_CROSS_OWNER_LOTS):
        lot = [candidates.take(rng.integers(len(candidates), size=LOT)) for candidates in candidates_of_owner]
        good = np.ones(LOT, dtype=bool)
        for relation in relations:
            rows = np.flatnonzero(good)
            left = [part.take(rows) for part in lot]
            parts = {
                name: OwnerLayouts(pool, one) for pool, one in zip(pools, left, strict=True) for name in pool.names
            }
            good[rows] = holds_across_owners(relation, parts, relation_values(relation, parts))
        rows = np.flatnonzero(good)[: layout_count - count]
        count += len(rows)
        for part, chosen in zip(lot, layouts_by_owner, strict=True):
            chosen.append(part.take(rows))
        if count >= layout_count or (number >= MOST_CROSS_OWNER_LOTS // 4 and count == 1):
            break
    return [joined(parts) for parts in layouts_by_owner]


def _random(pool: PoolModel, rng: Generator) -> Layouts:
    layouts = rejection_layouts(pool, LOT, rng, 1)
    return (
        layouts
        if len(layouts) >= LOT // 16
        else joined([layouts, rejection_layouts(pool, LOT // 4, rng, CANDIDATE_TRIES)])
    )


def _shortened(relation: CrossOwnerRelation, parts: Mapping[str, OwnerLayouts]) -> BoolArray:
    """Shortens steps of all links until a relation holds for all remaining poses; which layouts (l,) can be kept."""
    values = relation_values(relation, parts)
    links = [(parts[name], parts[name].pool.index[name], name in relation.turning) for name in relation.links]
    before = [(_steps(part)[:, i].copy(), _spins(part)[:, i].copy()) for part, i, _ in links]
    best = np.full(len(values), -1.0)

    def limit(step_m: FloatArray) -> None:
        for (part, i, turns), (step, spin) in zip(links, before, strict=True):
            _steps(part)[:, i] = np.minimum(step, step_m[:, None])
            _spins(part)[:, i] = np.minimum(spin, step_m) if turns else spin

    for step_m in CLIP_STEPS_M:
        limit(np.full(len(values), step_m))
        best = np.where((best < 0.0) & holds_across_owners(relation, parts, values), step_m, best)
        if (best >= 0.0).all():
            break
    limit(np.maximum(best, 0.0))
    return best >= 0.0


def _steps(part: OwnerLayouts) -> FloatArray:
    assert part.freedom is not None, "cells were grown"
    return part.freedom.step_m


def _spins(part: OwnerLayouts) -> FloatArray:
    assert part.freedom is not None, "cells were grown"
    return part.freedom.spin_m


def _merged(names: Sequence[str], cells_by_owner: Sequence[GrownCells], is_kept: BoolArray) -> list[PlanCase]:
    # The cases of all owners as one, things in the order of names; quality is the mean over things.
    cases_by_owner = [plan_cases(one, is_kept) for one in cells_by_owner]
    order = [name for one in cells_by_owner for name in one.pool.names]
    pick = [order.index(name) for name in names]
    merged = []
    for cases in zip(*cases_by_owner, strict=True):
        rates = [quality(one.pool, case) for one, case in zip(cells_by_owner, cases, strict=True)]
        worth = np.average(rates, weights=[len(one.pool.members) for one in cells_by_owner])
        columns = [
            [row for case in cases for row in getattr(case, key)]
            for key in ("cells_um", "origins_um", "yaws_urad", "stances", "base_um")
        ]
        cells, origins, yaws, stances, bases = (tuple(column[k] for k in pick) for column in columns)
        merged.append(
            PlanCase(
                family="point" if all(case.family == "point" for case in cases) else "seeded",
                quality=round(float(worth), 4),
                cells_um=cells,
                origins_um=origins,
                yaws_urad=yaws,
                stances=stances,
                base_um=bases,
            )
        )
    return merged
