"""Judge any USD asset, also ones Mana did not make."""

from __future__ import annotations

from pathlib import Path

from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from usdio.gate import gate
from usdio.outside import outside_verdicts

_USD = {".usd", ".usda", ".usdc", ".usdz"}


def main_usd_files(path: Path) -> list[Path]:
    """The asset files at `path`: itself, the main file of a package, or those of every package of a library."""
    if path.is_file():
        return [path]
    own = sorted(p for p in path.glob("*/*") if p.suffix in _USD)
    return own or sorted(p for p in path.glob("*/*/*") if p.suffix in _USD)


def validate_file(file: Path) -> tuple[Diagnostic, ...]:
    """All findings of the outside validators and of the gate, errors first; one when the file cannot be opened."""
    try:
        return _judged(file)
    except InvalidInput as unreadable:
        return (unreadable.diagnostic,)


def _judged(file: Path) -> tuple[Diagnostic, ...]:
    outside = [
        finding("asset/package-invalid", f"{verdict.judge}: {line}", where=Location(file=file.name), severity=severity)
        for verdict in outside_verdicts(file)
        for severity, lines in ((Severity.ERROR, verdict.findings), (Severity.WARNING, verdict.warnings))
        for line in lines
    ]
    return tuple(sorted([*outside, *gate(file)], key=lambda d: d.severity is not Severity.ERROR))
