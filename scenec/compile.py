"""The compiler: phases in their order, one verdict for each combination of variants, a whole scene or none."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path as FilePath

from scenec import verify
from scenec.assets import AssetLibrary
from scenec.conflicts import minimal_conflict
from scenec.drop_choices import dropped_choices
from scenec.emit import compiled_scene
from scenec.graph import Graph, interaction_graph
from scenec.ir import Exhausted, Infeasible, Path, Placement, Problem, Proof, Result, Solved
from scenec.lower import lower
from scenec.memo import Memo
from scenec.plan import runtime_plan
from scenec.report import conflict_members, verdict_of, why
from scenec.solve import DEFAULT_BUDGET, ComponentCache, solve
from scenec.source.pieces import Pieces
from scenec.source.read import Read, read_program
from scenec.suggest import MOST_SUGGESTIONS, suggestions
from schemas.compiled_scene import CombinationVerdict, CompiledScene, CompileReport, Suggestion
from schemas.diagnostics import Diagnostic, Severity
from schemas.runtime_plan import RuntimePlan

EXPLAIN_BUDGET = 2_000  # the same for each question asked while explaining why there is no scene
_WORST_FIRST = ("infeasible", "budget_exhausted", "compiled")


@dataclass(frozen=True)
class Compiled:
    """What came of a program. `problems` and `results` have one entry a combination, `scenes` as many or none.

    `failed` is the index of the combination that the report explains, None when every one gave a scene.
    """

    report: CompileReport
    scenes: tuple[CompiledScene, ...] = ()
    results: tuple[Result, ...] = ()
    problems: tuple[Problem, ...] = ()
    failed: int | None = None
    conflict: tuple[Path, ...] = ()
    plan: RuntimePlan | None = None

    @cached_property
    def graphs(self) -> tuple[Graph, ...]:
        """The typed interaction graph of each combination."""
        return tuple(interaction_graph(problem) for problem in self.problems)

    def placements(self, combination: dict[str, str]) -> dict[str, Placement]:
        """Where things stand in the combination of that name, empty where it has no scene."""
        for problem, result in zip(self.problems, self.results, strict=True):
            if problem.combination == combination and isinstance(result, Solved):
                return result.placements
        return {}


@dataclass(frozen=True)
class Explained:
    """Why there is no scene: constraints that conflict, whether their set is minimal (None: not asked), tried edits."""

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
        """Count what is done inside toward the phase `name`."""
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
    pieces: Pieces | None = None,
    memo: Memo | None = None,
    explain: bool = True,
    diversity: float | None = None,
) -> Compiled:
    """Compile the program in `path` with the packages in `assets`; deterministic in program, assets and seed.

    `scenes` holds a checked scene for each combination of geometry-changing variants, or nothing at all unless all of
    them compiled. `budget` bounds the steps of the search of each combination. Placements of `previous` are repaired
    before anything is searched anew; `cache`, `library`, `pieces` and `memo` keep components, assets, text and what was
    derived for single things in earlier compiles (`scenec.session` holds all five). With `explain`, a failure comes
    with conflict and suggestions; with `diversity`, success comes with a plan of many scenes (see scenec.plan). Raises
    RuntimeError when the independent checker refuses what was made: a defect of ours, not of the program.
    """
    clock = Clock()
    with clock.phase("read"):
        read = read_program(path, root, pieces, memo)
    if read.program is None:
        return Compiled(_invalid(read.diagnostics, clock))
    library, memo = library or AssetLibrary(assets), memo or Memo()
    with clock.phase("bind"):
        lowered = lower(read.program, library, read.spans, memo)
    found = (*read.diagnostics, *lowered.diagnostics)
    if not lowered.problems or any(d.severity is Severity.ERROR for d in lowered.diagnostics):
        return Compiled(_invalid(found, clock))
    with clock.phase("bind"):
        for problem in lowered.problems:
            verify.after_binding(problem, memo)
    cache = cache or ComponentCache()
    results, rows = [], []
    for problem in lowered.problems:
        since = clock.total_s
        with clock.phase("solve"):
            known = previous.placements(problem.combination) if previous is not None else None
            result = solve(problem, seed, budget, previous=known, cache=cache)
        if isinstance(result, Solved):
            with clock.phase("check"):
                verify.after_solving(problem, result.placements, memo)
        results.append(result)
        rows.append(_row(problem, result, clock.total_s - since))
    failed = _worst(results)
    if failed is None:
        with clock.phase("emit"):
            scenes = tuple(_emit(p, r, seed, memo) for p, r in zip(lowered.problems, results, strict=True))
        plan = None
        if diversity is not None:
            solved = [result for result in results if isinstance(result, Solved)]
            with clock.phase("plan"):
                plan = runtime_plan(
                    read.program,
                    lowered.problems,
                    solved,
                    library.folder,
                    file=path.name,
                    seed=seed,
                    diversity=diversity,
                )
        report = CompileReport(
            verdict="compiled",
            seconds=clock.total_s,
            matrix=tuple(rows),
            diagnostics=found,
            phases=clock.seconds,
        )
        return Compiled(report, scenes, tuple(results), lowered.problems, plan=plan)
    with clock.phase("explain"):
        told = _explain(lowered.problems, failed, results[failed], seed) if explain else Explained()
        told = replace(told, edits=(*dropped_choices(rows), *told.edits)[:MOST_SUGGESTIONS])
    report = _failure(read, lowered.problems[failed], results[failed], told, found, tuple(rows), clock)
    return Compiled(report, (), tuple(results), lowered.problems, failed, told.conflict)


def _invalid(diagnostics: tuple[Diagnostic, ...], clock: Clock) -> CompileReport:
    return CompileReport(
        verdict="invalid_program", seconds=clock.total_s, diagnostics=diagnostics, phases=clock.seconds
    )


def _emit(problem: Problem, result: Result, seed: int, memo: Memo) -> CompiledScene:
    assert isinstance(result, Solved), "no combination failed"
    scene = compiled_scene(problem, result.placements, seed, memo)
    verify.after_emission(problem, scene)
    return scene


def _row(problem: Problem, result: Result, seconds: float) -> CombinationVerdict:
    proof = result.proof.text if isinstance(result, Infeasible) else ""
    return CombinationVerdict(combination=problem.combination, verdict=verdict_of(result), proof=proof, seconds=seconds)


def _worst(results: list[Result]) -> int | None:
    """Index of the first result of the worst verdict; None when all are compiled."""
    ranks = [_WORST_FIRST.index(verdict_of(result)) for result in results]
    return None if min(ranks) == _WORST_FIRST.index("compiled") else ranks.index(min(ranks))


def _explain(problems: Sequence[Problem], failed: int, result: Result, seed: int) -> Explained:
    """The conflict behind a proof, and edits that were tried; for a search that ended without one, neither."""
    problem, others = problems[failed], (*problems[:failed], *problems[failed + 1 :])
    if not isinstance(result, Infeasible):
        return Explained()
    feasible = partial(solve, seed=seed, budget=EXPLAIN_BUDGET)
    conflict = minimal_conflict(problem, feasible)
    if conflict is None:
        return Explained(result.proof.paths)
    return Explained(conflict.paths, conflict.minimal, suggestions(problem, conflict, feasible, others), conflict.proof)


def _failure(
    read: Read,
    problem: Problem,
    result: Result,
    told: Explained,
    found: tuple[Diagnostic, ...],
    rows: tuple[CombinationVerdict, ...],
    clock: Clock,
) -> CompileReport:
    result = Infeasible(told.proof) if told.proof is not None else result  # Of the conflict, not of the whole.
    return CompileReport(
        verdict=verdict_of(result),
        seconds=clock.total_s,
        matrix=rows,
        diagnostics=(*found, why(problem, result, told.conflict, told.edits, read.spans)),
        conflict=conflict_members(told.conflict, read.spans),
        minimal=told.minimal,
        proof=result.proof.text if isinstance(result, Infeasible) else "",
        blocking=result.blocking if isinstance(result, Exhausted) else None,
        suggestions=told.edits,
        phases=clock.seconds,
    )
