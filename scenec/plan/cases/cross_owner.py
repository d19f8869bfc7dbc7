"""Cases of things of several owners that relations tie: whatever decides such a relation is chosen together.

The things of each owner are laid out at random as in a pool of their own. Layouts of the owners are put together at
random, those are kept in which every relation across owners holds, and poses are held so near to them that it goes on
holding for all that is left (see `scenec.plan.cases.cross_owner_relations`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.random import Generator

from scenec.ir.problem import FloatArray, RelationIR
from scenec.plan.cases.cells import Grown, grown, written
from scenec.plan.cases.clip_cells import STEPS_M, clip
from scenec.plan.cases.cross_owner_relations import Part, View, kept_across, measured, view_of
from scenec.plan.cases.feasible import BoolArray
from scenec.plan.cases.pool import SURPLUS, Asked, reach_P, solved_layout
from scenec.plan.cases.pool_model import Layouts, Scope, joined, scope_of
from scenec.plan.cases.quality import quality
from scenec.plan.cases.rejection import TRIES, seeded
from scenec.plan.cases.select import selected
from scenec.plan.cases.signature import distinct
from scenec.solve.model import Model
from scenec.solve.streams import stream
from schemas.scene.runtime_plan import PlanCase

LOT = 4096  # layouts of each owner, and put together at once
MOST_LOTS = 24


def tied_cases(
    model: Model, asked: Asked, groups: Sequence[Sequence[str]], rules: Sequence[RelationIR]
) -> list[PlanCase]:
    """Cases for all things of the groups, each of one owner, in the order of their names; none where no layout leaves
    any room for the `rules` across them."""
    rng = stream(asked.seed, "tied", *asked.names)
    scopes = [scope_of(model, names, asked.frozen, asked.solved) for names in groups]
    views = [view_of(model, rule) for rule in sorted(rules, key=lambda rule: rule.kind in ("near", "far_from"))]
    layouts = _together(scopes, views, asked, rng)
    made = [grown(scope, part, rng) for scope, part in zip(scopes, layouts, strict=True)]
    kept = np.ones(len(layouts[0]), dtype=bool)
    for one in made:
        kept &= clip(one.scope, one.layouts, one.freedom, *reach_P(model, one.scope))
    parts = {name: Part(one.scope, one.layouts, one.freedom) for one in made for name in one.scope.names}
    for view in views:
        kept &= _shortened(view, parts)
    cases = distinct(asked.names, _merged(asked.names, made, kept))
    members = sorted((member for scope in scopes for member in scope.members), key=lambda member: member.name)
    whole = Scope(tuple(members), scopes[0].clearance_m, (), model)
    return selected(whole, cases, asked.want)


def _together(scopes: Sequence[Scope], views: Sequence[View], asked: Asked, rng: Generator) -> list[Layouts]:
    """Layouts (l) of each scope that belong together, the solved ones first."""
    solved = [solved_layout(scope, asked.solved) for scope in scopes]
    pools = [joined([one, _random(scope, rng)]) for scope, one in zip(scopes, solved, strict=True)]
    want = int(SURPLUS * asked.want)
    found = [[one] for one in solved]
    count = 1
    for number in range(MOST_LOTS):
        lot = [pool.take(rng.integers(len(pool), size=LOT)) for pool in pools]
        good = np.ones(LOT, dtype=bool)
        for view in views:
            rows = np.flatnonzero(good)
            left = [part.take(rows) for part in lot]
            parts = {name: Part(scope, one) for scope, one in zip(scopes, left, strict=True) for name in scope.names}
            good[rows] = kept_across(view, parts, measured(view, parts))
        rows = np.flatnonzero(good)[: want - count]
        count += len(rows)
        for part, kept in zip(lot, found, strict=True):
            kept.append(part.take(rows))
        if count >= want or (number >= MOST_LOTS // 4 and count == 1):
            break
    return [joined(parts) for parts in found]


def _random(scope: Scope, rng: Generator) -> Layouts:
    found = seeded(scope, LOT, rng, 1)
    return found if len(found) >= LOT // 16 else joined([found, seeded(scope, LOT // 4, rng, TRIES)])


def _shortened(view: View, parts: Mapping[str, Part]) -> BoolArray:
    """Shortens the steps of all links until a relation holds for all that is left; which layouts (l,) can be kept."""
    measure = measured(view, parts)
    links = [(parts[name], parts[name].scope.index[name], name in view.turning) for name in view.links]
    before = [(_steps(part)[:, i].copy(), _spins(part)[:, i].copy()) for part, i, _ in links]
    best = np.full(len(measure), -1.0)

    def limit(step_m: FloatArray) -> None:
        for (part, i, turns), (step, spin) in zip(links, before, strict=True):
            _steps(part)[:, i] = np.minimum(step, step_m[:, None])
            _spins(part)[:, i] = np.minimum(spin, step_m) if turns else spin

    for step_m in STEPS_M:
        limit(np.full(len(measure), step_m))
        best = np.where((best < 0.0) & kept_across(view, parts, measure), step_m, best)
        if (best >= 0.0).all():
            break
    limit(np.maximum(best, 0.0))
    return best >= 0.0


def _steps(part: Part) -> FloatArray:
    assert part.freedom is not None, "cells were grown"
    return part.freedom.step_m


def _spins(part: Part) -> FloatArray:
    assert part.freedom is not None, "cells were grown"
    return part.freedom.spin_m


def _merged(names: Sequence[str], made: Sequence[Grown], kept: BoolArray) -> list[PlanCase]:
    # The cases of all owners as one, things in the order of names; quality is the mean over things.
    found = [written(one, kept) for one in made]
    order = [name for one in made for name in one.scope.names]
    pick = [order.index(name) for name in names]
    merged = []
    for cases in zip(*found, strict=True):
        rates = [quality(one.scope, case) for one, case in zip(made, cases, strict=True)]
        worth = np.average(rates, weights=[len(one.scope.members) for one in made])
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
