"""The transactional solve: a whole assignment, a proof that there is none, or how far the budget went."""

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
from scenec.solve.coupling import components_of, lifted, separated
from scenec.solve.model import Model, model_of
from scenec.solve.placed import Placed
from scenec.solve.search import Effort, search

DEFAULT_BUDGET = 6_000  # steps: packings and candidate poses tried; some milliseconds each in a crowded scene


def solve(
    problem: Problem,
    seed: int = 0,
    budget: int = DEFAULT_BUDGET,
    previous: Mapping[str, Placement] | None = None,
    cache: ComponentCache | None = None,
) -> Result:
    """A placement for every thing, a proof that there is no scene, or how far `budget` steps went. Deterministic.

    Relations across owners or components are first kept by stricter ones that leave components apart (lifted to their
    owners, separating coordinates); where that finds nothing, what they tie is merged and solved jointly. Cheap proofs
    are looked for before any long search, the complete one for few things after it.
    """
    if (proof := no_first_owner(problem)) is not None:
        return Infeasible(proof)
    cheap_proof = cache_call(lambda: prove_cheaply(problem))
    base = model_of(problem)
    efforts: list[Effort] = []
    for model, components, share in _ways(base):
        between_phases.after_analysis(problem, components)
        effort = Effort(int(share * (budget - sum(e.taken for e in efforts))))
        efforts.append(effort)
        found = _solve_all(model, components, seed, effort, previous or {}, cache, cheap_proof)
        if isinstance(found, Proof):
            return Infeasible(found)
        if found is not None and _agrees(base, model, found):
            placements = {name: found[name].placement for name in sorted(found)}
            return Solved(placements, sum(e.taken for e in efforts))
    proof = prove(problem)
    return Infeasible(proof) if proof is not None else _exhausted(base, efforts)


def _exhausted(base: Model, efforts: list[Effort]) -> Exhausted:
    failures: Counter[str] = Counter()
    for effort in efforts:
        failures.update(effort.failures)
    blocking = max(sorted(failures), key=lambda name: failures[name]) if failures else min(base.things, default="")
    stood = max((effort.stood for effort in efforts), key=len)
    at_best = {name: stood[name].placement for name in sorted(stood)}
    return Exhausted(len(stood), len(base.things), blocking, sum(e.taken for e in efforts), at_best)


def _ways(base: Model) -> Iterator[tuple[Model, tuple[tuple[str, ...], ...], float]]:
    """(model, components, share of the steps left) of the ways to solve: apart by stricter rules, then jointly."""
    rules = tuple(lifted(base, rule) for rule in base.rules)
    model = replace(base, rules=rules)
    components = components_of(model)
    limits = separated(model, components)
    if limits is not None:
        model = replace(model, limits=limits)
        joint = rules == base.rules and not limits
        yield model, components, 1.0 if joint else 0.5
        if joint:
            return
    yield base, _merged(base), 1.0


def _merged(base: Model) -> tuple[tuple[str, ...], ...]:
    # Components by the program's own rules, those that a directional rule ties merged.
    graph: nx.Graph[str] = nx.Graph()
    for members in components_of(base):
        graph.add_nodes_from(members)
        graph.add_edges_from(pairwise(members))
    for rule in base.rules:
        graph.add_edges_from(pairwise(sorted(base.depends_on(rule))))
    return tuple(sorted(tuple(sorted(members)) for members in nx.connected_components(graph)))


def _solve_all(
    model: Model,
    components: tuple[tuple[str, ...], ...],
    seed: int,
    effort: Effort,
    previous: Mapping[str, Placement],
    cache: ComponentCache | None,
    cheap_proof: Callable[[], Proof | None],
) -> dict[str, Placed] | Proof | None:
    # Components one after another, owners first; each commits as a whole or the solve is given up.
    rank = model.rank
    committed: dict[str, Placed] = {}
    for names in sorted(components, key=lambda members: min(rank[name] for name in members)):
        record = None if cache is None else cache.record(model, names, seed)
        if cache is not None and record is not None and (known := cache.solved.get(record.digest)) is not None:
            committed |= {name: model.put(name, placement) for name, placement in known.items()}
            continue
        suspects = None if cache is None or record is None else cache.suspects(record, previous)
        own = Effort(effort.left, effort.taken)
        found = solve_readily(model, names, seed, own, previous, suspects)
        if found is None:
            if (proof := cheap_proof()) is not None:
                return proof
            found = search(model, names, {}, seed, own)
        effort.taken = own.taken
        effort.reached({**committed, **own.stood})
        effort.failures.update(own.failures)
        if found is None:
            return None
        committed |= found
        effort.reached(committed)
        if cache is not None and record is not None:
            cache.keep(record, {name: placed.placement for name, placed in found.items()})
    return committed


def _agrees(base: Model, model: Model, found: Mapping[str, Placed]) -> bool:
    # The stricter rules imply the program's; looked at once more where they differ, for nothing invalid may leave.
    changed = {name for old, new in zip(base.rules, model.rules, strict=True) if old is not new for name in old.things}
    changed |= set(model.limits)
    return all(blockers(base, found, name) is None for name in changed)
