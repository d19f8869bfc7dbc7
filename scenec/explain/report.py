"""Reports the result of a combination as diagnostics: verdict, location in the program, conflicting constraints."""

from __future__ import annotations

from collections.abc import Mapping

from scenec.ir.problem import Infeasible, Problem, Result, Solved
from schemas.codes import CODES
from schemas.diagnostics import Diagnostic, Label, finding
from schemas.scene.compiled import ConflictMember, Suggestion, Verdict
from source.tree import Path, Spans, written

_MOST_CHOICES = 4  # whose lines are shown


def verdict_of(result: Result) -> Verdict:
    """The verdict of a result."""
    if isinstance(result, Solved):
        return "compiled"
    return "infeasible" if isinstance(result, Infeasible) else "budget_exhausted"


def failure_finding(
    problem: Problem,
    result: Result,
    paths: tuple[Path, ...],
    edits: tuple[Suggestion, ...],
    spans: Spans,
    chosen: Mapping[str, Path | None],
) -> Diagnostic:
    """The finding for a combination without a scene, at the first of `paths`, the conflicting constraints. `chosen`
    maps the choices that cause it, as text, to their paths."""
    among = f" (with {', '.join(chosen)})" if chosen else ""
    choices = tuple(Label(where=spans.place(at), text=words) for words, at in chosen.items() if at is not None)
    if isinstance(result, Infeasible):
        proof = result.proof
        code = f"scene/{proof.kind}" if f"scene/{proof.kind}" in CODES else "scene/infeasible"
        diagnostic = finding(
            code,
            proof.text + among,
            where=spans.place(paths[0] if paths else ()),
            value=proof.value,
            bound=proof.bound,
            unit=proof.unit,
            labels=(
                *(Label(where=spans.place(path), text=problem.title(path) or written(path)) for path in paths),
                *choices[:_MOST_CHOICES],
            ),
        )
    else:
        assert not isinstance(result, Solved), "a scene needs no excuse"
        blocking = next((thing for thing in problem.things if thing.name == result.blocking), None)
        headline = f"no scene was found in {result.steps} steps, which proves nothing; `{result.blocking}` failed most"
        if result.note:
            headline = f"{result.note}, which proves nothing of one at a time"
        diagnostic = finding(
            "scene/budget-exhausted",
            headline + among,
            where=spans.place(blocking.path if blocking else ()),
            value=None if result.note else result.placed,
            bound=None if result.note else result.of,
            unit="" if result.note else "things placed at best",
            labels=choices[:_MOST_CHOICES],
        )
    tried = [edit.edit for edit in edits if edit.verified]
    return diagnostic if not tried else diagnostic.model_copy(update={"help": "; or ".join(tried)})


def conflict_members(paths: tuple[Path, ...], spans: Spans) -> tuple[ConflictMember, ...]:
    """The authored constraints of a conflict with their locations."""
    members = []
    for path in paths:
        at = spans.place(path)
        members.append(ConflictMember(path=written(path), file=at.file, line=at.line, column=at.column))
    return tuple(members)
