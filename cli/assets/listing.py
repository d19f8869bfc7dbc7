"""`mana assets list` and `mana assets stats`: what a library holds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from assetkit.library import catalog
from assetkit.library.catalog import Selection
from cli import text

Library = Annotated[Path, typer.Argument(help="An output folder of `mana assets ingest`.", exists=True)]
AsJson = Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")]
_COUNTED = ("outcome", "category", "roles", "format", "license", "material")


def list_command(
    library: Library,
    outcome: Annotated[str | None, typer.Option(help="Only this outcome: accepted, repaired or review.")] = None,
    category: Annotated[str | None, typer.Option(help="Only this category, e.g. mug.")] = None,
    role: Annotated[str | None, typer.Option(help="Only with this role, e.g. receptacle.")] = None,
    source_format: Annotated[str | None, typer.Option("--format", help="Only from this source format.")] = None,
    license_: Annotated[str | None, typer.Option("--license", help="Only licences with these words.")] = None,
    name: Annotated[str | None, typer.Option(help="Only ids with these letters.")] = None,
    limit: Annotated[int, typer.Option(min=1, help="How many to show.")] = 1000,
    offset: Annotated[int, typer.Option(min=0, help="How many to pass over first.")] = 0,
    as_json: AsJson = False,
) -> None:
    """List the packages of a library, by id; all filters must hold. `mana assets search` takes words and reasons.

    Examples: `mana assets list library`, `mana assets list library --role receptacle --outcome accepted --json`
    """
    chosen = Selection(outcome, category, role, source_format, license_, name, limit, offset)
    rows = catalog.listing(library, chosen)
    if as_json:
        print(json.dumps(rows, indent=1))
        return
    shown = [
        {
            "id": row["asset_id"],
            "outcome": row["outcome"],
            "category": row["category"],
            "size": "×".join(f"{100.0 * float(str(row[f'size_{axis}_m'])):.3g}" for axis in "xyz"),
            "mass": f"{float(str(row['mass_kg'])):.3g}",
        }
        for row in rows
    ]
    headings = {"id": "asset", "outcome": "outcome", "category": "category", "size": "size, cm", "mass": "kg"}
    text.show_rows(shown, headings)
    if len(rows) == limit:
        text.console.print(f"the first {limit} from {offset} on; --offset {offset + limit} shows the next")


def stats_command(library: Library, as_json: AsJson = False) -> None:
    """Count the packages of a library by outcome, category, role, source format, licence and material.

    An asset with several roles counts in each.

    Example: `mana assets stats library`
    """
    counts = {column: catalog.counts(library, column) for column in _COUNTED}
    if as_json:
        print(json.dumps({"packages": sum(counts["outcome"].values()), **counts}, indent=1))
        return
    text.console.print(f"{sum(counts['outcome'].values())} packages")
    for column, values in counts.items():
        rows: list[dict[str, object]] = [{"value": value or "none", "count": count} for value, count in values.items()]
        text.show_rows(rows, {"value": column, "count": "packages"})
