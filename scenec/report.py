"""What became of a combination, in the words of the program: verdict, place in the text, what conflicts."""

from __future__ import annotations

from scenec.ir import Infeasible, Path, Problem, Result, Solved
from scenec.source.tree import Spans, written
from schemas.codes import CODES
from schemas.compiled_scene import ConflictMember, Suggestion, Verdict
from schemas.diagnostics import Diagnostic, Label, finding


def verdict_of(result: Result) -> Verdict:
    """The verdict in one word."""
    if isinstance(result, Solved):
        return "compiled"
    return "infeasible" if isinstance(result, Infeasible) else "budget_exhausted"


def why(
    problem: Problem, result: Result, paths: tuple[Path, ...], edits: tuple[Suggestion, ...], spans: Spans
) -> Diagnostic:
    """The finding for a combination without a scene, at the first of `paths`, the constraints that conflict."""
    among = _combination(problem)
    if isinstance(result, Infeasible):
        proof = result.proof
        code = f"scene/{proof.kind}" if f"scene/{proof.kind}" in CODES else "scene/infeasible"
        made = finding(
            code,
            proof.text + among,
            where=spans.place(paths[0] if paths else ()),
            value=proof.value,
            bound=proof.bound,
            unit=proof.unit,
            labels=tuple(Label(where=spans.place(path), text=written(path)) for path in paths),
        )
    else:
        assert not isinstance(result, Solved), "a scene needs no excuse"
        blocking = next((thing for thing in problem.things if thing.name == result.blocking), None)
        made = finding(
            "scene/budget-exhausted",
            f"no scene was found in {result.steps} steps, which proves nothing; `{result.blocking}` failed most"
            + among,
            where=spans.place(blocking.path if blocking else ()),
            value=result.placed,
            bound=result.of,
            unit="things placed at best",
        )
    tried = [edit.edit for edit in edits if edit.verified]
    return made if not tried else made.model_copy(update={"help": "; or ".join(tried)})


def conflict_members(paths: tuple[Path, ...], spans: Spans) -> tuple[ConflictMember, ...]:
    """The authored constraints of a conflict with their places in the text."""
    members = []
    for path in paths:
        at = spans.place(path)
        members.append(ConflictMember(path=written(path), file=at.file, line=at.line, column=at.column))
    return tuple(members)


def _combination(problem: Problem) -> str:
    chosen = ", ".join(f"{key}: {value}" for key, value in sorted(problem.combination.items()))
    return f" (with {chosen})" if chosen else ""
