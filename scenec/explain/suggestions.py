"""Suggests edits that make an infeasible program compile; each was solved again, the smallest change comes first.

Numbers are changed as little as needed: bisection between the failing value and one that works, rounded to a millimetre
(clearance: a tenth of it) towards the working side; the rounded value is what is solved last.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice

import numpy as np

from scenec.explain.minimal_conflict import Conflict, Feasible
from scenec.ir.problem import Problem, Solved, Thing
from scenec.ir.relaxed import CLEARANCE, relaxed
from scenec.proofs import prove_cheaply
from scenec.relations.protocol import SUGGESTION_STEP_M, WIDEST_M, WeakerNumber
from scenec.relations.table import RELATIONS
from schemas.scene.compiled import Suggestion
from schemas.scene.geometry import BACKGROUND, Domain, ScenePlace, SceneRelation
from source.tree import Path, written

MOST_SUGGESTIONS = 5
MOST_SOLVES = 80

Change = Callable[[Problem], Problem]


@dataclass(frozen=True)
class ProgramEdit:
    """One edit: its text, the change of a problem that it makes, and its cost (from 1 on, a constraint is dropped)."""

    text: str
    change: Change
    cost: float


class FeasibilityOracle:
    """Decides whether edited problems have scenes, within a number of solves."""

    def __init__(self, feasible: Feasible) -> None:
        self.feasible, self.solves_left = feasible, MOST_SOLVES

    def works(self, problem: Problem) -> bool:
        """Whether a scene was found; also False when the solves are used up."""
        if prove_cheaply(problem) is not None or self.solves_left <= 0:
            return False
        self.solves_left -= 1
        return isinstance(self.feasible(problem), Solved)


def suggestions(
    problem: Problem, conflict: Conflict, feasible: Feasible, others: Sequence[Problem] = ()
) -> tuple[Suggestion, ...]:
    """At most five edits that were solved again and gave a scene, the smallest first; none when no single edit does.
    They are found for one combination and verified in the `others`, since an edit changes the whole program."""
    oracle = FeasibilityOracle(feasible)
    edits = [edit for path in conflict.paths for edit in _edits(problem, path, oracle)]
    edits += [edit for thing in _involved(problem, conflict) for edit in _moves(problem, thing, oracle)]
    ranked = sorted({edit.text: edit for edit in reversed(edits)}.values(), key=lambda edit: (edit.cost, edit.text))
    oracle_of_others = FeasibilityOracle(feasible)
    right = (edit for edit in ranked if all(oracle_of_others.works(edit.change(other)) for other in others))
    return tuple(Suggestion(edit=edit.text, verified=True) for edit in islice(right, MOST_SUGGESTIONS))


def without_swept_spaces(problem: Problem, feasible: Feasible, others: Sequence[Problem]) -> tuple[Suggestion, ...]:
    """Spaces kept clear (`keep_clear`) without any one of which a scene was found, where no proof says why there is
    none."""
    oracle = FeasibilityOracle(feasible)
    titles = {space.path: space.title for space in problem.keep_clear}
    return tuple(
        Suggestion(edit=f"drop {title}", verified=True)
        for path, title in islice(titles.items(), MOST_SUGGESTIONS)
        if all(oracle.works(relaxed(one, {path})) for one in (problem, *others))
    )


def _edits(problem: Problem, path: Path, oracle: FeasibilityOracle) -> Iterator[ProgramEdit]:
    """Edits of one member of the conflict: its number moved, or the member dropped."""

    def without(of: Problem) -> Problem:
        return relaxed(of, {path})

    if not oracle.works(without(problem)):
        return
    relations = list({r.kind: r for r in reversed(problem.relations) if r.path == path}.values())[::-1]
    if path == CLEARANCE:
        yield from _lower_clearance(problem, oracle)
        return
    if relations:
        for relation in relations:
            yield from _relax_relation(problem, relation, oracle)
    elif problem.reach is not None and path == problem.reach.path:
        yield from _farther_reach(problem, oracle)
    elif path[-1] in ("x", "y"):
        yield from _widen(problem, path, oracle)
    elif path[-1] == "yaw":
        yield ProgramEdit(f"free yaw of {written(_owner(path))}", without, 0.5)
        return
    is_range = path[-1] in ("x", "y")
    subject = f"{path[-1]} of {written(_owner(path))}" if is_range else problem.title(path) or written(path)
    yield ProgramEdit(f"drop {subject}", without, 2.0 if any(thing.path == path for thing in problem.things) else 1.0)


def _owner(path: Path) -> Path:
    """Path of the node or group that owns a range."""
    return path[: path.index("ranges")] if "placement" not in path else path[: path.index("placement")]


def _lower_clearance(problem: Problem, oracle: FeasibilityOracle) -> Iterator[ProgramEdit]:
    def at(value: float, of: Problem) -> Problem:
        return replace(of, clearance_m=value)

    value = _least_change(problem.clearance_m, 0.0, SUGGESTION_STEP_M / 10.0, lambda v: oracle.works(at(v, problem)))
    if value is not None:
        yield ProgramEdit(f"lower clearance to {value:.4g}", partial(at, value), 1.0 - value / problem.clearance_m)


def _relax_relation(problem: Problem, relation: SceneRelation, oracle: FeasibilityOracle) -> Iterator[ProgramEdit]:
    """A changed gap, distance or tolerance of a relation."""
    for number in RELATIONS[relation.kind].weaker(relation):
        at = partial(_with_number, relation, number)
        value = _least_change(number.start, number.end, number.step, lambda v, at=at: oracle.works(at(v, problem)))
        if value is not None:
            text = f"set {number.key} of {written(relation.path)} to {value:.4g}"
            cost = min(0.9, number.cost_per_unit * abs(value - number.start))
            yield ProgramEdit(text, partial(at, value), cost)


def _with_number(relation: SceneRelation, number: WeakerNumber, value: float, problem: Problem) -> Problem:
    """The problem with another number in all relations that were lowered from the same written one to this kind."""
    changed = [
        number.changed(r, value) if (r.path, r.kind) == (relation.path, relation.kind) else r for r in problem.relations
    ]
    return replace(problem, relations=tuple(changed))


def _farther_reach(problem: Problem, oracle: FeasibilityOracle) -> Iterator[ProgramEdit]:
    reach = problem.reach
    assert reach is not None, "called for a reach only"

    def at(value: float, of: Problem) -> Problem:
        return replace(of, reach=None if of.reach is None else replace(of.reach, most_m=value))

    value = _least_change(
        reach.most_m, reach.most_m + WIDEST_M, SUGGESTION_STEP_M, lambda v: oracle.works(at(v, problem))
    )
    if value is not None:
        yield ProgramEdit(
            f"set radius of {written(reach.path)} to {value:.4g}", partial(at, value), value - reach.most_m
        )


def _widen(problem: Problem, path: Path, oracle: FeasibilityOracle) -> Iterator[ProgramEdit]:
    """A wider range of x or y: to one side where that is enough, else to both."""
    widenings = 0
    for sides, words in (((1, 0), "downward"), ((0, 1), "upward"), ((1, 1), "at both ends")):
        if sum(sides) > 1 and widenings:
            return
        by = _least_change(
            0.0, WIDEST_M, SUGGESTION_STEP_M, lambda v, s=sides: oracle.works(_widened(problem, path, v, s))
        )
        if by is not None:
            widenings += 1
            text = f"widen {path[-1]} of {written(_owner(path))} by {by:.4g} m {words}"
            yield ProgramEdit(text, partial(_widened, path=path, by_m=by, sides=sides), by)


def _widened(problem: Problem, path: Path, by_m: float, sides: tuple[int, int]) -> Problem:
    def change(domain: Domain) -> Domain:
        if (*domain.path, path[-1]) != path:
            return domain
        low, high = domain.x_m if path[-1] == "x" else domain.y_m
        wider = (low - sides[0] * by_m, high + sides[1] * by_m)
        return replace(domain, x_m=wider) if path[-1] == "x" else replace(domain, y_m=wider)

    return replace(problem, things=tuple(replace(thing, domain=change(thing.domain)) for thing in problem.things))


def _least_change(start: float, end: float, step: float, works: Callable[[float], bool]) -> float | None:
    """The value nearest to `start`, on the raster `step` from zero, that works; None when not even `end` does.

    Widening doubles first, so that a small change is found in few solves.
    """
    sign = 1.0 if end > start else -1.0
    good, last = None, 0.0
    reach = step
    while last < abs(end - start):
        offset = min(reach, abs(end - start))
        value = _rounded(start + sign * offset, step, sign)
        value = min(value, end) if sign > 0.0 else max(value, end)
        if works(value):
            good = value
            break
        last, reach = offset, reach * 4.0
    if good is None:
        return None
    while abs(good - start) - last > step * 1.5:
        middle = _rounded(start + sign * (abs(good - start) + last) / 2.0, step, sign)
        if abs(middle - good) < step / 2.0:
            break
        if works(middle):
            good = middle
        else:
            last = abs(middle - start)
    return good


def _rounded(value: float, step: float, sign: float) -> float:
    parts = value / step
    return round(float((np.ceil(parts - 1e-6) if sign > 0.0 else np.floor(parts + 1e-6)) * step), 9)


# Another place.


def _involved(problem: Problem, conflict: Conflict) -> list[Thing]:
    """Things that carry nothing and that the conflict, or one of its relations, names; at most four."""
    named = set(conflict.paths) | set(conflict.proof.paths)
    speak = {name for relation in problem.relations if relation.path in named for name in relation.things}
    owners = {thing.parent for thing in problem.things}
    return [t for t in problem.things if (t.path in named or t.name in speak) and t.name not in owners][:4]


def _moves(problem: Problem, thing: Thing, oracle: FeasibilityOracle) -> Iterator[ProgramEdit]:
    """Edits that move the thing to another place in use, free to be anywhere there."""
    if thing.group is not None or sum(other.path == thing.path for other in problem.things) > 1:
        return
    for owner, name in _places(problem):
        if (owner, name) == (thing.parent, thing.place.name) or owner == thing.name:
            continue
        change = partial(_moved, thing=thing.name, owner=owner, name=name)
        if oracle.works(change(problem)):
            yield ProgramEdit(f"move {thing.name} to {name if owner == BACKGROUND else owner}", change, 0.95)


def _places(problem: Problem) -> dict[tuple[str, str], ScenePlace]:
    """Places that the program uses, and the main surface of everything that is placed; by owner and name."""
    tops = {(owner.name, top.name): top for owner in problem.things for top in owner.body.surfaces[:1]}
    return tops | {(other.parent, other.place.name): other.place for other in problem.things}


def _moved(problem: Problem, thing: str, owner: str, name: str) -> Problem:
    """The problem with the thing free on another place; where its owner has another asset, on the first place of
    that."""
    places = _places(problem)
    place = places.get((owner, name)) or next((p for (of, _), p in places.items() if of == owner), None)
    if place is None:
        return problem
    return replace(
        problem,
        things=tuple(
            replace(
                t,
                parent=owner,
                place=place,
                domain=Domain(orientation_indices=t.domain.orientation_indices, path=t.domain.path),
            )
            if t.name == thing
            else t
            for t in problem.things
        ),
    )
