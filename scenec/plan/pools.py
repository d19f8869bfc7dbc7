"""The pools of a plan: things chosen together, made once for all combinations that leave them alike."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from scenec.ir.problem import Placement, Solved
from scenec.plan.cases.coupling import Tied, pools_of
from scenec.plan.cases.cross_owner import tied_cases
from scenec.plan.cases.cross_owner_relations import view_of
from scenec.plan.cases.pool import Asked, pool_cases
from scenec.solve.model import Model
from scenec.solve.stacks import piled
from schemas.scene.runtime_plan import PlanPool

MOST_CASES = 800  # of a pool
MOST_CELLS = 13_000  # in the cases of a pool: about a megabyte
Alike = tuple[tuple[str, ...], frozenset[tuple[str, str]]]  # things of pools, and what decides anything of them


def plan_pools(
    base: Model,
    result: Solved,
    seed: int,
    diversity: float,
    made: dict[Alike, tuple[PlanPool, ...]],
    reached_by: Mapping[str, Collection[str]] | None,
) -> tuple[PlanPool, ...]:
    """The pools of a solved combination. Those that `made` has, alike in all that decides anything of them, are taken
    over: `reached_by` are the keys of combinations by thing that do (all, when None)."""
    problem, pools = base.problem, pools_of(base)
    frozen = {name: result.placements[name] for name in pools.frozen}
    heaped = piled(base, {name: base.put(name, at) for name, at in result.placements.items()})
    found: list[PlanPool] = []
    for tied in pools.tied:
        keys = problem.combination.keys() if reached_by is None else reached_by[tied.names[0]]
        alike = tied.names, frozenset((key, problem.combination[key]) for key in keys if key in problem.combination)
        if alike not in made:
            for names in tied.groups:
                if heaped.intersection(names):  # a pile stays as it was found, in its receptacle
                    frozen |= {name: result.placements[name] for name in names}
            made[alike] = _tied_pools(
                pools.model, tied, frozen, result, _cases_wanted(len(tied.names), diversity), seed
            )
        found += made[alike]
    return tuple(found)


def _tied_pools(
    model: Model, tied: Tied, frozen: Mapping[str, Placement], result: Solved, wanted: int, seed: int
) -> tuple[PlanPool, ...]:
    # One pool where rules tie its groups and cases are found that keep them; else one a group, what is tied held still.
    if tied.rules:
        asked = Asked(tied.names, frozen, result.placements, wanted, seed)
        cases = tied_cases(model, asked, tied.groups, tied.rules)
        if cases:
            return (PlanPool(things=tied.names, cases=tuple(cases)),)
        held = {name for rule in tied.rules for name in view_of(model, rule).links}
        frozen = {**frozen, **{name: result.placements[name] for name in held}}
    asked = (Asked(names, frozen, result.placements, wanted, seed) for names in tied.groups)
    return tuple(PlanPool(things=one.names, cases=tuple(pool_cases(model, one))) for one in asked)


def _cases_wanted(things: int, diversity: float) -> int:
    return max(8, round(diversity * min(MOST_CASES, MOST_CELLS // things)))
