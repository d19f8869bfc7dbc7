"""Verdicts of a program's variants in a terminal: what is decided apart, and in which combinations it fails."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from rich.markup import escape

from cli import text
from schemas.scene.compiled import CombinationVerdict, CompileReport, ComponentVerdict

STYLE = {"compiled": "green", "infeasible": "red", "budget_exhausted": "yellow", "invalid_program": "red"}
SHORT = {"compiled": "compiled", "infeasible": "infeasible", "budget_exhausted": "not found"}
_MOST_ROWS, _MOST_NAMES = 12, 4


def show_verdicts(report: CompileReport) -> None:
    """Print one line a component with variants and one for each combination that failed; of a few in one component,
    for all."""
    if report.combinations < 2:
        return
    alone = len(report.components) == 1
    apart = "" if alone else f"; {len(report.components)} components have verdicts of their own"
    text.console.print(f"[bold]variants[/]: {report.combinations} combinations{apart}", highlight=False)
    for component in report.components:
        for line in _component(component, alone):
            text.console.print(f"  {line}", highlight=False, soft_wrap=True)


def in_words(combination: Mapping[str, str]) -> str:
    """`mug_a as mug, variants.backgrounds: low`, and `as written` for none."""
    words = (
        f"{value} as {key[8:]}" if key.startswith("objects.") else f"{key}: {value}"
        for key, value in combination.items()
    )
    return ", ".join(words) or "as written"


def _component(component: ComponentVerdict, alone: bool) -> Iterator[str]:
    rows = component.combinations
    if len(rows) > 1 or not alone:
        counts = Counter(row.verdict for row in rows)
        said = ", ".join(
            f"{counts[verdict]} [{STYLE[verdict]}]{SHORT[verdict]}[/]" for verdict in STYLE if counts[verdict]
        )
        many = "1 combination" if len(rows) == 1 else f"{len(rows)} combinations"
        union = f"; all candidates of {escape(_some(component.union))} at once" if component.union else ""
        yield f"{escape(_some(component.things))}: {many}, {said}{union}"
    failed = [row for row in rows if row.verdict != "compiled"]
    shown = rows if alone and len(rows) <= _MOST_ROWS else failed
    yield from (f"  {_row(row)}" for row in shown[:_MOST_ROWS])
    if len(shown) > _MOST_ROWS:
        yield f"  and {len(shown) - _MOST_ROWS} more (--json has all)"


def _row(row: CombinationVerdict) -> str:
    proof = f" ({escape(row.proof)})" if row.proof else ""
    return f"[{STYLE[row.verdict]}]{SHORT[row.verdict]}[/]: {escape(in_words(row.combination))}{proof}"


def _some(names: tuple[str, ...]) -> str:
    more = len(names) - _MOST_NAMES
    return ", ".join(names[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")
