"""`mana assets list`, `mana assets duplicates` and `mana assets stats`: what a library holds."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from assetkit.library import catalog
from assetkit.library.catalog import Selection
from assetkit.library.near_duplicates import NearDuplicate, groups_of, near_duplicates
from assetkit.library.search.limits import limit_of
from assetkit.library.search.query import Field
from cli import text

Library = Annotated[Path, typer.Argument(help="An output folder of `mana assets ingest`.", exists=True)]
AsJson = Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")]
_COUNTED = ("outcome", "category", "roles", "format", "license", "material")
LITRES_PER_M3 = 1000.0


def list_command(
    library: Library,
    outcome: Annotated[str | None, typer.Option(help="Only this outcome: accepted, repaired or review.")] = None,
    category: Annotated[str | None, typer.Option(help="Only this category, e.g. mug.")] = None,
    family: Annotated[str | None, typer.Option(help="Only this family, e.g. drinkware.")] = None,
    role: Annotated[str | None, typer.Option(help="Only with this role, e.g. receptacle.")] = None,
    group: Annotated[str | None, typer.Option(help="Only with this interaction group, e.g. drawer.")] = None,
    joint: Annotated[str | None, typer.Option(help="Only with a joint of this type, e.g. prismatic.")] = None,
    anchor: Annotated[str | None, typer.Option(help="Only with an anchor of this kind: surface or volume.")] = None,
    min_volume: Annotated[
        float | None, typer.Option("--min-volume", min=0.0, help="Least capacity of a volume anchor in litres.")
    ] = None,
    min_size: Annotated[str | None, typer.Option("--min-size", help="Least longest edge, e.g. 5cm.")] = None,
    max_size: Annotated[str | None, typer.Option("--max-size", help="Greatest longest edge, e.g. 10cm or 4in.")] = None,
    min_mass: Annotated[str | None, typer.Option("--min-mass", help="Least mass, e.g. 200g.")] = None,
    max_mass: Annotated[str | None, typer.Option("--max-mass", help="Greatest mass, e.g. 1kg.")] = None,
    source_format: Annotated[str | None, typer.Option("--format", help="Only from this source format.")] = None,
    license_: Annotated[str | None, typer.Option("--license", help="Only licences with these words.")] = None,
    name: Annotated[str | None, typer.Option(help="Only ids with these letters.")] = None,
    limit: Annotated[int, typer.Option(min=1, help="How many to show.")] = 1000,
    offset: Annotated[int, typer.Option(min=0, help="How many to pass over first.")] = 0,
    as_json: AsJson = False,
) -> None:
    """List the packages of a library, by id; all filters must hold. `mana assets search` takes words and reasons.

    Examples: `mana assets list library`, `mana assets list library --role receptacle --min-volume 0.2 --json`
    """
    chosen = Selection(
        outcome=outcome,
        category=category,
        role=role,
        format=source_format,
        license=license_,
        name=name,
        limit=limit,
        offset=offset,
        family=family,
        interaction_group=group,
        joint_type=joint,
        anchor=anchor,
        min_size_m=_figure("--min-size", "size_m", min_size),
        max_size_m=_figure("--max-size", "size_m", max_size),
        min_mass_kg=_figure("--min-mass", "mass_kg", min_mass),
        max_mass_kg=_figure("--max-mass", "mass_kg", max_mass),
        min_capacity_m3=None if min_volume is None else min_volume / LITRES_PER_M3,
    )
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


def duplicates_command(library: Library, as_json: AsJson = False) -> None:
    """Assets whose visible surfaces are the same up to rotation and scale, whatever their textures.

    Such pairs come of one object in two sources, formats or sizes. Nothing is removed: both packages stay.

    Example: `mana assets duplicates library`
    """
    pairs = near_duplicates(library)
    if as_json:
        print(json.dumps({"groups": groups_of(pairs), "pairs": [asdict(pair) for pair in pairs]}, indent=1))
        return
    show_duplicates(pairs)


def show_duplicates(pairs: list[NearDuplicate]) -> None:
    """Print pairs of near-duplicates with ratio of sizes and largest distance."""
    groups = groups_of(pairs)
    text.console.print(f"{len(groups)} groups of near-duplicates, {sum(map(len, groups))} packages")
    if pairs:
        rows = [{**asdict(pair), "distance": f"{100.0 * pair.max_share:.2g} %"} for pair in pairs]
        headings = {"asset_id": "asset", "other_id": "other", "scale_ratio": "size ratio", "distance": "of diagonal"}
        text.show_rows(rows, headings)


def stats_command(library: Library, as_json: AsJson = False) -> None:
    """Tables of the collection: totals, categories with sizes and masses, interaction groups, joints, roles, outcomes,
    licences, source formats, materials and near-duplicates.

    An asset with several roles counts in each.

    Example: `mana assets stats library`
    """
    tables = catalog.collection(library)
    groups = groups_of(near_duplicates(library))
    if as_json:
        counts = {column: catalog.counts(library, column) for column in _COUNTED}
        total = sum(counts["outcome"].values())
        print(json.dumps({"packages": total, **counts, "tables": tables, "near_duplicates": groups}, indent=1))
        return
    totals, *_ = tables.pop("totals")
    text.console.print(", ".join(f"{value} {name.replace('_', ' ')}" for name, value in totals.items()))
    for rows in tables.values():
        if rows:
            text.show_rows(_named(rows), {name: name.replace("_", " ") for name in rows[0]})
    text.console.print(f"{len(groups)} groups of near-duplicates, {sum(map(len, groups))} packages")


def _named(rows: Iterable[dict[str, object]]) -> list[dict[str, object]]:
    return [{name: "none" if value == "" else value for name, value in row.items()} for row in rows]


def _figure(flag: str, field: Field, value: str | None) -> float | None:
    """A limit of size or mass with its unit, in m or kg."""
    if value is None:
        return None
    try:
        return limit_of(value, field)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint=flag) from None
