"""Repair: keep what stands right of an earlier or a proposed assignment, and seat the rest anew."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from scenec.ir.problem import Placement
from scenec.solve.check import faulty
from scenec.solve.model import Model
from scenec.solve.placed import Placed
from scenec.solve.search import Effort, search
from scenec.solve.stacks import without

ROUNDS = 3  # each takes up what stood in the way of the last
STEPS_PER_THING = 40


def kept(model: Model, proposal: Mapping[str, Placement], suspects: Iterable[str] | None = None) -> dict[str, Placed]:
    """The largest part of a proposal found by taking away, one by one, what takes part in most faults. Only `suspects`
    are looked at where given (the rest was found right before); things on what was taken away stay with it."""
    assignment = {
        name: model.put(name, placement)
        for name, placement in proposal.items()
        if name in model.things and placement.stance < len(model.shapes[name])
    }
    faults = faulty(model, assignment, suspects)
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
    model: Model,
    names: Sequence[str],
    proposal: Mapping[str, Placement],
    seed: int,
    effort: Effort,
    suspects: Iterable[str] | None = None,
) -> dict[str, Placed] | None:
    """An assignment of `names` that keeps as much of the proposal as it can; None when a few rounds do not do it."""
    right = kept(model, proposal, suspects)
    missing = [name for name in names if name not in right]
    for _ in range(ROUNDS):
        if not missing:
            return right
        before = effort.failures.copy()
        trial = Effort(min(effort.left, effort.taken + STEPS_PER_THING * len(missing)), effort.taken)
        found = search(model, missing, right, seed, trial)
        effort.taken = trial.taken
        effort.reached(trial.stood)
        effort.failures = before + trial.failures
        if found is not None:
            return {**right, **found}
        stuck = trial.failures.most_common(1)[0][0] if trial.failures else missing[0]
        freed = _around(model, stuck, right)
        if not freed:
            return None
        left = without(model, right, freed)
        missing = [*missing, *(name for name in right if name not in left)]
        right = left
    return None


def _around(model: Model, name: str, right: Mapping[str, Placed]) -> list[str]:
    # The smaller half of what stands on the same owner: small things find a new place more easily.
    mates = [n for n, placed in right.items() if placed.parent == model.things[name].parent and n not in model.carriers]
    mates.sort(key=lambda n: (model.shapes[n][right[n].placement.stance].area_m2, n))
    return mates[: max(len(mates) // 2, 1)]
