"""Solves every combination of each component and derives verdicts of whole combinations from the results."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from scenec.bind.components import IndependentComponent, Lowered
from scenec.bind.pairwise_cover import AT_LEAST, containing, cover
from scenec.bind.variants import MAX_COMBINATIONS, Combination
from scenec.explain.report import verdict_of
from scenec.ir.problem import Exhausted, Infeasible, Placement, Problem, Result, Solved
from schemas.scene.compiled import CombinationVerdict, ComponentVerdict, Verdict

_WORST_FIRST: tuple[Verdict, ...] = ("infeasible", "budget_exhausted", "compiled")


@dataclass(frozen=True)
class CombinationResult:
    """Result of one combination of a component, or of one with single candidates where their union has no scene."""

    combination: Combination
    result: Result
    seconds: float

    @property
    def row(self) -> CombinationVerdict:
        """The entry of the report."""
        proof = self.result.proof.text if isinstance(self.result, Infeasible) else ""
        return CombinationVerdict(
            combination=self.combination, verdict=verdict_of(self.result), proof=proof, seconds=self.seconds
        )


@dataclass(frozen=True)
class Verdicts:
    """By component one result for each combination, followed by those of single candidates."""

    lowered: Lowered
    results: tuple[tuple[CombinationResult, ...], ...]

    @property
    def worst(self) -> tuple[int, CombinationResult] | None:
        """Number of the component and first result with the worst verdict; None when everything compiled."""
        every = [(k, one) for k, component_results in enumerate(self.results) for one in component_results]
        k, one = min(every, key=lambda pair: _rank(pair[1].row))
        return None if isinstance(one.result, Solved) else (k, one)

    @property
    def rows(self) -> tuple[CombinationVerdict, ...]:
        """The verdicts of all components."""
        return tuple(one.row for component_results in self.results for one in component_results)

    def due_to(self, component: int, failed: CombinationResult) -> Combination:
        """The choices that cause a failure: none where every combination of the component fails for the same reason."""
        why = {_cause(one.result) for one in self.results[component]}
        return {} if len(why) == 1 and len(self.results[component]) > 1 else failed.combination

    def components(self) -> tuple[ComponentVerdict, ...]:
        """The verdicts by component."""
        verdicts_by_component: list[ComponentVerdict] = []
        for component, component_results in zip(self.lowered.components, self.results, strict=True):
            rows = tuple(one.row for one in component_results)
            worst = min(rows, key=_rank)
            verdicts_by_component.append(
                ComponentVerdict(
                    things=component.things, verdict=worst.verdict, combinations=rows, union=component.union
                )
            )
        return tuple(verdicts_by_component)

    def shown(self) -> tuple[Combination, ...]:
        """Combinations of all keys that are made into scenes: every one where these are few, else a cover."""
        components = self.lowered.components
        if len(components) == 1:
            return components[0].combinations
        if self.lowered.count <= AT_LEAST:
            return tuple(self.lowered.binder.variants.combinations(self.lowered.keys))
        return cover([component.combinations for component in components])

    def whole(self, component: int, chosen: Combination) -> Combination:
        """A combination of all keys that contains `chosen`; other components have one that compiled, where there is
        any."""
        order: list[list[Combination]] = []
        for known in self.results:
            compiled = [one.combination for one in known if isinstance(one.result, Solved)]
            order.append(compiled + [one.combination for one in known])
        order[component] = [chosen]
        return containing(chosen, order)

    def result(self, whole: Mapping[str, str]) -> Result:
        """Result of a combination of all keys: placements of all components, or the worst of their results."""
        component_results = self._of(whole)
        if (
            refuted := next((one.result for one in component_results if isinstance(one.result, Infeasible)), None)
        ) is not None:
            return refuted
        placements_of_components = [
            one.result.placements if isinstance(one.result, Solved) else _best_placements(one.result)
            for one in component_results
        ]
        together = {name: at for places in placements_of_components for name, at in sorted(places.items())}
        steps = sum(one.result.steps for one in component_results if not isinstance(one.result, Infeasible))
        exhausted = next((one.result for one in component_results if isinstance(one.result, Exhausted)), None)
        if exhausted is None:
            return Solved(dict(sorted(together.items())), steps)
        things = sum(len(component.things) for component in self.lowered.components)
        return replace(exhausted, placed=len(together), of=things, steps=steps, best_placements=together)

    def matrix(self, shown: Sequence[Combination]) -> tuple[CombinationVerdict, ...]:
        """A row for each combination of all keys, while there are at most 256; else one for each of `shown`."""
        if self.lowered.count <= MAX_COMBINATIONS:
            shown = tuple(self.lowered.binder.variants.combinations(self.lowered.keys))
        rows: list[CombinationVerdict] = []
        for whole in shown:
            of = [one.row for one in self._of(whole)]
            worst = min(of, key=_rank)
            seconds = sum(row.seconds for row in of)
            rows.append(worst.model_copy(update={"combination": whole, "seconds": seconds}))
        return tuple(rows)

    def _of(self, whole: Mapping[str, str]) -> list[CombinationResult]:
        component_results: list[CombinationResult] = []
        for component, known in zip(self.lowered.components, self.results, strict=True):
            single = [one for one in known[len(component.combinations) :] if one.combination.items() <= whole.items()]
            component_results.append(single[0] if single else known[component.index(whole)])
        return component_results


def _rank(row: CombinationVerdict) -> int:
    return _WORST_FIRST.index(row.verdict)


def _cause(result: Result) -> tuple[object, ...]:
    # The part of a result that does not depend on sizes.
    return (result.proof.kind, result.proof.paths) if isinstance(result, Infeasible) else (type(result),)


def _best_placements(result: Result) -> dict[str, Placement]:
    return result.best_placements if isinstance(result, Exhausted) else {}


def verdicts(lowered: Lowered, solve: Callable[[Problem], Result]) -> Verdicts:
    """Solves every combination of every component with `solve`."""
    return Verdicts(lowered, tuple(_component_results(component, lowered, solve) for component in lowered.components))


def _component_results(
    component: IndependentComponent, lowered: Lowered, solve: Callable[[Problem], Result]
) -> tuple[CombinationResult, ...]:
    pairs = zip(component.combinations, component.problems, strict=True)
    results = [_timed(combination, problem, solve) for combination, problem in pairs]
    if not component.union:
        return tuple(results)
    singles = []
    for k, one in enumerate(results):
        if isinstance(one.result, Infeasible):
            results[k] = replace(one, result=_unproved(one.result, component))
        if not isinstance(one.result, Solved):
            singles += [
                _timed(c, lowered.binder.problem(c, component.nodes), solve) for c in _singled(one, component, lowered)
            ]
    return (*results, *singles)


def _timed(combination: Combination, problem: Problem, solve: Callable[[Problem], Result]) -> CombinationResult:
    since = time.perf_counter()
    return CombinationResult(combination, solve(problem), time.perf_counter() - since)


def _unproved(result: Infeasible, component: IndependentComponent) -> Exhausted:
    """An infeasible union of footprints, which proves nothing about single candidates."""
    note = f"all candidates of {', '.join(component.union)} at once have no scene ({result.proof.text})"
    return Exhausted(0, len(component.things), "", 0, note=note)


def _singled(one: CombinationResult, component: IndependentComponent, lowered: Lowered) -> list[Combination]:
    """Combinations of single candidates that contain each candidate at least once."""
    variants = lowered.binder.variants
    pools = {
        name: variants.candidates(name, one.combination.get("variants.assets", "as_written"))
        for name in component.union
    }
    combinations = []
    for k in range(max(map(len, pools.values()))):
        picked = {f"objects.{name}": candidates[min(k, len(candidates) - 1)] for name, candidates in pools.items()}
        combinations.append(
            one.combination | {key: single.id for key, single in picked.items() if single.type == "fixed"}
        )
    return combinations
