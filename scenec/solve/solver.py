"""Transactional solve: a complete assignment, a proof that there is none, or the best partial assignment of the
budget."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache as cache_call
from itertools import pairwise

import networkx as nx

from scenec.check import between_phases
from scenec.ir.problem import Exhausted, Infeasible, Placement, Problem, Proof, Result, Solved
from scenec.proofs import prove, prove_cheaply
from scenec.proofs.owners import no_first_owner
from scenec.solve.cache import ComponentCache
from scenec.solve.check import blockers
from scenec.solve.component import solve_readily
from scenec.solve.coupling import components_of, lifted, separating_limits
from scenec.solve.model import SolverModel, model_of
from scenec.solve.placed import Placed
from scenec.solve.search import SearchBudget, search

DEFAULT_BUDGET = 6_000  # steps: packings and candidate poses tried; some milliseconds each in a crowded scene


def solve(
    problem: Problem,
    seed: int = 0,
    budget: int = DEFAULT_BUDGET,
    previous: Mapping[str, Placement] | None = None,
    cache: ComponentCache | None = None,
) -> Result:
    """A placement for every thing, a proof that there is no scene, or `Exhausted` after `budget` steps. Deterministic.

    Relations across owners or components are first replaced by stricter ones that keep components independent (lifted
    to their owners, separating coordinates); where that fails, the linked components are merged and solved jointly.
    Cheap proofs are tried before any long search, the complete one for few things after it.
    """
    if (proof := no_first_owner(problem)) is not None:
        return Infeasible(proof)
    cheap_proof = cache_call(lambda: prove_cheaply(problem))
    base = model_of(problem)
    budgets: list[SearchBudget] = []
    for model, components, share in _ways(base):
        between_phases.after_analysis(problem, components)
        search_budget = SearchBudget(int(share * (budget - sum(e.steps_taken for e in budgets))))
        budgets.append(search_budget)
        outcome = _solve_all(model, components, seed, search_budget, previous or {}, cache, cheap_proof)
        if isinstance(outcome, Proof):
            return Infeasible(outcome)
        if outcome is not None and _agrees(base, model, outcome):
            placements = {name: outcome[name].placement for name in sorted(outcome)}
            return Solved(placements, sum(e.steps_taken for e in budgets))
    proof = prove(problem)
    return Infeasible(proof) if proof is not None else _exhausted(base, budgets)


def _exhausted(base: SolverModel, budgets: list[SearchBudget]) -> Exhausted:
    failures: Counter[str] = Counter()
    for search_budget in budgets:
        failures.update(search_budget.failures)
    blocking = max(sorted(failures), key=lambda name: failures[name]) if failures else min(base.things, default="")
    stood = max((search_budget.best_assignment for search_budget in budgets), key=len)
    at_best = {name: stood[name].placement for name in sorted(stood)}
    return Exhausted(len(stood), len(base.things), blocking, sum(e.steps_taken for e in budgets), at_best)


def _ways(base: SolverModel) -> Iterator[tuple[SolverModel, tuple[tuple[str, ...], ...], float]]:
    """(model, components, share of the remaining steps) by strategy: separate by stricter relations, then joint."""
    rules = tuple(lifted(base, rule) for rule in base.rules)
    model = replace(base, rules=rules)
    components = components_of(model)
    limits = separating_limits(model, components)
    if limits is not None:
        model = replace(model, limits=limits)
        joint = rules == base.rules and not limits
        yield model, components, 1.0 if joint else 0.5
        if joint:
            return
    yield base, _merged(base), 1.0


def _merged(base: SolverModel) -> tuple[tuple[str, ...], ...]:
    # Components by the program's own relations; those that a directional relation links are merged.
    graph: nx.Graph[str] = nx.Graph()
    for members in components_of(base):
        graph.add_nodes_from(members)
        graph.add_edges_from(pairwise(members))
    for rule in base.rules:
        graph.add_edges_from(pairwise(sorted(base.depends_on(rule))))
    return tuple(sorted(tuple(sorted(members)) for members in nx.connected_components(graph)))


def _solve_all(
    model: SolverModel,
    components: tuple[tuple[str, ...], ...],
    seed: int,
    search_budget: SearchBudget,
    previous: Mapping[str, Placement],
    cache: ComponentCache | None,
    cheap_proof: Callable[[], Proof | None],
) -> dict[str, Placed] | Proof | None:
    # Components in turn, owners first; each commits as a whole, or the solve fails.
    rank = model.rank
    committed: dict[str, Placed] = {}
    for names in sorted(components, key=lambda members: min(rank[name] for name in members)):
        component_digest = None if cache is None else cache.component_digest(model, names, seed)
        if (
            cache is not None
            and component_digest is not None
            and (known := cache.solved.get(component_digest.digest)) is not None
        ):
            committed |= {name: model.put(name, placement) for name, placement in known.items()}
            continue
        suspects = None if cache is None or component_digest is None else cache.suspects(component_digest, previous)
        component_budget = SearchBudget(search_budget.max_steps, search_budget.steps_taken)
        outcome = solve_readily(model, names, seed, component_budget, previous, suspects)
        if outcome is None:
            if (proof := cheap_proof()) is not None:
                return proof
            outcome = search(model, names, {}, seed, component_budget)
        search_budget.steps_taken = component_budget.steps_taken
        search_budget.record_best({**committed, **component_budget.best_assignment})
        search_budget.failures.update(component_budget.failures)
        if outcome is None:
            return None
        committed |= outcome
        search_budget.record_best(committed)
        if cache is not None and component_digest is not None:
            cache.store(component_digest, {name: placed.placement for name, placed in outcome.items()})
    return committed


def _agrees(base: SolverModel, model: SolverModel, assignment: Mapping[str, Placed]) -> bool:
    # The stricter relations imply the program's; where they differ they are checked again for safety.
    changed = {name for old, new in zip(base.rules, model.rules, strict=True) if old is not new for name in old.things}
    changed |= set(model.limits)
    return all(blockers(base, assignment, name) is None for name in changed)
