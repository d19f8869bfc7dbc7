"""`mana replay augment`: recordings in, variants with new static objects out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from cli import text
from cli.engines import REPLAY_CANDIDATES
from cli.placement import Scheduler, placement_of
from cli.replay.render import camera_names, draw_variants
from jobs.cache import write_atomically
from schemas.diagnostics import Diagnostic


def augment_command(
    episodes: Annotated[list[Path], typer.Argument(help="Recordings, or folders of them.", exists=True)],
    out: Annotated[Path, typer.Option("--out", help="Folder for the variants.")],
    plan: Annotated[Path | None, typer.Option(help="Plan whose things are put in.", exists=True)] = None,
    assets: Annotated[Path | None, typer.Option(help="Folder of packages.", exists=True)] = None,
    variants: Annotated[int, typer.Option(min=1, help="Variants of each episode.")] = 10,
    objects: Annotated[int, typer.Option(min=1, help="Objects in each variant.")] = 3,
    seed: Annotated[int, typer.Option(help="Same seed, same variants.")] = 0,
    clearance: Annotated[float, typer.Option(min=0.0, help="Distance kept to all that moves or stands (m).")] = 0.01,
    most_hidden: Annotated[float, typer.Option(help="Largest share of the task objects newly hidden.")] = 1.0,
    support: Annotated[
        list[str] | None, typer.Option(help="Where to put things; default: where objects stood.")
    ] = None,
    meshes: Annotated[Path | None, typer.Option(help="Mesh files that models name.", exists=True)] = None,
    scene: Annotated[Path | None, typer.Option(help="episode.json that says what moved.", exists=True)] = None,
    render: Annotated[bool, typer.Option("--render", help="Draw what the recorded cameras see of each.")] = False,
    cameras: Annotated[str, typer.Option(help="Of --render: names, with commas between; all by default.")] = "",
    every: Annotated[int, typer.Option(min=1, help="Of --render: draw each k-th row of the recording.")] = 1,
    jobs: Annotated[int, typer.Option(min=1, help="Recordings at a time.")] = 1,
    scheduler: Scheduler = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Put static objects into recorded episodes, outside the proven swept volume of everything that moves.

    Recorded states and stamps are copied bit for bit. What was finished is not done again. With --render colour, depth
    and instances are in pictures/ of each variant, as `mana replay render` draws them. Exit code 1 when a recording is
    refused.

    Example: `mana replay augment demos/ --assets library/ --out more/ --variants 20 --objects 3`
    """
    from replay.run import augment  # Loads the readers of episodes.

    with text.progress(quiet=as_json) as bar:
        task = bar.add_task("augmenting", total=None)
        outcome = augment(
            episodes,
            out,
            plan=plan,
            assets=assets,
            candidates=REPLAY_CANDIDATES,
            variants=variants,
            objects=objects,
            seed=seed,
            clearance_m=clearance,
            most_hidden=most_hidden,
            supports=support or [],
            meshes=meshes,
            scene=scene,
            placement=placement_of(jobs, scheduler),
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    rows, refused = list(outcome.rows), list(outcome.refused)
    if render:
        options = {"out": str(out), "meshes": _text(meshes), "cameras": camera_names(cameras), "every": every}
        numbered = [v for folder in outcome.folders for v in sorted(folder.glob("variant_*"))]
        drawn = draw_variants(numbered, options, jobs, as_json)
        for row, folder in zip(rows, outcome.folders, strict=True):
            row["frames"] = sum(drawn[v].get("frames", 0) for v in drawn if v.parent == folder)
        refused += [(v, Diagnostic.model_validate(one["refused"])) for v, one in drawn.items() if "refused" in one]
    report = {
        "schema_version": "1.0",
        "episodes": rows,
        "refused": [
            {"source": str(s), "diagnostic": d.model_dump(mode="json")} for s, d in sorted(refused, key=lambda r: r[0])
        ],
    }
    write_atomically(out / "report.json", (json.dumps(report, indent=1) + "\n").encode())
    if as_json:
        print(json.dumps(report, indent=1))
    else:
        _show(rows, refused, out)
    if refused:
        raise typer.Exit(1)


def _text(path: Path | None) -> str | None:
    return None if path is None else str(path)


def _show(rows: list[dict[str, Any]], refused: list[tuple[Path, Diagnostic]], out: Path) -> None:
    table = [
        {
            "episode": row["episode"],
            "variants": row["variants"],
            "objects": f"{row['objects_inserted']['min']} to {row['objects_requested']}",
            "supports": ", ".join(row["supports"]),
            "frames": row.get("frames", ""),
        }
        for row in rows
    ]
    shown = ("episode", "variants", "objects", "supports", "frames")
    drawn = any("frames" in row for row in rows)
    text.show_rows(table, {name: name for name in shown if drawn or name != "frames"})
    for row in rows:
        for diagnostic in row["diagnostics"][:1]:
            text.show_diagnostic(Diagnostic.model_validate(diagnostic))
    for left_out in dict.fromkeys(package for row in rows for package in row["packages_left_out"]):
        text.console.print(f"left out: {left_out}", markup=False)
    for _, diagnostic in refused:
        text.show_diagnostic(diagnostic)
    text.console.print(f"variants are in {out}; check them with `mana replay verify {out}`", markup=False)
