"""Pools of a plan: sets of things sampled jointly, made once for all combinations with equal keys."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from scenec.ir.problem import Placement, Solved
from scenec.plan.cases.coupling import JointPool, pools_of
from scenec.plan.cases.cross_owner import cross_owner_cases
from scenec.plan.cases.cross_owner_relations import cross_owner_relation
from scenec.plan.cases.pool import PoolRequest, pool_cases
from scenec.solve.model import SolverModel
from scenec.solve.stacks import stacked
from schemas.scene.runtime_plan import PlanPool

MOST_CASES = 800  # of a pool
MOST_CELLS = 13_000  # in the cases of a pool: about a megabyte
# Names of the things of a pool, and the key values that affect them.
PoolKey = tuple[tuple[str, ...], frozenset[tuple[str, str]]]


def plan_pools(
    base: SolverModel,
    result: Solved,
    seed: int,
    diversity: float,
    pools_by_key: dict[PoolKey, tuple[PlanPool, ...]],
    reached_by: Mapping[str, Collection[str]] | None,
) -> tuple[PlanPool, ...]:
    """The pools of a solved combination. Pools in `pools_by_key` are reused, new ones are added to it; `reached_by` are
    the keys that affect a thing, by its name (all, when None)."""
    problem, pools = base.problem, pools_of(base)
    frozen = {name: result.placements[name] for name in pools.frozen}
    stacked_names = stacked(base, {name: base.put(name, at) for name, at in result.placements.items()})
    all_pools: list[PlanPool] = []
    for joint_pool in pools.joint_pools:
        keys = problem.combination.keys() if reached_by is None else reached_by[joint_pool.names[0]]
        pool_key = (
            joint_pool.names,
            frozenset((key, problem.combination[key]) for key in keys if key in problem.combination),
        )
        if pool_key not in pools_by_key:
            for names in joint_pool.groups:
                if stacked_names.intersection(names):  # a stack keeps its solved poses in its receptacle
                    frozen |= {name: result.placements[name] for name in names}
            pools_by_key[pool_key] = _plan_pools_of(
                pools.model, joint_pool, frozen, result, _cases_wanted(len(joint_pool.names), diversity), seed
            )
        all_pools += pools_by_key[pool_key]
    return tuple(all_pools)


def _plan_pools_of(
    model: SolverModel,
    joint_pool: JointPool,
    frozen: Mapping[str, Placement],
    result: Solved,
    case_count: int,
    seed: int,
) -> tuple[PlanPool, ...]:
    # One pool for all groups where cases satisfy their cross-owner relations; else one per group, linked things frozen.
    if joint_pool.rules:
        request = PoolRequest(joint_pool.names, frozen, result.placements, case_count, seed)
        cases = cross_owner_cases(model, request, joint_pool.groups, joint_pool.rules)
        if cases:
            return (PlanPool(things=joint_pool.names, cases=tuple(cases)),)
        frozen_names = {name for rule in joint_pool.rules for name in cross_owner_relation(model, rule).links}
        frozen = {**frozen, **{name: result.placements[name] for name in frozen_names}}
    requests = (PoolRequest(names, frozen, result.placements, case_count, seed) for names in joint_pool.groups)
    return tuple(PlanPool(things=request.names, cases=tuple(pool_cases(model, request))) for request in requests)


def _cases_wanted(things: int, diversity: float) -> int:
    return max(8, round(diversity * min(MOST_CASES, MOST_CELLS // things)))
