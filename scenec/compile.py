"""The compiler: runs all phases on a program and returns a report with verdicts by component, and all scenes or
none."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path as FilePath

from scenec.analyse.interaction_graph import InteractionGraph, interaction_graph
from scenec.bind.asset_library import AssetLibrary
from scenec.bind.choice_spans import chosen_paths
from scenec.bind.components import lower
from scenec.bind.variants import Combination
from scenec.check import between_phases
from scenec.check.judge_views import plan_without_view, without_view
from scenec.emit.scene import compiled_scene
from scenec.explain.drop_choices import dropped_choices
from scenec.explain.minimal_conflict import minimal_conflict
from scenec.explain.report import conflict_members, failure_finding, verdict_of
from scenec.explain.suggestions import MOST_SUGGESTIONS, suggestions, without_swept_spaces
from scenec.explain.verdicts import verdicts
from scenec.ir.derivation_cache import DerivationCache
from scenec.ir.problem import Exhausted, Infeasible, Placement, Problem, Proof, Result, Solved
from scenec.plan.document import runtime_plan
from scenec.solve import DEFAULT_BUDGET, ComponentCache, solve
from scenec.source.read import ReadResult, read_program
from schemas.diagnostics import Diagnostic, any_error
from schemas.scene.compiled import CompiledScene, CompileReport, Suggestion
from schemas.scene.runtime_plan import RuntimePlan
from source.incremental_parse import IncrementalParser
from source.tree import Path

EXPLAIN_BUDGET = 2_000  # steps of each solve while explaining why there is no scene


@dataclass(frozen=True)
class Compiled:
    """Result of a compile. `problems` and `results` have one entry for each combination that is shown (see
    `scenec.explain.verdicts`), `scenes` as many or none.

    `failed` is the index of the combination that the report explains, None when every one gave a scene; `chosen` are
    those of its choices that cause the failure.
    """

    report: CompileReport
    scenes: tuple[CompiledScene, ...] = ()
    results: tuple[Result, ...] = ()
    problems: tuple[Problem, ...] = ()
    failed: int | None = None
    conflict: tuple[Path, ...] = ()
    plan: RuntimePlan | None = None
    chosen: Combination = field(default_factory=dict)

    @cached_property
    def graphs(self) -> tuple[InteractionGraph, ...]:
        """The typed interaction graph of each combination."""
        return tuple(interaction_graph(problem) for problem in self.problems)

    def placements(self, combination: dict[str, str]) -> dict[str, Placement]:
        """Placements in the first scene with these choices, empty where there is none."""
        for problem, result in zip(self.problems, self.results, strict=True):
            if combination.items() <= problem.combination.items() and isinstance(result, Solved):
                return result.placements
        return {}


@dataclass(frozen=True)
class Explanation:
    """Why there is no scene: conflicting constraints, whether their set is minimal (None: unknown), verified edits."""

    conflict: tuple[Path, ...] = ()
    minimal: bool | None = None
    edits: tuple[Suggestion, ...] = ()
    proof: Proof | None = None


class Clock:
    """Seconds spent in each phase, in the order in which they began."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._since = time.perf_counter()

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Adds the time spent inside to the phase `name`."""
        since = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - since

    @property
    def total_s(self) -> float:
        """Seconds since the clock was made."""
        return time.perf_counter() - self._since


def compile_program(
    path: FilePath,
    assets: FilePath | None = None,
    *,
    seed: int = 0,
    budget: int = DEFAULT_BUDGET,
    root: FilePath | None = None,
    previous: Compiled | None = None,
    cache: ComponentCache | None = None,
    library: AssetLibrary | None = None,
    parser: IncrementalParser | None = None,
    derivations: DerivationCache | None = None,
    explain: bool = True,
    diversity: float | None = None,
) -> Compiled:
    """Compile the program in `path` with the packages in `assets`; deterministic in program, assets and seed.

    `scenes` holds a checked scene for each combination of geometry-changing variants, or nothing at all unless all of
    them compiled. `budget` bounds the steps of the search of each combination. Placements of `previous` are repaired
    before anything is searched anew; `cache`, `library`, `parser` and `derivations` keep components, assets, parsed
    entries and derived values of earlier compiles (`scenec.session` holds all five). With `explain`, a failure comes
    with conflict and suggestions; with `diversity`, success comes with a plan of many scenes (see
    scenec.plan.document). Raises RuntimeError when the independent checker refuses the result: a defect of ours, not of
    the program.
    """
    clock = Clock()
    with clock.phase("read"):
        read = read_program(path, root, parser, derivations)
    if read.program is None:
        return Compiled(_invalid(read.diagnostics, clock))
    library, derivations = library or AssetLibrary(assets), derivations or DerivationCache()
    with clock.phase("bind"):
        lowered = lower(read.program, library, read.spans, derivations)
    diagnostics = (*read.diagnostics, *lowered.diagnostics)
    if not lowered.problems or any_error(lowered.diagnostics):
        return Compiled(_invalid(diagnostics, clock))
    with clock.phase("bind"):
        for problem in lowered.problems:
            between_phases.after_binding(problem, derivations)
    cache = cache or ComponentCache()

    def solved(problem: Problem) -> Result:
        with clock.phase("solve"):
            known = previous.placements(problem.combination) if previous is not None else None
            result = solve(problem, seed, budget, previous=known, cache=cache)
        if isinstance(result, Solved):
            with clock.phase("check"):
                between_phases.after_solving(problem, result.placements, derivations)
        return result

    outcome = verdicts(lowered, solved)
    worst = outcome.worst
    shown = outcome.shown()
    failed = None if worst is None else outcome.whole(worst[0], worst[1].combination)
    if failed is not None and failed not in shown:
        shown = (failed, *shown)
    with clock.phase("bind"):
        problems = tuple(lowered.whole(combination) for combination in shown)
    results = tuple(outcome.result(combination) for combination in shown)
    report = CompileReport(
        verdict="compiled",
        seconds=clock.total_s,
        matrix=outcome.matrix(shown),
        components=outcome.components(),
        combinations=lowered.count,
        diagnostics=diagnostics,
        phases=clock.seconds,
    )
    if worst is not None and failed is not None:
        index = shown.index(failed)
        with clock.phase("explain"):
            explanation = _explain(problems, index, results[index], seed) if explain else Explanation()
            explanation = replace(
                explanation, edits=(*dropped_choices(outcome.rows), *explanation.edits)[:MOST_SUGGESTIONS]
            )
        if explanation.proof is not None:  # Of the conflict, not of the whole.
            results = (*results[:index], Infeasible(explanation.proof), *results[index + 1 :])
        report = _failure(report, read, problems[index], results[index], explanation, outcome.due_to(*worst), clock)
        return Compiled(report, (), results, problems, index, explanation.conflict, chosen=outcome.due_to(*worst))
    if len(lowered.components) > 1:
        with clock.phase("check"):
            for problem, result in zip(problems, results, strict=True):
                assert isinstance(result, Solved), "all parts compiled"
                between_phases.after_binding(problem, derivations)
                between_phases.after_solving(problem, result.placements, derivations)
    with clock.phase("emit"):
        scenes = tuple(_emit(p, r, seed, derivations) for p, r in zip(problems, results, strict=True))
    blocked = tuple(without_view(read.program, scenes, seed, read.spans))
    if blocked:
        return Compiled(_invalid((*diagnostics, *blocked), clock), (), results, problems)
    plan = None
    if diversity is not None:
        ready = [result for result in results if isinstance(result, Solved)]
        with clock.phase("plan"):
            plan = runtime_plan(
                read.program,
                problems,
                ready,
                library.folder,
                file=path.name,
                seed=seed,
                diversity=diversity,
                reached_by=lowered.reached_by,
            )
        blocked = tuple(plan_without_view(plan, seed, read.spans))
        if blocked:
            return Compiled(_invalid((*diagnostics, *blocked), clock), (), results, problems)
    report = report.model_copy(update={"seconds": clock.total_s, "phases": clock.seconds})
    return Compiled(report, scenes, results, problems, plan=plan)


def _invalid(diagnostics: tuple[Diagnostic, ...], clock: Clock) -> CompileReport:
    return CompileReport(
        verdict="invalid_program", seconds=clock.total_s, diagnostics=diagnostics, phases=clock.seconds
    )


def _emit(problem: Problem, result: Result, seed: int, derivations: DerivationCache) -> CompiledScene:
    assert isinstance(result, Solved), "no combination failed"
    scene = compiled_scene(problem, result.placements, seed, derivations)
    between_phases.after_emission(problem, scene)
    return scene


def _explain(problems: Sequence[Problem], failed: int, result: Result, seed: int) -> Explanation:
    """The conflict behind a proof, and edits that were tried; of a search that ended without a proof the spaces kept
    clear without which there is a scene."""
    problem, others = problems[failed], (*problems[:failed], *problems[failed + 1 :])
    feasible = partial(solve, seed=seed, budget=EXPLAIN_BUDGET)
    if not isinstance(result, Infeasible):
        return Explanation(edits=without_swept_spaces(problem, feasible, others))
    conflict = minimal_conflict(problem, feasible)
    if conflict is None:
        return Explanation(result.proof.paths)
    return Explanation(
        conflict.paths, conflict.minimal, suggestions(problem, conflict, feasible, others), conflict.proof
    )


def _failure(
    report: CompileReport,
    read: ReadResult,
    problem: Problem,
    result: Result,
    explanation: Explanation,
    chosen: Combination,
    clock: Clock,
) -> CompileReport:
    assert read.program is not None, "it was compiled"
    paths = chosen_paths(read.program, chosen)
    choices = {f"{key}: {value}": paths.get(key) for key, value in sorted(chosen.items())}
    finding = failure_finding(problem, result, explanation.conflict, explanation.edits, read.spans, choices)
    return report.model_copy(
        update={
            "verdict": verdict_of(result),
            "seconds": clock.total_s,
            "diagnostics": (*report.diagnostics, finding),
            "conflict": conflict_members(explanation.conflict, read.spans),
            "minimal": explanation.minimal,
            "proof": result.proof.text if isinstance(result, Infeasible) else "",
            "blocking": result.blocking if isinstance(result, Exhausted) else None,
            "suggestions": explanation.edits,
            "phases": clock.seconds,
        }
    )
