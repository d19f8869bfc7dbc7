"""Parts solved one by one, and what that says of whole combinations."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from scenec.bind.components import Lowered, Part
from scenec.bind.pairwise_cover import AT_LEAST, containing, cover
from scenec.bind.variants import MAX_COMBINATIONS, Combination
from scenec.explain.report import verdict_of
from scenec.ir.problem import Exhausted, Infeasible, Placement, Problem, Result, Solved
from schemas.scene.compiled import CombinationVerdict, ComponentVerdict, Verdict

_WORST_FIRST: tuple[Verdict, ...] = ("infeasible", "budget_exhausted", "compiled")


@dataclass(frozen=True)
class Tried:
    """What became of one combination of a part, or of one with single candidates where their union has no scene."""

    combination: Combination
    result: Result
    seconds: float

    @property
    def row(self) -> CombinationVerdict:
        """As the report has it."""
        proof = self.result.proof.text if isinstance(self.result, Infeasible) else ""
        return CombinationVerdict(
            combination=self.combination, verdict=verdict_of(self.result), proof=proof, seconds=self.seconds
        )


@dataclass(frozen=True)
class Verdicts:
    """Of each part one entry a combination, and after these the single ones that were looked at."""

    lowered: Lowered
    tried: tuple[tuple[Tried, ...], ...]

    @property
    def worst(self) -> tuple[int, Tried] | None:
        """Number of the part and the first of the worst verdict; None when everything compiled."""
        every = [(k, one) for k, found in enumerate(self.tried) for one in found]
        k, one = min(every, key=lambda pair: _rank(pair[1].row))
        return None if isinstance(one.result, Solved) else (k, one)

    @property
    def rows(self) -> tuple[CombinationVerdict, ...]:
        """The verdicts of all parts."""
        return tuple(one.row for found in self.tried for one in found)

    def due_to(self, part: int, failed: Tried) -> Combination:
        """The choices to which a failure is due: none where every combination of the part fails by the same rule."""
        why = {_cause(one.result) for one in self.tried[part]}
        return {} if len(why) == 1 and len(self.tried[part]) > 1 else failed.combination

    def components(self) -> tuple[ComponentVerdict, ...]:
        """The verdicts by part."""
        made: list[ComponentVerdict] = []
        for part, found in zip(self.lowered.parts, self.tried, strict=True):
            rows = tuple(one.row for one in found)
            worst = min(rows, key=_rank)
            made.append(
                ComponentVerdict(things=part.things, verdict=worst.verdict, combinations=rows, union=part.union)
            )
        return tuple(made)

    def shown(self) -> tuple[Combination, ...]:
        """Combinations of all keys that are made into scenes: every one where these are few, else a cover."""
        parts = self.lowered.parts
        if len(parts) == 1:
            return parts[0].combinations
        if self.lowered.count <= AT_LEAST:
            return tuple(self.lowered.binder.variety.combinations(self.lowered.keys))
        return cover([part.combinations for part in parts])

    def whole(self, part: int, chosen: Combination) -> Combination:
        """A combination of all keys with that of a part; other parts have one that compiled, where there is any."""
        order: list[list[Combination]] = []
        for known in self.tried:
            compiled = [one.combination for one in known if isinstance(one.result, Solved)]
            order.append(compiled + [one.combination for one in known])
        order[part] = [chosen]
        return containing(chosen, order)

    def result(self, whole: Mapping[str, str]) -> Result:
        """What became of a combination of all keys: placements of all parts, or the worst of their results."""
        found = self._of(whole)
        if (refuted := next((one.result for one in found if isinstance(one.result, Infeasible)), None)) is not None:
            return refuted
        stood = [one.result.placements if isinstance(one.result, Solved) else _stood(one.result) for one in found]
        together = {name: at for places in stood for name, at in sorted(places.items())}
        steps = sum(one.result.steps for one in found if not isinstance(one.result, Infeasible))
        lost = next((one.result for one in found if isinstance(one.result, Exhausted)), None)
        if lost is None:
            return Solved(dict(sorted(together.items())), steps)
        things = sum(len(part.things) for part in self.lowered.parts)
        return replace(lost, placed=len(together), of=things, steps=steps, stood=together)

    def matrix(self, shown: Sequence[Combination]) -> tuple[CombinationVerdict, ...]:
        """A row for each combination of all keys, while there are at most 256; else one for each of `shown`."""
        if self.lowered.count <= MAX_COMBINATIONS:
            shown = tuple(self.lowered.binder.variety.combinations(self.lowered.keys))
        rows: list[CombinationVerdict] = []
        for whole in shown:
            of = [one.row for one in self._of(whole)]
            worst = min(of, key=_rank)
            seconds = sum(row.seconds for row in of)
            rows.append(worst.model_copy(update={"combination": whole, "seconds": seconds}))
        return tuple(rows)

    def _of(self, whole: Mapping[str, str]) -> list[Tried]:
        found: list[Tried] = []
        for part, known in zip(self.lowered.parts, self.tried, strict=True):
            single = [one for one in known[len(part.combinations) :] if one.combination.items() <= whole.items()]
            found.append(single[0] if single else known[part.index(whole)])
        return found


def _rank(row: CombinationVerdict) -> int:
    return _WORST_FIRST.index(row.verdict)


def _cause(result: Result) -> tuple[object, ...]:
    # What of a result does not depend on sizes.
    return (result.proof.kind, result.proof.paths) if isinstance(result, Infeasible) else (type(result),)


def _stood(result: Result) -> dict[str, Placement]:
    return result.stood if isinstance(result, Exhausted) else {}


def verdicts(lowered: Lowered, solve: Callable[[Problem], Result]) -> Verdicts:
    """Every combination of every part solved by `solve`; parts are independent."""
    return Verdicts(lowered, tuple(_tried(part, lowered, solve) for part in lowered.parts))


def _tried(part: Part, lowered: Lowered, solve: Callable[[Problem], Result]) -> tuple[Tried, ...]:
    pairs = zip(part.combinations, part.problems, strict=True)
    found = [_timed(combination, problem, solve) for combination, problem in pairs]
    if not part.union:
        return tuple(found)
    singles = []
    for k, one in enumerate(found):
        if isinstance(one.result, Infeasible):
            found[k] = replace(one, result=_unproved(one.result, part))
        if not isinstance(one.result, Solved):
            singles += [_timed(c, lowered.binder.problem(c, part.nodes), solve) for c in _singled(one, part, lowered)]
    return (*found, *singles)


def _timed(combination: Combination, problem: Problem, solve: Callable[[Problem], Result]) -> Tried:
    since = time.perf_counter()
    return Tried(combination, solve(problem), time.perf_counter() - since)


def _unproved(result: Infeasible, part: Part) -> Exhausted:
    """A union of footprints that has no scene proves nothing of single candidates."""
    note = f"all candidates of {', '.join(part.union)} at once have no scene ({result.proof.text})"
    return Exhausted(0, len(part.things), "", 0, note=note)


def _singled(one: Tried, part: Part, lowered: Lowered) -> list[Combination]:
    """Combinations of single candidates, so that each is in one."""
    variety = lowered.binder.variety
    pools = {
        name: variety.candidates(name, one.combination.get("variants.assets", "as_written")) for name in part.union
    }
    made = []
    for k in range(max(map(len, pools.values()))):
        picked = {f"objects.{name}": found[min(k, len(found) - 1)] for name, found in pools.items()}
        made.append(one.combination | {key: single.id for key, single in picked.items() if single.type == "fixed"})
    return made
