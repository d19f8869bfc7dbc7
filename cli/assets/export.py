"""`mana assets export`: packages in the formats of other simulators."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, get_args

import typer
from rich.markup import escape

from cli import text
from schemas.diagnostics import InvalidInput


def export_command(
    packages: Annotated[list[Path], typer.Argument(help="Package folders; with --library their ids.")],
    format_: Annotated[str, typer.Option("--format", help="mjcf, urdf or usdz.")],
    library: Annotated[
        Path | None, typer.Option("--library", help="The library that holds the packages.", exists=True)
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Exports go to OUT/FORMAT/ID.")] = Path("exports"),
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Export packages as MJCF (MuJoCo), URDF (PyBullet, Drake, ROS) or USDZ: a folder that needs nothing else.

    Visible meshes with their colour texture, colliders, mass, inertia, friction and joints with limits are those of the
    package's USD, digit for digit. Whatever the format cannot hold is a finding (asset/export-loss), printed here and
    kept in `export.json` beside the file. In MJCF the object has a free joint; a mechanism whose source was fixed has
    none. PyBullet takes the inertia only with `URDF_USE_INERTIA_FROM_FILE`. Exit code 1 when a package was refused, 2
    when the command could not run.

    Examples: `mana assets export library/mug --format mjcf`, `mana assets export mug microwave --library library
    --format urdf --out robots`
    """
    from assetkit.export.export import ExportFormat, export_package  # Loads USD, which most commands do not need.

    formats = {name: name for name in get_args(ExportFormat)}
    if format_ not in formats:
        raise typer.BadParameter(f"must be one of {', '.join(formats)}", param_hint="--format")
    folders = packages if library is None else [library / package for package in packages]
    for folder in folders:
        if not folder.is_dir():
            raise FileNotFoundError(folder)
    rows: list[dict[str, object]] = []
    refused = False
    for folder in folders:
        try:
            exported = export_package(folder, formats[format_], out)
        except InvalidInput as invalid:
            refused = True
            rows.append(
                {"package": str(folder), "file": None, "findings": [invalid.diagnostic.model_dump(mode="json")]}
            )
            if not as_json:
                text.show_diagnostic(invalid.diagnostic)
            continue
        losses = [each.model_dump(mode="json") for each in exported.lost]
        rows.append({"package": str(folder), "file": str(exported.file), "findings": losses})
        if not as_json:
            text.console.print(escape(str(exported.file)), soft_wrap=True)
            for each in exported.lost:
                text.console.print(f"  {each.severity.value}: {escape(each.headline)}", soft_wrap=True)
    if as_json:
        print(json.dumps(rows, indent=1))
    raise typer.Exit(1 if refused else 0)
