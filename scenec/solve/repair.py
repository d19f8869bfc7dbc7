"""Repairs an earlier or a proposed assignment: keeps its largest valid part found and searches poses for the rest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from scenec.ir.problem import Placement
from scenec.solve.check import invalid_things
from scenec.solve.model import SolverModel
from scenec.solve.placed import Placed
from scenec.solve.search import SearchBudget, search
from scenec.solve.stacks import without

REPAIR_ROUNDS = 3  # each also removes obstacles of the last
STEPS_PER_THING = 40


def largest_valid_subset(
    model: SolverModel, proposal: Mapping[str, Placement], suspects: Iterable[str] | None = None
) -> dict[str, Placed]:
    """The part of a proposal left after removing, one by one, the thing involved in most faults. With `suspects` only
    these are checked (the rest was valid before); things on a removed owner keep their pose relative to it."""
    assignment = {
        name: model.put(name, placement)
        for name, placement in proposal.items()
        if name in model.things and placement.stance < len(model.shapes[name])
    }
    faults = invalid_things(model, assignment, suspects)
    while faults:
        weight: Counter[str] = Counter()
        for name, others in faults.items():
            weight[name] += max(len(others), 1) if others else len(model.things)
            weight.update(other for other in others if other in assignment)
        worst = max(sorted(weight), key=lambda name: weight[name])
        assignment.pop(worst, None)
        faults.pop(worst, None)
        faults = {name: left for name, others in faults.items() if (left := others - {worst}) or not others}
    return without(model, assignment, ())


def repaired(
    model: SolverModel,
    names: Sequence[str],
    proposal: Mapping[str, Placement],
    seed: int,
    search_budget: SearchBudget,
    suspects: Iterable[str] | None = None,
) -> dict[str, Placed] | None:
    """An assignment of `names` that keeps as much of the proposal as possible; None after REPAIR_ROUNDS."""
    valid = largest_valid_subset(model, proposal, suspects)
    missing = [name for name in names if name not in valid]
    for _ in range(REPAIR_ROUNDS):
        if not missing:
            return valid
        before = search_budget.failures.copy()
        trial_budget = SearchBudget(
            min(search_budget.max_steps, search_budget.steps_taken + STEPS_PER_THING * len(missing)),
            search_budget.steps_taken,
        )
        assignment = search(model, missing, valid, seed, trial_budget)
        search_budget.steps_taken = trial_budget.steps_taken
        search_budget.record_best(trial_budget.best_assignment)
        search_budget.failures = before + trial_budget.failures
        if assignment is not None:
            return {**valid, **assignment}
        stuck = trial_budget.failures.most_common(1)[0][0] if trial_budget.failures else missing[0]
        freed = _around(model, stuck, valid)
        if not freed:
            return None
        left = without(model, valid, freed)
        missing = [*missing, *(name for name in valid if name not in left)]
        valid = left
    return None


def _around(model: SolverModel, name: str, valid: Mapping[str, Placed]) -> list[str]:
    # The smaller half of the things on the same owner: small things find a new place more easily.
    mates = [n for n, placed in valid.items() if placed.parent == model.things[name].parent and n not in model.carriers]
    mates.sort(key=lambda n: (model.shapes[n][valid[n].placement.stance].area_m2, n))
    return mates[: max(len(mates) // 2, 1)]
