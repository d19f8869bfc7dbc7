"""`mana assets gc`: free the space of what a library no longer uses."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from cli import text

_UNITS = ("bytes", "KiB", "MiB", "GiB", "TiB")


def gc_command(
    library: Annotated[Path, typer.Argument(help="An output folder of `mana assets ingest`.", exists=True)],
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Measure only; remove nothing.")] = False,
    unnamed: Annotated[
        bool, typer.Option("--all", help="Also stage results that no record names: rejected and unfinished items.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Remove what no package and no later run can use: stored results of other versions of Mana or its libraries,
    results of packages that are gone or newer, and files that a killed process left half-written.

    Packages, records, decisions and answers of annotators are never touched. Nothing is removed while an ingest is at
    work in the folder (exit code 2); killing this command at any moment leaves a whole library. What --all removes
    costs time, not results: rejected items and runs that were cut short are made anew from the first stage.

    Examples: `mana assets gc library --dry-run`, `mana assets gc library`
    """
    from assetkit.library.garbage import collect_garbage  # Loads the stages, which most commands do not need.

    freed = collect_garbage(library, unnamed=unnamed, dry_run=dry_run)
    total = sum(each.size_bytes for each in freed)
    if as_json:
        print(
            json.dumps({"dry_run": dry_run, "size_bytes": total, "kinds": [asdict(each) for each in freed]}, indent=1)
        )
        return
    rows: list[dict[str, object]] = [
        {"kind": each.kind, "files": each.files, "size": size_text(each.size_bytes)} for each in freed
    ]
    if rows:
        text.show_rows(rows, {"kind": "kind", "files": "files", "size": "size"})
    text.console.print(f"{size_text(total)} {'would be freed' if dry_run else 'freed'}")


def size_text(size_bytes: int) -> str:
    """A size with the binary unit in which it is at least 1, three digits."""
    size, unit = float(size_bytes), 0
    while size >= 1024.0 and unit < len(_UNITS) - 1:
        size, unit = size / 1024.0, unit + 1
    return f"{size:.3g} {_UNITS[unit]}"
