"""Solves one component without search: repairs the earlier assignment, else the proposals of structured families."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

from scenec.ir.problem import Placement
from scenec.solve.fixed_poses import match_fixed_poses
from scenec.solve.grid import spread_grid
from scenec.solve.model import SolverModel
from scenec.solve.placed import Placed
from scenec.solve.repair import repaired
from scenec.solve.search import SearchBudget, is_dense
from scenec.solve.shelf import pack_shelves
from scenec.solve.yaw_jitter import with_jittered_yaws

FAMILY_SHARE = 0.3  # of the steps; the rest is for exact search


def solve_readily(
    model: SolverModel,
    names: Sequence[str],
    seed: int,
    search_budget: SearchBudget,
    previous: Mapping[str, Placement],
    suspects: Iterable[str] | None = None,
) -> dict[str, Placed] | None:
    """Poses for all of `names` from `previous` or from structured families, repaired where invalid; or None.

    `previous` is kept as far as it is valid; `suspects` are those of its things that may be invalid (all, when None).
    """
    old = {name: previous[name] for name in names if name in previous}
    if old:
        assignment = repaired(model, names, old, seed, search_budget, suspects)
        if assignment is not None:
            return assignment
    proposal = propose(model, names, seed, search_budget)
    assignment = repaired(model, names, proposal, seed, search_budget) if proposal else None
    return assignment if assignment is None or is_dense(model, names) else with_jittered_yaws(model, assignment, seed)


def propose(model: SolverModel, names: Sequence[str], seed: int, search_budget: SearchBudget) -> dict[str, Placement]:
    """Proposals of structured families: things with fixed poses by matching, several on one place on a grid where they
    are unrelated and there is room, else by shelf packing; owners first."""
    proposal: dict[str, Placement] = {}
    placed: dict[str, Placed] = {}
    for members in _by_place(model, names):
        with_fixed_poses = [name for name in members if model.things[name].domain.fixed_poses]
        if with_fixed_poses:
            proposal |= match_fixed_poses(model, with_fixed_poses, placed)
        free = [name for name in members if not model.things[name].domain.fixed_poses]
        placed |= {name: model.put(name, proposal[name]) for name in with_fixed_poses if name in proposal}
        spread = spread_grid(model, free, placed, seed) if len(free) > 1 else None
        if spread is not None:
            search_budget.steps_taken += 1
            proposal |= spread
            placed |= {name: model.put(name, placement) for name, placement in spread.items()}
        elif len(free) > 1:
            steps = int(FAMILY_SHARE * (search_budget.max_steps - search_budget.steps_taken))
            seated, taken = pack_shelves(model, free, placed, model.rules, seed, steps)
            search_budget.steps_taken += taken
            proposal |= seated
            placed |= {name: model.put(name, placement) for name, placement in seated.items()}
    return proposal


def _by_place(model: SolverModel, names: Sequence[str]) -> list[list[str]]:
    groups: dict[tuple[str, str], list[str]] = defaultdict(list)
    for name in sorted(names, key=lambda n: model.rank[n]):
        thing = model.things[name]
        groups[thing.parent, thing.place.name].append(name)
    return [sorted(members) for members in groups.values()]
