"""The transactional solve: a whole assignment, a proof that there is none, or how far the budget went."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

from scenec.ir import Exhausted, Placement, Problem, Result, Solved
from scenec.solve.cache import ComponentCache, component_digest
from scenec.solve.check import blockers
from scenec.solve.component import solve_component
from scenec.solve.coupling import components_of, depends_on, lifted, separated, siblings_in_frame
from scenec.solve.model import Model, model_of, owner_first
from scenec.solve.placed import Placed
from scenec.solve.search import Effort

DEFAULT_BUDGET = 20_000  # steps: packings and candidate poses tried


def solve(
    problem: Problem,
    seed: int = 0,
    budget: int = DEFAULT_BUDGET,
    previous: Mapping[str, Placement] | None = None,
    cache: ComponentCache | None = None,
) -> Result:
    """Solved with a placement for every thing, or Exhausted after `budget` steps; deterministic in problem and seed.

    Relations across owners or components are first kept by stricter ones that leave components apart (lifted to their
    owners, separating coordinates); where that finds nothing, what they tie is merged and solved jointly.
    """
    base = model_of(problem)
    cache = cache if cache is not None else ComponentCache()
    previous = previous or {}
    # Half of the steps for the stricter way, all that is left for the joint one.
    apart = _apart(base)
    efforts: list[Effort] = []
    for model, components, share in (*([(*apart, 0.5)] if apart else []), (*_joint(base), 1.0)):
        effort = Effort(int(share * budget) - sum(e.taken for e in efforts) if share == 1.0 else int(share * budget))
        efforts.append(effort)
        found = _solve_all(model, components, seed, effort, previous, cache)
        if found is not None and _agrees(base, model, found):
            placements = {name: found[name].placement for name in sorted(found)}
            return Solved(placements, sum(e.taken for e in efforts))
    failures: Counter[str] = Counter()
    for effort in efforts:
        failures.update(effort.failures)
    blocking = max(sorted(failures), key=lambda name: failures[name]) if failures else min(base.things, default="")
    placed = max(effort.placed for effort in efforts)
    return Exhausted(min(placed, len(base.things)), len(base.things), blocking, sum(e.taken for e in efforts))


def _apart(base: Model) -> tuple[Model, tuple[tuple[str, ...], ...]] | None:
    # Stricter rules that let components be solved one by one; None where that is the joint way or has no room.
    rules = tuple(lifted(base, rule) for rule in base.rules)
    model = replace(base, rules=rules)
    components = components_of(model)
    limits = separated(model, components)
    if limits is None or (rules == base.rules and not limits):
        return None
    return replace(model, limits=limits), components


def _joint(base: Model) -> tuple[Model, tuple[tuple[str, ...], ...]]:
    # The program's own rules; components that a directional rule still ties are merged.
    parts = components_of(base)
    home = {name: k for k, members in enumerate(parts) for name in members}
    groups = {k: {k} for k in range(len(parts))}
    for rule in base.rules:
        if rule.kind == "before" and siblings_in_frame(base, rule):
            tied = {group for name in depends_on(base, rule) for group in groups[home[name]]}
            for k in tied:
                groups[k] = tied
    merged = {tuple(sorted(group)) for group in groups.values()}
    return base, tuple(sorted(tuple(sorted(n for k in group for n in parts[k])) for group in merged))


def _solve_all(
    model: Model,
    components: tuple[tuple[str, ...], ...],
    seed: int,
    effort: Effort,
    previous: Mapping[str, Placement],
    cache: ComponentCache,
) -> dict[str, Placed] | None:
    # Components one after another, owners first; each commits as a whole or the solve is given up.
    rank = {name: k for k, name in enumerate(owner_first(model.things))}
    committed: dict[str, Placed] = {}
    for names in sorted(components, key=lambda members: min(rank[name] for name in members)):
        digest, _things = component_digest(cache, model, names, seed)
        known = cache.solved.get(digest)
        if known is not None and not previous:
            committed |= {name: model.put(name, placement) for name, placement in known.items()}
            continue
        own = Effort(effort.left, effort.taken)
        found = solve_component(model, names, {}, seed, own, previous)
        effort.taken = own.taken
        effort.placed = max(effort.placed, len(committed) + own.placed)
        effort.failures.update(own.failures)
        if found is None:
            return None
        committed |= found
        effort.placed = max(effort.placed, len(committed))
        cache.solved[digest] = {name: placed.placement for name, placed in found.items()}
    return committed


def _agrees(base: Model, model: Model, found: Mapping[str, Placed]) -> bool:
    # The stricter rules imply the program's; looked at once more where they differ, for nothing invalid may leave.
    changed = {name for old, new in zip(base.rules, model.rules, strict=True) if old != new for name in old.things}
    changed |= set(model.limits)
    return all(blockers(base, found, name) is None for name in changed)
