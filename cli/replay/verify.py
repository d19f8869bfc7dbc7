"""`mana replay verify`: judge variants of recordings by their poses alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from cli import text
from schemas.replay.documents import VariantCheck

MOST_LISTED_ROWS = 20


def verify_command(
    out: Annotated[Path, typer.Argument(help="Output of `mana replay augment`, or one variant of it.", exists=True)],
    assets: Annotated[
        Path | None, typer.Option("--assets", help="Folder of packages; default: OUT/packages.", exists=True)
    ] = None,
    clearance: Annotated[float | None, typer.Option("--clearance", min=0.0, help="Other than stated (m).")] = None,
    meshes: Annotated[Path | None, typer.Option("--meshes", help="Mesh files that models name.", exists=True)] = None,
    settle: Annotated[bool, typer.Option(help="Let the inserted objects go as well.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Replay each recording densely and measure how near everything that moves comes to every inserted object.

    16 times within each interval, along straight lines and cubics in joint space, exact distances between convex
    shapes; then the inserted objects are let go with the robots absent. Shares no code with what chose the poses. Exit
    code 1 when anything comes nearer than the clearance, an object moves, or a recorded stream differs from its source.

    Example: `mana replay verify out/ --assets library/ --json`
    """
    from cli.replay.cell import checked
    from replay.verification.check_output import summary
    from usdio.write.scene import PACKAGES

    rows = checked(out, assets or (beside if (beside := out / PACKAGES).is_dir() else None), clearance, meshes, settle)
    figures = summary(rows)
    if as_json:
        bad = [row.model_dump() for row in rows if not row.sound]
        print(json.dumps({**figures, "unsound": bad[:MOST_LISTED_ROWS]}, indent=1))
    else:
        _show(rows, figures)
    if figures["sound"] < len(rows):
        raise typer.Exit(1)


def _show(rows: list[VariantCheck], figures: dict[str, object]) -> None:
    table: list[dict[str, object]] = [{"what": name, "value": text.figure(value)} for name, value in figures.items()]
    text.show_rows(table, {"what": "", "value": ""})
    for row in [row for row in rows if not row.sound][:MOST_LISTED_ROWS]:
        for pair in row.near:
            when = f" at t = {pair.t_s:.3f} s" if pair.t_s is not None else ""
            distance = f"{pair.distance_m * 1000:.1f} mm of {row.clearance_m * 1000:.1f} mm"
            text.console.print(f"{row.variant}: {pair.inserted} is near {pair.other}{when}: {distance}", markup=False)
        for thing in row.moved:
            if not thing.stayed:
                moved = f"{thing.moved_m * 1000:.1f} mm, {thing.turned_deg:.1f} deg"
                text.console.print(f"{row.variant}: {thing.name} moved when let go: {moved}", markup=False)
        if not row.states_identical:
            text.console.print(f"{row.variant}: the recorded streams are not those of the source", markup=False)
