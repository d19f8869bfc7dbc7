"""How the findings about one file look in a terminal: grouped by severity, errors first."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.markup import escape

from cli import text
from schemas.diagnostics import Diagnostic, Severity

_GROUPS = (
    (Severity.ERROR, "error", "wrong"),
    (Severity.WARNING, "warning", "suspicious"),
    (Severity.INFO, "remark", "not as in a released package; no fault of a file that does not claim to be one"),
)


def show_findings(file: Path, found: Sequence[Diagnostic]) -> None:
    """Print a line for the file, then errors and warnings in full and remarks in one line each."""
    groups = [(name, meaning, [d for d in found if d.severity is severity]) for severity, name, meaning in _GROUPS]
    counts = [f"{len(group)} {name}{'s' * (len(group) != 1)}" for name, _, group in groups if group]
    text.console.print(f"[bold]{escape(str(file))}[/bold]: {', '.join(counts) or 'no finding'}", soft_wrap=True)
    for name, meaning, group in groups:
        if group:
            text.console.print(f"  {name}s ({meaning})", soft_wrap=True)
        for diagnostic in group:
            if diagnostic.severity is Severity.INFO:
                line = (
                    f"    [cyan]{diagnostic.code}[/cyan] {escape(str(diagnostic.where))}: {escape(diagnostic.headline)}"
                )
                text.console.print(line, soft_wrap=True)
            else:
                text.show_diagnostic(diagnostic, "    ")
