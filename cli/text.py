"""How diagnostics and tables look in a terminal; the only place that formats them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
)
from rich.table import Table

from assetkit.batch.report_file import FinishedBatch
from schemas.diagnostics import Diagnostic, printable
from schemas.outcome import ItemOutcome
from schemas.report import CodeCount, ReportItem

console = Console()
STYLE = {
    ItemOutcome.ACCEPTED: "green",
    ItemOutcome.REPAIRED: "blue",
    ItemOutcome.REVIEW: "yellow",
    ItemOutcome.REJECTED: "red",
}
_SEVERITY = {"error": "red", "warning": "yellow", "info": "cyan"}


def progress(*more: ProgressColumn, quiet: bool) -> Progress:
    """A progress bar with `more` columns behind the usual ones; nothing is left of it where no one watches."""
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    return Progress(*columns, *more, console=console, disable=quiet, transient=not console.is_terminal)


def show_diagnostic(diagnostic: Diagnostic, indent: str = "") -> None:
    """Print one finding: headline, place, value against bound, causes, help."""
    style = _SEVERITY[diagnostic.severity.value]
    console.print(
        f"{indent}[{style}]{diagnostic.severity.value}[/{style}] [bold]{diagnostic.code}[/bold]: "
        f"{escape(diagnostic.headline)}",
        soft_wrap=True,
    )
    where = str(diagnostic.where)
    if where != "(whole asset)":
        console.print(f"{indent}  at {escape(where)}", soft_wrap=True)
    if diagnostic.value is not None:
        bound = "" if diagnostic.bound is None else f", bound {figure(diagnostic.bound)}"
        unit = f" {diagnostic.unit}" if diagnostic.unit else ""
        console.print(f"{indent}  found {escape(figure(diagnostic.value) + bound + unit)}", soft_wrap=True)
    for cause in diagnostic.because:
        console.print(f"{indent}  because", soft_wrap=True)
        show_diagnostic(cause, indent + "    ")
    if diagnostic.help:
        console.print(f"{indent}  [dim]help: {escape(diagnostic.help)}[/dim]", soft_wrap=True)


def show_summary(report: FinishedBatch, *, verbose: bool = False) -> None:
    """Print the outcome counts, and why items were not accepted: by code with an example, or `verbose` item by item."""
    table = Table(title="Outcomes", title_justify="left")
    for outcome in ItemOutcome:
        table.add_column(outcome.value, justify="right", style=STYLE[outcome])
    table.add_column("packages", justify="right")
    table.add_column("unchanged", justify="right")
    table.add_column("seconds", justify="right")
    totals = report.totals
    counts = [str(int(totals[o.value])) for o in ItemOutcome]
    table.add_row(*counts, str(int(totals["packages"])), str(int(totals["cached"])), f"{totals['wall_seconds']:.1f}")
    console.print(table)
    if "endpoint_requests" in totals:
        spent = f"{totals['endpoint_input_tokens']:.0f} tokens in, {totals['endpoint_output_tokens']:.0f} out"
        price = f", {totals['endpoint_usd']:.4f} USD" if "endpoint_usd" in totals else ""
        asked, kept = (int(totals[f"endpoint_{name}"]) for name in ("requests", "from_store"))
        console.print(f"annotator: {asked} requests, {kept} answers from the store, {spent}{price}")
    if verbose:
        _show_items(report.items)
    else:
        _show_reasons(report.reasons)


def _show_reasons(reasons: Sequence[CodeCount]) -> None:
    """Print each code that rejected items or sent them to review: how many, the first of them, and what to do."""
    for reason in reasons:
        counts = [
            f"[{STYLE[o]}]{reason.outcomes[o]} {o.value}[/]"
            for o in (ItemOutcome.REJECTED, ItemOutcome.REVIEW)
            if o in reason.outcomes
        ]
        if not counts:
            continue
        console.print(f"{', '.join(counts)}: [bold]{reason.code}[/bold]", soft_wrap=True)
        console.print(f"  e.g. {escape(reason.example)}: {escape(reason.headline)}", soft_wrap=True)
        if reason.help:
            console.print(f"  [dim]help: {escape(reason.help)}[/dim]", soft_wrap=True)


def _show_items(items: Iterable[ReportItem]) -> None:
    for item in items:
        if item.outcome in {ItemOutcome.REVIEW, ItemOutcome.REJECTED}:
            style = STYLE[item.outcome]
            console.print(f"[{style}]{item.outcome.value}[/{style}] {escape(item.source)}", soft_wrap=True)
            for diagnostic in item.diagnostics:
                if diagnostic.severity.value != "info":
                    show_diagnostic(diagnostic, "  ")


def show_rows(rows: Iterable[dict[str, object]], columns: dict[str, str]) -> None:
    """Print a table; `columns` maps keys of the rows to headings."""
    table = Table()
    for number, heading in enumerate(columns.values()):
        table.add_column(heading, no_wrap=number == 0, overflow="fold")
    for row in rows:
        table.add_row(*(escape(printable(figure(row[key]))) for key in columns))
    console.print(table)


def figure(value: object) -> str:
    """A number with four digits, anything else as it is."""
    return f"{value + 0.0:.4g}" if isinstance(value, float) else str(value)  # + 0.0: no negative zero
